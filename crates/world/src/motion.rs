//! True motion: paths sampled at 10 Hz and interpolated linearly. Local metres: east and north of the origin, height
//! above ground.

mod animal;
mod crewed;
mod fixed_wing;
mod fleet;
mod formation;
mod multirotor;

use nalgebra::Vector3;

pub use animal::{birds, clutter};
pub use crewed::{circuit, conflict, surface, transit};
pub use fleet::{Crowded, fleet, number, seeming};

/// Samples of a path per second.
pub const RATE_HZ: usize = 10;
/// Sampling interval, seconds.
const STEP_S: f64 = 1.0 / RATE_HZ as f64;

/// Position and velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KinematicState {
    /// East, north, and height above ground, metres.
    pub position: Vector3<f64>,
    /// Velocity, the derivative of the position, m/s.
    pub velocity: Vector3<f64>,
}

/// A flight from take-off (0 s) to the end, with a sample every 0.1 s.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightPath(Vec<KinematicState>);

impl FlightPath {
    /// Path through these samples.
    pub(crate) fn new(samples: Vec<KinematicState>) -> Self {
        Self(samples)
    }

    /// Path of an object that does not move.
    fn standing(position: Vector3<f64>) -> Self {
        Self(vec![KinematicState { position, velocity: Vector3::zeros() }])
    }

    /// Samples; sample n is at n / [`RATE_HZ`] seconds. A single sample holds for the whole time.
    pub fn samples(&self) -> &[KinematicState] {
        &self.0
    }

    /// Position and velocity `t_s` seconds after take-off: linear between samples, constant beyond the ends.
    pub fn at(&self, t_s: f64) -> KinematicState {
        let place = (t_s / STEP_S).clamp(0.0, (self.0.len() - 1) as f64);
        let before = place as usize;
        let after = (before + 1).min(self.0.len() - 1);
        let part = place - before as f64;
        let (a, b) = (&self.0[before], &self.0[after]);
        KinematicState {
            position: a.position.lerp(&b.position, part),
            velocity: a.velocity.lerp(&b.velocity, part),
        }
    }

    /// Whether the object turns at `t_s`: faster than 4 °/s, while moving faster than 2 m/s.
    pub fn turns(&self, t_s: f64) -> bool {
        let (before, after) = (self.at(t_s - 0.5).velocity.xy(), self.at(t_s + 0.5).velocity.xy());
        let moving = before.norm() > 2.0 && after.norm() > 2.0;
        moving && before.angle(&after) > 4.0_f64.to_radians()
    }

    /// Whether the object hovers at `t_s`: slower than 1 m/s.
    pub fn hovers(&self, t_s: f64) -> bool {
        self.at(t_s).velocity.norm() < 1.0
    }
}

/// Unit vector of a heading, in radians clockwise from north.
fn towards(heading: f64) -> nalgebra::Vector2<f64> {
    nalgebra::Vector2::new(heading.sin(), heading.cos())
}

/// Difference of two angles, -pi to pi.
fn turn(from: f64, to: f64) -> f64 {
    (to - from + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI
}
