//! How good an output is: the metrics of the paper's section 4 and of `docs/EVALUATION.md`, for the fused output and
//! for each input alone.
//!
//! Sans-IO: truth, labels and points in, an [`Evaluation`] out.

mod place;

pub use place::{Offset, Place};

use crate::time::Time;

/// What a point is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PointSource {
    /// Radar and transponder.
    Fused,
    /// Radar alone.
    Radar,
    /// Transponder alone.
    Transponder,
}

/// A point that is to be scored: of the output, a radar's plot, or an interpolated transponder position.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputPoint {
    /// Its time of applicability.
    pub time: Time,
    /// Where it is.
    pub place: Place,
    /// What it is made of.
    pub source: PointSource,
    /// The published track number.
    pub number: u32,
    /// The radar's own number of the track that takes part (I048/161).
    pub radar_track: Option<u16>,
    /// The radar of that track, where the format tells.
    pub sensor: Option<String>,
    /// The number of the transponder that takes part.
    pub transponder: Option<u32>,
}

/// A point and what became of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Its time of applicability.
    pub time: Time,
    /// Where it is.
    pub place: Place,
    /// What it is made of.
    pub source: PointSource,
    /// The published track number.
    pub number: u32,
    /// The drone it belongs to, an index of [`Evaluation::drones`]; `None`: none.
    pub drone: Option<usize>,
    /// From the drone's true place to the point.
    pub error: Option<Offset>,
    /// The drone's true place as the first radar sees it; `None` where no site is known.
    pub seen: Option<Seen>,
}

/// A place as a radar sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Distance over ground, metres.
    pub range_m: f64,
    /// Clockwise from north, degrees, 0 to 360.
    pub azimuth_deg: f64,
}

/// The score of the output and of each input alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// The drones of the truth, in the order of their ids.
    pub drones: Vec<Drone>,
    /// The output.
    pub fused: Scored,
    /// The radars' plots; `None` without a capture.
    pub radar: Option<Scored>,
    /// The interpolated transponders; `None` without a capture.
    pub transponder: Option<Scored>,
}

/// A drone of the truth.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Drone {
    /// Its id in the truth.
    pub id: String,
    /// Whether it carries a transponder; `None` where neither labels nor a capture tell.
    pub equipped: Option<bool>,
}

/// One stream of points with its scores.
#[derive(Clone, Debug, PartialEq)]
pub struct Scored {
    /// Of all drones together.
    pub all: Score,
    /// Of the drones that carry a transponder.
    pub equipped: Score,
    /// Of the drones that carry none.
    pub unequipped: Score,
    /// Of each drone, in the order of [`Evaluation::drones`].
    pub drones: Vec<Score>,
    /// Every point that counts, in order of emission.
    pub samples: Vec<Sample>,
}

/// The metrics of one stream; see [`crate::evaluate`]. What cannot be told (nothing to divide by) is `None`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Score {
    /// Probability of update, percent: slots with at least one point of the drone / slots of its span.
    pub pu_percent: Option<f64>,
    /// Position error, 3-D (horizontal for points without height), metres.
    pub epos: Option<ErrorStatistics>,
    /// Horizontal position error, metres.
    pub eposh: Option<ErrorStatistics>,
    /// Vertical position error, metres.
    pub eposv: Option<ErrorStatistics>,
    /// Position error in slots where the drone's transponder interpolates.
    pub epos_covered: Option<ErrorStatistics>,
    /// Position error in the other slots of an equipped drone.
    pub epos_gap: Option<ErrorStatistics>,
    /// Fused points whose radar track and transponder belong to one drone / all fused points.
    pub precision: Option<f64>,
    /// Slots with such a point / slots in which both inputs of the drone are present.
    pub recall: Option<f64>,
    /// Changes of the published track number a drone and minute.
    pub id_changes: Option<f64>,
    /// Seconds of tracks of no drone a minute; not told for a single drone.
    pub false_track_s: Option<f64>,
    /// Mean GOSPA (p = 2, c = 50 m, alpha = 2), metres; of all drones together only.
    pub gospa_m: Option<f64>,
}

/// Mean and spread of an error, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorStatistics {
    /// How many points.
    pub count: u64,
    /// Mean.
    pub mean_m: f64,
    /// Standard error of the mean: standard deviation / sqrt(count); 0 for a single point.
    pub sem_m: f64,
    /// Median.
    pub p50_m: f64,
    /// 95th percentile.
    pub p95_m: f64,
}
