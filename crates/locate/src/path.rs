//! The path of one transponder: a piecewise cubic through its reports.

use nalgebra::Vector3;

/// Longest interval between two reports that is interpolated, in median intervals and in seconds.
const GAP_INTERVALS: f64 = 3.0;
const GAP_S: (f64, f64) = (3.0, 12.0);

/// Acceleration of a drone that its reports do not show, m/s² (judgement).
const HIDDEN_M_S2: f64 = 1.5;

/// Largest deviation of an interpolated position, metres.
const COARSEST_M: f64 = 12.0;

/// A transponder's path in the site's frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Path {
    times_s: Vec<f64>,
    positions: Vec<Vector3<f64>>,
    slopes: Vec<Vector3<f64>>,
    longest_s: f64,
}

/// A point of a path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathPoint {
    pub(crate) position: Vector3<f64>,
    pub(crate) velocity: Vector3<f64>,
    /// Standard deviation of the interpolation per axis, metres.
    pub(crate) sigma_m: f64,
}

impl Path {
    /// The path through reports in order of time; of reports with the same time the last one counts.
    pub(crate) fn new(reports: &[(f64, Vector3<f64>)]) -> Self {
        let mut path = Self::default();
        for &(time_s, position) in reports {
            if path.times_s.last().is_some_and(|&last_s| time_s <= last_s) {
                path.times_s.pop();
                path.positions.pop();
            }
            path.times_s.push(time_s);
            path.positions.push(position);
        }
        let count = path.times_s.len();
        path.slopes = (0..count).map(|index| path.slope(index)).collect();
        let mut intervals: Vec<f64> = path.times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        intervals.sort_by(f64::total_cmp);
        let median_s = intervals.get(intervals.len() / 2).copied().unwrap_or(0.0);
        path.longest_s = (GAP_INTERVALS * median_s).clamp(GAP_S.0, GAP_S.1);
        path
    }

    /// Derivative of the parabola through a report and its neighbours.
    fn slope(&self, index: usize) -> Vector3<f64> {
        let secant = |at: usize| {
            (self.positions[at + 1] - self.positions[at]) / (self.times_s[at + 1] - self.times_s[at])
        };
        let last = self.times_s.len() - 1;
        match index {
            _ if last == 0 => Vector3::zeros(),
            0 => secant(0),
            _ if index == last => secant(last - 1),
            _ => {
                let (before_s, after_s) = (
                    self.times_s[index] - self.times_s[index - 1],
                    self.times_s[index + 1] - self.times_s[index],
                );
                (secant(index - 1) * after_s + secant(index) * before_s) / (before_s + after_s)
            }
        }
    }

    /// The point at a time, unless the reports around it are too far apart.
    pub(crate) fn at(&self, time_s: f64) -> Option<PathPoint> {
        let after = self.times_s.partition_point(|&knot_s| knot_s <= time_s);
        let before = after.checked_sub(1)?;
        let (from_s, to_s) = (self.times_s[before], *self.times_s.get(after)?);
        let length_s = to_s - from_s;
        if length_s > self.longest_s {
            return None;
        }
        let sigma_m = 0.5 * HIDDEN_M_S2 * (time_s - from_s) * (to_s - time_s);
        if sigma_m > COARSEST_M {
            return None;
        }
        let share = (time_s - from_s) / length_s;
        let rest = 1.0 - share;
        let (from, to) = (self.positions[before], self.positions[after]);
        let (slope_from, slope_to) = (self.slopes[before] * length_s, self.slopes[after] * length_s);
        let step = to - from;
        let weight = share * share * (3.0 - 2.0 * share);
        let position = from + step * weight + (slope_from * rest - slope_to * share) * (share * rest);
        let velocity = (step * (6.0 * share * rest)
            + slope_from * (rest * (1.0 - 3.0 * share))
            + slope_to * (share * (3.0 * share - 2.0)))
            / length_s;
        Some(PathPoint { position, velocity, sigma_m })
    }

    /// Number of reports.
    pub(crate) fn len(&self) -> usize {
        self.times_s.len()
    }

    /// First and last time.
    pub(crate) fn span_s(&self) -> Option<(f64, f64)> {
        self.times_s.first().copied().zip(self.times_s.last().copied())
    }

    /// Reported positions.
    pub(crate) fn positions(&self) -> &[Vector3<f64>] {
        &self.positions
    }
}
