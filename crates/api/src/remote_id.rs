//! `POST /api/v1/remote-id`: Remote ID received by gateways, as JSON lines.

use std::collections::BTreeMap;

use axum::http::{StatusCode, header};
use schemars::JsonSchema;
use serde::Serialize;

use super::problem::Problem;
use super::request::ApiRequest;
use input::gateways::remote_id::{LineRefusal, REFUSALS};
use service::live::{PostError, PostResult};

/// Media type of JSON lines. It is not registered but common.
pub const LINES: &str = "application/x-ndjson";
/// Other media types of JSON lines; a single line is JSON.
const OTHER_TYPES: [&str; 4] =
    ["application/ndjson", "application/jsonl", "application/jsonlines", "application/json"];
/// Time after which a full queue usually has space again, in seconds.
const RETRY_AFTER_S: u32 = 1;

/// Result of posted lines.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RemoteIdPosted")]
pub struct PostedLines {
    /// Number of lines, without blank ones.
    lines: u64,
    /// Number of lines accepted for processing. Lines that the engine cannot use are counted with the sensor.
    taken: u64,
    /// Number of refused lines, by reason. The other lines are accepted.
    #[schemars(extend("propertyNames" = { "enum": REFUSALS }))]
    refused: BTreeMap<&'static str, u64>,
}

/// Accepts the lines of a gateway.
pub fn post(request: &ApiRequest) -> Result<PostedLines, Problem> {
    if request.state.options.player.is_some() {
        return Err(Problem::new(StatusCode::CONFLICT, "a recording is replayed: nothing is received"));
    }
    let hub = &request.state.hub;
    let has_line = hub.config.sensors.iter().any(site::config::Sensor::is_posted);
    if !has_line {
        return Err(Problem::not_found(
            "this site takes no Remote ID over HTTP; a sensor of kind \"remote-id\" does with connections = [{ format = \"http\" }]",
        ));
    }
    check_media_type(request)?;
    let later = |detail: String| Problem::unavailable(detail, Vec::new()).retry_after_s(RETRY_AFTER_S);
    let line = hub.http_input().ok_or_else(|| later("the service starts".to_owned()))?;
    let posted = line.post(request.client, &request.body).map_err(|why: PostError| later(why.to_string()))?;
    let PostResult { counts, turned_away } = posted;
    if turned_away > 0 {
        let (taken, sound) = (counts.taken, counts.taken + turned_away);
        return Err(later(format!(
            "too much waits for the engine: the first {taken} of {sound} sound lines were taken; send the rest later"
        )));
    }
    let strange = counts.refused.of(LineRefusal::Receiver as usize);
    if counts.taken == 0 && strange > 0 {
        let ids = line.receivers().ids().collect::<Vec<_>>().join(", ");
        return Err(Problem::new(
            StatusCode::FORBIDDEN,
            format!(
                "{strange} of {} lines name a receiver that is not posted to, and none was taken; lines may name: {ids}",
                counts.lines
            ),
        ));
    }
    let refused = counts.refused.iter().filter(|(_, count)| *count > 0).collect();
    Ok(PostedLines { lines: counts.lines, taken: counts.taken, refused })
}

/// Whether the body can be JSON lines: neither of another type, nor compressed.
fn check_media_type(request: &ApiRequest) -> Result<(), Problem> {
    let refuse = |detail: String| Err(Problem::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, detail));
    let kind = request.headers.get(header::CONTENT_TYPE).map(|kind| kind.to_str().unwrap_or("unreadable"));
    let bare = kind.map(|kind| kind.split(';').next().unwrap_or("").trim());
    if bare
        .is_some_and(|kind| ![LINES].iter().chain(&OTHER_TYPES).any(|known| known.eq_ignore_ascii_case(kind)))
    {
        return refuse(format!("the body is lines of JSON ({LINES}), not {}", bare.unwrap_or("")));
    }
    match request.headers.get(header::CONTENT_ENCODING) {
        Some(coding) if coding != "identity" => {
            refuse("the body is sent as it is, not compressed".to_owned())
        }
        _ => Ok(()),
    }
}
