//! What is measured of one target, and its state by that.

use nalgebra::{Matrix2, Vector2, Vector3};

use super::bias::Bias;
use super::errors::{LineOfSight, RadarErrors};
use super::imm::Gaussian;
use crate::frames::Enu;
use crate::time::Time;

/// One measurement of a target.
#[derive(Clone, Copy, Debug, PartialEq)]
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

/// What measured.
#[derive(Clone, Copy, Debug, PartialEq)]
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
}

/// Whose bias: a radar track, and since when it has been the source of the position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Owner {
    /// Tells radar tracks apart.
    pub tracklet: u64,
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
    /// Time since the last measurement, seconds; `None`: there was none, it is extrapolated backward.
    pub since_s: Option<f64>,
    /// Time to the next measurement, seconds; `None`: there is none, it is extrapolated.
    pub until_s: Option<f64>,
}

impl StateEstimate {
    /// Of a state over ground and one above it. `jumped`: see [`super::smoother`].
    pub(super) fn of<const P: usize, const H: usize>(
        plane: &Gaussian<P>,
        height: &Gaussian<H>,
        jumped: Vector2<f64>,
        since_s: Option<f64>,
        until_s: Option<f64>,
    ) -> Self {
        Self {
            position: Enu::new(plane.mean[0], plane.mean[1], height.mean[0]),
            velocity: Vector3::new(plane.mean[2], plane.mean[3], height.mean[1]),
            horizontal: plane.covariance.fixed_view::<2, 2>(0, 0) + jumped * jumped.transpose(),
            vertical: height.covariance[(0, 0)],
            velocity_covariance: plane.covariance.fixed_view::<2, 2>(2, 2).into_owned(),
            since_s,
            until_s,
        }
    }

    /// Standard deviation over ground, metres: of each axis in the mean.
    pub fn sigma_m(&self) -> f64 {
        (self.horizontal.trace() / 2.0).max(0.0).sqrt()
    }
}
