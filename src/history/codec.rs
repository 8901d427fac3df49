//! Saved tracks as octets: what a trail and a past picture show, and no more.

use crate::picture::{PictureMaker, PictureTrack, TrackSource};

/// A track of the past.
#[derive(Clone, Debug, PartialEq)]
pub struct SavedTrack {
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

const SOURCES: [&str; 3] = TrackSource::NAMES;
/// The height of a track that has none.
const NO_HEIGHT: i32 = i32::MIN;
/// Octets of a place.
const PLACE: usize = 17;

impl SavedTrack {
    /// Of a track of `maker`.
    pub fn of(track: &PictureTrack, maker: &PictureMaker) -> Self {
        Self {
            id: maker.track_id(track),
            source: track.source_name(),
            number: track.point.number,
            latitude_deg: track.position.latitude_deg(),
            longitude_deg: track.position.longitude_deg(),
            altitude_amsl_m: track.altitude_amsl_m,
        }
    }
}

/// A track without its id, in whole units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Units {
    /// Its place in [`SOURCES`].
    source: u8,
    pub(super) number: u32,
    /// 1e-7 degrees.
    pub(super) latitude: i32,
    /// 1e-7 degrees.
    pub(super) longitude: i32,
    /// Centimetres above mean sea level.
    pub(super) height: Option<i32>,
}

impl Units {
    /// Source, and whether there is a height, as one number.
    pub(super) const fn kind(self) -> u8 {
        self.source << 1 | self.height.is_some() as u8
    }

    /// The inverse of that and the rest; `height` is asked for where there is one. `None`: numbers of something else.
    pub(super) fn of(
        kind: u8,
        number: u32,
        latitude: i64,
        longitude: i64,
        height: impl FnOnce() -> Option<i64>,
    ) -> Option<Self> {
        let height = if kind & 1 == 1 { Some(i32::try_from(height()?).ok()?) } else { None };
        let (latitude, longitude) = (i32::try_from(latitude).ok()?, i32::try_from(longitude).ok()?);
        Some(Self { source: kind >> 1, number, latitude, longitude, height })
    }
}

/// What is kept of a track besides its id.
pub(super) fn units(track: &SavedTrack) -> Units {
    let degrees = |degrees: f64| (degrees * 1e7).round() as i32;
    Units {
        source: SOURCES.iter().position(|&source| source == track.source).unwrap_or(0) as u8,
        number: track.number,
        latitude: degrees(track.latitude_deg),
        longitude: degrees(track.longitude_deg),
        // The least number stands for none.
        height: track.altitude_amsl_m.map(|metres| ((metres * 100.0).round() as i32).max(NO_HEIGHT + 1)),
    }
}

/// The inverse; `None` for a source that there is not.
pub(super) fn track(id: &str, units: Units) -> Option<SavedTrack> {
    Some(SavedTrack {
        id: id.to_owned(),
        source: SOURCES.get(usize::from(units.source)).copied()?,
        number: units.number,
        latitude_deg: f64::from(units.latitude) * 1e-7,
        longitude_deg: f64::from(units.longitude) * 1e-7,
        altitude_amsl_m: units.height.map(|height| f64::from(height) * 0.01),
    })
}

/// Source, number, latitude, longitude, height.
fn place(track: &SavedTrack) -> [u8; PLACE] {
    let units = units(track);
    let mut octets = [0; PLACE];
    octets[0] = units.source;
    octets[1..5].copy_from_slice(&units.number.to_le_bytes());
    octets[5..9].copy_from_slice(&units.latitude.to_le_bytes());
    octets[9..13].copy_from_slice(&units.longitude.to_le_bytes());
    octets[13..].copy_from_slice(&units.height.unwrap_or(NO_HEIGHT).to_le_bytes());
    octets
}

/// The inverse; `None` for octets of something else.
fn placed(id: &str, place: &[u8]) -> Option<SavedTrack> {
    let word = |at: usize| Some(i32::from_le_bytes(place.get(at..at + 4)?.try_into().ok()?));
    let height = word(13)?;
    let units = Units {
        source: *place.first()?,
        number: word(1)? as u32,
        latitude: word(5)?,
        longitude: word(9)?,
        height: (height != NO_HEIGHT).then_some(height),
    };
    track(id, units)
}

/// Of each track: the length of its id, the id, the place.
pub(super) fn picture(tracks: &[SavedTrack]) -> Vec<u8> {
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
pub(super) fn tracks(mut octets: &[u8]) -> Option<Vec<SavedTrack>> {
    let mut tracks = Vec::new();
    while let Some((&length, rest)) = octets.split_first() {
        let (id, rest) = rest.split_at_checked(usize::from(length))?;
        let (place, rest) = rest.split_at_checked(PLACE)?;
        tracks.push(placed(str::from_utf8(id).ok()?, place)?);
        octets = rest;
    }
    Some(tracks)
}
