//! Targets and detections of a simulated radar.

use crate::motion::FlightPath;
use crate::scenario::{Radar, Span};

/// A radar's report of a target, with errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadarDetection {
    /// Time of detection since take-off, s.
    pub time_s: f64,
    /// Time stamp by the radar's clock, s since take-off.
    pub stamped_s: f64,
    /// Index of the target among the radar's targets.
    pub target: usize,
    /// Track number.
    pub number: u16,
    /// Slant range, metres.
    pub range_m: f64,
    /// Azimuth, degrees, 0 to 360.
    pub azimuth_deg: f64,
    /// Height above mean sea level, metres.
    pub altitude_amsl_m: f64,
    /// Probability that the target is a UAV.
    pub uav_probability: f64,
    /// Velocity east and north, m/s.
    pub velocity: (f64, f64),
    /// Whether the track is seduced, away from its target.
    pub seduced: bool,
}

/// An object that a radar may detect.
#[derive(Clone, Debug)]
pub struct RadarTarget {
    /// Number in the random streams; from [`OTHERS`] on for objects other than drones.
    pub number: usize,
    /// Path of the object.
    pub path: FlightPath,
    /// Number of the drone; `None` for other objects.
    pub drone: Option<usize>,
    /// Mean UAV probability of an object other than a drone; 0: always exactly 0.
    pub uav_probability: f64,
    /// Intervals in which the object can be detected, s since take-off; `None`: always.
    pub exists_s: Option<Vec<Span>>,
}

impl RadarTarget {
    pub(crate) fn exists(&self, time_s: f64) -> bool {
        let spans = self.exists_s.as_deref();
        spans.is_none_or(|spans| spans.iter().any(|span| (span.low..span.high).contains(&time_s)))
    }
}

/// Number of the first target other than a drone, so that adding a drone leaves these unchanged.
pub const OTHERS: usize = 1 << 16;

/// Reading of the radar's clock at `time_s`; both in seconds since take-off.
pub fn clock_s(radar: &Radar, time_s: f64) -> f64 {
    time_s + radar.clock_s + radar.clock_drift_ms_s * 1e-3 * time_s
}
