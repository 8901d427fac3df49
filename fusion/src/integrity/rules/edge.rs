//! Position and velocity at the edge of a gap, from the three reports on one side of it.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::history::TimedReport;
use crate::filter::speed_factor;
use crate::time::Time;

/// Maximum age of reports, relative to the edge, that are used for its motion, seconds.
const REACH_S: f64 = 16.0;
/// Minimum interval between reports whose positions are used for a velocity, seconds.
const NEAREST_S: f64 = 0.05;
/// Minimum interval between the three reports, as a share of the gap: an error of the velocity is extrapolated over the
/// gap.
const SPACING: f64 = 0.3;

/// Change of the velocity that a parabola does not show, m/s².
const LEFT_OVER_M_S2: f64 = 0.5;
/// Acceleration assumed with two reports, which show no turn, m/s².
const UNKNOWN_M_S2: f64 = 2.0;
/// Speed assumed without a velocity, m/s.
const CRUISE_M_S: f64 = 30.0;
/// Acceleration beyond the observed one that an aircraft may have within a gap, m/s². An aircraft that turns with A
/// m/s² between two velocities is at most A T²/4 off their mean. An aircraft that turns hard within a gap turns on one
/// side of it, or has another course after it. These constants were measured over 320,000 gaps.
const UNSEEN_M_S2: f64 = 2.0;
/// Factor on the observed acceleration.
const MORE_THAN_SEEN: f64 = 1.4;
/// Maximum acceleration in a turn, m/s².
const TURN_MAX_M_S2: f64 = 10.0;

/// Motion at the edge of a gap: a parabola through the three nearest reports, the line through two, or one position.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct GapEdge {
    pub(super) time: Time,
    /// Position over ground, metres.
    pub(super) place: Vector2<f64>,
    motion: Option<EdgeMotion>,
}

/// Velocity and acceleration at an edge.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct EdgeMotion {
    /// Velocity over ground, m/s.
    velocity: Vector2<f64>,
    /// Error of the velocity without noise, m/s.
    unsure_m_s: f64,
    /// Acceleration along the parabola, m/s²; `None` with only two reports.
    acceleration: Option<Vector2<f64>>,
    /// Weights of the three reports in the velocity, 1/s, the one at the edge first.
    velocity_weights: [f64; 3],
    /// Weights of the three reports in the acceleration, 1/s², the one at the edge first.
    acceleration_weights: [f64; 3],
}

impl GapEdge {
    /// Creates an edge from reports that lead away from a gap of `gap_s` seconds, the one at the edge first; `None` if
    /// there is none.
    pub(super) fn new<'a>(away: impl Iterator<Item = &'a TimedReport>, gap_s: f64) -> Option<Self> {
        let mut away = away.peekable();
        let edge = *away.peek()?;
        let motion = EdgeMotion::new(edge, away.take_while(|heard| heard.apart_s(edge) <= REACH_S), gap_s);
        Some(Self { time: edge.time, place: edge.position.xy(), motion })
    }

    /// Whether an aircraft can move like this: its acceleration is at most `most_m_s2` beyond what noise of `noise_m`
    /// on each axis causes.
    pub(super) fn is_motion(&self, most_m_s2: f64, noise_m: f64) -> bool {
        self.motion.is_none_or(|motion| {
            let feigned_m_s2 = 5.0 * noise_m * norm(motion.acceleration_weights);
            motion.acceleration_m_s2() <= most_m_s2 + feigned_m_s2
        })
    }

    /// Whether the velocity is known.
    pub(super) fn has_motion(&self) -> bool {
        self.motion.is_some()
    }

    /// Whether three reports define the motion.
    pub(super) fn is_whole(&self) -> bool {
        self.motion.is_some_and(|motion| motion.acceleration.is_some())
    }

    /// Distance of a report from the extrapolated position, and distance that turns of an aircraft can explain, metres.
    pub(super) fn miss_m(&self, later: &TimedReport) -> (f64, f64) {
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

impl EdgeMotion {
    /// Creates the motion from the report at the edge and the reports after it.
    fn new<'a>(
        edge: &TimedReport,
        mut away: impl Iterator<Item = &'a TimedReport>,
        gap_s: f64,
    ) -> Option<Self> {
        let spacing_s = (SPACING * gap_s).max(NEAREST_S);
        let middle = away.find(|heard| heard.apart_s(edge) >= spacing_s)?;
        let far = away.find(|heard| heard.apart_s(middle) >= spacing_s);
        let x1 = middle.time.seconds_since(edge.time);
        let (velocity_weights, acceleration_weights, changed_m_s2) = match far {
            // Lagrange polynomials of the nodes 0, x1 and x2, differentiated at 0.
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

    /// Acceleration, m/s²; with two reports an assumed value.
    fn acceleration_m_s2(&self) -> f64 {
        self.acceleration.map_or(UNKNOWN_M_S2, |acceleration| acceleration.norm())
    }

    /// Error of the velocity, m/s. `other` is the motion on the other side of the gap: their difference may be hidden
    /// in a mean over a longer time.
    fn unsure_m_s(&self, other: &Self) -> f64 {
        let hidden_m_s =
            if self.acceleration.is_none() { (self.velocity - other.velocity).norm() } else { 0.0 };
        self.unsure_m_s + hidden_m_s
    }
}

/// Distance between the motion after a gap and the continuation of the motion before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct GapMiss {
    /// Distance over ground between the continued position and that extrapolated with the mean of both velocities,
    /// metres.
    pub(super) distance_m: f64,
    /// Contribution of noise to the distance: on each axis, for noise of 1 m.
    pub(super) noise_gain: f64,
    pub(super) gap_s: f64,
    /// Contribution of turns to the distance, metres.
    pub(super) by_turns_m: f64,
}

impl GapMiss {
    /// Compares the motions before and after a gap; `None` if neither side has a velocity.
    pub(super) fn between(before: &GapEdge, after: &GapEdge) -> Option<Self> {
        let gap_s = after.time.seconds_since(before.time);
        let half_s = gap_s / 2.0;
        // A side without a velocity gets that of the other side; turns then contribute A T²/2.
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
        let seen_m_s2 = sides.iter().map(EdgeMotion::acceleration_m_s2).fold(turned_m_s2, f64::max);
        // A fast aircraft is fast on both sides; a side with a false position may only look fast.
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

/// Largest acceleration in a turn of an aircraft of that speed whose reports show `seen_m_s2`, m/s².
fn turn_m_s2(seen_m_s2: f64, speed_m_s: f64) -> f64 {
    // A fast aircraft turns harder in proportion to its speed, and its turns begin and end faster in proportion.
    let factor = speed_factor(speed_m_s);
    (UNSEEN_M_S2 * factor.powi(2) + MORE_THAN_SEEN * seen_m_s2).min(TURN_MAX_M_S2 * factor)
}

fn norm(values: [f64; 3]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}
