//! `/uss`: ASTM F3411-22a display data, of the tracks that identify themselves: a radar track alone is no flight there.
//!
//! The standard requires its fields and gives each a value for "unknown"; only here such values are sent.

use std::borrow::Cow;
use std::collections::HashSet;
use std::sync::Arc;

use axum::http::StatusCode;
use geo::{Distance, Haversine, Point};
use schemars::JsonSchema;
use serde::Serialize;

use super::ask::Ask;
use super::piece::Piece;
use super::problem::Problem;
use super::shown::Shown;
use super::trails::{PLACES_OF_A_REQUEST, Trail};
use crate::json::rounded;
use crate::names::with;
use crate::picture::remote_id_json::{self, HeightJson};
use crate::picture::{HORIZONTAL, PictureTrack, SPEED, TrackClass, VERTICAL, class_names, serial_text};
use fusion::Identity;
use fusion::declaration::OperatorPlace;
use fusion::point::TransponderPart;
use fusion::report::Space;

/// NetMaxNearRealTimeDataPeriod.
const WINDOW_S: u32 = 60;
/// NetMaxDisplayAreaDiagonal.
const DIAGONAL_M: f64 = 7_000.0;
const VIEW: &str = "four numbers lat1,lng1,lat2,lng2 in degrees: two corners";
/// Values for "unknown" of the standard's `track`, `speed`, `vertical_speed` and `alt`.
const UNKNOWN: (f64, f64, f64, f64) = (361.0, 255.0, 63.0, -1000.0);

/// Its greatest `speed` and `vertical_speed`, metres per second, which stand for all above.
const FASTEST: f64 = 254.25;
const STEEPEST: f64 = 62.0;

/// GetFlightsResponse.
#[derive(Serialize, JsonSchema)]
pub struct Flights {
    timestamp: Timestamp,
    flights: Vec<Flight>,
}

/// Classes of accuracies that are not known.
const NO_HORIZONTAL_CLASS: &str = "HAUnknown";
const NO_VERTICAL_CLASS: &str = "VAUnknown";
const NO_SPEED_CLASS: &str = "SAUnknown";
/// Format of times.
const RFC3339: &str = "RFC3339";
/// Datum and unit of heights.
const DATUM: &str = "W84";
const METRES: &str = "M";

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RIDTime")]
struct Timestamp {
    value: String,
    #[schemars(extend("const" = RFC3339))]
    format: &'static str,
}

impl Timestamp {
    fn new(value: &impl ToString) -> Self {
        Self { value: value.to_string(), format: RFC3339 }
    }
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RIDFlight")]
struct Flight {
    id: String,
    #[schemars(extend("enum" = remote_id_json::UA_TYPES))]
    aircraft_type: &'static str,
    simulated: bool,
    current_state: AircraftState,
    /// Only where `recent_positions_duration` asks for them.
    #[serde(skip_serializing_if = "Option::is_none")]
    recent_positions: Option<Vec<RecentPosition>>,
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RIDAircraftState")]
struct AircraftState {
    timestamp: Timestamp,
    timestamp_accuracy: f64,
    #[schemars(extend("enum" = remote_id_json::STATUSES))]
    operational_status: &'static str,
    position: FlightPosition,
    /// Degrees true; 361: unknown.
    track: f64,
    /// Metres per second; 255: unknown.
    speed: f64,
    #[schemars(extend("enum" = with(&class_names(&SPEED), NO_SPEED_CLASS)))]
    speed_accuracy: &'static str,
    /// Metres per second; 63: unknown.
    vertical_speed: f64,
    /// Above take-off or ground, as the drone declares it.
    #[serde(skip_serializing_if = "Option::is_none")]
    height: Option<HeightJson>,
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RIDAircraftPosition")]
struct FlightPosition {
    lat: f64,
    lng: f64,
    /// Metres above the ellipsoid; -1000: unknown.
    alt: f64,
    #[schemars(extend("enum" = with(&class_names(&HORIZONTAL), NO_HORIZONTAL_CLASS)))]
    accuracy_h: &'static str,
    #[schemars(extend("enum" = with(&class_names(&VERTICAL), NO_VERTICAL_CLASS)))]
    accuracy_v: &'static str,
    extrapolated: bool,
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RIDRecentAircraftPosition")]
struct RecentPosition {
    time: Timestamp,
    position: PastPosition,
}

#[derive(Serialize, JsonSchema)]
struct PastPosition {
    lat: f64,
    lng: f64,
    alt: f64,
}

/// Cost of `/uss/flights` in requests.
pub fn weight(ask: &Ask) -> u32 {
    1 + ask.state.trails().places(WINDOW_S) as u32 / PLACES_OF_A_REQUEST
}

/// `/uss/flights`.
pub fn flights(ask: &Ask) -> Result<Flights, Problem> {
    let view = ask.query.numbers::<4>("view", VIEW)?.ok_or_else(|| Problem::parameter("view", VIEW))?;
    let [lat1, lng1, lat2, lng2] = view;
    if lat1.abs() > 90.0 || lat2.abs() > 90.0 || lng1.abs() > 180.0 || lng2.abs() > 180.0 {
        return Err(Problem::parameter("view", VIEW));
    }
    let recent_s = ask
        .query
        .value("recent_positions_duration", "seconds, 0 to 60", |s: &f64| (0.0..=60.0).contains(s))?;
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
        return Ok(Flights { timestamp: Timestamp::new(&ask.state.now()), flights: Vec::new() });
    };
    // A track's time is its slot's centre; the standard has whole tenths.
    let accuracy_s = (ask.state.hub.config.fusion.slot.as_secs_f64() * 5.0).ceil() / 10.0;
    let trails = ask.state.last_trails(WINDOW_S, latest.time());
    let mut told = HashSet::new();
    let mut flights = Vec::new();
    for (piece, track, part) in slots.iter().flat_map(|shown| identified(shown)) {
        // An aircraft is one flight, as it was last, whichever of its tracks that was.
        if !told.insert(part.identity) {
            continue;
        }
        // A flight that has left the view counts within the window as well.
        let recent = trails.get(&piece.id).into_iter().flat_map(Trail::places);
        let recent: Vec<_> = recent.filter(|&(_, lng, lat, _)| inside(lng, lat)).collect();
        if recent.is_empty() && !inside(piece.lng, piece.lat) {
            continue;
        }
        let mut flight = flight(piece, track, part, accuracy_s);
        if let Some(recent_s) = recent_s.filter(|&recent_s| recent_s > 0.0) {
            // One position per second.
            let first = recent.len().saturating_sub(recent_s.ceil() as usize);
            flight.recent_positions = Some(recent[first..].iter().map(recent_position).collect());
        }
        flights.push(flight);
    }
    Ok(Flights { timestamp: Timestamp::new(&latest.frame.published_at), flights })
}

/// The slots that are remembered, the latest first: a track that misses one has not ended.
fn recent_slots(ask: &Ask) -> Vec<Arc<Shown>> {
    let log = &ask.state.log;
    let mut slots = log.slots_until(log.latest().0);
    slots.reverse();
    slots
}

fn recent_position(&(at, lng, lat, height_m): &(&str, f64, f64, Option<f64>)) -> RecentPosition {
    let position = PastPosition { lat, lng, alt: height_m.unwrap_or(UNKNOWN.3) };
    RecentPosition { time: Timestamp::new(&at), position }
}

/// The drones that say who they are. Remote ID knows nobody on board, and no ICAO address.
fn identified(shown: &Shown) -> impl Iterator<Item = (&Piece, &PictureTrack, &TransponderPart)> {
    let known = |piece: &'_ Piece| {
        let part = shown.track(piece).point.source.transponder()?;
        let is_drone = piece.class == TrackClass::Drone && part.identity.space() != Space::Address;
        is_drone.then_some(part)
    };
    let known = move |piece| Some((piece, shown.track(piece), known(piece)?));
    shown.usual().filter_map(known)
}

fn flight(piece: &Piece, track: &PictureTrack, part: &TransponderPart, accuracy_s: f64) -> Flight {
    let declared = &part.aircraft.declared;
    let (no_track, no_speed, no_vertical_speed, no_alt) = UNKNOWN;
    let (motion, vertical) = (track.motion.as_ref(), track.vertical_motion());
    let direction = motion.and_then(|motion| motion.track_deg);
    Flight {
        id: piece.id.to_string(),
        aircraft_type: remote_id_json::ua_type(declared).unwrap_or(remote_id_json::UA_TYPES[0]),
        simulated: false,
        current_state: AircraftState {
            timestamp: Timestamp::new(&track.time),
            timestamp_accuracy: accuracy_s,
            operational_status: remote_id_json::status(declared).unwrap_or(remote_id_json::STATUSES[0]),
            position: FlightPosition {
                lat: rounded(piece.lat, 7),
                lng: rounded(piece.lng, 7),
                alt: piece.height_m.map_or(no_alt, |metres| rounded(metres, 1)),
                accuracy_h: motion.map_or(NO_HORIZONTAL_CLASS, |motion| motion.class_h().name),
                accuracy_v: vertical.map_or(NO_VERTICAL_CLASS, |motion| motion.class_v().name),
                extrapolated: track.is_extrapolated(),
            },
            track: direction.map_or(no_track, |degrees| rounded(degrees, 1) % 360.0),
            speed: motion.map_or(no_speed, |motion| rounded(motion.speed().min(FASTEST), 2)),
            speed_accuracy: motion.map_or(NO_SPEED_CLASS, |motion| motion.class_speed().name),
            vertical_speed: vertical
                .map_or(no_vertical_speed, |motion| rounded(motion.climb().clamp(-STEEPEST, STEEPEST), 2)),
            height: declared.height.map(HeightJson::from),
        },
        recent_positions: None,
    }
}

/// GetFlightDetailsResponse.
#[derive(Serialize, JsonSchema)]
pub struct FlightDetails {
    details: Details,
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RIDFlightDetails")]
struct Details {
    id: String,
    uas_id: UasId,
    #[serde(skip_serializing_if = "Option::is_none")]
    operator_id: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    operator_location: Option<OperatorLocation>,
}

#[derive(Serialize, JsonSchema)]
struct OperatorLocation {
    position: LatLngPoint,
    #[serde(skip_serializing_if = "Option::is_none")]
    altitude: Option<OperatorAltitude>,
    #[schemars(extend("enum" = remote_id_json::PLACE_TYPES))]
    altitude_type: &'static str,
}

#[derive(Serialize, JsonSchema)]
struct LatLngPoint {
    lat: f64,
    lng: f64,
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Altitude")]
struct OperatorAltitude {
    /// Metres above the WGS-84 ellipsoid.
    value: f64,
    #[schemars(extend("const" = DATUM))]
    reference: &'static str,
    #[schemars(extend("const" = METRES))]
    units: &'static str,
}

impl From<&OperatorPlace> for OperatorLocation {
    fn from(operator: &OperatorPlace) -> Self {
        let [lat, lng] = remote_id_json::degrees(operator);
        let altitude = remote_id_json::metres(operator);
        Self {
            position: LatLngPoint { lat, lng },
            altitude: altitude.map(|value| OperatorAltitude { value, reference: DATUM, units: METRES }),
            altitude_type: remote_id_json::place_type(operator),
        }
    }
}

/// One of them.
#[derive(Serialize, JsonSchema)]
#[schemars(inline)]
#[serde(rename_all = "snake_case")]
enum UasId {
    SerialNumber(String),
    RegistrationId(String),
    UtmId(String),
    SpecificSessionId(String),
}

impl UasId {
    fn of(identity: Identity) -> Self {
        let text = serial_text(identity);
        match identity.space() {
            Space::Serial | Space::Address => Self::SerialNumber(text),
            Space::Registration => Self::RegistrationId(text),
            Space::Flight => Self::UtmId(text),
            Space::Session => Self::SpecificSessionId(text),
        }
    }
}

/// `/uss/flights/{id}/details`.
pub fn details(ask: &Ask) -> Result<FlightDetails, Problem> {
    let slots = recent_slots(ask);
    let mut known = slots.iter().flat_map(|shown| identified(shown));
    let (_, _, part) = known
        .find(|(piece, _, _)| *piece.id == *ask.id)
        .ok_or_else(|| Problem::not_found("no flight of the last seconds has this id"))?;
    let uas_id = UasId::of(part.identity);
    let declared = &part.aircraft.declared;
    Ok(FlightDetails {
        details: Details {
            id: ask.id.clone(),
            uas_id,
            operator_id: remote_id_json::operator_id(declared).map(Cow::into_owned),
            operator_location: declared.operator.as_ref().map(OperatorLocation::from),
        },
    })
}
