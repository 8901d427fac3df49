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

/// By how much a velocity may have changed since the time of which it is known, m/s²: where a parabola tells the change it is
/// what that leaves over.
const CHANGED_M_S2: f64 = 4.0;
const LEFT_OVER_M_S2: f64 = 0.5;

/// An aircraft that turns with A m/s² between two velocities is at most A T²/4 off their mean. Who turns hard within a gap
/// turns on one side of it or has another course behind it; measured over 320,000 gaps: beside this much, m/s²,
const UNSEEN_M_S2: f64 = 2.0;
/// so many times as hard as is seen,
const MORE_THAN_SEEN: f64 = 1.4;
/// and no harder than this, m/s².
const TURN_MAX_M_S2: f64 = 10.0;

/// Motion at the edge of a gap: a parabola through the three reports nearest to it, or the line through two of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub(super) time: Time,
    /// Over ground, metres.
    pub(super) place: Vector2<f64>,
    /// Over ground, m/s.
    velocity: Vector2<f64>,
    /// By how much the velocity may be wrong beside noise, m/s.
    unsure_m_s: f64,
    /// Along the parabola, m/s²; `None`: two reports do not show it.
    acceleration: Option<Vector2<f64>>,
    /// What each of the three weighs in the velocity, 1/s, the one at the edge first.
    velocity_weights: [f64; 3],
    /// The same for the acceleration, 1/s².
    acceleration_weights: [f64; 3],
}

impl Edge {
    /// From reports that lead away from a gap of `gap_s` seconds; `None` where there are too few.
    pub(super) fn new<'a>(away: impl Iterator<Item = &'a Heard>, gap_s: f64) -> Option<Self> {
        let spacing_s = (SPACING * gap_s).max(NEAREST_S);
        let mut away = away.peekable();
        let edge = *away.peek()?;
        let mut away = away.take_while(|heard| heard.apart_s(edge) <= REACH_S);
        let middle = away.find(|heard| heard.apart_s(edge) >= spacing_s)?;
        let far = away.find(|heard| heard.apart_s(middle) >= spacing_s);
        let x1 = middle.time.seconds_since(edge.time);
        let (velocity_weights, acceleration_weights, changed_m_s2) = match far {
            // Lagrange's polynomials of the nodes 0, x1 and x2, differentiated at 0.
            Some(far) => {
                let x2 = far.time.seconds_since(edge.time);
                let (at, of_middle, of_far) = (x1 * x2, x1 * (x1 - x2), x2 * (x2 - x1));
                let velocity_weights = [-(x1 + x2) / at, -x2 / of_middle, -x1 / of_far];
                (velocity_weights, [2.0 / at, 2.0 / of_middle, 2.0 / of_far], LEFT_OVER_M_S2)
            }
            None => ([-1.0 / x1, 1.0 / x1, 0.0], [0.0; 3], CHANGED_M_S2 / 2.0),
        };
        let weigh = |weights: [f64; 3]| {
            let places = [edge, middle, far.unwrap_or(edge)].map(|heard| heard.position.xy());
            places.iter().zip(weights).map(|(place, weight)| place * weight).sum()
        };
        Some(Self {
            time: edge.time,
            place: edge.position.xy(),
            velocity: weigh(velocity_weights),
            unsure_m_s: changed_m_s2 * x1.abs(),
            acceleration: far.map(|_| weigh(acceleration_weights)),
            velocity_weights,
            acceleration_weights,
        })
    }

    /// Whether an aircraft moves so: no faster than `most_m_s2` turns or speeds it up, beyond what noise of `noise_m` an axis feigns.
    pub(super) fn is_motion(&self, most_m_s2: f64, noise_m: f64) -> bool {
        let feigned_m_s2 = 5.0 * noise_m * norm(self.acceleration_weights);
        self.acceleration.is_none_or(|acceleration| acceleration.norm() <= most_m_s2 + feigned_m_s2)
    }

    /// What it turns with, m/s²; where two reports do not show it, what it may.
    fn acceleration_m_s2(&self) -> f64 {
        self.acceleration.map_or(CHANGED_M_S2, |acceleration| acceleration.norm())
    }

    /// Whether three reports show it.
    pub(super) fn is_whole(&self) -> bool {
        self.acceleration.is_some()
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
    /// How much of it may be due to turns, metres.
    pub(super) by_turns_m: f64,
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
        let turns = [before.acceleration_m_s2(), after.acceleration_m_s2()];
        let seen_m_s2 = turns.into_iter().fold((after.velocity - before.velocity).norm() / gap_s, f64::max);
        let turn_m_s2 = (UNSEEN_M_S2 + MORE_THAN_SEEN * seen_m_s2).min(TURN_MAX_M_S2);
        Self {
            distance_m: (after.place - led).norm(),
            noise_gain: gain(before).hypot(gain(after)),
            gap_s,
            by_turns_m: turn_m_s2 * gap_s * gap_s / 4.0 + (before.unsure_m_s + after.unsure_m_s) * half_s,
        }
    }
}

fn norm(values: [f64; 3]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}
