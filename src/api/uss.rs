//! `/uss`: ASTM F3411-22a display data, of the tracks that identify themselves: a radar track alone is no flight there.
//!
//! The standard requires its fields and gives each a value for "unknown"; only here such values are sent.

use std::collections::HashSet;
use std::sync::Arc;

use axum::http::StatusCode;
use geo::{Distance, Haversine, Point};
use serde_json::{Value, json};

use super::ask::{Answer, Ask, JSON, json};
use super::problem::Problem;
use super::shown::{Piece, Shown};
use super::trails::Trail;
use crate::json::rounded;
use crate::picture::Track;
use fusion::point::TransponderPart;
use fusion::time::Time;

/// NetMaxNearRealTimeDataPeriod.
const WINDOW_S: u32 = 60;
/// NetMaxDisplayAreaDiagonal.
const DIAGONAL_M: f64 = 7_000.0;
const VIEW: &str = "four numbers lat1,lng1,lat2,lng2 in degrees: two corners";
/// Values for "unknown" of the standard's `track`, `speed`, `vertical_speed` and `alt`.
const UNKNOWN: (f64, f64, f64, f64) = (361.0, 255.0, 63.0, -1000.0);

/// Its greatest `speed` and `vertical_speed`, metres a second, which stand for all above.
const FASTEST: f64 = 254.25;
const STEEPEST: f64 = 62.0;

/// `/uss/flights`.
pub fn flights(ask: &Ask) -> Answer {
    let view = ask.numbers::<4>("view", VIEW)?.ok_or_else(|| Problem::parameter("view", VIEW))?;
    let [lat1, lng1, lat2, lng2] = view;
    if lat1.abs() > 90.0 || lat2.abs() > 90.0 || lng1.abs() > 180.0 || lng2.abs() > 180.0 {
        return Err(Problem::parameter("view", VIEW));
    }
    let recent_s =
        ask.value("recent_positions_duration", "seconds, 0 to 60", |s: &f64| (0.0..=60.0).contains(s))?;
    if Haversine.distance(Point::new(lng1, lat1), Point::new(lng2, lat2)) > DIAGONAL_M {
        let detail = "the view is larger than 7 km from corner to corner, which F3411-22a does not allow";
        return Err(Problem::new(StatusCode::PAYLOAD_TOO_LARGE, detail));
    }
    // Corners in any order; of two meridians the shorter way between them.
    let (west, east) =
        if (lng1 < lng2) == ((lng1 - lng2).abs() <= 180.0) { (lng1, lng2) } else { (lng2, lng1) };
    let inside = |lng: f64, lat: f64| {
        let across = if west <= east { (west..=east).contains(&lng) } else { lng >= west || lng <= east };
        across && (lat1.min(lat2)..=lat1.max(lat2)).contains(&lat)
    };
    let slots = recent_slots(ask);
    let Some(latest) = slots.first() else {
        return json(JSON, &json!({ "timestamp": time(ask.state.now()), "flights": [] }));
    };
    // A track's time is its slot's centre; the standard has whole tenths.
    let accuracy_s = (ask.state.hub().config.fusion.slot.as_secs_f64() * 5.0).ceil() / 10.0;
    let trails = ask.state.trails().last(WINDOW_S, latest.time());
    let mut told = HashSet::new();
    let mut flights: Vec<Value> = Vec::new();
    for (piece, track, part) in slots.iter().flat_map(|shown| identified(shown)) {
        // An aircraft is one flight, as it was last, whichever of its tracks that was.
        if !told.insert(part.identity) {
            continue;
        }
        // Who has left the view counts for the window as well.
        let recent = trails.get(&piece.id).into_iter().flat_map(Trail::places);
        let recent: Vec<_> = recent.filter(|&(_, lng, lat, _)| inside(lng, lat)).collect();
        if recent.is_empty() && !inside(piece.lng, piece.lat) {
            continue;
        }
        let mut flight = flight(piece, track, accuracy_s);
        if let Some(recent_s) = recent_s.filter(|&recent_s| recent_s > 0.0) {
            // A place a second.
            let first = recent.len().saturating_sub(recent_s.ceil() as usize);
            flight["recent_positions"] = recent[first..].iter().map(recent_position).collect();
        }
        flights.push(flight);
    }
    json(JSON, &json!({ "timestamp": time(latest.frame.published_at), "flights": flights }))
}

/// The slots that are remembered, the latest first: a track that misses one has not ended.
fn recent_slots(ask: &Ask) -> Vec<Arc<Shown>> {
    let log = ask.state.log();
    let mut slots = log.slots_until(log.latest().0);
    slots.reverse();
    slots
}

/// RIDRecentAircraftPosition.
fn recent_position(&(at, lng, lat, height_m): &(&str, f64, f64, Option<f64>)) -> Value {
    json!({
        "time": { "value": at, "format": "RFC3339" },
        "position": { "lat": lat, "lng": lng, "alt": height_m.unwrap_or(UNKNOWN.3) },
    })
}

/// The tracks that say who they are.
fn identified(shown: &Shown) -> impl Iterator<Item = (&Piece, &Track, &TransponderPart)> {
    let known = |piece| {
        let track = shown.track(piece);
        Some((piece, track, track.point.source.transponder()?))
    };
    shown.pieces.iter().filter_map(known)
}

fn time(time: Time) -> Value {
    json!({ "value": time.to_string(), "format": "RFC3339" })
}

fn flight(piece: &Piece, track: &Track, accuracy_s: f64) -> Value {
    let (no_track, no_speed, no_vertical_speed, no_alt) = UNKNOWN;
    let (motion, vertical) = (track.motion.as_ref(), track.vertical_motion());
    let direction = motion.and_then(|motion| motion.track_deg);
    let alt = piece.alt_msl.map_or(no_alt, |_| rounded(track.position.height_m, 1));
    json!({
        "id": &*piece.id,
        "aircraft_type": "NotDeclared",
        "simulated": false,
        "current_state": {
            "timestamp": time(track.time),
            "timestamp_accuracy": accuracy_s,
            "operational_status": "Undeclared",
            "position": {
                "lat": rounded(piece.lat, 7),
                "lng": rounded(piece.lng, 7),
                "alt": alt,
                "accuracy_h": motion.map_or("HAUnknown", |motion| motion.class_h().name),
                "accuracy_v": vertical.map_or("VAUnknown", |motion| motion.class_v().name),
                "extrapolated": track.is_extrapolated(),
            },
            "track": direction.map_or(no_track, |degrees| rounded(degrees, 1) % 360.0),
            "speed": motion.map_or(no_speed, |motion| rounded(motion.speed().min(FASTEST), 2)),
            "speed_accuracy": motion.map_or("SAUnknown", |motion| motion.class_speed().name),
            "vertical_speed":
                vertical.map_or(no_vertical_speed, |motion| rounded(motion.climb().clamp(-STEEPEST, STEEPEST), 2)),
        },
    })
}

/// `/uss/flights/{id}/details`.
pub fn details(ask: &Ask) -> Answer {
    let slots = recent_slots(ask);
    let mut known = slots.iter().flat_map(|shown| identified(shown));
    let (_, _, part) = known
        .find(|(piece, _, _)| *piece.id == *ask.id)
        .ok_or_else(|| Problem::not_found("no flight of the last seconds has this id"))?;
    let serial = part.identity.serial().escape_ascii().to_string();
    json(JSON, &json!({ "details": { "id": ask.id, "uas_id": { "serial_number": serial } } }))
}
