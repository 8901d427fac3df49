//! Search for the pairs that can come near each other, square by square, so that the cost grows with the traffic and
//! not with its square.

use nalgebra::Vector2;

use super::encounter::RESTING;
use super::{ConflictAircraft, ConflictRules, Extrapolation, SteadyFlightRatios, Volume, WORTH_A_LINE};
use crate::cells::GroundCells;

/// Side of a square, metres.
const SIDE_M: f64 = 1000.0;
/// Standard deviations beyond which less than a hundredth of the errors lies, on one side.
const FURTHEST: f64 = 2.33;

/// Position and reach of an aircraft, by which most others of the same squares are excluded.
#[derive(Clone, Copy, Debug)]
struct Spot {
    place: Vector2<f64>,
    reach_m: f64,
}

/// Velocity, climb and uncertainty of an aircraft.
#[derive(Clone, Copy, Debug)]
struct FlightState {
    velocity: Vector2<f64>,
    /// Variance of the position after t seconds, sum of both axes, without random acceleration.
    ground: Variance,
    up_m: f64,
    climb: f64,
    /// Variance of the height after t seconds; infinite if the height is not known.
    above: Variance,
}

/// A variance that grows with time: factors of 1, t and t², m².
#[derive(Clone, Copy, Debug)]
struct Variance([f64; 3]);

impl Variance {
    fn at(self, t: f64) -> f64 {
        let Self([place, across, rate]) = self;
        (place + t * (across + t * rate)).max(0.0)
    }

    fn and(self, other: Self) -> Self {
        let (Self([a, b, c]), Self([d, e, f])) = (self, other);
        Self([a + d, b + e, c + f])
    }
}

/// Aircraft in the order of their squares: those of a row are contiguous.
#[derive(Debug, Default)]
pub(super) struct SortedAircraft {
    cells: GroundCells,
    order: Vec<usize>,
    spots: Vec<Spot>,
    flights: Vec<FlightState>,
    /// Buffer for the aircraft near one of them.
    near: Vec<usize>,
}

impl SortedAircraft {
    /// The pairs, the lower index first, in no order; and the number of pairs tested.
    pub(super) fn find(
        &mut self,
        aircraft: &[ConflictAircraft],
        rules: &ConflictRules,
    ) -> (Vec<(usize, usize)>, usize) {
        let search = PairSearch::of(rules);
        let Self { cells, order, spots, flights, near } = self;
        cells.fill(aircraft.iter().map(|one| one.position), SIDE_M);
        order.clear();
        spots.clear();
        flights.clear();
        order.extend(cells.order());
        flights.extend(order.iter().map(|&index| search.flight(&aircraft[index])));
        spots.extend(order.iter().zip(&*flights).map(|(&index, flight)| Spot {
            place: aircraft[index].position.0.xy(),
            reach_m: search.reach_m(flight),
        }));
        near.resize(spots.len(), 0);
        let (mut found, mut tested) = (Vec::new(), 0);
        for (a, (spot, flight)) in spots.iter().zip(&*flights).enumerate() {
            // The aircraft with the larger reach searches for the others, so a fast one lengthens only its own search.
            let is_near = |b: usize, other: &Spot| {
                let reach_m = spot.reach_m + other.reach_m;
                let is_shorter = (other.reach_m < spot.reach_m) | ((other.reach_m == spot.reach_m) & (b < a));
                is_shorter & ((other.place - spot.place).norm_squared() <= reach_m * reach_m)
            };
            // Stored without a branch, which would be mispredicted half of the time.
            let mut count = 0;
            for part in cells.parts_within(aircraft[order[a]].position, 2.0 * spot.reach_m, SIDE_M) {
                for (b, other) in part.clone().zip(&spots[part]) {
                    near[count] = b;
                    count += usize::from(is_near(b, other));
                }
            }
            tested += count;
            let mut kept = 0;
            for at in 0..count {
                let b = near[at];
                near[kept] = b;
                kept += usize::from(search.may_meet(spots[b].place - spot.place, flight, &flights[b]));
            }
            let named = |&b: &usize| (order[a].min(order[b]), order[a].max(order[b]));
            found.extend(near[..kept].iter().map(named));
        }
        (found, tested)
    }
}

/// Limits of the search: pairs for which a probability of [`WORTH_A_LINE`] is possible.
struct PairSearch {
    ahead: Extrapolation,
    radius_m: f64,
    half_height_m: f64,
    /// Standard deviations beyond the radius within which a pair that is still approaching at the horizon is searched;
    /// `None`: its position is then too uncertain for a probability of [`WORTH_A_LINE`].
    at_horizon: Option<f64>,
}

impl PairSearch {
    fn of(rules: &ConflictRules) -> Self {
        let most = |of: fn(&Volume) -> f64| rules.volumes.iter().map(of).fold(0.0, f64::max);
        let (ahead, radius_m) = (rules.ahead, most(|volume| volume.horizontal_m));
        // The density of a position at the horizon is at most `highest` for the disc's area, and falls off with the
        // distance.
        let highest = radius_m * radius_m / (4.0 * ahead.grown_m2(ahead.horizon_s));
        let at_horizon =
            (highest > WORTH_A_LINE).then(|| (2.0 * (highest / WORTH_A_LINE).ln()).sqrt().min(FURTHEST));
        Self { ahead, radius_m, half_height_m: most(|volume| volume.vertical_m), at_horizon }
    }

    fn flight(&self, one: &ConflictAircraft) -> FlightState {
        let at = |row: usize, column: usize| one.covariance[(row, column)];
        let SteadyFlightRatios { height, climb, .. } = self.ahead.steady;
        let above = one.vertical.map_or([f64::INFINITY, 0.0, 0.0], |[hh, hc, cc]| {
            [height * height * hh, 2.0 * height * climb * hc, climb * climb * cc]
        });
        FlightState {
            velocity: one.velocity.xy(),
            ground: Variance([at(0, 0) + at(1, 1), 2.0 * (at(0, 2) + at(1, 3)), at(2, 2) + at(3, 3)]),
            up_m: one.position.up(),
            climb: one.velocity.z,
            above: Variance(above),
        }
    }

    /// Reach of an aircraft, metres: two are tested if their distance is at most the sum of their reaches. It covers
    /// the distance flown and, across it, the possible miss (the miss lies across the flight, except at the horizon).
    fn reach_m(&self, flight: &FlightState) -> f64 {
        let horizon_s = self.ahead.horizon_s;
        let flown_m = horizon_s * flight.velocity.norm();
        let sigma_m = (flight.ground.at(horizon_s) + 2.0 * self.ahead.grown_m2(horizon_s)).sqrt();
        let half_m = self.radius_m / 2.0;
        let at_horizon_m = self.at_horizon.map_or(0.0, |sigmas| flown_m + half_m + sigmas * sigma_m);
        flown_m.hypot(half_m + FURTHEST * sigma_m).max(at_horizon_m)
    }

    /// Whether two come so near each other that the probability must be computed.
    fn may_meet(&self, apart: Vector2<f64>, a: &FlightState, b: &FlightState) -> bool {
        let velocity = b.velocity - a.velocity;
        let square = velocity.norm_squared();
        let unbounded_s = if square < RESTING * RESTING { 0.0 } else { -apart.dot(&velocity) / square };
        let t = unbounded_s.clamp(0.0, self.ahead.horizon_s);
        let may_be =
            |away_m: f64, half_m: f64, variance_m2: f64| away_m <= half_m + FURTHEST * variance_m2.sqrt();
        // Upper bound of the variance of both in any direction.
        let ground_m2 = a.ground.and(b.ground).at(t) + 4.0 * self.ahead.grown_m2(t);
        let above_m = b.up_m - a.up_m;
        let above_then_m = above_m + (b.climb - a.climb) * t;
        // A pair that is within the height of a volume now may be in conflict now, whatever the heights are later.
        may_be((apart + velocity * t).norm(), self.radius_m, ground_m2)
            & ((above_m.abs() <= self.half_height_m)
                | may_be(above_then_m.abs(), self.half_height_m, a.above.and(b.above).at(t)))
    }
}
