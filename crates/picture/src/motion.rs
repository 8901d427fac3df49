//! Published velocity and accuracy of a track; only for a track with an estimate.

use nalgebra::{Matrix2, Vector3};
use serde::{Deserialize, Serialize};

use super::accuracy::{self, AccuracyClass, HALF, HORIZONTAL, MOST, SPEED, VERTICAL};
use fusion::Enu;
use fusion::frames::{Geodetic, TangentPlane};
use fusion::point::{Basis, Estimate};
use fusion::time::Time;

/// Minimum speed with a direction, in metres per second.
const SLOWEST: f64 = 0.5;
/// Number of standard deviations that contain 95 % of a normal error in one dimension.
const MOST_OF_A_LINE: f64 = 1.96;
/// Squared Mahalanobis distance that contains 95 % of the errors in a plane: -2 ln 0.05.
const MOST_OF_A_PLANE: f64 = 5.991;

/// Velocity of a track, and the accuracy of velocity and position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PublishedMotion {
    /// Velocity east, north and up at the track's position, in metres per second.
    pub velocity: Vector3<f64>,
    /// Direction over ground, in degrees true, 0 to 360; `None` if it is uncertain.
    pub track_deg: Option<f64>,
    /// Radius that contains 50 % of the horizontal errors, in metres.
    pub half_h_m: f64,
    /// Radius that contains 95 % of the horizontal errors, in metres.
    pub accuracy_h_m: f64,
    /// Bound of 95 % of the vertical errors, in metres.
    pub accuracy_v_m: f64,
    /// Bound of 95 % of the errors of the horizontal velocity, in metres per second.
    pub speed_accuracy: f64,
    /// Horizontal standard deviation per axis (root mean square of both), in metres.
    pub deviation_h_m: f64,
    /// Standard deviation of the height, in metres.
    pub deviation_v_m: f64,
    /// Basis of the position: measured, interpolated or extrapolated.
    pub basis: Basis,
    /// Time of the latest measurement up to the track's time; `None` before the first one.
    pub last_measurement: Option<Time>,
    /// Ellipse that contains 95 % of the horizontal errors; for predicted positions only.
    pub ellipse: Option<Ellipse>,
}

/// An ellipse about a position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ellipse {
    /// Semi-major and semi-minor axis, in metres.
    pub half_axes_m: [f64; 2],
    /// Direction of the major axis, in degrees from north, 0 to 180.
    pub azimuth_deg: f64,
}

impl Ellipse {
    /// Ellipse that contains 95 % of the errors with this covariance of east and north.
    pub(super) fn of(covariance: &Matrix2<f64>) -> Self {
        let (east, north, across) = (covariance[(0, 0)], covariance[(1, 1)], covariance[(0, 1)]);
        let (mean, half) = (0.5 * (east + north), (0.5 * (north - east)).hypot(across));
        Self {
            half_axes_m: [mean + half, mean - half]
                .map(|variance| (MOST_OF_A_PLANE * variance.max(0.0)).sqrt()),
            azimuth_deg: (0.5 * (2.0 * across).atan2(north - east)).to_degrees().rem_euclid(180.0),
        }
    }
}

impl PublishedMotion {
    /// Motion of an estimate at `place` in `frame`, which is `position` on Earth.
    pub(super) fn new(estimate: &Estimate, place: Enu, position: Geodetic, frame: &TangentPlane) -> Self {
        // North and up differ from those at the site's origin. The velocity is the position in one second, as seen from the
        // present one.
        let ahead = frame.to_ecef(Enu::from(place.0 + estimate.velocity));
        let velocity = TangentPlane::at_site(position).from_ecef(ahead).0;
        let speed = velocity.xy().norm();
        let speed_accuracy = MOST.radius(&estimate.velocity_covariance);
        // If the circle of velocity errors includes standstill, the direction is uncertain.
        let is_known = speed >= SLOWEST && speed > speed_accuracy;
        let deviation_v_m = estimate.vertical_m2.max(0.0).sqrt();
        Self {
            velocity,
            track_deg: is_known.then(|| velocity.x.atan2(velocity.y).to_degrees().rem_euclid(360.0)),
            half_h_m: HALF.radius(&estimate.horizontal),
            accuracy_h_m: MOST.radius(&estimate.horizontal),
            accuracy_v_m: MOST_OF_A_LINE * deviation_v_m,
            speed_accuracy,
            deviation_h_m: (estimate.horizontal.trace() / 2.0).max(0.0).sqrt(),
            deviation_v_m,
            basis: estimate.basis,
            last_measurement: estimate.last_measurement,
            ellipse: None,
        }
    }

    /// Ground speed, in metres per second.
    pub fn speed(&self) -> f64 {
        self.velocity.xy().norm()
    }

    /// Vertical speed, in metres per second, positive up.
    pub fn climb(&self) -> f64 {
        self.velocity.z
    }

    /// Class of `accuracy_h_m`.
    pub fn class_h(&self) -> AccuracyClass {
        accuracy::class_of(&HORIZONTAL, self.accuracy_h_m)
    }

    /// Class of `accuracy_v_m`.
    pub fn class_v(&self) -> AccuracyClass {
        accuracy::class_of(&VERTICAL, self.accuracy_v_m)
    }

    /// Class of `speed_accuracy`.
    pub fn class_speed(&self) -> AccuracyClass {
        accuracy::class_of(&SPEED, self.speed_accuracy)
    }
}
