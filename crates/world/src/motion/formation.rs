//! Drones in formation: positions on a grid around a common flight, each kept to within about a metre.

use nalgebra::{Vector2, Vector3};

use super::{FlightPath, KinematicState, RATE_HZ, STEP_S, towards};
use crate::streams::{GaussMarkov, RandomStream};

/// Deviation of a drone from its grid position: standard deviation per axis in metres, and time constant in seconds
/// (Gauss–Markov).
const KEEPING: (f64, f64) = (1.0, 10.0);
/// Time between two drawn deviations, seconds, with a smooth path in between.
const KNOT_S: usize = 4;

/// A grid of positions around a common flight. The directions of its axes are constant.
pub(super) struct Formation {
    leader: FlightPath,
    columns: usize,
    rows: usize,
    spacing_m: f64,
    heading: f64,
}

impl Formation {
    /// Formation for `count` drones, with as many columns as rows or one more.
    pub(super) fn new(leader: FlightPath, count: usize, spacing_m: f64, stream: &mut RandomStream) -> Self {
        let columns = ((count as f64).sqrt().ceil() as usize).max(1);
        let rows = count.div_ceil(columns);
        Self { leader, columns, rows, spacing_m, heading: stream.heading() }
    }

    /// Flight of the drone at index `place` of the grid.
    pub(super) fn member(&self, place: usize, stream: &mut RandomStream) -> FlightPath {
        let place = self.place(place).push(0.0);
        let mut keeping = [KEEPING.0; 3].map(|sigma_m| GaussMarkov::new(sigma_m, KEEPING.1, 0.0, stream));
        let samples = self.leader.samples();
        let knots: Vec<Vector3<f64>> = (0..samples.len().div_ceil(KNOT_S * RATE_HZ) + 1)
            .map(|knot| {
                let time_s = (knot * KNOT_S) as f64;
                Vector3::from(keeping.each_mut().map(|axis| axis.at(time_s, stream)))
            })
            .collect();
        let off = |step: usize| {
            let (knot, part) = (step / (KNOT_S * RATE_HZ), step % (KNOT_S * RATE_HZ));
            let part = part as f64 / (KNOT_S * RATE_HZ) as f64;
            knots[knot].lerp(&knots[knot + 1], part * part * (3.0 - 2.0 * part))
        };
        let members = samples.iter().enumerate().map(|(step, leader)| {
            let drift = if step > 0 { (off(step) - off(step - 1)) / STEP_S } else { Vector3::zeros() };
            KinematicState {
                position: leader.position + place + off(step),
                velocity: leader.velocity + drift,
            }
        });
        FlightPath::new(members.collect())
    }

    /// Offset from the leader, east and north, metres.
    fn place(&self, place: usize) -> Vector2<f64> {
        let from_middle = |index: usize, count: usize| index as f64 - (count as f64 - 1.0) / 2.0;
        let across = from_middle(place % self.columns, self.columns) * self.spacing_m;
        let along = from_middle(place / self.columns, self.rows) * self.spacing_m;
        towards(self.heading) * along + towards(self.heading + std::f64::consts::FRAC_PI_2) * across
    }
}
