//! A track prepared for answers.

use std::sync::{Arc, OnceLock};

use axum::body::Bytes;

use fusion::integrity::State;
use input::json::rounded;
use picture::{PictureMaker, PictureTrack, TrackClass, TrackSource};

/// Names of the sources of a track.
pub const SOURCES: [&str; 4] = TrackSource::NAMES;

/// A track of a slot, with the properties needed by filters.
#[derive(Clone, Debug)]
pub struct TrackSlice {
    /// Index of the track in the picture.
    pub(super) index: usize,
    /// Id of the track.
    pub id: Arc<str>,
    /// Source, one of [`SOURCES`].
    pub source: &'static str,
    /// Class of the target.
    pub class: TrackClass,
    /// Integrity of its transponder; `None` if there is none that is evaluated.
    pub integrity: Option<State>,
    /// Longitude, in degrees.
    pub lng: f64,
    /// Latitude, in degrees.
    pub lat: f64,
    /// Height above mean sea level, in metres, if it was measured.
    pub alt_msl: Option<f64>,
    /// Height above the ellipsoid, in metres, if it was measured.
    pub height_m: Option<f64>,
    /// Radius that contains 95 % of its horizontal errors, in metres; only if no sensor measured it in its slot.
    pub unmeasured_accuracy_m: Option<f64>,
    pub(super) radar: Option<usize>,
    pub(super) transponder: Option<usize>,
    cameras: Vec<usize>,
    /// Whether the track differs from the previous slot.
    pub is_new: bool,
    /// GeoJSON feature with competitors, made on the first request.
    pub(super) full: OnceLock<Bytes>,
}

impl TrackSlice {
    /// Track `index` of a picture made by `maker`. Filters compare the rounded values that readers receive.
    pub(super) fn new((index, track): (usize, &PictureTrack), maker: &PictureMaker, is_new: bool) -> Self {
        let source = &track.point.source;
        Self {
            index,
            id: maker.track_id(track).into(),
            source: track.source_name(),
            class: maker.class(track),
            integrity: track.point.integrity.map(|integrity| integrity.state),
            lng: rounded(track.position.longitude_deg(), 9),
            lat: rounded(track.position.latitude_deg(), 9),
            alt_msl: track.altitude_amsl_m.map(|metres| rounded(metres, 3)),
            height_m: track.altitude_amsl_m.map(|_| track.position.height_m),
            unmeasured_accuracy_m: track.unmeasured_accuracy_m(),
            radar: source.radar().map(|radar| usize::from(radar.track.sensor.0)),
            transponder: source.transponder().map(|part| usize::from(part.sensor.0)),
            cameras: track.point.cameras.iter().map(|part| usize::from(part.track.sensor.0)).collect(),
            is_new,
            full: OnceLock::new(),
        }
    }

    /// Indices of the sensors that contributed.
    pub fn sensors(&self) -> impl Iterator<Item = usize> {
        self.radar.into_iter().chain(self.transponder).chain(self.cameras.iter().copied())
    }
}
