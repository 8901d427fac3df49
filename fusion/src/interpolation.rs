//! Piecewise cubic Hermite interpolation that preserves the shape of its data (PCHIP).
//!
//! Fritsch and Carlson, *Monotone piecewise cubic interpolation* (SIAM J. Numer. Anal. 17, 1980), with the weighted
//! harmonic mean of Fritsch and Butland and the one-sided end formula of MATLAB and SciPy. Checked against SciPy in
//! `fusion/tests/oracles.rs`.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::time::Time;

/// A point on the curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Knot {
    /// Time of the knot.
    pub time: Time,
    /// Position, metres.
    pub position: Vector3<f64>,
}

/// A curve with stored slopes, because it is evaluated more often than its knots change.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct HermiteCurve {
    knots: Vec<Knot>,
    /// Slope at each knot; zero if there is only one knot.
    slopes: Vec<Vector3<f64>>,
}

impl HermiteCurve {
    /// The knots, by time.
    pub(crate) fn knots(&self) -> &[Knot] {
        &self.knots
    }

    /// Inserts a knot at `index`.
    pub(crate) fn insert(&mut self, index: usize, knot: Knot) {
        self.knots.insert(index, knot);
        self.slopes.insert(index, Vector3::zeros());
        self.slope_around(index);
    }

    /// Replaces the knot at `index`.
    pub(crate) fn replace(&mut self, index: usize, knot: Knot) {
        self.knots[index] = knot;
        self.slope_around(index);
    }

    /// Removes the first `count` knots.
    pub(crate) fn forget(&mut self, count: usize) {
        if count > 0 {
            self.knots.drain(..count);
            self.slopes.drain(..count);
            self.slope_around(0);
        }
    }

    /// Recomputes the slopes that depend on the knot at `index`: the slope at an end depends on the next two knots.
    fn slope_around(&mut self, index: usize) {
        let Self { knots, slopes } = self;
        if knots.len() < 2 {
            return;
        }
        let (first, last) = (index.saturating_sub(2), (index + 2).min(knots.len() - 1));
        for (index, slope) in slopes.iter_mut().enumerate().take(last + 1).skip(first) {
            *slope = self::slope(knots, index);
        }
    }

    /// The piece from knot `index` to the next.
    pub(crate) fn piece(&self, index: usize) -> CubicPiece {
        let (from, to) = (self.knots[index], self.knots[index + 1]);
        let length_s = to.time.seconds_since(from.time);
        let (from_slope, to_slope) = (self.slopes[index], self.slopes[index + 1]);
        CubicPiece { from, to, length_s, from_slope, to_slope }
    }
}

/// The cubic between two adjacent knots.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CubicPiece {
    from: Knot,
    to: Knot,
    length_s: f64,
    from_slope: Vector3<f64>,
    to_slope: Vector3<f64>,
}

impl CubicPiece {
    /// The piece from knot `index` to the next. Slopes are computed from the adjacent knots (`knots` has at least two,
    /// with strictly increasing times).
    fn of(knots: &[Knot], index: usize) -> Self {
        let (from, to) = (knots[index], knots[index + 1]);
        Self {
            from,
            to,
            length_s: to.time.seconds_since(from.time),
            from_slope: slope(knots, index),
            to_slope: slope(knots, index + 1),
        }
    }

    /// Whether `time` is between the piece's knots, and not at one of them.
    pub(crate) fn spans(&self, time: Time) -> bool {
        self.from.time < time && time < self.to.time
    }

    /// Time from the first knot to `time`, and from there to the second knot, seconds.
    pub(crate) fn apart_s(&self, time: Time) -> (f64, f64) {
        (time.seconds_since(self.from.time), self.to.time.seconds_since(time))
    }

    /// Mean speed over ground between the knots, metres a second.
    pub(crate) fn speed_m_s(&self) -> f64 {
        (self.to.position - self.from.position).xy().norm() / self.length_s
    }

    /// The position at `time`, between the piece's knots.
    pub(crate) fn at(&self, time: Time) -> Vector3<f64> {
        let h = self.length_s;
        let s = time.seconds_since(self.from.time) / h;
        let rest = 1.0 - s;
        let from_weight = (1.0 + 2.0 * s) * rest * rest;
        self.from.position * from_weight
            + self.to.position * (1.0 - from_weight)
            + (self.from_slope * rest - self.to_slope * s) * (h * s * rest)
    }
}

/// Position of the curve through `knots` at `time`. At a knot it is the knot itself; outside the knots, or with fewer
/// than two, it is `None`.
pub fn evaluate(knots: &[Knot], time: Time) -> Option<Vector3<f64>> {
    let index = knots.partition_point(|knot| knot.time <= time).checked_sub(1)?;
    if knots.len() < 2 {
        return None;
    }
    if knots[index].time == time {
        return Some(knots[index].position);
    }
    (index + 1 < knots.len()).then(|| CubicPiece::of(knots, index).at(time))
}

/// The derivative at a knot, metres per second, each axis on its own.
fn slope(knots: &[Knot], index: usize) -> Vector3<f64> {
    let step = |i: usize| knots[i + 1].time.seconds_since(knots[i].time);
    let secant = |i: usize| (knots[i + 1].position - knots[i].position) / step(i);
    let last = knots.len() - 1;
    if last == 1 {
        secant(0)
    } else if index == 0 {
        end_slope(step(0), step(1), secant(0), secant(1))
    } else if index == last {
        end_slope(step(last - 1), step(last - 2), secant(last - 1), secant(last - 2))
    } else {
        let (before, after) = (step(index - 1), step(index));
        secant(index - 1).zip_map(&secant(index), |d0, d1| interior_slope(before, after, d0, d1))
    }
}

/// Weighted harmonic mean of the secants; zero at an extremum.
fn interior_slope(before: f64, after: f64, d0: f64, d1: f64) -> f64 {
    if d0 * d1 <= 0.0 {
        return 0.0;
    }
    let (w1, w2) = (2.0 * after + before, after + 2.0 * before);
    (w1 + w2) / (w1 / d0 + w2 / d1)
}

/// The three-point formula at an end, clamped to preserve the shape; `near` and `d0` belong to the piece at the end.
fn end_slope(near: f64, far: f64, d0: Vector3<f64>, d1: Vector3<f64>) -> Vector3<f64> {
    d0.zip_map(&d1, |d0, d1| {
        let slope = ((2.0 * near + far) * d0 - near * d1) / (near + far);
        if slope * d0 <= 0.0 {
            0.0
        } else if d0 * d1 <= 0.0 && slope.abs() > 3.0 * d0.abs() {
            3.0 * d0
        } else {
            slope
        }
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_curve_is_what_its_knots_are_evaluated_to(
            steps in prop::collection::vec((0..5_u8, 0..40_i64, -50.0..50.0_f64), 1..60),
        ) {
            let mut curve = HermiteCurve::default();
            for (step, second, east_m) in steps {
                let knot = Knot { time: Time::from_nanos(second), position: Vector3::new(east_m, 7.0, -east_m) };
                match curve.knots().binary_search_by_key(&knot.time, |knot| knot.time) {
                    _ if step == 0 => curve.forget(curve.knots().len().min(2)),
                    Ok(index) => curve.replace(index, knot),
                    Err(index) => curve.insert(index, knot),
                }
                let knots = curve.knots();
                for index in 1..knots.len() {
                    let time = Time::from_nanos(knots[index - 1].time.nanos().midpoint(knots[index].time.nanos()));
                    if time > knots[index - 1].time {
                        prop_assert_eq!(Some(curve.piece(index - 1).at(time)), evaluate(knots, time));
                    }
                }
            }
        }
    }
}
