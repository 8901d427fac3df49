//! `/data/*.json` as readsb serves them, so that tar1090 and its kin show the picture unchanged.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::ask::{Answer, Ask, JSON, json};
use super::shown::Piece;
use crate::json::rounded;
use crate::live::PublishedPicture;
use crate::picture::Track;

const FEET_PER_METRE: f64 = 1.0 / 0.3048;
/// Knots in a metre a second.
const KNOTS: f64 = 3600.0 / 1852.0;
/// `hex` has 24 bits.
const HEX: u32 = 0x00ff_ffff;

/// `/data/aircraft.json`.
pub fn aircraft(ask: &Ask) -> Answer {
    let (_, latest) = ask.state.log().latest();
    let messages = ask.state.hub().status().map_or(0, |status| status.tally.received);
    let Some(shown) = latest else {
        return json(
            JSON,
            &json!({ "now": ask.state.now().as_seconds(), "messages": messages, "aircraft": [] }),
        );
    };
    let mut taken = BTreeSet::new();
    let placed = shown
        .pieces
        .iter()
        .map(|piece| entry(piece, shown.track(piece), &shown.frame, hex(&piece.id, &mut taken)));
    let aircraft: Vec<Value> = placed.collect();
    let now = rounded(shown.frame.published_at.as_seconds(), 3);
    json(JSON, &json!({ "now": now, "messages": messages, "aircraft": aircraft }))
}

/// Nothing here is ADS-B: a radar's track is what readsb calls a track file; the rest is `other`, and nothing claims an
/// ICAO address. There is no barometric height, and none is made up.
fn entry(piece: &Piece, track: &Track, frame: &PublishedPicture, hex: u32) -> Value {
    let age_s = rounded(frame.published_at.seconds_since(frame.picture.time), 1);
    let mut entry = json!({
        "hex": format!("~{hex:06x}"),
        "type": if piece.source == "radar" { "tisb_trackfile" } else { "other" },
        "lat": rounded(piece.lat, 6),
        "lon": rounded(piece.lng, 6),
        "seen": age_s,
        "seen_pos": age_s,
        "mlat": [],
        "tisb": [],
    });
    entry["flight"] = json!(match track.point.source.transponder() {
        Some(part) => part.identity.serial().escape_ascii().to_string(),
        None => piece.id.to_string(),
    });
    if piece.alt_msl.is_some() {
        entry["alt_geom"] = json!((track.position.height_m * FEET_PER_METRE).round() as i64);
    }
    if let Some(motion) = &track.motion {
        entry["gs"] = json!(rounded(motion.speed() * KNOTS, 1));
        entry["nac_p"] = json!(motion.class_h().category);
        entry["nac_v"] = json!(motion.class_speed().category);
        if let Some(degrees) = motion.track_deg {
            entry["track"] = json!(rounded(degrees, 2) % 360.0);
        }
    }
    if let Some(motion) = track.vertical_motion() {
        entry["geom_rate"] = json!((motion.climb() * FEET_PER_METRE * 60.0).round() as i64);
        entry["gva"] = json!(motion.class_v().category);
    }
    entry
}

/// A number of 24 bits from the id: the same as long as no other track of the picture has it.
fn hex(id: &str, taken: &mut BTreeSet<u32>) -> u32 {
    let hash =
        id.bytes().fold(0x811c_9dc5_u32, |hash, octet| (hash ^ u32::from(octet)).wrapping_mul(0x0100_0193));
    let mut hex = (hash ^ hash >> 24) & HEX;
    while !taken.insert(hex) {
        hex = (hex + 1) & HEX;
    }
    hex
}

/// `/data/receiver.json`.
pub fn receiver(ask: &Ask) -> Answer {
    let config = &ask.state.hub().config;
    let slot_ms = config.fusion.slot.as_millis() as i64;
    let mut receiver = json!({
        "version": concat!("utm-fusion ", env!("CARGO_PKG_VERSION")),
        "refresh": slot_ms.max(1_000),
        // No history is served.
        "history": 0,
    });
    if let Some((_, radar)) = config.radars().next() {
        receiver["lat"] = json!(radar.latitude_deg);
        receiver["lon"] = json!(radar.longitude_deg);
    }
    json(JSON, &receiver)
}
