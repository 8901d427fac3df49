//! What is measured of one target, and its state by that.

use nalgebra::{Matrix2, Vector2, Vector3};

use super::bias::Bias;
use super::errors::{LineOfSight, RadarErrors};
use super::imm::Gaussian;
use crate::frames::Enu;
use crate::time::Time;

/// Something that was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// When.
    pub time: Time,
    /// Where.
    pub position: Enu,
    /// Whether the height was measured.
    pub height_measured: bool,
    /// Velocity over ground at that time, east and north, and the standard deviation of each; metres a second. One that is
    /// no number is not used.
    pub velocity: Option<(Vector2<f64>, f64)>,
    /// Rate of climb, and its standard deviation; metres a second. The same.
    pub climb: Option<(f64, f64)>,
    /// By what.
    pub by: By,
}

/// What measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum By {
    /// A transponder; deviations of its position over ground and in height from report to report, metres.
    Transponder {
        /// Over ground, each axis.
        horizontal_m: f64,
        /// In height.
        vertical_m: f64,
    },
    /// A track of a radar.
    Radar {
        /// Another one has another slow error.
        owner: Owner,
        /// What is known of that before.
        known: Bias,
        /// How the radar sees the place.
        seen: LineOfSight,
        /// Its errors.
        errors: RadarErrors,
    },
}

/// Whose slow error: a radar track, since when it has been the source of the position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Owner {
    /// Tells radar tracks apart.
    pub tracklet: u64,
    /// The last report of a transponder before; `None`: there was none.
    pub since: Option<Time>,
}

/// Where a target is, and how it moves.
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
    /// How long ago the last measurement was, seconds; `None`: nothing was measured earlier, it is extrapolated backward.
    pub since_s: Option<f64>,
    /// How long it is to the next one, seconds; `None`: nothing was measured later, it is extrapolated.
    pub until_s: Option<f64>,
}

impl StateEstimate {
    /// Of a state over ground and one above it. `jumped`: see [`super::filter`].
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
