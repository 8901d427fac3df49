//! A picture as observations for a provider of surveillance supplementary data (ASTM F3623), in the JSON that Flight Blender
//! takes (`docs/OUTPUTS.md`).

use std::borrow::Cow;

use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::hex;
use crate::json::rounded;
use crate::picture::{PictureMaker, PictureTrack, TrackJson};
use fusion::Source;

/// Longest identifier that its interface allows, characters.
const LONGEST_ID: usize = 24;
/// Characters of a longer one that are kept, and octets of its digest behind them.
const KEPT: usize = 15;
const DIGEST: usize = 4;

/// What is posted.
#[derive(Debug, Serialize)]
struct Body<'a> {
    observations: Vec<Observation<'a>>,
}

/// A track.
#[derive(Debug, Serialize)]
struct Observation<'a> {
    /// WGS-84, degrees.
    lat_dd: f64,
    lon_dd: f64,
    /// Above the ellipsoid, millimetres.
    altitude_mm: f64,
    /// What tells it from others: the track's id.
    icao_address: Cow<'a, str>,
    /// 5: primary radar; 8: fused of what an aircraft says and radar; 11: Remote ID, what it says alone.
    traffic_source: u8,
    /// 1: fused.
    source_type: u8,
    /// Of the position, milliseconds since 1970.
    timestamp: i64,
    /// The track as the API shows it.
    metadata: TrackJson<'a>,
}

/// The body of a second, and how many tracks it does not hold: those whose height no sensor measured, because an observation has
/// to have one.
pub fn observations<'a>(
    tracks: impl Iterator<Item = &'a PictureTrack>,
    maker: &'a PictureMaker,
) -> (Vec<u8>, u64) {
    let mut left_out = 0;
    let mut observations = Vec::new();
    for track in tracks {
        if track.altitude_amsl_m.is_none() || !is_finite(track) {
            left_out += 1;
            continue;
        }
        let (traffic_source, source_type) = match track.point.source {
            Source::Fused(..) => (8, 1),
            Source::Radar(_) => (5, 0),
            Source::Transponder(_) => (11, 0),
        };
        observations.push(Observation {
            lat_dd: rounded(track.position.latitude_deg(), 7),
            lon_dd: rounded(track.position.longitude_deg(), 7),
            altitude_mm: rounded(track.position.height_m * 1000.0, 0),
            icao_address: short(maker.track_id(track)).into(),
            traffic_source,
            source_type,
            timestamp: track.time.nanos().div_euclid(1_000_000),
            metadata: TrackJson::lean(track, maker),
        });
    }
    let body = serde_json::to_vec(&Body { observations }).expect("texts and numbers are JSON");
    (body, left_out)
}

fn is_finite(track: &PictureTrack) -> bool {
    let position = &track.position;
    [position.latitude_deg(), position.longitude_deg(), position.height_m].into_iter().all(f64::is_finite)
}

/// An id that its interface allows: a long one, of radar tracks in the `reference` profile, by its beginning and its digest.
fn short(id: String) -> String {
    if id.chars().count() <= LONGEST_ID {
        return id;
    }
    let digest = hex::text(&Sha256::digest(&id)[..DIGEST]);
    let kept: String = id.chars().take(KEPT).collect();
    format!("{kept}-{digest}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_id_becomes_a_short_one_and_stays_its_own() {
        assert_eq!(short("U-10007".to_owned()), "U-10007");
        let ids = ["R-north-east-radar-17-1763000000", "R-north-east-radar-18-1763000000"]
            .map(|id| short(id.to_owned()));
        assert!(ids.iter().all(|id| id.len() == LONGEST_ID && id.starts_with("R-north-east-ra-")), "{ids:?}");
        assert_ne!(ids[0], ids[1]);
    }
}
