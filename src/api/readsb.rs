//! `/data/*.json` as readsb serves them, so that tar1090 and its kin show the picture unchanged.

use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::Serialize;

use super::ask::Ask;
use super::piece::Piece;
use super::problem::Problem;
use super::shown::Shown;
use crate::json::rounded;
use crate::picture::{TrackClass, TrackSource, serial_text};
use fusion::point::TransponderPart;
use fusion::report::Space;

const FEET_PER_METRE: f64 = 1.0 / 0.3048;
/// Knots in a metre per second.
const KNOTS: f64 = 3600.0 / 1852.0;
/// `hex` has 24 bits.
const HEX: u32 = 0x00ff_ffff;

#[derive(Serialize, JsonSchema)]
pub struct Picture {
    /// Seconds since 1970.
    now: f64,
    /// Datagrams received.
    messages: u64,
    aircraft: Vec<Aircraft>,
}

/// ICAO type designator of a drone.
const DESIGNATOR: &str = "UHEL";
/// Description of a drone.
const DESCRIPTION: &str = "Drone";
/// Source of a track of radar alone.
const RADAR: &str = TrackSource::Radar.name();
/// Emitter category of an unmanned aircraft.
const UNMANNED: (u8, &str) = (13, "B6");
/// Emitter categories of ADS-B, set and number, by their value of I021/020.
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

/// Where readsb's position of an aircraft comes from.
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

/// A track as readsb describes an aircraft. Only an aircraft that is heard by ADS-B has an ICAO address. Barometric heights are
/// not known and left out.
#[derive(Serialize, JsonSchema)]
struct Aircraft {
    /// ICAO address, six digits; of a track without one `~` and a hash of its id.
    hex: String,
    /// `tisb_trackfile`: radar alone.
    #[schemars(extend("enum" = PositionType::NAMES))]
    r#type: &'static str,
    lat: f64,
    lon: f64,
    seen: f64,
    seen_pos: f64,
    mlat: [(); 0],
    tisb: [(); 0],
    /// Emitter category of ADS-B, by which displays choose an icon: the one that the aircraft states, else B6 (unmanned) of a
    /// drone. Absent where neither is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = CATEGORIES.map(|(_, category)| category)))]
    category: Option<&'static str>,
    /// ICAO type designator of a drone. tar1090 draws B6 alone as an aeroplane; for UHEL it takes the icon with rotors.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = [DESIGNATOR]))]
    t: Option<&'static str>,
    /// Description of the type, shown beside `t`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = [DESCRIPTION]))]
    desc: Option<&'static str>,
    /// Serial number of the transponder, else the track's id.
    flight: String,
    /// Above the ellipsoid, feet.
    #[serde(skip_serializing_if = "Option::is_none")]
    alt_geom: Option<i64>,
    /// Ground speed, knots.
    #[serde(skip_serializing_if = "Option::is_none")]
    gs: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    nac_p: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    nac_v: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    track: Option<f64>,
    /// Feet per minute.
    #[serde(skip_serializing_if = "Option::is_none")]
    geom_rate: Option<i64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gva: Option<u8>,
}

/// `/data/aircraft.json`.
pub fn aircraft(ask: &Ask) -> Result<Picture, Problem> {
    let (_, latest) = ask.state.log.latest();
    let messages = ask.state.hub.status().map_or(0, |status| status.tally.received);
    let Some(shown) = latest else {
        return Ok(Picture { now: ask.state.now().as_seconds(), messages, aircraft: Vec::new() });
    };
    let mut taken = BTreeSet::new();
    let aircraft = shown.usual().map(|piece| entry(piece, &shown, &mut taken)).collect();
    Ok(Picture { now: rounded(shown.frame.published_at.as_seconds(), 3), messages, aircraft })
}

fn entry(piece: &Piece, shown: &Shown, taken: &mut BTreeSet<u32>) -> Aircraft {
    let track = shown.track(piece);
    let (motion, vertical) = (track.motion.as_ref(), track.vertical_motion());
    let age_s = rounded(shown.frame.published_at.seconds_since(shown.time()), 1);
    let transponder = track.point.source.transponder();
    let icao24 = transponder.map(|part| part.identity).filter(|identity| identity.space() == Space::Address);
    let stated = transponder.and_then(|part| part.aircraft.emitter_category).and_then(emitter_category);
    let is_drone = piece.class == TrackClass::Drone;
    let feet = |metres: f64| (metres * FEET_PER_METRE).round() as i64;
    Aircraft {
        hex: icao24.map_or_else(
            || format!("~{:06x}", hash(&piece.id, taken)),
            |icao24| serial_text(icao24).to_lowercase(),
        ),
        r#type: match (icao24, piece.source) {
            (Some(_), _) => PositionType::AdsbIcao,
            (None, RADAR) => PositionType::TisbTrackfile,
            (None, _) => PositionType::Other,
        }
        .name(),
        lat: rounded(piece.lat, 6),
        lon: rounded(piece.lng, 6),
        seen: age_s,
        seen_pos: age_s,
        mlat: [],
        tisb: [],
        category: stated.or(is_drone.then_some(UNMANNED.1)),
        t: is_drone.then_some(DESIGNATOR),
        desc: is_drone.then_some(DESCRIPTION),
        flight: transponder.map_or(piece.id.to_string(), called),
        alt_geom: piece.height_m.map(feet),
        gs: motion.map(|motion| rounded(motion.speed() * KNOTS, 1)),
        nac_p: motion.map(|motion| motion.class_h().category),
        nac_v: motion.map(|motion| motion.class_speed().category),
        track: motion.and_then(|motion| motion.track_deg).map(|degrees| rounded(degrees, 2) % 360.0),
        geom_rate: vertical.map(|motion| (motion.climb() * FEET_PER_METRE * 60.0).round() as i64),
        gva: vertical.map(|motion| motion.class_v().category),
    }
}

/// Its callsign, or who it says it is.
fn called(part: &TransponderPart) -> String {
    let callsign = std::str::from_utf8(&part.aircraft.callsign).unwrap_or_default().trim_matches(['\0', ' ']);
    if callsign.is_empty() { serial_text(part.identity) } else { callsign.to_owned() }
}

/// The category of ADS-B (set and number) for a value of I021/020; `None` of one that says nothing.
fn emitter_category(code: u8) -> Option<&'static str> {
    CATEGORIES.into_iter().find(|(known, _)| *known == code).map(|(_, category)| category)
}

/// A number of 24 bits from the id: the same as long as no other track of the picture has it.
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
pub struct Receiver {
    version: &'static str,
    /// Milliseconds between two pictures.
    refresh: i64,
    /// 0: no history is served.
    history: u32,
    /// Of the first radar, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    lat: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lon: Option<f64>,
}

/// `/data/receiver.json`.
pub fn receiver(ask: &Ask) -> Result<Receiver, Problem> {
    let config = &ask.state.hub.config;
    let radar = config.radars().next().map(|(_, radar)| radar);
    Ok(Receiver {
        version: concat!("utm-fusion ", env!("CARGO_PKG_VERSION")),
        refresh: (config.fusion.slot.as_millis() as i64).max(1_000),
        history: 0,
        lat: radar.map(|radar| radar.latitude_deg),
        lon: radar.map(|radar| radar.longitude_deg),
    })
}
