//! `POST /api/v1/remote-id`: what gateways have heard of Remote ID, as lines.

use std::collections::BTreeMap;

use axum::http::{StatusCode, header};
use schemars::JsonSchema;
use serde::Serialize;

use super::ask::Ask;
use super::problem::Problem;
use crate::gateways::remote_id::{REFUSALS, Refusal};
use crate::live::{NotPosted, Posted};

/// Lines of JSON. No registry lists a type of theirs; this is what most who speak them write.
pub const LINES: &str = "application/x-ndjson";
/// What else lines are called; a single one is JSON.
const ALSO: [&str; 4] =
    ["application/ndjson", "application/jsonl", "application/jsonlines", "application/json"];
/// After this time there is room again as a rule, seconds.
const AGAIN_S: u32 = 1;

/// What came of the lines.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RemoteIdPosted")]
pub struct Answer {
    /// Lines, blank ones apart.
    lines: u64,
    /// Lines that were handed to the engine. What it does not use of them is counted with the sensor.
    taken: u64,
    /// Lines that were not, by reason; the others beside them stand.
    #[schemars(extend("propertyNames" = { "enum": REFUSALS }))]
    refused: BTreeMap<&'static str, u64>,
}

/// Lines of a gateway.
pub fn post(ask: &Ask) -> Result<Answer, Problem> {
    if ask.state.options.player.is_some() {
        return Err(Problem::new(StatusCode::CONFLICT, "a recording is replayed: nothing is received"));
    }
    let hub = &ask.state.hub;
    let has_line = hub.config.sensors.iter().any(crate::config::Sensor::is_posted);
    if !has_line {
        return Err(Problem::not_found(
            "this site takes no Remote ID over HTTP; a sensor of kind \"remote-id\" does with connections = [{ format = \"http\" }]",
        ));
    }
    are_lines(ask)?;
    let later = |detail: String| Problem::unavailable(detail, Vec::new()).retry_after_s(AGAIN_S);
    let line = hub.posts().ok_or_else(|| later("the service starts".to_owned()))?;
    let posted = line.post(ask.client, &ask.body).map_err(|why: NotPosted| later(why.to_string()))?;
    let Posted { counts, turned_away } = posted;
    if turned_away > 0 {
        let (taken, sound) = (counts.taken, counts.taken + turned_away);
        return Err(later(format!(
            "too much waits for the engine: the first {taken} of {sound} sound lines were taken; send the rest later"
        )));
    }
    let strange = counts.refused.of(Refusal::Receiver as usize);
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
    Ok(Answer { lines: counts.lines, taken: counts.taken, refused })
}

/// Whether the body may be lines: they are neither of another type, nor compressed.
fn are_lines(ask: &Ask) -> Result<(), Problem> {
    let refuse = |detail: String| Err(Problem::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, detail));
    let kind = ask.headers.get(header::CONTENT_TYPE).map(|kind| kind.to_str().unwrap_or("unreadable"));
    let bare = kind.map(|kind| kind.split(';').next().unwrap_or("").trim());
    if bare.is_some_and(|kind| ![LINES].iter().chain(&ALSO).any(|known| known.eq_ignore_ascii_case(kind))) {
        return refuse(format!("the body is lines of JSON ({LINES}), not {}", bare.unwrap_or("")));
    }
    match ask.headers.get(header::CONTENT_ENCODING) {
        Some(coding) if coding != "identity" => {
            refuse("the body is sent as it is, not compressed".to_owned())
        }
        _ => Ok(()),
    }
}
