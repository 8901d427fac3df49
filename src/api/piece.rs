//! A track as answers are put together of it.

use std::sync::{Arc, OnceLock};

use axum::body::Bytes;

use crate::json::rounded;
use crate::picture::{PictureMaker, PictureTrack, serial_text};
use fusion::integrity::State;
use fusion::point::Source;

/// Where a track can come from.
pub const SOURCES: [&str; 3] = ["fused", "radar", "transponder"];

/// What a track is taken for: the configuration knows who is crewed, then a transponder is a drone's, then the radar's
/// classifier is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Nobody is on board: it has a transponder, or the radar holds that for likelier than not.
    Drone,
    /// Somebody is on board: its transponder is one of `[conflicts] crewed`.
    Crewed,
    /// The radar holds it for something else: a bird.
    Other,
    /// Of radar alone, which says nothing of it.
    Unknown,
}

impl Class {
    /// All classes.
    pub const ALL: [Self; 4] = [Self::Drone, Self::Crewed, Self::Other, Self::Unknown];

    /// Its name on the interfaces.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Drone => "drone",
            Self::Crewed => "crewed",
            Self::Other => "other",
            Self::Unknown => "unknown",
        }
    }

    /// Of a track; `crewed`: serial numbers of transponders. The map shows what is below one half as no drone, too.
    fn of(source: &Source, crewed: &[String]) -> Self {
        match (source.transponder(), source.radar().and_then(|radar| radar.uav_probability)) {
            (Some(part), _) if !crewed.is_empty() && crewed.contains(&serial_text(part.identity)) => {
                Self::Crewed
            }
            (Some(_), _) => Self::Drone,
            (None, Some(probability)) if probability < 0.5 => Self::Other,
            (None, Some(_)) => Self::Drone,
            (None, None) => Self::Unknown,
        }
    }
}

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
    pub class: Class,
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
    /// Whether it differs from the slot before.
    pub is_new: bool,
    /// The GeoJSON feature with competitors, once somebody has asked for them.
    pub(super) full: OnceLock<Bytes>,
}

impl Piece {
    /// Of a track of the picture, which `maker` made, at that index; `crewed`: serial numbers of transponders. Filters compare what readers see: the rounded values.
    pub(super) fn new(
        (index, track): (usize, &PictureTrack),
        maker: &PictureMaker,
        crewed: &[String],
        is_new: bool,
    ) -> Self {
        let source = &track.point.source;
        Self {
            index,
            id: maker.track_id(track).into(),
            source: track.source_name(),
            class: Class::of(source, crewed),
            integrity: track.point.integrity.map(|integrity| integrity.state),
            lng: rounded(track.position.longitude_deg(), 9),
            lat: rounded(track.position.latitude_deg(), 9),
            alt_msl: track.altitude_amsl_m.map(|metres| rounded(metres, 3)),
            height_m: track.altitude_amsl_m.map(|_| track.position.height_m),
            unmeasured_accuracy_m: track.unmeasured_accuracy_m(),
            radar: source.radar().map(|radar| usize::from(radar.track.sensor.0)),
            transponder: source.transponder().map(|part| usize::from(part.sensor.0)),
            is_new,
            full: OnceLock::new(),
        }
    }

    /// The sensors that took part, as indices.
    pub fn sensors(&self) -> impl Iterator<Item = usize> {
        self.radar.into_iter().chain(self.transponder)
    }
}
