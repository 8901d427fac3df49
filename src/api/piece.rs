//! A track as answers are put together of it.

use std::sync::{Arc, OnceLock};

use axum::body::Bytes;

use crate::json::rounded;
use crate::picture::{PictureMaker, PictureTrack, TrackClass, TrackSource};
use fusion::integrity::State;

/// Where a track can come from.
pub const SOURCES: [&str; 3] = TrackSource::NAMES;

/// A track of a slot, and what filters ask of it.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Index in the picture.
    pub(super) index: usize,
    /// The track's id.
    pub id: Arc<str>,
    /// One of [`SOURCES`].
    pub source: &'static str,
    /// What it is taken for.
    pub class: TrackClass,
    /// Whether its transponder can be trusted; `None` where there is none that is judged.
    pub integrity: Option<State>,
    /// Degrees.
    pub lng: f64,
    /// Degrees.
    pub lat: f64,
    /// Metres above mean sea level, where it was measured.
    pub alt_msl: Option<f64>,
    /// Metres above the ellipsoid, where it was measured.
    pub height_m: Option<f64>,
    /// Radius that holds 95 % of its horizontal errors, metres, where no sensor measured it in its slot.
    pub unmeasured_accuracy_m: Option<f64>,
    pub(super) radar: Option<usize>,
    pub(super) transponder: Option<usize>,
    cameras: Vec<usize>,
    /// Whether it differs from the slot before.
    pub is_new: bool,
    /// The GeoJSON feature with competitors, once somebody has asked for them.
    pub(super) full: OnceLock<Bytes>,
}

impl Piece {
    /// Of a track of the picture, which `maker` made, at that index. Filters compare what readers see: the rounded values.
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

    /// The sensors that took part, as indices.
    pub fn sensors(&self) -> impl Iterator<Item = usize> {
        self.radar.into_iter().chain(self.transponder).chain(self.cameras.iter().copied())
    }
}
