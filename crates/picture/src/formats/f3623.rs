//! Encoding of a picture for a provider of surveillance supplementary data (ASTM F3623), in the JSON of Flight Blender
//! (`docs/OUTPUTS.md`).

use std::borrow::Cow;

use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::{PictureMaker, PictureTrack, TrackJson};
use fusion::Source;
use input::hex;
use input::json::rounded;

/// Maximum length of an identifier in that interface, in characters.
const LONGEST_ID: usize = 24;
/// Number of characters kept of a longer identifier.
const KEPT: usize = 15;
/// Number of octets of the digest that is appended to them.
const DIGEST: usize = 4;

/// Body of a post.
#[derive(Debug, Serialize)]
struct ObservationsBody<'a> {
    observations: Vec<Observation<'a>>,
}

/// Observation of a track.
#[derive(Debug, Serialize)]
struct Observation<'a> {
    /// WGS-84 latitude, in degrees.
    lat_dd: f64,
    lon_dd: f64,
    /// Height above the ellipsoid, in millimetres.
    altitude_mm: f64,
    /// Id of the track.
    icao_address: Cow<'a, str>,
    /// 5: primary radar; 8: fused from transponder and radar; 11: Remote ID, transponder only.
    traffic_source: u8,
    /// 1: fused.
    source_type: u8,
    /// Time of the position, in milliseconds since 1970.
    timestamp: i64,
    /// The track as in the API.
    metadata: TrackJson<'a>,
}

/// Body of a second, and the number of tracks left out because no sensor measured their height, which an observation requires.
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
            // No value of the list is a camera: several sensors see it without its help.
            Source::Cameras => (5, 1),
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
    let body = serde_json::to_vec(&ObservationsBody { observations }).expect("texts and numbers are JSON");
    (body, left_out)
}

fn is_finite(track: &PictureTrack) -> bool {
    let position = &track.position;
    [position.latitude_deg(), position.longitude_deg(), position.height_m].into_iter().all(f64::is_finite)
}

/// Id within the maximum length. A long one, of radar tracks in the `reference` profile, is replaced by its beginning and its
/// digest.
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
    fn long_id_is_shortened_and_stays_unique() {
        assert_eq!(short("U-10007".to_owned()), "U-10007");
        let ids = ["R-north-east-radar-17-1763000000", "R-north-east-radar-18-1763000000"]
            .map(|id| short(id.to_owned()));
        assert!(ids.iter().all(|id| id.len() == LONGEST_ID && id.starts_with("R-north-east-ra-")), "{ids:?}");
        assert_ne!(ids[0], ids[1]);
    }
}
