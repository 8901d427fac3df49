//! Place and velocity at the edge of a gap, from the three reports on one side of it.

use nalgebra::Vector2;

use super::history::Heard;
use crate::time::Time;

/// Reports so far from the edge say nothing of the motion at it, seconds.
const REACH_S: f64 = 16.0;
/// Reports nearer to each other than this, seconds, are not told apart by their places.
const NEAREST_S: f64 = 0.05;
/// How far apart the three lie, at least, for a gap of 1 s: what they leave open of the velocity counts over the gap.
const SPACING: f64 = 0.3;

/// Motion at the edge of a gap: a parabola through the three reports nearest to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub(super) time: Time,
    /// Over ground, metres.
    pub(super) place: Vector2<f64>,
    /// Over ground, m/s.
    velocity: Vector2<f64>,
    acceleration: Vector2<f64>,
    /// From the edge to the next report on its side, seconds.
    pub(super) step_s: f64,
    /// What each of the three weighs in the velocity, 1/s, the one at the edge first.
    velocity_weights: [f64; 3],
    /// The same for the acceleration, 1/s².
    acceleration_weights: [f64; 3],
}

impl Edge {
    /// From reports that lead away from a gap of `gap_s` seconds; `None` where there are too few.
    pub(super) fn new<'a>(mut away: impl Iterator<Item = &'a Heard>, gap_s: f64) -> Option<Self> {
        let spacing_s = (SPACING * gap_s).max(NEAREST_S);
        let edge = away.next()?;
        let middle = away.find(|heard| heard.apart_s(edge) >= spacing_s)?;
        let far = away.find(|heard| heard.apart_s(middle) >= spacing_s)?;
        let [x1, x2] = [middle, far].map(|heard| heard.time.seconds_since(edge.time));
        if x2.abs() > REACH_S {
            return None;
        }
        // Lagrange's polynomials of the nodes 0, x1 and x2, differentiated at 0.
        let velocity_weights =
            [-(x1 + x2) / (x1 * x2), -x2 / (x1 * (x1 - x2)), -x1 / (x2 * (x2 - x1))];
        let acceleration_weights = [2.0 / (x1 * x2), 2.0 / (x1 * (x1 - x2)), 2.0 / (x2 * (x2 - x1))];
        let weigh = |weights: [f64; 3]| {
            let places = [edge, middle, far].map(|heard| heard.position.xy());
            places.iter().zip(weights).map(|(place, weight)| place * weight).sum()
        };
        Some(Self {
            time: edge.time,
            place: edge.position.xy(),
            velocity: weigh(velocity_weights),
            acceleration: weigh(acceleration_weights),
            step_s: x1.abs(),
            velocity_weights,
            acceleration_weights,
        })
    }

    /// Whether an aircraft moves so: no faster than `most_m_s2` turns or speeds it up, beyond what noise of `noise_m` an axis feigns.
    pub(super) fn is_motion(&self, most_m_s2: f64, noise_m: f64) -> bool {
        let feigned_m_s2 = 5.0 * noise_m * norm(self.acceleration_weights);
        self.acceleration.norm() <= most_m_s2 + feigned_m_s2
    }
}

/// How far the motion after a gap is from going on as the motion before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Miss {
    /// Distance over ground between where it went on and where the mean of both velocities leads, metres.
    pub(super) distance_m: f64,
    /// How much of it noise makes: in an axis, for noise of 1 m.
    pub(super) noise_gain: f64,
    pub(super) gap_s: f64,
    /// Mean distance of the reports on either side, seconds.
    step_s: f64,
}

impl Miss {
    /// Between what was and what is.
    pub(super) fn between(before: &Edge, after: &Edge) -> Self {
        let gap_s = after.time.seconds_since(before.time);
        let half_s = gap_s / 2.0;
        let led = before.place + (before.velocity + after.velocity) * half_s;
        let gain = |edge: &Edge| {
            let [at, middle, far] = edge.velocity_weights.map(|weight| weight.abs() * half_s);
            norm([1.0 + at, middle, far])
        };
        Self {
            distance_m: (after.place - led).norm(),
            noise_gain: gain(before).hypot(gain(after)),
            gap_s,
            step_s: (before.step_s + after.step_s) / 2.0,
        }
    }

    /// How far an aircraft's turns can bring it off, metres: an aircraft that has both velocities at the edges and turns with
    /// A between them is at most A T²/4 off; each velocity is known as far as it was kept since the report before.
    pub(super) fn by_turns_m(&self, turn_m_s2: f64, kept_m_s2: f64) -> f64 {
        turn_m_s2 * self.gap_s * self.gap_s / 4.0 + kept_m_s2 * self.gap_s * self.step_s
    }
}

fn norm(values: [f64; 3]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}
