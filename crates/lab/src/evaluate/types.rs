//! Points to be scored, and scores.

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::place::{GeodeticPlace, LocalOffset};
use fusion::Source;
use fusion::integrity::{Reasons, State};
use fusion::point::Estimate;
use fusion::slots::SlotGrid;
use fusion::time::Time;
use picture::{PictureMaker, PictureTrack, serial_text};
use site::config::{Config, Radar};

/// Sources of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PointSource {
    /// Radar and transponder.
    Fused,
    /// Radar alone.
    Radar,
    /// Transponder alone.
    Transponder,
    /// Cameras alone.
    Camera,
}

/// A point to be scored: an output point, a radar's plot, or an interpolated transponder position.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputPoint {
    /// Time of applicability.
    pub time: Time,
    /// Position.
    pub place: GeodeticPlace,
    /// Sources of the point.
    pub source: PointSource,
    /// Published track number.
    pub number: u32,
    /// Track number of the contributing track in the radar (I048/161).
    pub radar_track: Option<u16>,
    /// Radar of that track, if the format names it.
    pub sensor: Option<String>,
    /// The service's number of the contributing transponder.
    pub transponder: Option<u32>,
    /// Name of that transponder's identity: serial number, ICAO address in hexadecimal, ...; `None` if the format does
    /// not state it.
    pub identity: Option<String>,
    /// Covariance of the position; `None` if the output has none, as in every file format.
    pub covariance: Option<Covariance>,
    /// Transponder integrity, and the mark of an aircraft without a transponder.
    pub flags: PointFlags,
}

/// Statements of an output about a point's transponder, or its absence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PointFlags {
    /// Integrity of the transponder, with reasons; `None` if not assessed.
    pub integrity: Option<(State, Reasons)>,
    /// Whether the aircraft flies without a transponder where one would be received.
    pub is_uncooperative: bool,
}

/// Published covariance of a position, in the axes of the site's frame. At 10 km, these are rotated by about a tenth of
/// a degree relative to local east and north, which is negligible here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covariance {
    /// Variance to the east, m².
    pub east_m2: f64,
    /// Variance to the north, m².
    pub north_m2: f64,
    /// Covariance of east and north, m².
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

/// Settings for scoring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scoring {
    /// The slot grid.
    pub grid: SlotGrid,
    /// Position of the first radar; `None` if unknown: errors are then not given over range and azimuth.
    pub site: Option<GeodeticPlace>,
    /// Time from the opening of a slot to its publication.
    pub latency: SignedDuration,
}

impl Scoring {
    /// Settings from the slot grid and the first radar of a configuration.
    pub fn of(config: &Config) -> Self {
        let radar = config.radars().next().map(|(_, radar)| radar);
        let site = |radar: &Radar| GeodeticPlace {
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

/// Slots of 0.25 s, published 6.25 s after they open, without a site.
impl Default for Scoring {
    fn default() -> Self {
        Self { grid: SlotGrid::default(), site: None, latency: SignedDuration::from_millis(6250) }
    }
}

impl OutputPoint {
    /// Point of a track made by `maker`.
    pub fn of_track(track: &PictureTrack, maker: &PictureMaker) -> Self {
        let source = &track.point.source;
        Self {
            time: track.time,
            place: GeodeticPlace {
                latitude_deg: track.position.latitude_deg(),
                longitude_deg: track.position.longitude_deg(),
                altitude_amsl_m: track.altitude_amsl_m,
            },
            source: match source {
                Source::Fused(..) => PointSource::Fused,
                Source::Radar(_) => PointSource::Radar,
                Source::Transponder(_) => PointSource::Transponder,
                Source::Cameras => PointSource::Camera,
            },
            number: track.point.number,
            radar_track: source.radar().map(|part| part.track.number),
            sensor: source.radar().map(|part| maker.sensor(part.track.sensor).to_owned()),
            transponder: source.transponder().map(|part| part.number),
            identity: source.transponder().map(|part| serial_text(part.identity)),
            covariance: track.point.estimate.as_ref().map(Covariance::from),
            flags: PointFlags::of_track(track),
        }
    }
}

impl PointFlags {
    fn of_track(track: &PictureTrack) -> Self {
        Self {
            integrity: track.point.integrity.map(|integrity| (integrity.state, integrity.reasons)),
            is_uncooperative: track.is_uncooperative,
        }
    }
}

/// A scored point.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorSample {
    /// Time of applicability.
    pub time: Time,
    /// Position.
    pub place: GeodeticPlace,
    /// Sources of the point.
    pub source: PointSource,
    /// Published track number.
    pub number: u32,
    /// Drone of the point, an index into [`Evaluation::drones`]; `None`: not a drone.
    pub drone: Option<usize>,
    /// Error: from the drone's true position to the point.
    pub error: Option<LocalOffset>,
    /// True position of the drone as seen from the first radar; `None` if unknown.
    pub seen: Option<PolarPlace>,
}

/// A position in a radar's polar coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarPlace {
    /// Ground range, metres.
    pub range_m: f64,
    /// Azimuth, clockwise from north, degrees, 0 to 360.
    pub azimuth_deg: f64,
}

/// Scores of the output and of each input alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Drones of the truth, in the order of their ids.
    pub drones: Vec<TrueDrone>,
    /// The output.
    pub fused: ScoredStream,
    /// The radars' plots alone; `None` without a capture.
    pub radar: Option<ScoredStream>,
    /// Interpolated transponder positions alone; `None` without a capture.
    pub transponder: Option<ScoredStream>,
}

/// A drone of the truth.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TrueDrone {
    /// Id in the truth.
    pub id: String,
    /// Whether the drone carries a transponder; `None` without labels and without a capture.
    pub equipped: Option<bool>,
}

/// A stream of points and its scores.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoredStream {
    /// Score of all drones together.
    pub all: StreamMetrics,
    /// Score of the drones with a transponder.
    pub equipped: StreamMetrics,
    /// Score of the drones without a transponder.
    pub unequipped: StreamMetrics,
    /// Score of each drone, in the order of [`Evaluation::drones`].
    pub drones: Vec<StreamMetrics>,
    /// Every point that counts, in order of emission.
    pub samples: Vec<ErrorSample>,
}

/// Metrics of one stream (`docs/METRICS.md`). A metric without data (nothing to divide by) is `None`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StreamMetrics {
    /// Probability of update, percent: slots with at least one point of the drone / slots of its span.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pu_percent: Option<f64>,
    /// Probability of update in slots where the drone's transponder interpolates, percent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pu_covered_percent: Option<f64>,
    /// Probability of update in slots where an equipped drone's transponder does not interpolate, percent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pu_gap_percent: Option<f64>,
    /// Share of the slots without an interpolated transponder position that have a point within 50 m of the drone,
    /// percent.
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
    /// Position error in slots where the drone's transponder interpolates, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epos_covered: Option<ErrorStatistics>,
    /// Position error in slots where an equipped drone's transponder does not interpolate, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epos_gap: Option<ErrorStatistics>,
    /// Position error in slots where one radar alone has a plot of the drone, of a track that is not seduced, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epos_one_radar: Option<ErrorStatistics>,
    /// Position error in slots where several radars have such a plot of the drone, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epos_radars: Option<ErrorStatistics>,
    /// Consistency of the published covariances, over all points that have one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees: Option<Nees>,
    /// Consistency in slots where the drone's transponder interpolates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees_covered: Option<Nees>,
    /// Consistency in slots where an equipped drone's transponder does not interpolate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees_gap: Option<Nees>,
    /// Consistency of points whose drone flies straight on or hovers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees_straight: Option<Nees>,
    /// Consistency of points whose drone turns faster than 4 degrees per second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees_turning: Option<Nees>,
    /// Consistency of points whose radar track is seduced, away from its drone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees_walked_off: Option<Nees>,
    /// Fused points whose radar track and transponder belong to one drone / all fused points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub precision: Option<f64>,
    /// Slots with a correctly fused point / slots in which both inputs of the drone are present.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recall: Option<f64>,
    /// Changes of the published track number per drone and minute.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id_changes: Option<f64>,
    /// Share of the drones' slots in which one drone has more than one published number, percent; output only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub two_numbers_percent: Option<f64>,
    /// Ghosts, seconds per minute: points of a radar alone beside a drone that is published by its transponder; output
    /// only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ghosts_s: Option<f64>,
    /// False tracks, seconds per minute; all drones together only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub false_track_s: Option<f64>,
    /// Mean GOSPA (p = 2, c = 50 m, alpha = 2), metres; all drones together only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gospa_m: Option<f64>,
    /// Components of the mean GOSPA.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gospa_parts: Option<GospaParts>,
}

/// Components of the mean GOSPA, over its slots.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GospaParts {
    /// Number of slots.
    pub slots: u64,
    /// Root mean square distance of matched truths and points, metres; `None` if none is matched.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub localisation_rms_m: Option<f64>,
    /// Mean number of truths with a point.
    pub matched: f64,
    /// Mean number of truths without a point.
    pub missed: f64,
    /// Mean number of points without a truth.
    pub unmatched: f64,
}

/// Normalised estimation error squared over its degrees of freedom: 1 for consistent covariances, above 1 if
/// covariances are too small, below 1 if they are too large.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Nees {
    /// Number of points.
    pub count: u64,
    /// Mean of eᵀ P⁻¹ e / 2 over ground.
    pub horizontal: f64,
    /// Mean of e² / P in height; `None` without heights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertical: Option<f64>,
    /// Share of points whose error over ground exceeds 3.7 standard deviations, percent.
    pub beyond_percent: f64,
    /// Share of points whose error in height exceeds 3.7 standard deviations, percent; `None` without heights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertical_beyond_percent: Option<f64>,
}

/// Statistics of an error, metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorStatistics {
    /// Number of points.
    pub count: u64,
    /// Mean, metres.
    pub mean_m: f64,
    /// Standard error of the mean, metres: standard deviation / sqrt(count); 0 for a single point.
    pub sem_m: f64,
    /// Median, metres.
    pub p50_m: f64,
    /// 95th percentile, metres.
    pub p95_m: f64,
}
