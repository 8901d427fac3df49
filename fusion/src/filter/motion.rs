//! How drones move: constant velocity, disturbed little or much, and turns at a constant rate.

use nalgebra::{Matrix4, matrix};

/// How many models interact.
pub(super) const MODELS: usize = 4;

/// A model of the motion over ground; the state is east, north (metres), and their rates (metres a second).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Model {
    /// Straight on; the acceleration is white noise of this density, m²/s³.
    ConstantVelocity {
        /// Power spectral density of the acceleration on each axis, m²/s³.
        noise: f64,
    },
    /// A turn at this rate, clockwise positive as a heading is.
    Turn {
        /// Radians a second; not zero.
        rate: f64,
        /// Power spectral density of the acceleration on each axis, m²/s³.
        noise: f64,
    },
}

/// The motion models and how long each lasts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Models {
    /// The models.
    pub each: [Model; MODELS],
    /// How long each lasts in the mean, seconds.
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
    /// Probabilities to change from one model to another within `dt` seconds.
    pub(super) fn switch(&self, dt: f64) -> [[f64; MODELS]; MODELS] {
        const TOWARDS: [[f64; MODELS]; MODELS] =
            [[0.0, 0.7, 0.15, 0.15], [0.6, 0.0, 0.2, 0.2], [0.5, 0.5, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0]];
        std::array::from_fn(|from| {
            let stays = (-dt / self.lasts_s[from]).exp();
            std::array::from_fn(|to| if from == to { stays } else { (1.0 - stays) * TOWARDS[from][to] })
        })
    }
}

/// The motion over an interval: x' = F x + w, w normal with covariance Q.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Transition F.
    pub transition: Matrix4<f64>,
    /// Covariance Q of what F does not tell.
    pub noise: Matrix4<f64>,
}

impl Model {
    /// Over `dt` seconds, not negative.
    pub fn over(&self, dt: f64) -> Motion {
        match *self {
            Self::ConstantVelocity { noise } => {
                let transition = matrix![
                    1.0, 0.0, dt, 0.0;
                    0.0, 1.0, 0.0, dt;
                    0.0, 0.0, 1.0, 0.0;
                    0.0, 0.0, 0.0, 1.0;
                ];
                Motion { transition, noise: white_acceleration(noise, dt) }
            }
            Self::Turn { rate, noise } => {
                // Clockwise: the velocity (sin χ, cos χ) v of heading χ becomes that of χ + rate·dt. Bar-Shalom (2001),
                // eq. 11.7.1-4, with the sign of a heading.
                let (sin, cos) = (rate * dt).sin_cos();
                let (along, aside) = (sin / rate, (1.0 - cos) / rate);
                let transition = matrix![
                    1.0, 0.0, along, aside;
                    0.0, 1.0, -aside, along;
                    0.0, 0.0, cos, sin;
                    0.0, 0.0, -sin, cos;
                ];
                Motion { transition, noise: white_acceleration(noise, dt) }
            }
        }
    }
}

/// Discretised continuous white acceleration (Bar-Shalom (2001), eq. 6.2.2-12), on each axis by itself.
fn white_acceleration(density: f64, dt: f64) -> Matrix4<f64> {
    let (p, c, v) = (density * dt * dt * dt / 3.0, density * dt * dt / 2.0, density * dt);
    matrix![
        p, 0.0, c, 0.0;
        0.0, p, 0.0, c;
        c, 0.0, v, 0.0;
        0.0, c, 0.0, v;
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;

    #[test]
    fn a_quarter_turn_to_the_right_ends_where_the_circle_does() {
        let model = Model::Turn { rate: std::f64::consts::FRAC_PI_2, noise: 0.0 };
        // Northward at 10 m/s: the circle has a radius of v / rate.
        let end = model.over(1.0).transition * vector![0.0, 0.0, 0.0, 10.0];
        let radius = 10.0 / std::f64::consts::FRAC_PI_2;
        assert!((end - vector![radius, radius, 10.0, 0.0]).norm() < 1e-12, "{end}");
    }

    #[test]
    fn two_steps_are_one() {
        for model in [
            Model::ConstantVelocity { noise: 2.0 },
            Model::Turn { rate: 0.3, noise: 0.0 },
            Model::Turn { rate: -0.2, noise: 0.0 },
        ] {
            let (first, second, both) = (model.over(0.7), model.over(1.1), model.over(1.8));
            assert!((second.transition * first.transition - both.transition).norm() < 1e-12);
            let noise = second.transition * first.noise * second.transition.transpose() + second.noise;
            assert!((noise - both.noise).norm() < 1e-12, "{model:?}");
        }
    }
}
