//! `/api/v1/tracks`: the picture of the latest slot.

use axum::http::{HeaderValue, header};

use super::ask::{Answer, Ask, GEO_JSON, live, matches, not_modified, with_type};
use super::filter::Filter;
use super::payload::Payload;
use super::problem::Problem;
use super::shown::{Shown, nothing_yet};
use super::state::ApiState;
use super::trails::{LONGEST_S, PLACES_OF_A_REQUEST};
use crate::config::PictureKind;

/// The picture.
pub fn all(ask: &Ask) -> Answer {
    let filter = filter(ask)?;
    let trail_s = trail_s(ask)?;
    let kind = kind(ask)?;
    let (_, latest) = ask.state.log.latest();
    let latest = latest.and_then(|shown| shown.of(kind));
    let seq = latest.as_ref().map_or(0, |shown| shown.frame.seq);
    // Weak: what a proxy may have compressed is the same picture.
    let of_kind = if kind == PictureKind::Now { "-now" } else { "" };
    let tag = HeaderValue::try_from(format!("W/\"{}{of_kind}\"", ask.state.event_id(seq)));
    let tag = tag.expect("digits and dashes in quotes");
    let known = ask.header(header::IF_NONE_MATCH).is_some_and(|tags| matches(tags, &tag));
    let mut response = if known {
        not_modified()
    } else {
        let payload = picture(&ask.state, (latest.as_deref(), kind), &filter, trail_s);
        // To be kept for the next comparison, and never to be used without one.
        let mut response = with_type(GEO_JSON, "no-cache", payload.plain());
        response.extensions_mut().insert(payload);
        response
    };
    response.headers_mut().insert(header::ETAG, tag);
    Ok(response)
}

/// Which of the pictures of a deadline is asked for.
pub fn kind(ask: &Ask) -> Result<PictureKind, Problem> {
    let kind = ask.query.value("at", "lagged or now", |_| true)?.unwrap_or(PictureKind::Lagged);
    if kind == PictureKind::Now && !ask.state.hub.config.fusion.now {
        return Err(Problem::parameter("at", "lagged: this service makes no picture of now (fusion.now)"));
    }
    Ok(kind)
}

/// Which tracks are asked for.
pub fn filter(ask: &Ask) -> Result<Filter, Problem> {
    Filter::of(&ask.query, &ask.state.hub.config.sensors)
}

/// How long the trails are to be, seconds.
pub fn trail_s(ask: &Ask) -> Result<Option<u32>, Problem> {
    ask.query.value("trail_s", "a whole number of seconds, 1 to 600", |s| (1..=LONGEST_S).contains(s))
}

/// Cost of the picture in requests; 0: it is cheap.
pub fn weight(ask: &Ask) -> u32 {
    let seconds = trail_s(ask).ok().flatten();
    seconds.map_or(0, |seconds| 1 + ask.state.trails().places(seconds) as u32 / PLACES_OF_A_REQUEST)
}

/// A picture of this kind, filtered, with trails where asked for.
pub fn picture(
    state: &ApiState,
    (shown, kind): (Option<&Shown>, PictureKind),
    filter: &Filter,
    trail_s: Option<u32>,
) -> Payload {
    match (shown, trail_s) {
        (None, _) => nothing_yet(&state.hub.config, kind),
        (Some(shown), None) => shown.filtered(filter),
        (Some(shown), Some(seconds)) if filter.is_default() => state.with_trails(shown, kind, seconds),
        (Some(shown), Some(seconds)) => shown.with_trails(filter, &state.last_trails(seconds, shown.time())),
    }
}

/// One track, with its competitors.
pub fn one(ask: &Ask) -> Answer {
    let (_, latest) = ask.state.log.latest();
    let feature = latest.as_ref().and_then(|shown| {
        let piece = shown.pieces.iter().find(|piece| *piece.id == *ask.id)?;
        Some(shown.feature(piece, true))
    });
    feature
        .map(|feature| live(GEO_JSON, feature))
        .ok_or_else(|| Problem::not_found("no track of the latest slot has this id"))
}
