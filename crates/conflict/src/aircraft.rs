//! An aircraft that takes part in the prediction.

use nalgebra::{Matrix4, Vector3};

use super::extrapolation::Extrapolation;
use super::volume::TrafficKind;
use fusion::frames::Enu;
use fusion::time::Time;

/// Unique key of an aircraft: its track number, which may be reused, and the time since which it has that number.
pub type ConflictKey = (u32, Time);

/// An aircraft of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct ConflictAircraft {
    /// Unique key.
    pub key: ConflictKey,
    /// Position in the site's axes.
    pub position: Enu,
    /// Velocity east, north and up, metres a second.
    pub velocity: Vector3<f64>,
    /// Covariance of east and north (metres) and their rates (metres a second).
    pub covariance: Matrix4<f64>,
    /// Variance of the height, covariance of height and climb, variance of the climb: m², m²/s, m²/s². `None`: the
    /// height is not known.
    pub vertical: Option<[f64; 3]>,
    /// Crewed aircraft or drone.
    pub kind: TrafficKind,
    /// Track numbers of tracks that claim to be the same aircraft at another position; they are in no conflict with it.
    pub disputed: Vec<u32>,
    /// Whether it has a transponder. If not, it was only detected.
    pub has_transponder: bool,
    /// Whether the picture shows it now. If not, this is its last state, extrapolated, and it takes part only as long as it
    /// can be expected to fly straight on.
    pub is_shown: bool,
}

impl ConflictAircraft {
    /// This aircraft, extrapolated by `age_s`, in seconds.
    #[must_use]
    pub fn moved(mut self, age_s: f64, ahead: &Extrapolation) -> Self {
        let grown_m2 = ahead.grown_m2(age_s);
        let mut flight = Matrix4::identity();
        (flight[(0, 2)], flight[(1, 3)]) = (age_s, age_s);
        self.position = Enu::from(self.position.0 + self.velocity * age_s);
        self.covariance = flight * self.covariance * flight.transpose();
        for axis in [0, 1] {
            self.covariance[(axis, axis)] += grown_m2;
        }
        self.vertical = self
            .vertical
            .map(|[hh, hc, cc]| [hh + 2.0 * age_s * hc + age_s * age_s * cc, hc + age_s * cc, cc]);
        self
    }

    /// Whether both claim to be the same aircraft.
    pub(super) fn is_also(&self, other: &Self) -> bool {
        self.disputed.contains(&other.key.0) || other.disputed.contains(&self.key.0)
    }

    /// Whether all numbers are finite and the covariance is positive definite.
    pub(super) fn is_sound(&self) -> bool {
        let is_finite = self.position.0.iter().chain(self.velocity.iter()).all(|number| number.is_finite());
        let vertical = self.vertical.unwrap_or([1.0, 0.0, 1.0]);
        let is_variance =
            vertical[0] > 0.0 && vertical[2] > 0.0 && vertical.iter().all(|number| number.is_finite());
        is_finite && is_variance && self.covariance.cholesky().is_some()
    }
}
