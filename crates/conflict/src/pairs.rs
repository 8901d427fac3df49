//! Search for the pairs that can come near each other, square by square, so that the cost grows with the traffic and
//! not with its square.

use std::f64::consts::FRAC_2_PI;

use nalgebra::Vector2;

use super::aircraft::ConflictAircraft;
use super::encounter::Vertical;
use super::extrapolation::{Extrapolation, SteadyFlightRatios};
use super::motion::Motion;
use super::passage::is_slow;
use super::rules::{ConflictRules, WORTH_A_LINE};
use super::volume::TrafficKind;
use fusion::cells::GroundCells;

/// Side of a square, metres.
const SIDE_M: f64 = 1000.0;
/// Standard deviations beyond which less than half a hundredth of the errors lies, on one side.
const FURTHEST: f64 = 2.58;
/// Standard deviations beyond which less than a quarter of a hundredth lies: a height can come near from above and from below.
const FURTHEST_HEIGHT: f64 = 2.81;

/// Position and reach of an aircraft, by which most others of the same squares are excluded.
#[derive(Clone, Copy, Debug)]
struct Spot {
    place: Vector2<f64>,
    is_crewed: bool,
    /// Reach towards drones and towards crewed aircraft, metres.
    reach_m: [f64; 2],
    longest_m: f64,
}

/// Velocity, climb and uncertainty of an aircraft.
#[derive(Clone, Copy, Debug)]
struct FlightState {
    velocity: Vector2<f64>,
    /// Variance of the position after t seconds, sum of both axes, without random acceleration.
    ground: Variance,
    /// Difference between the velocity and that of its leg, metres a second.
    faster: f64,
    up_m: f64,
    climb: f64,
    is_crewed: bool,
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
        motions: &[Motion],
        rules: &ConflictRules,
    ) -> (Vec<(usize, usize)>, usize) {
        let search = PairSearch::of(rules);
        let Self { cells, order, spots, flights, near } = self;
        cells.fill(aircraft.iter().map(|one| one.position), SIDE_M);
        order.clear();
        spots.clear();
        flights.clear();
        order.extend(cells.order());
        flights.extend(order.iter().map(|&index| search.flight(&aircraft[index], &motions[index])));
        spots.extend(order.iter().zip(&*flights).map(|(&index, flight)| {
            let reach_m = [false, true].map(|is_crewed| search.reach_m(flight, is_crewed));
            Spot {
                place: aircraft[index].position.0.xy(),
                is_crewed: flight.is_crewed,
                reach_m,
                longest_m: reach_m[0].max(reach_m[1]),
            }
        }));
        near.resize(spots.len(), 0);
        let (mut found, mut tested) = (Vec::new(), 0);
        for (a, (spot, flight)) in spots.iter().zip(&*flights).enumerate() {
            // The aircraft with the larger reach searches for the others, so a fast one lengthens only its own search.
            let is_near = |b: usize, other: &Spot| {
                let reach_m =
                    spot.reach_m[usize::from(other.is_crewed)] + other.reach_m[usize::from(spot.is_crewed)];
                let (own_m, others_m) = (spot.longest_m, other.longest_m);
                let is_shorter = (others_m < own_m) | ((others_m == own_m) & (b < a));
                is_shorter & ((other.place - spot.place).norm_squared() <= reach_m * reach_m)
            };
            // Stored without a branch, which would be mispredicted half of the time.
            let mut count = 0;
            for part in cells.parts_within(aircraft[order[a]].position, 2.0 * spot.longest_m, SIDE_M) {
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
    /// Limits for two drones, for a drone and a crewed aircraft, and for two crewed aircraft; `None`: no volume applies.
    limits: [Option<Limits>; 3],
}

/// Largest extent of the volumes of a pair.
#[derive(Clone, Copy)]
struct Limits {
    radius_m: f64,
    half_height_m: f64,
    tau_s: f64,
    /// Standard deviations beyond the radius within which a pair that is still approaching at the horizon is searched.
    at_horizon: f64,
}

impl PairSearch {
    fn of(rules: &ConflictRules) -> Self {
        use TrafficKind::{Crewed, Drone};
        let limits =
            [(Drone, Drone), (Drone, Crewed), (Crewed, Crewed)].map(|(a, b)| Limits::of(rules, a, b));
        Self { ahead: rules.ahead, limits }
    }

    fn limits(&self, a_is_crewed: bool, b_is_crewed: bool) -> Option<&Limits> {
        self.limits[usize::from(a_is_crewed) + usize::from(b_is_crewed)].as_ref()
    }

    fn flight(&self, one: &ConflictAircraft, motion: &Motion) -> FlightState {
        let at = |row: usize, column: usize| one.covariance[(row, column)];
        let SteadyFlightRatios { height, climb, .. } = self.ahead.steady;
        let mut above = one.vertical.map_or([f64::INFINITY, 0.0, 0.0], |[hh, hc, cc]| {
            [height * height * hh, 2.0 * height * climb * hc, climb * climb * cc]
        });
        let mut ground = [at(0, 0) + at(1, 1), 2.0 * (at(0, 2) + at(1, 3)), at(2, 2) + at(3, 3)];
        let (mut up_m, mut rate, mut faster) = (one.position.up(), one.velocity.z, 0.0);
        if let Some(leg) = &motion.leg {
            // The distance of the leg from the state counts as an error of the state.
            let away_m = (leg.position - one.position.0.xy()).norm();
            faster = (leg.velocity - one.velocity.xy()).norm();
            ground[0] += away_m * away_m;
            ground[1] += 2.0 * away_m * faster;
            ground[2] += faster * faster;
            if let Some(Vertical { height_m, climb, covariance: [hh, hc, cc] }) =
                leg.vertical.filter(|_| one.vertical.is_some())
            {
                // A climb may end.
                above = [hh, 2.0 * hc, cc + if one.kind == TrafficKind::Drone { climb * climb } else { 0.0 }];
                (up_m, rate) = (height_m, climb);
            }
        }
        FlightState {
            velocity: one.velocity.xy(),
            ground: Variance(ground),
            faster,
            up_m,
            climb: rate,
            is_crewed: one.kind == TrafficKind::Crewed,
            above: Variance(above),
        }
    }

    /// Reach of an aircraft towards others of a kind, metres: two are tested if their distance is at most the sum of their
    /// reaches. It covers the distance flown and, across it, the possible miss (the miss lies across the flight, except at
    /// the horizon).
    fn reach_m(&self, flight: &FlightState, of_crewed: bool) -> f64 {
        let Some(limits) = self.limits(flight.is_crewed, of_crewed) else { return 0.0 };
        let horizon_s = self.ahead.horizon_s;
        let flown_m = (horizon_s + limits.tau_s) * flight.velocity.norm();
        // The sum of two is at least the deviation of both, whose random acceleration adds twice `grown_m2`.
        let sigma_m = (flight.ground.at(horizon_s) + self.ahead.grown_m2(horizon_s) / 2.0).sqrt();
        let half_m = limits.radius_m / 2.0;
        let at_horizon_m = flown_m + half_m + limits.at_horizon * sigma_m;
        flown_m.hypot(half_m + FURTHEST * sigma_m).max(at_horizon_m)
    }

    /// Whether two come so near each other that the probability must be computed.
    fn may_meet(&self, apart: Vector2<f64>, a: &FlightState, b: &FlightState) -> bool {
        let Some(limits) = self.limits(a.is_crewed, b.is_crewed) else { return false };
        let horizon_s = self.ahead.horizon_s;
        let velocity = b.velocity - a.velocity;
        let square = velocity.norm_squared();
        let closest_s = if square > 0.0 { -apart.dot(&velocity) / square } else { 0.0 };
        // With tau, a volume is entered before the closest approach.
        let t = closest_s.clamp(0.0, horizon_s + limits.tau_s);
        // Upper bound of the variance of both in any direction.
        let ground = a.ground.and(b.ground);
        let Variance([_, _, rate_m2s2]) = ground;
        let SteadyFlightRatios { velocity: ratio, .. } = self.ahead.steady;
        let faster = 2.0 * (a.faster + b.faster);
        let is_slow = is_slow(square, ratio * ratio * rate_m2s2) || square < faster * faster;
        let ground_m2 = ground.at(t) + 2.0 * self.ahead.grown_m2(t.min(horizon_s));
        let ground_m2 = if is_slow { ground_m2.max(ground.at(horizon_s)) } else { ground_m2 };
        let near_m = limits.radius_m + FURTHEST * ground_m2.sqrt();
        if (apart + velocity * t).norm_squared() > near_m * near_m {
            return false;
        }
        let half_s = near_m / square.sqrt();
        let (from_s, until_s) = if is_slow {
            (0.0, horizon_s)
        } else {
            let limited = |t: f64| t.clamp(0.0, horizon_s);
            (limited(closest_s - limits.tau_s - half_s), limited(closest_s + half_s))
        };
        let above = |t: f64| b.up_m - a.up_m + (b.climb - a.climb) * t;
        let (from_m, until_m) = (above(from_s), above(until_s));
        let away_m = if from_m * until_m <= 0.0 { 0.0 } else { from_m.abs().min(until_m.abs()) };
        let height = a.above.and(b.above);
        let (climb, early_s) = (b.climb - a.climb, (ground_m2 / square).sqrt().min(t / 2.0));
        let early_m2 = if climb == 0.0 { 0.0 } else { climb * climb * early_s * early_s };
        let height_m2 = height.at(from_s).max(height.at(until_s)) + early_m2;
        away_m <= limits.half_height_m + FURTHEST_HEIGHT * height_m2.sqrt()
    }
}

impl Limits {
    /// The limits for a pair of these kinds; `None`: no volume applies.
    fn of(rules: &ConflictRules, a: TrafficKind, b: TrafficKind) -> Option<Self> {
        let ahead = &rules.ahead;
        let of_both = || rules.volumes.iter().filter(|volume| volume.is_between(a, b));
        of_both().next()?;
        let radius_m = of_both().map(|volume| volume.horizontal_m).fold(0.0, f64::max);
        // The density across the velocity, at the horizon, is at most `highest` for the width of the volume, and falls off
        // with the distance.
        let sigma_m = (2.0 * ahead.grown_m2(ahead.horizon_s)).sqrt();
        let highest = (radius_m * (FRAC_2_PI).sqrt() / sigma_m).min(1.0);
        let tail = 2.0 * (highest / (2.0 * WORTH_A_LINE)).ln();
        Some(Self {
            radius_m,
            half_height_m: of_both().map(|volume| volume.vertical_m).fold(0.0, f64::max),
            tau_s: of_both().map(|volume| volume.tau_s).fold(0.0, f64::max),
            at_horizon: if tail > 0.0 { tail.sqrt().clamp(1.0, FURTHEST) } else { 1.0 },
        })
    }
}
