//! `/api/v1/tracks`: the picture of the latest slot.

use axum::http::{HeaderValue, header};

use super::filter::TrackFilter;
use super::payload::Payload;
use super::problem::Problem;
use super::request::{ApiRequest, ApiResult, GEO_JSON, live, matches, not_modified, with_type};
use super::slot_json::{SlotJson, empty_collection};
use super::state::ApiState;
use super::trails::{LONGEST_S, PLACES_OF_A_REQUEST};
use site::config::PictureKind;

/// Picture of the latest slot.
pub fn all(request: &ApiRequest) -> ApiResult {
    let filter = filter(request)?;
    let trail_s = trail_s(request)?;
    let kind = kind(request)?;
    let (_, latest) = request.state.log.latest();
    let latest = latest.and_then(|slot| slot.of(kind));
    let seq = latest.as_ref().map_or(0, |slot| slot.frame.seq);
    // Weak tags, because a proxy may compress the same picture.
    let of_kind = if kind == PictureKind::Now { "-now" } else { "" };
    let tag = HeaderValue::try_from(format!("W/\"{}{of_kind}\"", request.state.event_id(seq)));
    let tag = tag.expect("digits and dashes in quotes");
    let known = request.header(header::IF_NONE_MATCH).is_some_and(|tags| matches(tags, &tag));
    let mut response = if known {
        not_modified()
    } else {
        let payload = picture(&request.state, (latest.as_deref(), kind), &filter, trail_s);
        // Clients may keep the answer for revalidation only.
        let mut response = with_type(GEO_JSON, "no-cache", payload.plain());
        response.extensions_mut().insert(payload);
        response
    };
    response.headers_mut().insert(header::ETAG, tag);
    Ok(response)
}

/// Requested picture of a deadline.
pub fn kind(request: &ApiRequest) -> Result<PictureKind, Problem> {
    let kind = request.query.value("at", "lagged or now", |_| true)?.unwrap_or(PictureKind::Lagged);
    if kind == PictureKind::Now && !request.state.hub.config.fusion.now {
        return Err(Problem::parameter("at", "lagged: this service makes no picture of now (fusion.now)"));
    }
    Ok(kind)
}

/// Requested selection of tracks.
pub fn filter(request: &ApiRequest) -> Result<TrackFilter, Problem> {
    TrackFilter::of(&request.query, &request.state.hub.config.sensors)
}

/// Requested length of the trails, in seconds.
pub fn trail_s(request: &ApiRequest) -> Result<Option<u32>, Problem> {
    request.query.value("trail_s", "a whole number of seconds, 1 to 600", |s| (1..=LONGEST_S).contains(s))
}

/// Cost of the picture in requests; 0 if it is cheap.
pub fn weight(request: &ApiRequest) -> u32 {
    let seconds = trail_s(request).ok().flatten();
    seconds.map_or(0, |seconds| 1 + request.state.trails().places(seconds) as u32 / PLACES_OF_A_REQUEST)
}

/// A picture of this kind, filtered, with trails if requested.
pub fn picture(
    state: &ApiState,
    (slot, kind): (Option<&SlotJson>, PictureKind),
    filter: &TrackFilter,
    trail_s: Option<u32>,
) -> Payload {
    match (slot, trail_s) {
        (None, _) => empty_collection(&state.hub.config, kind),
        (Some(slot), None) => slot.filtered(filter),
        (Some(slot), Some(seconds)) if filter.is_default() => state.with_trails(slot, kind, seconds),
        (Some(slot), Some(seconds)) => slot.with_trails(filter, &state.last_trails(seconds, slot.time())),
    }
}

/// One track, with its competitors.
pub fn one(request: &ApiRequest) -> ApiResult {
    let (_, latest) = request.state.log.latest();
    let feature = latest.as_ref().and_then(|slot| {
        let slice = slot.slices.iter().find(|slice| *slice.id == *request.id)?;
        Some(slot.feature(slice, true))
    });
    feature
        .map(|feature| live(GEO_JSON, feature))
        .ok_or_else(|| Problem::not_found("no track of the latest slot has this id"))
}
