//! What is published for a slot, whichever the profile.

use nalgebra::{Matrix2, Vector3};
use serde::{Deserialize, Serialize};

use crate::frames::Enu;
use crate::integrity::{Concern, PointIntegrity};
use crate::numbering::NumberChange;
use crate::report::{Aircraft, CameraTrackKey, Identity, Plot, RadarTrackKey, SensorIndex, UasItems};
use crate::slots::Slot;
use crate::time::Time;

/// Everything published for one slot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Emission {
    /// The slot.
    pub slot: Slot,
    /// Its centre, the time of applicability.
    pub time: Time,
    /// Fused, then radar, then transponder; each by track number, equal numbers by sensor.
    pub points: Vec<Point>,
    /// What became of transponder numbers with this slot, in the order in which it did.
    pub numbers: Vec<NumberChange>,
    /// What became of new identities, a transponder receiver each that has some (`operational` profile).
    pub newcomers: Vec<Newcomers>,
    /// What is wrong with transponders at this slot (`operational` profile).
    pub concerns: Vec<Concern>,
    /// Where its aircraft are by now (`operational` profile, where that is set).
    pub now: Option<NowPicture>,
}

/// Where aircraft are predicted to be in the slot that opens with a deadline, by everything that was received before.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NowPicture {
    /// The slot.
    pub slot: Slot,
    /// Its centre, the time of applicability.
    pub time: Time,
    /// In the order of [`Emission::points`], and under the numbers that they were last published with there.
    pub points: Vec<Point>,
}

/// One output point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Track number: T · 10000 + R, R or T.
    pub number: u32,
    /// Position; its height is an assumed one where [`Source::height_measured`] is false.
    pub position: Enu,
    /// Centre of the first slot that was emitted with this radar track or, where it takes part, this transponder.
    pub first_seen: Time,
    /// What it is made of.
    pub source: Source,
    /// How it moves and how well that is known (`operational` profile).
    pub estimate: Option<Estimate>,
    /// Who else its radar track or its transponder could be, the likeliest first (`operational` profile).
    pub competitors: Vec<Competitor>,
    /// Whether its transponder can be trusted, where it has one (`operational` profile).
    pub integrity: Option<PointIntegrity>,
    /// Track numbers of the points that claim to be the same aircraft elsewhere (`operational` profile).
    pub disputed: Vec<u32>,
    /// A confirmed drone seen by radar alone that no transponder heard lately explains (`operational` profile).
    pub is_unexplained: bool,
    /// The cameras' tracks that its position rests on as well, by sensor and number (`operational` profile).
    pub cameras: Vec<CameraPart>,
}

impl Point {
    /// One of which no more is known than where it is and since when, and what it is made of.
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
        }
    }
}

/// Velocity and covariance of a point's aircraft, in the site's axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// East, north, up, metres a second.
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
    /// What of the covariance is there only because the transponder is believed no more: mean of the axes, m².
    pub lie_m2: f64,
    /// What the position rests on.
    pub basis: Basis,
    /// The latest measurement, of whichever sensor, up to the point's time; `None`: it was measured only later.
    pub last_measurement: Option<Time>,
}

impl Estimate {
    /// Standard deviation of the position over ground: mean of the axes, metres.
    pub fn sigma_m(&self) -> f64 {
        (self.horizontal.trace() / 2.0).max(0.0).sqrt()
    }
}

/// What a position rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Basis {
    /// A measurement within the slot.
    Measured,
    /// Measurements before and after it.
    Interpolated,
    /// Measurements before it alone, or after it alone.
    Extrapolated,
}

/// What a point is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Source {
    /// An associated pair; in the `operational` profile also while one of the two is silent.
    Fused(RadarPart, TransponderPart, Association),
    /// A radar track that no transponder explains.
    Radar(RadarPart),
    /// A transponder that no radar track confirms.
    Transponder(TransponderPart),
}

/// The radar's part in a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RadarPart {
    /// The radar track.
    pub track: RadarTrackKey,
    /// Time of the plot.
    pub time: Time,
    /// Whether the radar measured a height.
    pub height_measured: bool,
    /// Probability that it is a UAV; `None` unknown.
    pub uav_probability: Option<f64>,
}

/// A camera's part in a point: its bearings say in which direction that is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CameraPart {
    /// The camera's track.
    pub track: CameraTrackKey,
    /// Time of its latest bearing that is used, up to the slot's end.
    pub time: Time,
}

/// The transponder's part in a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransponderPart {
    /// Its number T.
    pub number: u32,
    /// Who it is.
    pub identity: Identity,
    /// The sensor that received it last; in the `operational` profile, up to the slot's end.
    pub sensor: SensorIndex,
    /// Its latest report up to the slot's end (`operational` profile).
    pub time: Option<Time>,
    /// Its identifying items as last received.
    pub items: UasItems,
    /// What else it says of its aircraft.
    pub aircraft: Aircraft,
    /// Whether it states its height: its latest report, one of the seconds before that, or, before its first report, that one.
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

/// Why a pair was fused.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Association {
    /// Distance between the two, metres (horizontal where one of them measured no height).
    pub distance_m: f64,
    /// What it rests on.
    pub because: Because,
}

/// What an association rests on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Because {
    /// Distance threshold and ratio (`reference` profile).
    Ratio {
        /// The threshold D(ρ), metres.
        threshold_m: f64,
        /// The slots within it.
        ratio: SlotRatio,
    },
    /// Likelihood ratio of "one aircraft" to "two" (`operational` profile).
    Likelihood {
        /// Its natural logarithm.
        score: f64,
    },
    /// An operator has said so (`operational` profile).
    Manual {
        /// What the measurements say, as for [`Because::Likelihood`]; `None` where the two were never near each other.
        score: Option<f64>,
    },
}

/// How often the two of a pair agreed, from the window's first slot to the point's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SlotRatio {
    /// Slots where both have a point.
    pub co_present: u32,
    /// Slots among them where their distance is within the threshold.
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
    /// Who.
    pub who: Rival,
    /// Natural logarithm of the likelihood ratio for its being part of the point.
    pub score: f64,
    /// An operator has said that it is not.
    pub decorrelated: bool,
}

/// What could take a part of a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Rival {
    /// A radar track that could be its transponder's.
    Radar(RadarTrackKey),
    /// A transponder that its radar track could be.
    Transponder {
        /// The sensor that received it last.
        sensor: SensorIndex,
        /// Its number, where it has one by now.
        number: Option<u32>,
        /// Who it is.
        identity: Identity,
    },
}

/// Fates of the new identities of a transponder receiver in a slot: how many of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Newcomers {
    /// The receiver.
    pub sensor: SensorIndex,
    /// Heard for the first time, or for the first time after a long silence.
    pub heard: u32,
    /// Admitted, with their second report.
    pub admitted: u32,
    /// Forgotten: there was no second report.
    pub heard_once: u32,
    /// Forgotten: no two of their reports agree.
    pub inconsistent: u32,
    /// Forgotten: they could have been admitted, but for the limit `max_new_per_s`.
    pub rate_limited: u32,
    /// Forgotten before their time: too many waited.
    pub crowded_out: u32,
    /// During a flood of new identities: the most heard in one second of it.
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

    /// The fates, each with its name on the interfaces and its count.
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

impl Source {
    pub(crate) fn rank(&self) -> u8 {
        match self {
            Self::Fused(..) => 0,
            Self::Radar(_) => 1,
            Self::Transponder(_) => 2,
        }
    }

    /// Whether the point's height was measured by who says where it is: its transponder, where it has one, else its radar. In
    /// the `operational` profile a height may be known all the same, by its variance.
    pub fn height_measured(&self) -> bool {
        match self {
            Self::Radar(radar) => radar.height_measured,
            Self::Fused(_, transponder, _) | Self::Transponder(transponder) => transponder.height_measured,
        }
    }

    /// The radar's part, if it has one.
    pub fn radar(&self) -> Option<&RadarPart> {
        match self {
            Self::Fused(radar, ..) | Self::Radar(radar) => Some(radar),
            Self::Transponder(_) => None,
        }
    }

    /// The transponder's part, if it has one.
    pub fn transponder(&self) -> Option<&TransponderPart> {
        match self {
            Self::Fused(_, transponder, _) | Self::Transponder(transponder) => Some(transponder),
            Self::Radar(_) => None,
        }
    }
}
