//! The output: the points of a slot, in either profile.

use nalgebra::{Matrix2, Vector3};
use serde::{Deserialize, Serialize};

use crate::frames::Enu;
use crate::integrity::{Concern, PointIntegrity};
use crate::numbering::NumberChange;
use crate::report::{Aircraft, CameraTrackKey, Identity, Plot, RadarTrackKey, SensorIndex, UasItems};
use crate::slots::Slot;
use crate::time::Time;

/// The output for one slot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Emission {
    /// The slot.
    pub slot: Slot,
    /// Centre of the slot, the time of applicability.
    pub time: Time,
    /// Fused points first, then radar points, transponder points, and points of cameras; each group by track number, equal
    /// numbers by sensor.
    pub points: Vec<Point>,
    /// Changes of transponder numbers in this slot, in order.
    pub numbers: Vec<NumberChange>,
    /// Counts of new identities, for each transponder receiver that has some (`operational` profile).
    pub newcomers: Vec<Newcomers>,
    /// Counts of radar tracks discarded because their numbers jump, for each radar that has some (`operational` profile).
    pub jumping: Vec<JumpingTracks>,
    /// Integrity concerns about transponders at this slot (`operational` profile).
    pub concerns: Vec<Concern>,
    /// Predicted current positions of the aircraft (`operational` profile, if enabled).
    pub now: Option<NowPicture>,
}

/// Predicted positions of aircraft in the slot that opens at a deadline, from everything received before it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NowPicture {
    /// The slot.
    pub slot: Slot,
    /// Centre of the slot, the time of applicability.
    pub time: Time,
    /// Points in the order of [`Emission::points`], with the numbers last published there.
    pub points: Vec<Point>,
}

/// One output point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Track number: T · 10000 + R, R or T.
    pub number: u32,
    /// Position; the height is assumed if [`Source::height_measured`] is false.
    pub position: Enu,
    /// Centre of the first slot that was emitted with this radar track or, if the point has one, with this transponder.
    pub first_seen: Time,
    /// Radar track and transponder of the point.
    pub source: Source,
    /// Velocity and covariance (`operational` profile).
    pub estimate: Option<Estimate>,
    /// Other candidates for the radar track or the transponder, the likeliest first (`operational` profile).
    pub competitors: Vec<Competitor>,
    /// Integrity of the transponder, if the point has one (`operational` profile).
    pub integrity: Option<PointIntegrity>,
    /// Track numbers of points that claim to be the same aircraft at another position (`operational` profile).
    pub disputed: Vec<u32>,
    /// Whether the point is a confirmed drone that only radar detects and that no recently received transponder
    /// explains (`operational` profile).
    pub is_unexplained: bool,
    /// Camera tracks that contribute to the position, by sensor and number (`operational` profile).
    pub cameras: Vec<CameraPart>,
    /// Further transponders of the same aircraft, in the order in which they were first received (`operational`
    /// profile).
    pub also: Vec<TransponderPart>,
}

impl Point {
    /// Creates a point with only a number, a position, the time of first detection and a source.
    pub const fn new(number: u32, position: Enu, first_seen: Time, source: Source) -> Self {
        Self {
            number,
            position,
            first_seen,
            source,
            estimate: None,
            competitors: Vec::new(),
            integrity: None,
            disputed: Vec::new(),
            is_unexplained: false,
            cameras: Vec::new(),
            also: Vec::new(),
        }
    }
}

/// Velocity and covariance of a point's aircraft, in the site's axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Velocity east, north and up, metres a second.
    pub velocity: Vector3<f64>,
    /// Covariance of the position, east and north, m².
    pub horizontal: Matrix2<f64>,
    /// Variance of the height, m².
    pub vertical_m2: f64,
    /// Covariance of the velocity over ground, east and north, m²/s².
    pub velocity_covariance: Matrix2<f64>,
    /// Covariance of the position over ground (rows) with the velocity (columns), m²/s.
    pub position_velocity: Matrix2<f64>,
    /// Covariance of the height with the climb, m²/s.
    pub height_climb: f64,
    /// Variance of the climb, m²/s².
    pub climb_m2s2: f64,
    /// Part of the covariance that is due to doubt in the transponder's integrity: mean of the axes, m².
    pub lie_m2: f64,
    /// Kind of evidence for the position.
    pub basis: Basis,
    /// Time of the latest measurement by any sensor up to the point's time; `None`: the first measurement came later.
    pub last_measurement: Option<Time>,
}

impl Estimate {
    /// Standard deviation of the position over ground: mean of the axes, metres.
    pub fn sigma_m(&self) -> f64 {
        (self.horizontal.trace() / 2.0).max(0.0).sqrt()
    }
}

/// Kind of evidence for a position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Basis {
    /// A measurement within the slot.
    Measured,
    /// Measurements before and after the slot.
    Interpolated,
    /// Measurements only before or only after the slot.
    Extrapolated,
}

/// Sensors of a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Source {
    /// An associated pair; in the `operational` profile also while one of the two is not received.
    Fused(RadarPart, TransponderPart, Association),
    /// A radar track without a transponder.
    Radar(RadarPart),
    /// A transponder without a radar track.
    Transponder(TransponderPart),
    /// Only cameras, at least two, where their lines of sight cross ([`Point::cameras`]; `operational` profile).
    Cameras,
}

/// The radar's contribution to a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RadarPart {
    /// The radar track.
    pub track: RadarTrackKey,
    /// Time of the plot.
    pub time: Time,
    /// Whether the radar measured a height.
    pub height_measured: bool,
    /// Probability that the target is a UAV; `None`: unknown.
    pub uav_probability: Option<f64>,
}

/// A camera's contribution to a point: its bearings give the direction of the aircraft.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CameraPart {
    /// The camera's track.
    pub track: CameraTrackKey,
    /// Time of the latest bearing used, up to the slot's end.
    pub time: Time,
}

/// The transponder's contribution to a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransponderPart {
    /// The transponder's number T.
    pub number: u32,
    /// The transponder's identity.
    pub identity: Identity,
    /// The sensor that last received it; in the `operational` profile, up to the slot's end.
    pub sensor: SensorIndex,
    /// Time of its latest report up to the slot's end (`operational` profile).
    pub time: Option<Time>,
    /// Identifying items as last received.
    pub items: UasItems,
    /// Further reported data on the aircraft.
    pub aircraft: Aircraft,
    /// Whether the transponder reports its height: in its latest report or one of the seconds before. Before its first
    /// report, that first report counts.
    pub height_measured: bool,
}

impl From<&Plot> for RadarPart {
    fn from(plot: &Plot) -> Self {
        Self {
            track: plot.track,
            time: plot.time,
            height_measured: plot.height_measured,
            uav_probability: plot.uav_probability,
        }
    }
}

/// Association of a fused pair.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Association {
    /// Distance between radar and transponder, metres (horizontal if one of them measured no height).
    pub distance_m: f64,
    /// Evidence for the association.
    pub because: AssociationEvidence,
}

/// Evidence for an association.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum AssociationEvidence {
    /// Distance threshold and ratio (`reference` profile).
    Ratio {
        /// The threshold D(ρ), metres.
        threshold_m: f64,
        /// Number of slots with both, and of those within the threshold.
        ratio: SlotRatio,
    },
    /// Likelihood ratio of "one aircraft" to "two aircraft" (`operational` profile).
    Likelihood {
        /// Natural logarithm of the likelihood ratio.
        score: f64,
    },
    /// An operator's correlation (`operational` profile).
    Manual {
        /// Score of the measurements, as for [`AssociationEvidence::Likelihood`]; `None` if the two were never near each other.
        score: Option<f64>,
    },
}

/// Agreement of radar and transponder, from the window's first slot to the point's slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SlotRatio {
    /// Number of slots in which both have a point.
    pub co_present: u32,
    /// Number of these slots in which their distance is within the threshold.
    pub within: u32,
}

impl SlotRatio {
    /// The share of slots within the threshold, 0 to 1.
    pub fn value(&self) -> f64 {
        f64::from(self.within) / f64::from(self.co_present)
    }
}

/// A sensor track that came near a point without being part of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Competitor {
    /// The radar track or transponder.
    pub who: Rival,
    /// Natural logarithm of the likelihood ratio for being part of the point.
    pub score: f64,
    /// Whether an operator has decorrelated it from the point.
    pub decorrelated: bool,
}

/// A candidate for the radar track or the transponder of a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Rival {
    /// Candidate for the radar track of the point's transponder.
    Radar(RadarTrackKey),
    /// Candidate for the transponder of the point's radar track.
    Transponder {
        /// The sensor that last received it.
        sensor: SensorIndex,
        /// Its transponder number, if one is assigned.
        number: Option<u32>,
        /// Its identity.
        identity: Identity,
    },
}

/// New identities of a transponder receiver in a slot, counted by outcome.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Newcomers {
    /// The receiver.
    pub sensor: SensorIndex,
    /// Received for the first time, or for the first time after a long silence.
    pub heard: u32,
    /// Admitted with their second report.
    pub admitted: u32,
    /// Discarded: no second report was received.
    pub heard_once: u32,
    /// Discarded: no two reports agree.
    pub inconsistent: u32,
    /// Discarded: the limit `max_new_per_s` did not admit them in time.
    pub rate_limited: u32,
    /// Discarded early: too many identities were waiting.
    pub crowded_out: u32,
    /// During a flood of new identities: largest number received in one second of it.
    pub flood: Option<u32>,
}

impl Newcomers {
    pub(crate) fn none(sensor: SensorIndex, flood: Option<u32>) -> Self {
        Self {
            sensor,
            heard: 0,
            admitted: 0,
            heard_once: 0,
            inconsistent: 0,
            rate_limited: 0,
            crowded_out: 0,
            flood,
        }
    }

    /// Names of the outcomes on the interfaces, with their counts.
    pub const fn fates(&self) -> [(&'static str, u32); 6] {
        [
            ("heard", self.heard),
            ("admitted", self.admitted),
            ("heard_once", self.heard_once),
            ("inconsistent", self.inconsistent),
            ("rate_limited", self.rate_limited),
            ("crowded_out", self.crowded_out),
        ]
    }
}

/// Radar tracks discarded in a slot because their numbers began again elsewhere, plot after plot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct JumpingTracks {
    /// The radar.
    pub sensor: SensorIndex,
    /// Number of tracks.
    pub discarded: u32,
}

impl Source {
    pub(crate) fn rank(&self) -> u8 {
        match self {
            Self::Fused(..) => 0,
            Self::Radar(_) => 1,
            Self::Transponder(_) => 2,
            Self::Cameras => 3,
        }
    }

    /// Whether the height was measured: by the transponder if the point has one, otherwise by the radar or the cameras. In the
    /// `operational` profile a height may be known from other sensors too; see its variance.
    pub fn height_measured(&self) -> bool {
        match self {
            Self::Radar(radar) => radar.height_measured,
            Self::Fused(_, transponder, _) | Self::Transponder(transponder) => transponder.height_measured,
            Self::Cameras => true,
        }
    }

    /// The radar's contribution, if any.
    pub fn radar(&self) -> Option<&RadarPart> {
        match self {
            Self::Fused(radar, ..) | Self::Radar(radar) => Some(radar),
            Self::Transponder(_) | Self::Cameras => None,
        }
    }

    /// The transponder's contribution, if any.
    pub fn transponder(&self) -> Option<&TransponderPart> {
        match self {
            Self::Fused(_, transponder, _) | Self::Transponder(transponder) => Some(transponder),
            Self::Radar(_) | Self::Cameras => None,
        }
    }
}
