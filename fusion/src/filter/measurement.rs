//! What is measured of one target, and its state by that.

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
    /// When.
    pub time: Time,
    /// Where.
    pub position: Enu,
    /// Whether the height was measured.
    pub height_measured: bool,
    /// Velocity over ground, east and north, and the standard deviation of each, m/s. Not finite: not used.
    pub velocity: Option<(Vector2<f64>, f64)>,
    /// Rate of climb and its standard deviation, m/s. Not finite: not used.
    pub climb: Option<(f64, f64)>,
    /// By what.
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

    /// Whether it does not say where over ground the target is: no more than on which line, or how high.
    pub fn is_partial(&self) -> bool {
        matches!(self.by, By::Camera { .. } | By::Height { .. })
    }
}

/// What measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum By {
    /// A transponder, with the standard deviations of its reports, metres.
    Transponder {
        /// Over ground, each axis.
        horizontal_m: f64,
        /// In height.
        vertical_m: f64,
    },
    /// A track of a radar.
    Radar {
        /// Whose bias it carries.
        owner: Owner,
        /// Prior of that bias.
        known: Bias,
        /// The radar's line of sight.
        seen: LineOfSight,
        /// Its errors.
        errors: RadarErrors,
    },
    /// A camera: the target is on a line.
    Camera {
        /// The camera.
        sensor: SensorIndex,
        /// Unit vector across the line, over ground.
        clockwise: Vector2<f64>,
        /// Standard deviation across the line, metres.
        across_m: f64,
        /// In height.
        height_m: f64,
    },
    /// A radar's height of what a transponder locates that does not say its own.
    Height {
        /// The radar.
        sensor: SensorIndex,
        /// Standard deviation, metres.
        sigma_m: f64,
    },
}

/// Whose bias: a radar track, and since when it has been the source of the position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Owner {
    /// The radar.
    pub radar: SensorIndex,
    /// Tells its radar tracks apart: when one began, and its number.
    pub tracklet: (Time, u16),
    /// The last report of a transponder before; `None`: there was none.
    pub since: Option<Time>,
}

/// State of a target: position, velocity, covariance.
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
    /// Time since the last measurement, seconds; `None`: there was none, it is extrapolated backward.
    pub since_s: Option<f64>,
    /// Time to the next measurement, seconds; `None`: there is none, it is extrapolated.
    pub until_s: Option<f64>,
}

impl StateEstimate {
    /// Standard deviation over ground, metres: of each axis in the mean.
    pub fn sigma_m(&self) -> f64 {
        (self.horizontal.trace() / 2.0).max(0.0).sqrt()
    }
}
