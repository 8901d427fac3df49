//! Which pairs can come near each other at all: found square by square, so that the cost grows with the traffic and not with
//! its square.

use nalgebra::Vector2;

use super::encounter::RESTING;
use super::{Ahead, Aircraft, Rules, WORTH_A_LINE};
use crate::cells::Cells;

/// Side of a square, metres.
const SIDE_M: f64 = 1000.0;
/// Standard deviations beyond which less than a hundredth of the errors lie, on one side.
const FURTHEST: f64 = 2.33;

/// Where an aircraft is, how it flies, and how far it gets: what the search looks at, in one place.
#[derive(Clone, Copy, Debug)]
struct Flight {
    place: Vector2<f64>,
    velocity: Vector2<f64>,
    /// Variance of its place after t seconds, both axes together, without what random acceleration adds: factors of 1, t
    /// and t², m².
    variance: [f64; 3],
    reach_m: f64,
}

/// Aircraft by square.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    cells: Cells,
    flights: Vec<Flight>,
}

impl Pairs {
    /// The pairs, the lower index first, in no order; and how many were looked at.
    pub(super) fn find(&mut self, aircraft: &[Aircraft], rules: &Rules) -> (Vec<(usize, usize)>, usize) {
        let search = Search::of(rules);
        self.flights.clear();
        self.flights.extend(aircraft.iter().map(|one| search.flight(one)));
        self.cells.fill(aircraft.iter().map(|one| one.position), SIDE_M);
        let (mut found, mut tested) = (Vec::new(), 0);
        for (a, (one, flight)) in aircraft.iter().zip(&self.flights).enumerate() {
            // The one that gets further looks for the others: a fast one makes only its own search long.
            for b in self.cells.within(one.position, 2.0 * flight.reach_m, SIDE_M) {
                let other = &self.flights[b];
                if (other.reach_m, b) >= (flight.reach_m, a) {
                    continue;
                }
                let apart = other.place - flight.place;
                if apart.norm_squared() > (flight.reach_m + other.reach_m).powi(2) {
                    continue;
                }
                tested += 1;
                if search.may_meet(apart, flight, other) {
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
        let highest = radius_m * radius_m / (4.0 * ahead.grown_m2(ahead.horizon_s));
        let at_horizon =
            (highest > WORTH_A_LINE).then(|| (2.0 * (highest / WORTH_A_LINE).ln()).sqrt().min(FURTHEST));
        Self { ahead, radius_m, at_horizon }
    }

    fn flight(&self, one: &Aircraft) -> Flight {
        let at = |row: usize, column: usize| one.covariance[(row, column)];
        let variance = [at(0, 0) + at(1, 1), 2.0 * (at(0, 2) + at(1, 3)), at(2, 2) + at(3, 3)];
        let (place, velocity) = (one.position.0.xy(), one.velocity.xy());
        let mut flight = Flight { place, velocity, variance, reach_m: 0.0 };
        flight.reach_m = self.reach_m(&flight);
        flight
    }

    /// Two are to be looked at where they are within the sum of their reaches: what they fly, and across that how far a miss
    /// may lead (the miss lies across the flight, but at the horizon).
    fn reach_m(&self, flight: &Flight) -> f64 {
        let horizon_s = self.ahead.horizon_s;
        let flown_m = horizon_s * flight.velocity.norm();
        let sigma_m = self.variance_m2(horizon_s, flight.variance, 1.0).sqrt();
        let half_m = self.radius_m / 2.0;
        let at_horizon_m = self.at_horizon.map_or(0.0, |sigmas| flown_m + half_m + sigmas * sigma_m);
        flown_m.hypot(half_m + FURTHEST * sigma_m).max(at_horizon_m)
    }

    /// Variance of a place over ground after `t` seconds, both axes together, of so many aircraft, m²: at least that in any
    /// direction.
    fn variance_m2(&self, t: f64, [place, across, rate]: [f64; 3], aircraft: f64) -> f64 {
        let grown_m2 = 2.0 * aircraft * self.ahead.grown_m2(t);
        (place + t * (across + t * rate) + grown_m2).max(0.0)
    }

    /// Whether two come so near each other that a probability is worth computing.
    fn may_meet(&self, apart: Vector2<f64>, a: &Flight, b: &Flight) -> bool {
        let velocity = b.velocity - a.velocity;
        let t = -apart.dot(&velocity) / velocity.norm_squared().max(RESTING * RESTING);
        let t = t.clamp(0.0, self.ahead.horizon_s);
        let variance = std::array::from_fn(|index| a.variance[index] + b.variance[index]);
        let variance_m2 = self.variance_m2(t, variance, 2.0);
        let beyond_m = (apart + velocity * t).norm() - self.radius_m;
        beyond_m <= 0.0 || beyond_m * beyond_m <= FURTHEST * FURTHEST * variance_m2
    }
}
