//! `/api/v1/tracks`: the picture of the latest slot.

use axum::body::{Body, Bytes};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::Response;

use super::ApiState;
use super::ask::{Answer, Ask, GEO_JSON, live, with_type};
use super::filter::Filter;
use super::problem::Problem;
use super::shown::{Shown, nothing_yet};
use super::trails::LONGEST_S;

/// The picture.
pub fn all(ask: &Ask) -> Answer {
    let filter = Filter::of(ask)?;
    let trail_s = trail_s(ask)?;
    let (_, latest) = ask.state.log().latest();
    let seq = latest.as_ref().map_or(0, |shown| shown.frame.seq);
    // Weak: what a proxy may have compressed is the same picture.
    let tag = format!("W/\"{}\"", ask.state.event_id(seq));
    let known = ask.header(header::IF_NONE_MATCH).is_some_and(|tags| matches(tags, &tag));
    let mut response = if known {
        let mut unchanged = Response::new(Body::empty());
        *unchanged.status_mut() = StatusCode::NOT_MODIFIED;
        unchanged.headers_mut().insert(header::CACHE_CONTROL, HeaderValue::from_static("no-cache"));
        unchanged
    } else {
        let body = picture(&ask.state, latest.as_deref(), &filter, trail_s);
        // To be kept for the next comparison, and never to be used without one.
        with_type(GEO_JSON, "no-cache", body)
    };
    if let Ok(tag) = HeaderValue::try_from(tag) {
        response.headers_mut().insert(header::ETAG, tag);
    }
    Ok(response)
}

/// How long the trails are to be.
pub fn trail_s(ask: &Ask) -> Result<Option<u32>, Problem> {
    ask.value("trail_s", "a whole number of seconds, 1 to 600", |s| (1..=LONGEST_S).contains(s))
}

/// A slot's picture as it is asked for.
pub fn picture(state: &ApiState, shown: Option<&Shown>, filter: &Filter, trail_s: Option<u32>) -> Bytes {
    match (shown, trail_s) {
        (None, _) => nothing_yet(&state.hub().config),
        (Some(shown), None) => shown.filtered(filter),
        (Some(shown), Some(seconds)) => {
            let trails = state.trails().last(seconds, shown.time());
            shown.with_trails(filter, &state.hub().maker, &trails)
        }
    }
}

/// One track.
pub fn one(ask: &Ask) -> Answer {
    let (_, latest) = ask.state.log().latest();
    let piece = latest.as_ref().and_then(|shown| shown.pieces.iter().find(|piece| *piece.id == *ask.id));
    piece
        .map(|piece| live(GEO_JSON, piece.feature.clone()))
        .ok_or_else(|| Problem::not_found("no track of the latest slot has this id"))
}

/// Weak comparison (RFC 9110, 8.8.3.2); our tags hold no comma.
fn matches(tags: &str, tag: &str) -> bool {
    let opaque = |tag: &str| tag.trim().trim_start_matches("W/").to_owned();
    tags.split(',').any(|known| known.trim() == "*" || opaque(known) == opaque(tag))
}
