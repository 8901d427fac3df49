//! Encoding of saved tracks: the data of trails and past pictures, and no more.

use picture::{PictureMaker, PictureTrack, TrackSource};

/// A track of the past.
#[derive(Clone, Debug, PartialEq)]
pub struct HistoryTrack {
    /// Id of the track.
    pub id: String,
    /// `fused`, `radar` or `transponder`.
    pub source: &'static str,
    /// The published track number.
    pub number: u32,
    /// WGS-84 latitude, in degrees; resolution 1e-7 (1 cm).
    pub latitude_deg: f64,
    /// WGS-84 longitude, in degrees; resolution 1e-7.
    pub longitude_deg: f64,
    /// Height above mean sea level, in metres; resolution 1 cm.
    pub altitude_amsl_m: Option<f64>,
}

const SOURCES: [&str; 4] = TrackSource::NAMES;
/// Encoded height of a track without a height.
const NO_HEIGHT: i32 = i32::MIN;
/// Size of an encoded place, in octets.
const PLACE: usize = 17;

impl HistoryTrack {
    /// Saves a track of `maker`.
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

/// A track without its id, in integer units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Units {
    /// Index in [`SOURCES`].
    source: u8,
    pub(super) number: u32,
    /// Latitude, in 1e-7 degrees.
    pub(super) latitude: i32,
    /// Longitude, in 1e-7 degrees.
    pub(super) longitude: i32,
    /// Height above mean sea level, in centimetres.
    pub(super) height: Option<i32>,
}

impl Units {
    /// Source, and whether there is a height, in one number.
    pub(super) const fn kind(self) -> u8 {
        self.source << 1 | self.height.is_some() as u8
    }

    /// Inverse of [`Units::kind`], with the other fields; `height` is called only if there is one. `None` if a number is
    /// out of range.
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

/// Converts a track, without its id.
pub(super) fn units(track: &HistoryTrack) -> Units {
    let degrees = |degrees: f64| (degrees * 1e7).round() as i32;
    Units {
        source: SOURCES.iter().position(|&source| source == track.source).unwrap_or(0) as u8,
        number: track.number,
        latitude: degrees(track.latitude_deg),
        longitude: degrees(track.longitude_deg),
        // The smallest number stands for no height.
        height: track.altitude_amsl_m.map(|metres| ((metres * 100.0).round() as i32).max(NO_HEIGHT + 1)),
    }
}

/// Inverse of [`units`]; `None` for an unknown source.
pub(super) fn track(id: &str, units: Units) -> Option<HistoryTrack> {
    Some(HistoryTrack {
        id: id.to_owned(),
        source: SOURCES.get(usize::from(units.source)).copied()?,
        number: units.number,
        latitude_deg: f64::from(units.latitude) * 1e-7,
        longitude_deg: f64::from(units.longitude) * 1e-7,
        altitude_amsl_m: units.height.map(|height| f64::from(height) * 0.01),
    })
}

/// Encodes source, number, latitude, longitude and height.
fn place(track: &HistoryTrack) -> [u8; PLACE] {
    let units = units(track);
    let mut octets = [0; PLACE];
    octets[0] = units.source;
    octets[1..5].copy_from_slice(&units.number.to_le_bytes());
    octets[5..9].copy_from_slice(&units.latitude.to_le_bytes());
    octets[9..13].copy_from_slice(&units.longitude.to_le_bytes());
    octets[13..].copy_from_slice(&units.height.unwrap_or(NO_HEIGHT).to_le_bytes());
    octets
}

/// Inverse of [`place`]; `None` for invalid octets.
fn placed(id: &str, place: &[u8]) -> Option<HistoryTrack> {
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

/// Encodes a picture. For each track: length of its id, id, place.
pub(super) fn picture(tracks: &[HistoryTrack]) -> Vec<u8> {
    let mut octets = Vec::with_capacity(tracks.len() * (PLACE + 16));
    for track in tracks {
        let id = &track.id.as_bytes()[..track.id.len().min(255)];
        octets.push(id.len() as u8);
        octets.extend_from_slice(id);
        octets.extend_from_slice(&place(track));
    }
    octets
}

/// Inverse of [`picture`]; `None` if the octets are truncated or invalid.
pub(super) fn tracks(mut octets: &[u8]) -> Option<Vec<HistoryTrack>> {
    let mut tracks = Vec::new();
    while let Some((&length, rest)) = octets.split_first() {
        let (id, rest) = rest.split_at_checked(usize::from(length))?;
        let (place, rest) = rest.split_at_checked(PLACE)?;
        tracks.push(placed(str::from_utf8(id).ok()?, place)?);
        octets = rest;
    }
    Some(tracks)
}
