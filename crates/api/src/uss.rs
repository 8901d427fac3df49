//! `/uss`: display data of ASTM F3411-22a, for tracks with an identity. A radar-only track is not a flight in this standard.
//!
//! The standard requires all of its fields and defines values for "unknown". Such values are sent only here.

use std::borrow::Cow;
use std::collections::HashSet;
use std::sync::Arc;

use axum::http::StatusCode;
use geo::{Distance, Haversine, Point};
use schemars::JsonSchema;
use serde::Serialize;

use super::problem::Problem;
use super::request::ApiRequest;
use super::slot_json::SlotJson;
use super::track_slice::TrackSlice;
use super::trails::{PLACES_OF_A_REQUEST, RecentTrail};
use fusion::Identity;
use fusion::declaration::OperatorPlace;
use fusion::point::TransponderPart;
use fusion::report::Space;
use input::json::rounded;
use input::names::with;
use picture::remote_id_json::{self, HeightJson};
use picture::{HORIZONTAL, PictureTrack, SPEED, TrackClass, VERTICAL, class_names, serial_text};

/// NetMaxNearRealTimeDataPeriod, in seconds.
const WINDOW_S: u32 = 60;
/// NetMaxDisplayAreaDiagonal, in metres.
const DIAGONAL_M: f64 = 7_000.0;
const VIEW: &str = "four numbers lat1,lng1,lat2,lng2 in degrees: two corners";
/// Values for "unknown" of the standard's `track`, `speed`, `vertical_speed` and `alt`.
const UNKNOWN: (f64, f64, f64, f64) = (361.0, 255.0, 63.0, -1000.0);

/// Maximum `speed` and `vertical_speed` of the standard, in metres per second; they stand for all higher ones.
const FASTEST: f64 = 254.25;
const STEEPEST: f64 = 62.0;

/// GetFlightsResponse.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Flights")]
pub struct UssFlights {
    timestamp: UssTime,
    flights: Vec<UssFlight>,
}

/// Class of an unknown accuracy.
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
struct UssTime {
    value: String,
    #[schemars(extend("const" = RFC3339))]
    format: &'static str,
}

impl UssTime {
    fn new(value: &impl ToString) -> Self {
        Self { value: value.to_string(), format: RFC3339 }
    }
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RIDFlight")]
struct UssFlight {
    id: String,
    #[schemars(extend("enum" = remote_id_json::UA_TYPES))]
    aircraft_type: &'static str,
    simulated: bool,
    current_state: AircraftState,
    /// Present if `recent_positions_duration` asks for them.
    #[serde(skip_serializing_if = "Option::is_none")]
    recent_positions: Option<Vec<RecentPosition>>,
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RIDAircraftState")]
struct AircraftState {
    timestamp: UssTime,
    timestamp_accuracy: f64,
    #[schemars(extend("enum" = remote_id_json::STATUSES))]
    operational_status: &'static str,
    position: FlightPosition,
    /// Track angle, in degrees true; 361 means unknown.
    track: f64,
    /// Ground speed, in metres per second; 255 means unknown.
    speed: f64,
    #[schemars(extend("enum" = with(&class_names(&SPEED), NO_SPEED_CLASS)))]
    speed_accuracy: &'static str,
    /// Vertical speed, in metres per second; 63 means unknown.
    vertical_speed: f64,
    /// Height above take-off or ground, as declared by the drone.
    #[serde(skip_serializing_if = "Option::is_none")]
    height: Option<HeightJson>,
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RIDAircraftPosition")]
struct FlightPosition {
    lat: f64,
    lng: f64,
    /// Height above the ellipsoid, in metres; -1000 means unknown.
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
    time: UssTime,
    position: PastPosition,
}

#[derive(Serialize, JsonSchema)]
struct PastPosition {
    lat: f64,
    lng: f64,
    alt: f64,
}

/// Cost of `/uss/flights` in requests.
pub fn weight(request: &ApiRequest) -> u32 {
    1 + request.state.trails().places(WINDOW_S) as u32 / PLACES_OF_A_REQUEST
}

/// `/uss/flights`.
pub fn flights(request: &ApiRequest) -> Result<UssFlights, Problem> {
    let view = request.query.numbers::<4>("view", VIEW)?.ok_or_else(|| Problem::parameter("view", VIEW))?;
    let [lat1, lng1, lat2, lng2] = view;
    if lat1.abs() > 90.0 || lat2.abs() > 90.0 || lng1.abs() > 180.0 || lng2.abs() > 180.0 {
        return Err(Problem::parameter("view", VIEW));
    }
    let recent_s = request
        .query
        .value("recent_positions_duration", "seconds, 0 to 60", |s: &f64| (0.0..=60.0).contains(s))?;
    if Haversine.distance(Point::new(lng1, lat1), Point::new(lng2, lat2)) > DIAGONAL_M {
        let detail = "the view is larger than 7 km from corner to corner, which F3411-22a does not allow";
        return Err(Problem::new(StatusCode::PAYLOAD_TOO_LARGE, detail));
    }
    // The corners may be in any order. The box spans the shorter way between its two meridians.
    let (west, east) =
        if (lng1 < lng2) == ((lng1 - lng2).abs() <= 180.0) { (lng1, lng2) } else { (lng2, lng1) };
    let inside = |lng: f64, lat: f64| {
        let across = if west <= east { (west..=east).contains(&lng) } else { lng >= west || lng <= east };
        across && (lat1.min(lat2)..=lat1.max(lat2)).contains(&lat)
    };
    let slots = recent_slots(request);
    let Some(latest) = slots.first() else {
        return Ok(UssFlights { timestamp: UssTime::new(&request.state.now()), flights: Vec::new() });
    };
    // The time of a track is the centre of its slot. The standard has tenths of a second.
    let accuracy_s = (request.state.hub.config.fusion.slot.as_secs_f64() * 5.0).ceil() / 10.0;
    let trails = request.state.last_trails(WINDOW_S, latest.time());
    let mut told = HashSet::new();
    let mut flights = Vec::new();
    for (slice, track, part) in slots.iter().flat_map(|slot| identified(slot)) {
        // An aircraft is one flight, with its latest position, whichever of its tracks has it.
        if !told.insert(part.identity) {
            continue;
        }
        // A flight that has left the view still counts within the window.
        let recent = trails.get(&slice.id).into_iter().flat_map(RecentTrail::places);
        let recent: Vec<_> = recent.filter(|&(_, lng, lat, _)| inside(lng, lat)).collect();
        if recent.is_empty() && !inside(slice.lng, slice.lat) {
            continue;
        }
        let mut flight = flight(slice, track, part, accuracy_s);
        if let Some(recent_s) = recent_s.filter(|&recent_s| recent_s > 0.0) {
            // One position per second.
            let first = recent.len().saturating_sub(recent_s.ceil() as usize);
            flight.recent_positions = Some(recent[first..].iter().map(recent_position).collect());
        }
        flights.push(flight);
    }
    Ok(UssFlights { timestamp: UssTime::new(&latest.frame.published_at), flights })
}

/// Slots kept, latest first. A track that is missing in one slot has not ended.
fn recent_slots(request: &ApiRequest) -> Vec<Arc<SlotJson>> {
    let log = &request.state.log;
    let mut slots = log.slots_until(log.latest().0);
    slots.reverse();
    slots
}

fn recent_position(&(at, lng, lat, height_m): &(&str, f64, f64, Option<f64>)) -> RecentPosition {
    let position = PastPosition { lat, lng, alt: height_m.unwrap_or(UNKNOWN.3) };
    RecentPosition { time: UssTime::new(&at), position }
}

/// Drones with an identity. Crewed aircraft and ICAO addresses have no place in Remote ID.
fn identified(slot: &SlotJson) -> impl Iterator<Item = (&TrackSlice, &PictureTrack, &TransponderPart)> {
    let known = |slice: &'_ TrackSlice| {
        let part = slot.track(slice).point.source.transponder()?;
        let is_drone = slice.class == TrackClass::Drone && part.identity.space() != Space::Address;
        is_drone.then_some(part)
    };
    let known = move |slice| Some((slice, slot.track(slice), known(slice)?));
    slot.default_tracks().filter_map(known)
}

fn flight(slice: &TrackSlice, track: &PictureTrack, part: &TransponderPart, accuracy_s: f64) -> UssFlight {
    let declared = &part.aircraft.declared;
    let (no_track, no_speed, no_vertical_speed, no_alt) = UNKNOWN;
    let (motion, vertical) = (track.motion.as_ref(), track.vertical_motion());
    let direction = motion.and_then(|motion| motion.track_deg);
    UssFlight {
        id: slice.id.to_string(),
        aircraft_type: remote_id_json::ua_type(declared).unwrap_or(remote_id_json::UA_TYPES[0]),
        simulated: false,
        current_state: AircraftState {
            timestamp: UssTime::new(&track.time),
            timestamp_accuracy: accuracy_s,
            operational_status: remote_id_json::status(declared).unwrap_or(remote_id_json::STATUSES[0]),
            position: FlightPosition {
                lat: rounded(slice.lat, 7),
                lng: rounded(slice.lng, 7),
                alt: slice.height_m.map_or(no_alt, |metres| rounded(metres, 1)),
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
    details: UssFlightDetails,
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RIDFlightDetails")]
struct UssFlightDetails {
    id: String,
    uas_id: UssUasId,
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
    /// Height above the WGS-84 ellipsoid, in metres.
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

/// One of the kinds of identities.
#[derive(Serialize, JsonSchema)]
#[schemars(inline)]
#[serde(rename_all = "snake_case")]
enum UssUasId {
    SerialNumber(String),
    RegistrationId(String),
    UtmId(String),
    SpecificSessionId(String),
}

impl UssUasId {
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
pub fn details(request: &ApiRequest) -> Result<FlightDetails, Problem> {
    let slots = recent_slots(request);
    let mut known = slots.iter().flat_map(|slot| identified(slot));
    let (_, _, part) = known
        .find(|(slice, _, _)| *slice.id == *request.id)
        .ok_or_else(|| Problem::not_found("no flight of the last seconds has this id"))?;
    let uas_id = UssUasId::of(part.identity);
    let declared = &part.aircraft.declared;
    Ok(FlightDetails {
        details: UssFlightDetails {
            id: request.id.clone(),
            uas_id,
            operator_id: remote_id_json::operator_id(declared).map(Cow::into_owned),
            operator_location: declared.operator.as_ref().map(OperatorLocation::from),
        },
    })
}
