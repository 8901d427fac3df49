//! `/uss`: ASTM F3411-22a display data, of the tracks that identify themselves: a radar track alone is no flight there.
//!
//! The standard requires its fields and gives each a value for "unknown"; only here such values are sent.

use axum::http::StatusCode;
use serde_json::{Value, json};

use super::ask::{Answer, Ask, JSON, json};
use super::problem::Problem;
use super::shown::{Piece, Shown};
use crate::json::rounded;
use crate::picture::Track;
use crate::time::Time;

/// NetMaxDisplayAreaDiagonal.
const DIAGONAL_M: f64 = 7_000.0;
const EARTH_M: f64 = 6_371_008.8;
const VIEW: &str = "four numbers lat1,lng1,lat2,lng2 in degrees: two corners";
/// Values for "unknown" of the standard's `track`, `speed`, `vertical_speed` and `alt`.
const UNKNOWN: (f64, f64, f64, f64) = (361.0, 255.0, 63.0, -1000.0);

/// `/uss/flights`.
pub fn flights(ask: &Ask) -> Answer {
    let view = ask.numbers::<4>("view", VIEW)?.ok_or_else(|| Problem::parameter("view", VIEW))?;
    let [lat1, lng1, lat2, lng2] = view;
    if lat1.abs() > 90.0 || lat2.abs() > 90.0 || lng1.abs() > 180.0 || lng2.abs() > 180.0 {
        return Err(Problem::parameter("view", VIEW));
    }
    ask.value("recent_positions_duration", "seconds, 0 to 60", |s: &f64| (0.0..=60.0).contains(s))?;
    if distance_m([lat1, lng1], [lat2, lng2]) > DIAGONAL_M {
        let detail = "the view is larger than 7 km from corner to corner, which F3411-22a does not allow";
        return Err(Problem::new(StatusCode::PAYLOAD_TOO_LARGE, detail));
    }
    // Corners in any order; of two meridians the shorter way between them.
    let (west, east) =
        if (lng1 < lng2) == ((lng1 - lng2).abs() <= 180.0) { (lng1, lng2) } else { (lng2, lng1) };
    let inside = |piece: &Piece| {
        let across = if west <= east {
            (west..=east).contains(&piece.lng)
        } else {
            piece.lng >= west || piece.lng <= east
        };
        across && (lat1.min(lat2)..=lat1.max(lat2)).contains(&piece.lat)
    };
    let (_, latest) = ask.state.log().latest();
    let flights: Vec<Value> = latest
        .iter()
        .flat_map(|shown| identified(shown))
        .filter(|(piece, _)| inside(piece))
        .map(|(piece, track)| flight(piece, track))
        .collect();
    let now = latest.map_or_else(|| ask.state.now(), |shown| shown.frame.published_at);
    json(JSON, &json!({ "timestamp": time(now), "flights": flights }))
}

/// The tracks that say who they are.
fn identified(shown: &Shown) -> impl Iterator<Item = (&Piece, &Track)> {
    shown.pieces.iter().map(|piece| (piece, shown.track(piece))).filter(|(_, track)| track.is_interpolated())
}

fn time(time: Time) -> Value {
    json!({ "value": time.to_string(), "format": "RFC3339" })
}

fn flight(piece: &Piece, track: &Track) -> Value {
    let (no_track, no_speed, no_vertical_speed, no_alt) = UNKNOWN;
    let alt = piece.alt_msl.map_or(no_alt, |_| rounded(track.position.height_m, 1));
    json!({
        "id": &*piece.id,
        "aircraft_type": "NotDeclared",
        "simulated": false,
        "recent_positions": [],
        "current_state": {
            "timestamp": time(track.time),
            "timestamp_accuracy": 0.25,
            "operational_status": "Undeclared",
            "position": {
                "lat": rounded(piece.lat, 7),
                "lng": rounded(piece.lng, 7),
                "alt": alt,
                "accuracy_h": "HAUnknown",
                "accuracy_v": "VAUnknown",
                "extrapolated": false,
            },
            "track": no_track,
            "speed": no_speed,
            "speed_accuracy": "SAUnknown",
            "vertical_speed": no_vertical_speed,
        },
    })
}

/// `/uss/flights/{id}/details`.
pub fn details(ask: &Ask) -> Answer {
    let (_, latest) = ask.state.log().latest();
    let mut known = latest.iter().flat_map(|shown| identified(shown));
    let part =
        known.find(|(piece, _)| *piece.id == *ask.id).and_then(|(_, track)| track.point.source.transponder());
    let part = part.ok_or_else(|| Problem::not_found("no flight of the latest slot has this id"))?;
    let serial = part.identity.serial().escape_ascii().to_string();
    json(JSON, &json!({ "details": { "id": ask.id, "uas_id": { "serial_number": serial } } }))
}

/// On the sphere.
fn distance_m([lat1, lng1]: [f64; 2], [lat2, lng2]: [f64; 2]) -> f64 {
    let half = |degrees: f64| (degrees.to_radians() / 2.0).sin().powi(2);
    let a = half(lat2 - lat1) + lat1.to_radians().cos() * lat2.to_radians().cos() * half(lng2 - lng1);
    2.0 * EARTH_M * a.clamp(0.0, 1.0).sqrt().asin()
}
