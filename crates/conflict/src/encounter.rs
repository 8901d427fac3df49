//! Two aircraft that fly straight on: time and distance of their closest approach over ground.

use nalgebra::{Matrix2, Matrix4, Vector2};

use super::aircraft::ConflictAircraft;

/// Relative state of two aircraft at one instant: b minus a.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relative {
    /// Position over ground: east and north, metres.
    pub position: Vector2<f64>,
    /// Velocity over ground, metres a second.
    pub velocity: Vector2<f64>,
    /// Covariance of position and velocity: east, north, and their rates.
    pub covariance: Matrix4<f64>,
    /// Vertical state; `None`: the height of one of them is not known.
    pub vertical: Option<Vertical>,
}

/// Relative height and climb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertical {
    /// Difference of the heights, metres.
    pub height_m: f64,
    /// Difference of the climbs, metres a second.
    pub climb: f64,
    /// Variance of the height, covariance of height and climb, variance of the climb: m², m²/s, m²/s².
    pub covariance: [f64; 3],
}

/// The closest point of approach over ground within the horizon, and the covariance of the miss there. It is independent
/// of volumes: the time in which a volume is entered, and the probability of that, are in [`Passage`](super::Passage).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Time to the closest point, seconds: 0 if they fly apart, the horizon if they are still approaching then.
    pub t_cpa_s: f64,
    /// Position of b relative to a at that time, over ground, metres.
    pub miss: Vector2<f64>,
    /// Covariance of the miss if both fly straight on, m².
    pub straight: Matrix2<f64>,
    /// Covariance of the miss if one of them turns, or has begun to turn, m².
    pub turning: Matrix2<f64>,
    /// Probability that both fly straight on until that time.
    pub share: f64,
    /// Difference of the heights at that time, metres, and its variance, m².
    pub vertical: Option<(f64, f64)>,
    /// Unit vector in the direction of the miss; [`Self::across_m2`] is the variance of the miss along it.
    pub across: Vector2<f64>,
}

impl Relative {
    /// State of `b` relative to `a`.
    pub fn of(a: &ConflictAircraft, b: &ConflictAircraft) -> Self {
        let vertical = a.vertical.zip(b.vertical).map(|(one, other)| Vertical {
            height_m: b.position.up() - a.position.up(),
            climb: b.velocity.z - a.velocity.z,
            covariance: [one[0] + other[0], one[1] + other[1], one[2] + other[2]],
        });
        Self {
            position: (b.position.0 - a.position.0).xy(),
            velocity: (b.velocity - a.velocity).xy(),
            covariance: a.covariance + b.covariance,
            vertical,
        }
    }

    /// Covariance of the position over ground after `t` seconds, m², with these ratios of the deviations of position and
    /// velocity.
    pub(super) fn after(&self, t: f64, [place, rate]: [f64; 2], grown_m2: f64) -> Matrix2<f64> {
        let at = |row: usize, column: usize| self.covariance[(row, column)];
        let of = |row: usize, column: usize| {
            let both = at(row, column + 2) + at(row + 2, column);
            place * place * at(row, column)
                + t * (place * rate * both + t * rate * rate * at(row + 2, column + 2))
        };
        Matrix2::new(of(0, 0) + grown_m2, of(0, 1), of(0, 1), of(1, 1) + grown_m2)
    }
}

impl Approach {
    /// Length of the miss over ground, metres.
    pub fn horizontal_m(&self) -> f64 {
        self.miss.norm()
    }

    /// Variance of the miss along `across`, m², averaged over flying straight on and turning.
    pub fn across_m2(&self) -> f64 {
        let [straight, turning] = [&self.straight, &self.turning].map(|part| self.variance_across_m2(part));
        self.share * straight + (1.0 - self.share) * turning
    }

    fn variance_across_m2(&self, covariance: &Matrix2<f64>) -> f64 {
        self.across.dot(&(covariance * self.across))
    }
}
