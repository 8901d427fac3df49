//! Motion models of drones: constant velocity with little or much noise, and turns at a constant rate.

use serde::{Deserialize, Serialize};

use super::gaussian::LinearMotion;
use super::symmetric::{Rows, Symmetric};

/// Number of interacting models.
pub const MODELS: usize = 4;

/// A model of the motion over ground; the state is east, north (metres), and their rates (metres a second).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Model {
    /// Constant velocity; the acceleration is white noise.
    ConstantVelocity {
        /// Power spectral density of the acceleration on each axis, m²/s³.
        noise: f64,
    },
    /// A turn at a constant rate, clockwise positive like a heading.
    Turn {
        /// Rate of turn, radians a second; not zero.
        rate: f64,
        /// Power spectral density of the acceleration on each axis, m²/s³.
        noise: f64,
    },
}

/// The interacting motion models and their mean durations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Models {
    /// The models.
    pub each: [Model; MODELS],
    /// Mean duration of each model, seconds.
    pub lasts_s: [f64; MODELS],
}

impl Default for Models {
    fn default() -> Self {
        Self {
            each: [
                Model::ConstantVelocity { noise: 0.05 },
                Model::ConstantVelocity { noise: 6.0 },
                Model::Turn { rate: 0.25, noise: 0.5 },
                Model::Turn { rate: -0.25, noise: 0.5 },
            ],
            lasts_s: [8.0, 4.0, 6.0, 6.0],
        }
    }
}

impl Models {
    /// Probabilities of a change from one model to another within `dt` seconds.
    pub fn switch(&self, dt: f64) -> [[f64; MODELS]; MODELS] {
        const TOWARDS: [[f64; MODELS]; MODELS] =
            [[0.0, 0.7, 0.15, 0.15], [0.6, 0.0, 0.2, 0.2], [0.5, 0.5, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0]];
        std::array::from_fn(|from| {
            let stays = (-dt / self.lasts_s[from]).exp();
            std::array::from_fn(|to| if from == to { stays } else { (1.0 - stays) * TOWARDS[from][to] })
        })
    }
}

/// The motion over an interval: x' = F x + w, w normal with covariance Q.
///
/// F combines two rotations with scaling, for both axes at once: of the velocity, and of its contribution to the
/// position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Seconds along the velocity, and to its right, by which it contributes to the position.
    along: [f64; 2],
    /// Cosine and sine of the turn to the right.
    turned: [f64; 2],
    /// Variance of the position, covariance of position and velocity, variance of the velocity, on each axis.
    noise: [f64; 3],
}

/// Noise below which a constant-velocity model counts as straight flight, m²/s³.
const STRAIGHT: f64 = 1.0;
/// Speed over ground up to which the models are used unchanged, m/s.
const USUAL_M_S: f64 = 25.0;

/// Factor on the accelerations for a target of that speed over ground, m/s. A faster target has the same rate of turn,
/// so its acceleration rises in proportion to its speed.
pub(crate) fn speed_factor(speed_m_s: f64) -> f64 {
    (speed_m_s / USUAL_M_S).max(1.0)
}

impl Model {
    /// The model for a target of that speed over ground, m/s. The noise of manoeuvres rises with the speed; that of straight
    /// flight does not.
    pub(super) fn at_speed(self, speed_m_s: f64) -> Self {
        let more = speed_factor(speed_m_s).powi(2);
        match self {
            Self::ConstantVelocity { noise } if noise < STRAIGHT => self,
            Self::ConstantVelocity { noise } => Self::ConstantVelocity { noise: noise * more },
            Self::Turn { rate, noise } => Self::Turn { rate, noise: noise * more },
        }
    }

    /// The motion over `dt` seconds, not negative.
    pub fn over(&self, dt: f64) -> Course {
        match *self {
            Self::ConstantVelocity { noise } => {
                Course { along: [dt, 0.0], turned: [1.0, 0.0], noise: white_acceleration(noise, dt) }
            }
            Self::Turn { rate, noise } => {
                // Clockwise: the velocity (sin χ, cos χ) v of heading χ becomes that of χ + rate·dt. Bar-Shalom (2001),
                // eq. 11.7.1-4, with the sign of a heading.
                let (sin, cos) = (rate * dt).sin_cos();
                Course {
                    along: [sin / rate, (1.0 - cos) / rate],
                    turned: [cos, sin],
                    noise: white_acceleration(noise, dt),
                }
            }
        }
    }
}

/// Motion of a state that begins with east, north, and their rates.
impl<const D: usize> LinearMotion<D> for Course {
    const MOVING: usize = 4;

    #[inline]
    fn carry<const N: usize>(&self, rows: &mut Rows<N, D>) {
        self.carry_at(rows, [0, 1], [2, 3]);
    }

    #[inline]
    fn add_noise(&self, covariance: &mut Symmetric<D>) {
        [(0, 2), (1, 3)].into_iter().for_each(|states| self.add_noise_at(covariance, states));
    }
}

impl Course {
    /// Applies the motion to the rows of east and north, and of their rates.
    #[inline]
    pub fn carry_at<const N: usize, const D: usize>(
        &self,
        rows: &mut Rows<N, D>,
        places: [usize; 2],
        rates: [usize; 2],
    ) {
        let ([ahead, aside], [cos, sin]) = (self.along, self.turned);
        let (east_rate, north_rate) = (rows[rates[0]], rows[rates[1]]);
        for column in 0..N {
            let (east, north) = (east_rate[column], north_rate[column]);
            rows[places[0]][column] += ahead * east + aside * north;
            rows[places[1]][column] += ahead * north - aside * east;
            rows[rates[0]][column] = cos * east + sin * north;
            rows[rates[1]][column] = cos * north - sin * east;
        }
    }

    /// Adds the noise of one axis, given the indices of its position and rate.
    #[inline]
    pub fn add_noise_at<const D: usize>(&self, covariance: &mut Symmetric<D>, (place, rate): (usize, usize)) {
        let [of_place, across, of_rate] = self.noise;
        covariance.add_at(place, place, of_place);
        covariance.add_at(place, rate, across);
        covariance.add_at(rate, rate, of_rate);
    }
}

/// Discretised continuous white acceleration (Bar-Shalom (2001), eq. 6.2.2-12): variance of the position, covariance of
/// position and velocity, variance of the velocity.
pub(crate) fn white_acceleration(density: f64, dt: f64) -> [f64; 3] {
    [density * dt * dt * dt / 3.0, density * dt * dt / 2.0, density * dt]
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix4, Vector4, vector};

    use super::*;
    use crate::filter::tests::{noise_of, transition_of};

    #[test]
    fn a_quarter_turn_to_the_right_ends_where_the_circle_does() {
        let model = Model::Turn { rate: std::f64::consts::FRAC_PI_2, noise: 0.0 };
        let transition: Matrix4<f64> = transition_of(&model.over(1.0));
        // Northward at 10 m/s: the circle has a radius of v / rate.
        let end = transition * vector![0.0, 0.0, 0.0, 10.0];
        let radius = 10.0 / std::f64::consts::FRAC_PI_2;
        assert!((end - Vector4::new(radius, radius, 10.0, 0.0)).norm() < 1e-12, "{end}");
    }

    #[test]
    fn two_steps_are_one() {
        for model in [
            Model::ConstantVelocity { noise: 2.0 },
            Model::Turn { rate: 0.3, noise: 0.0 },
            Model::Turn { rate: -0.2, noise: 0.0 },
        ] {
            let over = |dt| (transition_of::<4>(&model.over(dt)), noise_of::<4>(&model.over(dt)));
            let (first, second, both) = (over(0.7), over(1.1), over(1.8));
            assert!((second.0 * first.0 - both.0).norm() < 1e-12);
            let noise = second.0 * first.1 * second.0.transpose() + second.1;
            assert!((noise - both.1).norm() < 1e-12, "{model:?}");
        }
    }
}
