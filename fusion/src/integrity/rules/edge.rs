//! Place and velocity at the edge of a gap, from the three reports on one side of it.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::history::Heard;
use crate::filter::speed_factor;
use crate::time::Time;

/// Reports so far from the edge say nothing of the motion at it, seconds.
const REACH_S: f64 = 16.0;
/// Reports nearer to each other than this, seconds, are not told apart by their places.
const NEAREST_S: f64 = 0.05;
/// How far apart the three lie, at least, for a gap of 1 s: what they leave open of the velocity counts over the gap.
const SPACING: f64 = 0.3;

/// By how much a velocity may have changed since the time of which it is known, m/s²: a parabola tells most of it.
const LEFT_OVER_M_S2: f64 = 0.5;
/// What two reports, which show no turn, may hide, m/s².
const UNKNOWN_M_S2: f64 = 2.0;
/// Speed of what shows none, m/s.
const CRUISE_M_S: f64 = 30.0;
/// An aircraft that turns with A m/s² between two velocities is at most A T²/4 off their mean. Who turns hard within a gap
/// turns on one side of it or has another course behind it; measured over 320,000 gaps: beside this much, m/s²,
const UNSEEN_M_S2: f64 = 2.0;
/// so many times as hard as is seen,
const MORE_THAN_SEEN: f64 = 1.4;
/// and no harder than this, m/s².
const TURN_MAX_M_S2: f64 = 10.0;

/// Motion at the edge of a gap: a parabola through the three reports nearest to it, the line through two, or one place.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Edge {
    pub(super) time: Time,
    /// Over ground, metres.
    pub(super) place: Vector2<f64>,
    motion: Option<Motion>,
}

/// Velocity at an edge.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Motion {
    /// Over ground, m/s.
    velocity: Vector2<f64>,
    /// By how much it may be wrong beside noise, m/s.
    unsure_m_s: f64,
    /// Along the parabola, m/s²; `None`: two reports do not show it.
    acceleration: Option<Vector2<f64>>,
    /// What each of the three reports weighs in the velocity, 1/s, the one at the edge first.
    velocity_weights: [f64; 3],
    /// The same for the acceleration, 1/s².
    acceleration_weights: [f64; 3],
}

impl Edge {
    /// From reports that lead away from a gap of `gap_s` seconds, the one at the edge first; `None` where there is none.
    pub(super) fn new<'a>(away: impl Iterator<Item = &'a Heard>, gap_s: f64) -> Option<Self> {
        let mut away = away.peekable();
        let edge = *away.peek()?;
        let motion = Motion::new(edge, away.take_while(|heard| heard.apart_s(edge) <= REACH_S), gap_s);
        Some(Self { time: edge.time, place: edge.position.xy(), motion })
    }

    /// Whether an aircraft moves so: it turns or speeds up no harder than this, beyond what noise of `noise_m` an axis feigns.
    pub(super) fn is_motion(&self, most_m_s2: f64, noise_m: f64) -> bool {
        self.motion.is_none_or(|motion| {
            let feigned_m_s2 = 5.0 * noise_m * norm(motion.acceleration_weights);
            motion.acceleration_m_s2() <= most_m_s2 + feigned_m_s2
        })
    }

    /// Whether anything is known of its velocity.
    pub(super) fn has_motion(&self) -> bool {
        self.motion.is_some()
    }

    /// Whether three reports show it.
    pub(super) fn is_whole(&self) -> bool {
        self.motion.is_some_and(|motion| motion.acceleration.is_some())
    }

    /// How far a report is from where the motion led, metres, and how far an aircraft's turns can bring it off.
    pub(super) fn miss_m(&self, later: &Heard) -> (f64, f64) {
        let ahead_s = later.time.seconds_since(self.time);
        let Some(motion) = self.motion else {
            return ((later.position.xy() - self.place).norm(), CRUISE_M_S * ahead_s.abs());
        };
        let led = self.place + motion.velocity * ahead_s;
        let turn_m_s2 = turn_m_s2(motion.acceleration_m_s2(), motion.velocity.norm());
        let turned_m = turn_m_s2 * ahead_s * ahead_s / 2.0;
        ((later.position.xy() - led).norm(), turned_m + motion.unsure_m_s * ahead_s.abs())
    }
}

impl Motion {
    /// From the report at the edge, and all reports from there on.
    fn new<'a>(edge: &Heard, mut away: impl Iterator<Item = &'a Heard>, gap_s: f64) -> Option<Self> {
        let spacing_s = (SPACING * gap_s).max(NEAREST_S);
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
            None => ([-1.0 / x1, 1.0 / x1, 0.0], [0.0; 3], LEFT_OVER_M_S2),
        };
        let weigh = |weights: [f64; 3]| {
            let places = [edge, middle, far.unwrap_or(edge)].map(|heard| heard.position.xy());
            places.iter().zip(weights).map(|(place, weight)| place * weight).sum()
        };
        Some(Self {
            velocity: weigh(velocity_weights),
            unsure_m_s: changed_m_s2 * x1.abs(),
            acceleration: far.map(|_| weigh(acceleration_weights)),
            velocity_weights,
            acceleration_weights,
        })
    }

    /// What it turns with, m/s²; where two reports do not show it, what it may.
    fn acceleration_m_s2(&self) -> f64 {
        self.acceleration.map_or(UNKNOWN_M_S2, |acceleration| acceleration.norm())
    }

    /// By how much its velocity may be wrong, m/s, where that on the other side of the gap is `other`: what a mean over a longer
    /// time hides, both differ by.
    fn unsure_m_s(&self, other: &Self) -> f64 {
        let hidden_m_s =
            if self.acceleration.is_none() { (self.velocity - other.velocity).norm() } else { 0.0 };
        self.unsure_m_s + hidden_m_s
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
    /// Between what was and what is; `None` where neither side has a velocity.
    pub(super) fn between(before: &Edge, after: &Edge) -> Option<Self> {
        let gap_s = after.time.seconds_since(before.time);
        let half_s = gap_s / 2.0;
        // A side without a velocity is taken to have that of the other side; turns then move it by A T²/2.
        let (sides, apart_s) = match (before.motion, after.motion) {
            (Some(before), Some(after)) => ([before, after], half_s * half_s),
            (Some(one), None) | (None, Some(one)) => ([one, one], gap_s * half_s),
            (None, None) => return None,
        };
        let [velocity_before, velocity_after] = sides.map(|side| side.velocity);
        let led = before.place + (velocity_before + velocity_after) * half_s;
        let gains = sides.map(|side| {
            let [at, middle, far] = side.velocity_weights.map(|weight| weight.abs() * half_s);
            norm([1.0 + at, middle, far])
        });
        let turned_m_s2 = (velocity_after - velocity_before).norm() / gap_s;
        let seen_m_s2 = sides.iter().map(Motion::acceleration_m_s2).fold(turned_m_s2, f64::max);
        // A fast aircraft is fast on both sides; a side with a false place may only look fast.
        let speed_m_s = velocity_before.norm().min(velocity_after.norm());
        let unsure_m_s = sides[0].unsure_m_s(&sides[1]) + sides[1].unsure_m_s(&sides[0]);
        let unsure_m_s = unsure_m_s * speed_factor(speed_m_s).powi(2);
        Some(Self {
            distance_m: (after.place - led).norm(),
            noise_gain: gains[0].hypot(gains[1]),
            gap_s,
            by_turns_m: turn_m_s2(seen_m_s2, speed_m_s) * apart_s + unsure_m_s * half_s,
        })
    }
}

/// Largest acceleration in a turn of an aircraft of that speed, where reports show `seen_m_s2`, m/s².
fn turn_m_s2(seen_m_s2: f64, speed_m_s: f64) -> f64 {
    // A fast aircraft turns harder in proportion to its speed, and its turns begin and end faster in proportion.
    let factor = speed_factor(speed_m_s);
    (UNSEEN_M_S2 * factor.powi(2) + MORE_THAN_SEEN * seen_m_s2).min(TURN_MAX_M_S2 * factor)
}

fn norm(values: [f64; 3]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}
