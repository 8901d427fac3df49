//! Measurements of one target, and its estimated state.

use nalgebra::{Matrix2, Vector2, Vector3};
use serde::{Deserialize, Serialize};

use super::bias::Bias;
use super::errors::{LineOfSight, RadarErrors};
use crate::frames::Enu;
use crate::report::SensorIndex;
use crate::time::Time;

/// One measurement of a target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Time of the measurement.
    pub time: Time,
    /// Measured position.
    pub position: Enu,
    /// Whether the height was measured.
    pub height_measured: bool,
    /// Velocity over ground, east and north, and the standard deviation of each, m/s. Values that are not finite are
    /// ignored.
    pub velocity: Option<(Vector2<f64>, f64)>,
    /// Rate of climb and its standard deviation, m/s. Values that are not finite are ignored.
    pub climb: Option<(f64, f64)>,
    /// Sensor of the measurement.
    pub by: By,
}

impl Measurement {
    /// The radar or camera that measured it; `None`: a transponder.
    pub fn sensor(&self) -> Option<SensorIndex> {
        match &self.by {
            By::Transponder { .. } => None,
            By::Radar { owner, .. } => Some(owner.radar),
            By::Camera { sensor, .. } | By::Height { sensor, .. } => Some(*sensor),
        }
    }

    /// Whether the measurement has no full position over ground, but only a line or a height.
    pub fn is_partial(&self) -> bool {
        matches!(self.by, By::Camera { is_crossed: false, .. } | By::Height { .. })
    }
}

/// Sensor of a measurement, with its errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum By {
    /// A transponder, with the standard deviations of its reports, metres.
    Transponder {
        /// Standard deviation of each axis over ground, metres.
        horizontal_m: f64,
        /// Standard deviation in height, metres.
        vertical_m: f64,
    },
    /// A track of a radar.
    Radar {
        /// Radar track whose bias the measurement contains.
        owner: Owner,
        /// Prior of that bias.
        known: Bias,
        /// The radar's line of sight.
        seen: LineOfSight,
        /// The radar's errors.
        errors: RadarErrors,
    },
    /// A camera, which measures a line through the target.
    Camera {
        /// The camera.
        sensor: SensorIndex,
        /// Whether another camera looks from another side at about that time, so that together they measure the position.
        is_crossed: bool,
        /// Unit vector across the line, over ground.
        clockwise: Vector2<f64>,
        /// Standard deviation across the line, metres.
        across_m: f64,
        /// Standard deviation in height, metres.
        height_m: f64,
    },
    /// Only the height, measured by a radar, of a target whose transponder reports no height.
    Height {
        /// The radar.
        sensor: SensorIndex,
        /// Standard deviation, metres.
        sigma_m: f64,
    },
}

/// Identifies a bias: a radar track, and since when it has been the source of the position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Owner {
    /// The radar.
    pub radar: SensorIndex,
    /// Identifies the radar's tracklet: the time of its start, and its number.
    pub tracklet: (Time, u16),
    /// Time of the last transponder report before the tracklet became the source; `None`: there was none.
    pub since: Option<Time>,
}

/// Estimated state of a target: position, velocity, covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateEstimate {
    /// Position.
    pub position: Enu,
    /// Velocity east, north, up, metres a second.
    pub velocity: Vector3<f64>,
    /// Covariance of the position over ground, m².
    pub horizontal: Matrix2<f64>,
    /// Variance of the height, m².
    pub vertical: f64,
    /// Covariance of the velocity over ground, east and north, m²/s².
    pub velocity_covariance: Matrix2<f64>,
    /// Covariance of the position over ground (rows) with the velocity (columns), m²/s.
    pub position_velocity: Matrix2<f64>,
    /// Covariance of the height with the climb, m²/s.
    pub height_climb: f64,
    /// Variance of the climb, m²/s².
    pub climb: f64,
    /// Time since the last measurement, seconds; `None`: there was none, and the state is extrapolated backward.
    pub since_s: Option<f64>,
    /// Time to the next measurement, seconds; `None`: there is none, and the state is extrapolated forward.
    pub until_s: Option<f64>,
}

impl StateEstimate {
    /// Standard deviation over ground, mean of the axes, metres.
    pub fn sigma_m(&self) -> f64 {
        (self.horizontal.trace() / 2.0).max(0.0).sqrt()
    }
}
