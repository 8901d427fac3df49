//! `/data/*.json` in the format of readsb, so that tar1090 and similar displays show the picture unchanged.

use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::Serialize;

use super::problem::Problem;
use super::request::ApiRequest;
use super::slot_json::SlotJson;
use super::track_slice::TrackSlice;
use fusion::point::TransponderPart;
use fusion::report::Space;
use input::json::rounded;
use picture::{TrackClass, TrackSource, serial_text};

const FEET_PER_METRE: f64 = 1.0 / 0.3048;
/// Knots per metre per second.
const KNOTS: f64 = 3600.0 / 1852.0;
/// Mask of the 24 bits of `hex`.
const HEX: u32 = 0x00ff_ffff;

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Picture")]
pub struct ReadsbPicture {
    /// Time, in seconds since 1970.
    now: f64,
    /// Number of datagrams received.
    messages: u64,
    aircraft: Vec<ReadsbAircraft>,
}

/// ICAO type designator of a drone.
const DESIGNATOR: &str = "UHEL";
/// Description of a drone.
const DESCRIPTION: &str = "Drone";
/// Source of a radar-only track.
const RADAR: &str = TrackSource::Radar.name();
/// Emitter category of an unmanned aircraft.
const UNMANNED: (u8, &str) = (13, "B6");
/// Emitter categories of ADS-B (set and number), by their value of I021/020.
const CATEGORIES: [(u8, &str); 18] = [
    (1, "A1"),
    (2, "A2"),
    (3, "A3"),
    (4, "A4"),
    (5, "A5"),
    (6, "A6"),
    (10, "A7"),
    (11, "B1"),
    (12, "B2"),
    (16, "B3"),
    (15, "B4"),
    UNMANNED,
    (14, "B7"),
    (20, "C1"),
    (21, "C2"),
    (22, "C3"),
    (23, "C4"),
    (24, "C5"),
];

/// Source of an aircraft's position, in the terms of readsb.
#[derive(Clone, Copy)]
enum PositionType {
    AdsbIcao,
    TisbTrackfile,
    Other,
}

fusion::interface_names!(PositionType {
    AdsbIcao = "adsb_icao",
    TisbTrackfile = "tisb_trackfile",
    Other = "other",
});

/// A track in the format of a readsb aircraft. Only an aircraft with ADS-B has an ICAO address. Barometric heights are unknown
/// and left out.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Aircraft")]
struct ReadsbAircraft {
    /// ICAO address, six digits. For a track without one, `~` and a hash of its id.
    hex: String,
    /// `tisb_trackfile` means radar only.
    #[schemars(extend("enum" = PositionType::NAMES))]
    r#type: &'static str,
    lat: f64,
    lon: f64,
    seen: f64,
    seen_pos: f64,
    mlat: [(); 0],
    tisb: [(); 0],
    /// Emitter category of ADS-B, by which displays choose an icon: the reported one, else B6 (unmanned) for a drone. Left out if
    /// neither is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = CATEGORIES.map(|(_, category)| category)))]
    category: Option<&'static str>,
    /// ICAO type designator of a drone. tar1090 draws B6 alone as an aeroplane; for UHEL it uses the rotorcraft icon.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = [DESIGNATOR]))]
    t: Option<&'static str>,
    /// Description of the type, shown beside `t`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = [DESCRIPTION]))]
    desc: Option<&'static str>,
    /// Serial number of the transponder, else the id of the track.
    flight: String,
    /// Height above the ellipsoid, in feet.
    #[serde(skip_serializing_if = "Option::is_none")]
    alt_geom: Option<i64>,
    /// Ground speed, in knots.
    #[serde(skip_serializing_if = "Option::is_none")]
    gs: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    nac_p: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    nac_v: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    track: Option<f64>,
    /// Vertical rate, in feet per minute.
    #[serde(skip_serializing_if = "Option::is_none")]
    geom_rate: Option<i64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gva: Option<u8>,
}

/// `/data/aircraft.json`.
pub fn aircraft(request: &ApiRequest) -> Result<ReadsbPicture, Problem> {
    let (_, latest) = request.state.log.latest();
    let messages = request.state.hub.status().map_or(0, |status| status.tally.received);
    let Some(slot) = latest else {
        return Ok(ReadsbPicture { now: request.state.now().as_seconds(), messages, aircraft: Vec::new() });
    };
    let mut taken = BTreeSet::new();
    let aircraft = slot.default_tracks().map(|slice| entry(slice, &slot, &mut taken)).collect();
    Ok(ReadsbPicture { now: rounded(slot.frame.published_at.as_seconds(), 3), messages, aircraft })
}

fn entry(slice: &TrackSlice, slot: &SlotJson, taken: &mut BTreeSet<u32>) -> ReadsbAircraft {
    let track = slot.track(slice);
    let (motion, vertical) = (track.motion.as_ref(), track.vertical_motion());
    let age_s = rounded(slot.frame.published_at.seconds_since(slot.time()), 1);
    let transponder = track.point.source.transponder();
    let icao24 = transponder.map(|part| part.identity).filter(|identity| identity.space() == Space::Address);
    let stated = transponder.and_then(|part| part.aircraft.emitter_category).and_then(emitter_category);
    let is_drone = slice.class == TrackClass::Drone;
    let feet = |metres: f64| (metres * FEET_PER_METRE).round() as i64;
    ReadsbAircraft {
        hex: icao24.map_or_else(
            || format!("~{:06x}", hash(&slice.id, taken)),
            |icao24| serial_text(icao24).to_lowercase(),
        ),
        r#type: match (icao24, slice.source) {
            (Some(_), _) => PositionType::AdsbIcao,
            (None, RADAR) => PositionType::TisbTrackfile,
            (None, _) => PositionType::Other,
        }
        .name(),
        lat: rounded(slice.lat, 6),
        lon: rounded(slice.lng, 6),
        seen: age_s,
        seen_pos: age_s,
        mlat: [],
        tisb: [],
        category: stated.or(is_drone.then_some(UNMANNED.1)),
        t: is_drone.then_some(DESIGNATOR),
        desc: is_drone.then_some(DESCRIPTION),
        flight: transponder.map_or(slice.id.to_string(), called),
        alt_geom: slice.height_m.map(feet),
        gs: motion.map(|motion| rounded(motion.speed() * KNOTS, 1)),
        nac_p: motion.map(|motion| motion.class_h().category),
        nac_v: motion.map(|motion| motion.class_speed().category),
        track: motion.and_then(|motion| motion.track_deg).map(|degrees| rounded(degrees, 2) % 360.0),
        geom_rate: vertical.map(|motion| (motion.climb() * FEET_PER_METRE * 60.0).round() as i64),
        gva: vertical.map(|motion| motion.class_v().category),
    }
}

/// Callsign of a transponder, or its identity.
fn called(part: &TransponderPart) -> String {
    let callsign = std::str::from_utf8(&part.aircraft.callsign).unwrap_or_default().trim_matches(['\0', ' ']);
    if callsign.is_empty() { serial_text(part.identity) } else { callsign.to_owned() }
}

/// Emitter category of ADS-B (set and number) for a value of I021/020; `None` if the value gives no information.
fn emitter_category(code: u8) -> Option<&'static str> {
    CATEGORIES.into_iter().find(|(known, _)| *known == code).map(|(_, category)| category)
}

/// A 24-bit number from the id, stable as long as no other track of the picture has it.
fn hash(id: &str, taken: &mut BTreeSet<u32>) -> u32 {
    let hash =
        id.bytes().fold(0x811c_9dc5_u32, |hash, octet| (hash ^ u32::from(octet)).wrapping_mul(0x0100_0193));
    let mut hex = (hash ^ hash >> 24) & HEX;
    while !taken.insert(hex) {
        hex = (hex + 1) & HEX;
    }
    hex
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Receiver")]
pub struct ReadsbReceiver {
    version: &'static str,
    /// Interval between two pictures, in milliseconds.
    refresh: i64,
    /// Always 0, because no history is served.
    history: u32,
    /// Latitude of the first radar, in degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    lat: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lon: Option<f64>,
}

/// `/data/receiver.json`.
pub fn receiver(request: &ApiRequest) -> Result<ReadsbReceiver, Problem> {
    let config = &request.state.hub.config;
    let radar = config.radars().next().map(|(_, radar)| radar);
    Ok(ReadsbReceiver {
        version: concat!("utm-fusion ", env!("CARGO_PKG_VERSION")),
        refresh: (config.fusion.slot.as_millis() as i64).max(1_000),
        history: 0,
        lat: radar.map(|radar| radar.latitude_deg),
        lon: radar.map(|radar| radar.longitude_deg),
    })
}
