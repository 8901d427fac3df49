//! A track as octets: what a trail and a past picture show, and no more.

use crate::picture::{PictureMaker, PictureTrack};
use fusion::Source;

/// A track as it is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// Its id.
    pub id: String,
    /// `fused`, `radar` or `transponder`.
    pub source: &'static str,
    /// The published track number.
    pub number: u32,
    /// WGS-84 latitude, degrees; to 1e-7 (1 cm).
    pub latitude_deg: f64,
    /// WGS-84 longitude, degrees; to 1e-7.
    pub longitude_deg: f64,
    /// Height above mean sea level, metres; to 1 cm.
    pub altitude_amsl_m: Option<f64>,
}

const SOURCES: [&str; 3] = ["fused", "radar", "transponder"];
/// The height of a track that has none.
const NO_HEIGHT: i32 = i32::MIN;
/// Octets of a place.
const PLACE: usize = 17;

impl Kept {
    /// Of a track of `maker`'s.
    pub fn of(track: &PictureTrack, maker: &PictureMaker) -> Self {
        let source = match track.point.source {
            Source::Fused(..) => SOURCES[0],
            Source::Radar(_) => SOURCES[1],
            Source::Transponder(_) => SOURCES[2],
        };
        Self {
            id: maker.track_id(track),
            source,
            number: track.point.number,
            latitude_deg: track.position.latitude_deg(),
            longitude_deg: track.position.longitude_deg(),
            altitude_amsl_m: track.altitude_amsl_m,
        }
    }
}

/// Source, number, latitude, longitude, height.
pub(super) fn place(track: &Kept) -> [u8; PLACE] {
    let mut octets = [0; PLACE];
    octets[0] = SOURCES.iter().position(|&source| source == track.source).unwrap_or(0) as u8;
    octets[1..5].copy_from_slice(&track.number.to_le_bytes());
    let degrees = |degrees: f64| ((degrees * 1e7).round() as i32).to_le_bytes();
    octets[5..9].copy_from_slice(&degrees(track.latitude_deg));
    octets[9..13].copy_from_slice(&degrees(track.longitude_deg));
    let height = track.altitude_amsl_m.map_or(NO_HEIGHT, |metres| (metres * 100.0).round() as i32);
    octets[13..].copy_from_slice(&height.to_le_bytes());
    octets
}

/// The inverse; `None` for octets of something else.
pub(super) fn kept(id: &str, place: &[u8]) -> Option<Kept> {
    let word = |at: usize| Some(i32::from_le_bytes(place.get(at..at + 4)?.try_into().ok()?));
    let height = word(13)?;
    Some(Kept {
        id: id.to_owned(),
        source: SOURCES.get(usize::from(*place.first()?)).copied()?,
        number: word(1)? as u32,
        latitude_deg: f64::from(word(5)?) * 1e-7,
        longitude_deg: f64::from(word(9)?) * 1e-7,
        altitude_amsl_m: (height != NO_HEIGHT).then(|| f64::from(height) * 0.01),
    })
}

/// Of each track: the length of its id, the id, the place.
pub(super) fn picture(tracks: &[Kept]) -> Vec<u8> {
    let mut octets = Vec::with_capacity(tracks.len() * (PLACE + 16));
    for track in tracks {
        let id = &track.id.as_bytes()[..track.id.len().min(255)];
        octets.push(id.len() as u8);
        octets.extend_from_slice(id);
        octets.extend_from_slice(&place(track));
    }
    octets
}

/// The inverse; `None` where the octets end early.
pub(super) fn tracks(mut octets: &[u8]) -> Option<Vec<Kept>> {
    let mut tracks = Vec::new();
    while let Some((&length, rest)) = octets.split_first() {
        let (id, rest) = rest.split_at_checked(usize::from(length))?;
        let (place, rest) = rest.split_at_checked(PLACE)?;
        tracks.push(kept(str::from_utf8(id).ok()?, place)?);
        octets = rest;
    }
    Some(tracks)
}
