//! Which pairs can come near each other at all: found square by square, so that the cost grows with the traffic and not with
//! its square.

use super::encounter::RESTING;
use super::{Ahead, Aircraft, Rules, WORTH_A_LINE};
use crate::cells::Cells;

/// Side of a square, metres.
const SIDE_M: f64 = 1000.0;
/// Standard deviations beyond which less than a hundredth of the errors lie, on one side.
const FURTHEST: f64 = 2.33;

/// Aircraft by square, each with how far it gets.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    cells: Cells,
    reaches_m: Vec<f64>,
    /// Indices, the shortest reach first.
    order: Vec<u32>,
    /// Place of each in `order`.
    ranks: Vec<u32>,
}

impl Pairs {
    /// The pairs, the lower index first, in no order; and how many were looked at.
    pub(super) fn find(&mut self, aircraft: &[Aircraft], rules: &Rules) -> (Vec<(usize, usize)>, usize) {
        let search = Search::of(rules);
        self.reaches_m.clear();
        self.reaches_m.extend(aircraft.iter().map(|one| search.reach_m(one)));
        self.cells.fill(aircraft.iter().map(|one| one.position), SIDE_M);
        self.order.clear();
        self.order.extend(0..aircraft.len() as u32);
        let reaches_m = &self.reaches_m;
        self.order.sort_by(|&a, &b| reaches_m[a as usize].total_cmp(&reaches_m[b as usize]));
        self.ranks.resize(aircraft.len(), 0);
        for (rank, &index) in (0..).zip(&self.order) {
            self.ranks[index as usize] = rank;
        }
        let (mut found, mut tested) = (Vec::new(), 0);
        // The one that gets further looks for the others: a fast one makes only its own search long.
        for (a, one) in aircraft.iter().enumerate() {
            let reach_m = self.reaches_m[a];
            for b in self.cells.within(one.position, 2.0 * reach_m, SIDE_M) {
                if self.ranks[b] >= self.ranks[a] {
                    continue;
                }
                let apart = (aircraft[b].position.0 - one.position.0).xy();
                if apart.norm_squared() > (reach_m + self.reaches_m[b]).powi(2) {
                    continue;
                }
                tested += 1;
                if search.may_meet(one, &aircraft[b]) {
                    found.push((a.min(b), a.max(b)));
                }
            }
        }
        (found, tested)
    }
}

/// How far a pair is looked for: where a probability of [`WORTH_A_LINE`] is possible.
struct Search {
    ahead: Ahead,
    radius_m: f64,
    /// Standard deviations beyond the radius at which those may be that are still approaching at the horizon; `None`: they are
    /// known too poorly by then to be worth a line wherever they are.
    at_horizon: Option<f64>,
}

impl Search {
    fn of(rules: &Rules) -> Self {
        let (ahead, radius_m) = (rules.ahead, rules.largest_m());
        // The density of a place at the horizon is at most this times the disc's, and falls off with the distance to it.
        let highest = radius_m * radius_m / (4.0 * ahead.grown_m2(ahead.horizon_s)[0]);
        let at_horizon =
            (highest > WORTH_A_LINE).then(|| (2.0 * (highest / WORTH_A_LINE).ln()).sqrt().min(FURTHEST));
        Self { ahead, radius_m, at_horizon }
    }

    /// Two are to be looked at where they are within the sum of their reaches: what they fly, and across that how far a miss
    /// may lead (the miss lies across the flight, but at the horizon).
    fn reach_m(&self, one: &Aircraft) -> f64 {
        let flown_m = self.ahead.horizon_s * one.velocity.xy().norm();
        let sigma_m = self.variance_m2(self.ahead.horizon_s, one).sqrt();
        let half_m = self.radius_m / 2.0;
        let at_horizon_m = self.at_horizon.map_or(0.0, |sigmas| flown_m + half_m + sigmas * sigma_m);
        flown_m.hypot(half_m + FURTHEST * sigma_m).max(at_horizon_m)
    }

    /// Variance of a position over ground after `t` seconds, both axes together, m²: at least that in any direction.
    fn variance_m2(&self, t: f64, one: &Aircraft) -> f64 {
        let at = |row: usize, column: usize| one.covariance[(row, column)];
        let grown_m2 = 2.0 * self.ahead.grown_m2(t)[0];
        let place = at(0, 0) + at(1, 1) + 2.0 * t * (at(0, 2) + at(1, 3)) + t * t * (at(2, 2) + at(3, 3));
        (place + grown_m2).max(0.0)
    }

    /// Whether two come so near each other that a probability is worth computing.
    fn may_meet(&self, a: &Aircraft, b: &Aircraft) -> bool {
        let position = (b.position.0 - a.position.0).xy();
        let velocity = (b.velocity - a.velocity).xy();
        let t = -position.dot(&velocity) / velocity.norm_squared().max(RESTING * RESTING);
        let t = t.clamp(0.0, self.ahead.horizon_s);
        let variance_m2 = self.variance_m2(t, a) + self.variance_m2(t, b);
        (position + velocity * t).norm() <= self.radius_m + FURTHEST * variance_m2.sqrt()
    }
}
