//! The points that are scored, and the scores.

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::place::{Offset, Place};
use crate::config::{Config, Radar};
use crate::picture::{PictureMaker, PictureTrack, serial_text};
use fusion::Source;
use fusion::integrity::{Reasons, State};
use fusion::point::Estimate;
use fusion::slots::SlotGrid;
use fusion::time::Time;

/// What a point is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PointSource {
    /// Radar and transponder.
    Fused,
    /// Radar alone.
    Radar,
    /// Transponder alone.
    Transponder,
}

/// A point to be scored: of the output, a radar's plot, or an interpolated transponder position.
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
    /// The radar's own number of the contributing track (I048/161).
    pub radar_track: Option<u16>,
    /// The radar of that track, where the format names it.
    pub sensor: Option<String>,
    /// The service's number of the contributing transponder.
    pub transponder: Option<u32>,
    /// The name of that transponder's identity: serial number, ICAO address in hexadecimal, ...; `None` where the format does
    /// not state it.
    pub identity: Option<String>,
    /// Covariance of its position; `None` where the output has none, as in every file format.
    pub covariance: Option<Covariance>,
    /// What the output says of its transponder, or for want of one.
    pub flags: Flags,
}

/// What an output says of a point's transponder, or for want of one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    /// Whether the transponder can be trusted, and what speaks against it; `None` where that is not judged.
    pub integrity: Option<(State, Reasons)>,
    /// Whether the aircraft flies without a transponder where one would be heard.
    pub is_uncooperative: bool,
}

/// The covariance that the output states for a position, in the axes of the site's frame. At 10 km these are turned by
/// about a tenth of a degree against local east and north, which is negligible here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covariance {
    /// Variance to the east, m².
    pub east_m2: f64,
    /// Variance to the north, m².
    pub north_m2: f64,
    /// Covariance of the two, m².
    pub east_north_m2: f64,
    /// Variance of the height, m².
    pub vertical_m2: f64,
}

impl From<&Estimate> for Covariance {
    fn from(estimate: &Estimate) -> Self {
        let plane = &estimate.horizontal;
        Self {
            east_m2: plane[(0, 0)],
            north_m2: plane[(1, 1)],
            east_north_m2: plane[(0, 1)],
            vertical_m2: estimate.vertical_m2,
        }
    }
}

/// What scoring needs besides the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scoring {
    /// The slot grid.
    pub grid: SlotGrid,
    /// The first radar's position; `None` if unknown: errors are then not given over range and azimuth.
    pub site: Option<Place>,
    /// From the opening of a slot to its publication.
    pub latency: SignedDuration,
}

impl Scoring {
    /// The slot grid and the first radar of a configuration.
    pub fn of(config: &Config) -> Self {
        let radar = config.radars().next().map(|(_, radar)| radar);
        let site = |radar: &Radar| Place {
            latitude_deg: radar.latitude_deg,
            longitude_deg: radar.longitude_deg,
            altitude_amsl_m: Some(radar.height_amsl_m),
        };
        Self {
            grid: SlotGrid::new(config.fusion.slot),
            site: radar.map(site),
            latency: config.fusion.latency(),
        }
    }
}

/// Slots of 0.25 s, published 6.25 s after they open, and no site.
impl Default for Scoring {
    fn default() -> Self {
        Self { grid: SlotGrid::default(), site: None, latency: SignedDuration::from_millis(6250) }
    }
}

impl OutputPoint {
    /// The point of a track that `maker` made.
    pub fn of_track(track: &PictureTrack, maker: &PictureMaker) -> Self {
        let source = &track.point.source;
        Self {
            time: track.time,
            place: Place {
                latitude_deg: track.position.latitude_deg(),
                longitude_deg: track.position.longitude_deg(),
                altitude_amsl_m: track.altitude_amsl_m,
            },
            source: match source {
                Source::Fused(..) => PointSource::Fused,
                Source::Radar(_) => PointSource::Radar,
                Source::Transponder(_) => PointSource::Transponder,
            },
            number: track.point.number,
            radar_track: source.radar().map(|part| part.track.number),
            sensor: source.radar().map(|part| maker.sensor(part.track.sensor).to_owned()),
            transponder: source.transponder().map(|part| part.number),
            identity: source.transponder().map(|part| serial_text(part.identity)),
            covariance: track.point.estimate.as_ref().map(Covariance::from),
            flags: Flags::of_track(track),
        }
    }
}

impl Flags {
    fn of_track(track: &PictureTrack) -> Self {
        Self {
            integrity: track.point.integrity.map(|integrity| (integrity.state, integrity.reasons)),
            is_uncooperative: track.is_uncooperative,
        }
    }
}

/// A scored point.
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
    /// The drone it belongs to, an index into [`Evaluation::drones`]; `None` if it belongs to none.
    pub drone: Option<usize>,
    /// From the drone's true place to the point.
    pub error: Option<Offset>,
    /// The drone's true position as seen from the first radar; `None` where that is unknown.
    pub seen: Option<PolarPlace>,
}

/// A position in a radar's polar coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarPlace {
    /// Ground range, metres.
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
    /// The radars' plots alone; `None` without a capture.
    pub radar: Option<Scored>,
    /// The interpolated transponders alone; `None` without a capture.
    pub transponder: Option<Scored>,
}

/// A drone of the truth.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Drone {
    /// Its id in the truth.
    pub id: String,
    /// Whether it carries a transponder; `None` where neither labels nor a capture say.
    pub equipped: Option<bool>,
}

/// A stream of points and its scores.
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

/// The metrics of one stream (`docs/METRICS.md`). A metric without data (nothing to divide by) is `None`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Score {
    /// Probability of update, percent: slots with at least one point of the drone / slots of its span.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pu_percent: Option<f64>,
    /// Probability of update in slots where the drone's transponder interpolates, percent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pu_covered_percent: Option<f64>,
    /// Probability of update in the other slots of an equipped drone, percent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pu_gap_percent: Option<f64>,
    /// Share of those other slots with a point of the drone within 50 m of it, percent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap_within_50_m_percent: Option<f64>,
    /// Position error, 3-D (horizontal for points without height), metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epos: Option<ErrorStatistics>,
    /// Horizontal position error, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eposh: Option<ErrorStatistics>,
    /// Vertical position error, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eposv: Option<ErrorStatistics>,
    /// Position error in slots where the drone's transponder interpolates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epos_covered: Option<ErrorStatistics>,
    /// Position error in the other slots of an equipped drone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epos_gap: Option<ErrorStatistics>,
    /// Position error in slots where one radar alone has a plot of the drone, of a track that is not seduced.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epos_one_radar: Option<ErrorStatistics>,
    /// Position error in slots where several radars have one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epos_radars: Option<ErrorStatistics>,
    /// Consistency of the stated covariances, over all points that state one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees: Option<Nees>,
    /// Consistency in slots where the drone's transponder interpolates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees_covered: Option<Nees>,
    /// Consistency in the other slots of an equipped drone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees_gap: Option<Nees>,
    /// Consistency of points whose drone flies straight on or stands.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees_straight: Option<Nees>,
    /// Consistency of points whose drone turns faster than 4 degrees a second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees_turning: Option<Nees>,
    /// Consistency of points whose radar track has walked off its drone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees_walked_off: Option<Nees>,
    /// Fused points whose radar track and transponder belong to one drone / all fused points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub precision: Option<f64>,
    /// Slots with such a point / slots in which both inputs of the drone are present.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recall: Option<f64>,
    /// Changes of the published track number per drone and minute.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id_changes: Option<f64>,
    /// Share of the drones' slots in which one is published under more than one number, percent; of the output only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub two_numbers_percent: Option<f64>,
    /// Seconds a minute of points of a radar alone beside a drone that is published by its transponder; of the output only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ghosts_s: Option<f64>,
    /// Seconds of false tracks per minute; of all drones together only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub false_track_s: Option<f64>,
    /// Mean GOSPA (p = 2, c = 50 m, alpha = 2), metres; of all drones together only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gospa_m: Option<f64>,
    /// The components of that mean.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gospa_parts: Option<GospaParts>,
}

/// The components of the mean GOSPA, over its slots.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GospaParts {
    /// Number of slots.
    pub slots: u64,
    /// Root mean square distance of matched truths and points, metres; `None` where none is matched.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub localisation_rms_m: Option<f64>,
    /// Mean number of truths with a point.
    pub matched: f64,
    /// Mean number of truths without a point.
    pub missed: f64,
    /// Mean number of points without a truth.
    pub unmatched: f64,
}

/// Normalised estimation error squared over its degrees of freedom: 1 for consistent covariances, more where they are
/// too small, less where they are too large.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Nees {
    /// Number of points.
    pub count: u64,
    /// Mean of eᵀ P⁻¹ e / 2 over ground.
    pub horizontal: f64,
    /// Mean of e² / P in height; `None` without heights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertical: Option<f64>,
}

/// Statistics of an error, metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorStatistics {
    /// Number of points.
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
