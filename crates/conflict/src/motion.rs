//! Expected motion of an aircraft, from its present state and its past, and of a pair.

use nalgebra::{Matrix4, Vector2};

use super::aircraft::ConflictAircraft;
use super::encounter::{Approach, Relative, Vertical};
use super::extrapolation::{Extrapolation, SteadyFlightRatios};
use super::history::{FlightHistory, StraightLeg};
use super::outlook::LegOutlook;
use super::volume::TrafficKind;
use fusion::time::Time;

/// Probability that an aircraft flies straight whose latest positions are on no line.
const UNFITTED: f64 = 0.1;
/// Probability that an aircraft flies straight when its leg begins, and time in which the rest of it vanishes, seconds.
const BEGUN: f64 = 0.3;
const BEGUN_S: f64 = 8.0;
/// Speed below which an aircraft hovers, metres a second, and mean time for which it does, seconds.
const HOVER_M_S: f64 = 1.5;
const HOVER_S: f64 = 20.0;
/// Minimum duration of the leg of an aircraft that is no longer shown, maximum time since its last position (seconds), and
/// minimum speed (metres a second).
const COASTED_S: f64 = 10.0;
const COASTING_S: f64 = 20.0;
const COASTING_M_S: f64 = 2.0;
/// Climb of a drone above which it may end soon, metres a second; the probability that it does.
const CLIMB_M_S: f64 = 0.7;
const LEVELS_OFF: f64 = 0.5;
/// Mean climb until the conflict if it ends soon, and its standard deviation, as shares of the present one.
const LEVEL: f64 = 0.25;
/// Factor on the probability of a turning aircraft with a known past: its turn leads further away than random acceleration.
const AWAY: f64 = 0.5;
/// A track without transponder and one with, at most this far apart (metres), with a relative speed of at most this (metres a
/// second), are probably the same aircraft until both are this old, seconds.
const TWIN_M: f64 = 80.0;
const TWIN_M_S: f64 = 10.0;
const TWIN_S: f64 = 20.0;

/// Expected motion of an aircraft.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    /// Its present leg, if it is known.
    pub(super) leg: Option<StraightLeg>,
    /// Probability that it flies straight now.
    share: f64,
    outlook: LegOutlook,
    /// State for straight flight with its real errors.
    state: Relative,
    /// Time since it was first seen, seconds.
    known_s: f64,
}

impl Motion {
    pub(super) fn of(
        history: &FlightHistory,
        now: Time,
        one: &ConflictAircraft,
        ahead: &Extrapolation,
    ) -> Self {
        let (leg, prior_s) = (history.leg(now), 2.0 * ahead.straight_s);
        let known_s = now.seconds_since(history.first);
        let state = straight_state(one, leg.as_ref(), &ahead.steady);
        let Some(leg) = leg else {
            let share = if history.is_known() { UNFITTED } else { 1.0 };
            return Self { leg: None, share, outlook: LegOutlook::Unknown(prior_s), state, known_s };
        };
        let outlook = if leg.speed() < HOVER_M_S {
            LegOutlook::after(0.0, HOVER_S, &[])
        } else {
            history.outlook(now, &leg, prior_s)
        };
        let begun = leg.lasted_s / BEGUN_S;
        let share = 1.0 - (1.0 - BEGUN) * (-begun * begun).exp();
        Self { leg: Some(leg), share: share * outlook.survival(leg.age_s), outlook, state, known_s }
    }

    /// Whether the aircraft can be followed for a while without new positions.
    pub(super) fn is_coasting(&self) -> bool {
        self.leg.is_some_and(|leg| {
            leg.lasted_s - leg.age_s >= COASTED_S && leg.age_s <= COASTING_S && leg.speed() >= COASTING_M_S
        })
    }
}

/// State for straight flight with its real errors.
fn straight_state(
    one: &ConflictAircraft,
    leg: Option<&StraightLeg>,
    steady: &SteadyFlightRatios,
) -> Relative {
    let SteadyFlightRatios { place, velocity, height, climb } = *steady;
    let stated = || {
        one.vertical.map(|[hh, hc, cc]| Vertical {
            height_m: one.position.up(),
            climb: one.velocity.z,
            covariance: [height * height * hh, height * climb * hc, climb * climb * cc],
        })
    };
    let Some(leg) = leg else {
        let ratios = [place, place, velocity, velocity];
        return Relative {
            position: one.position.0.xy(),
            velocity: one.velocity.xy(),
            covariance: Matrix4::from_fn(|row, column| {
                ratios[row] * ratios[column] * one.covariance[(row, column)]
            }),
            vertical: stated(),
        };
    };
    let [pp, pv, vv] = leg.ground;
    let mut covariance = Matrix4::from_diagonal(&[pp, pp, vv, vv].into());
    for (row, column) in [(0, 2), (2, 0), (1, 3), (3, 1)] {
        covariance[(row, column)] = pv;
    }
    let vertical = one.vertical.and(leg.vertical).or_else(stated);
    Relative { position: leg.position, velocity: leg.velocity, covariance, vertical }
}

/// Motion of a pair: straight on from one state, or turning from another.
#[derive(Clone, Copy, Debug)]
pub(super) struct PairMotion {
    /// State for straight flight.
    pub(super) steady: Relative,
    /// Ratios of real to stated deviations of position and velocity over ground in that state.
    pub(super) ratios: [f64; 2],
    /// Probability that climbs end, and the state in which they have.
    pub(super) level: Option<(f64, Relative)>,
    /// State for turns, and the factor on the probability.
    pub(super) turning: Relative,
    pub(super) away: f64,
    /// Whether the legs of both are known.
    pub(super) are_legs_known: bool,
    /// Probability that both fly straight now.
    share: f64,
    outlooks: [LegOutlook; 2],
}

impl PairMotion {
    /// Motion of a pair of which only the present state is known.
    pub(super) fn unknown(stated: &Relative, ahead: &Extrapolation) -> Self {
        let SteadyFlightRatios { place, velocity, height, climb } = ahead.steady;
        let vertical = stated.vertical.map(|vertical| {
            let [hh, hc, cc] = vertical.covariance;
            Vertical {
                covariance: [height * height * hh, height * climb * hc, climb * climb * cc],
                ..vertical
            }
        });
        let steady = Relative { vertical, ..*stated };
        Self {
            steady,
            ratios: [place, velocity],
            level: None,
            turning: steady,
            away: 1.0,
            are_legs_known: false,
            share: 1.0,
            outlooks: [LegOutlook::Unknown(2.0 * ahead.straight_s); 2],
        }
    }

    /// Motion of two aircraft. `stated` is their relative state.
    pub(super) fn of(
        stated: &Relative,
        (one, a): (&ConflictAircraft, &Motion),
        (other, b): (&ConflictAircraft, &Motion),
        ahead: &Extrapolation,
    ) -> Self {
        let (share, outlooks) = (a.share * b.share, [a.outlook, b.outlook]);
        let are_legs_known = a.leg.is_some() && b.leg.is_some();
        if a.leg.is_none() && b.leg.is_none() {
            return Self { share, outlooks, ..Self::unknown(stated, ahead) };
        }
        let (x, y) = (&a.state, &b.state);
        let vertical = x.vertical.zip(y.vertical).map(|(x, y)| Vertical {
            height_m: y.height_m - x.height_m,
            climb: y.climb - x.climb,
            covariance: std::array::from_fn(|part| x.covariance[part] + y.covariance[part]),
        });
        let steady = Relative {
            position: y.position - x.position,
            velocity: y.velocity - x.velocity,
            covariance: x.covariance + y.covariance,
            vertical,
        };
        let climb = |one: &ConflictAircraft, state: &Relative| {
            let climb = state.vertical.map_or(0.0, |vertical| vertical.climb);
            if one.kind == TrafficKind::Drone && climb.abs() > CLIMB_M_S { climb } else { 0.0 }
        };
        let (up, other_up) = (climb(one, x), climb(other, y));
        let level = vertical.filter(|_| up != 0.0 || other_up != 0.0).map(|mut vertical| {
            vertical.climb -= (1.0 - LEVEL) * (other_up - up);
            vertical.covariance[2] += LEVEL * LEVEL * (up * up + other_up * other_up);
            (LEVELS_OFF, Relative { vertical: Some(vertical), ..steady })
        });
        let turning = Relative { vertical, ..*stated };
        Self { steady, ratios: [1.0; 2], level, turning, away: AWAY, are_legs_known, share, outlooks }
    }

    /// Probability that both fly straight for `t` seconds from now.
    pub(super) fn share_at(&self, t: f64) -> f64 {
        self.share * self.outlooks.iter().map(|outlook| outlook.survival(t)).product::<f64>()
    }
}

impl Relative {
    /// The closest point of approach within the horizon, of a pair of which only the present state is known.
    pub fn approach(&self, ahead: &Extrapolation) -> Approach {
        PairMotion::unknown(self, ahead).approach(ahead)
    }
}

impl PairMotion {
    /// The closest point of approach within the horizon.
    pub(super) fn approach(&self, ahead: &Extrapolation) -> Approach {
        let Relative { position, velocity, vertical, .. } = &self.steady;
        let square = velocity.norm_squared();
        let unbounded_s = if square > 0.0 { -position.dot(velocity) / square } else { 0.0 };
        let t = unbounded_s.clamp(0.0, ahead.horizon_s);
        let is_inside = unbounded_s > 0.0 && unbounded_s < ahead.horizon_s;
        let miss = position + velocity * t;
        let along = if is_inside { Vector2::new(-velocity.y, velocity.x) } else { miss };
        let across = along.try_normalize(0.0).unwrap_or_else(Vector2::x);
        Approach {
            t_cpa_s: t,
            miss,
            straight: self.steady.after(t, self.ratios, 0.0),
            // Added for each of the two aircraft.
            turning: self.turning.after(t, [1.0; 2], 2.0 * ahead.grown_m2(t)),
            share: self.share_at(t),
            vertical: vertical.map(|Vertical { height_m, climb, covariance: [hh, hc, cc] }| {
                (height_m + climb * t, hh + t * (2.0 * hc + t * cc))
            }),
            // The sign of the normal is arbitrary; it is chosen so that b passes on the positive side.
            across: if across.dot(&miss) < 0.0 { -across } else { across },
        }
    }
}

/// Whether two tracks are probably one aircraft that radar and its transponder still show apart.
pub(super) fn are_twins(
    now: &Relative,
    (one, a): (&ConflictAircraft, &Motion),
    (other, b): (&ConflictAircraft, &Motion),
) -> bool {
    one.has_transponder != other.has_transponder
        && a.known_s.min(b.known_s) < TWIN_S
        && now.velocity.norm() < TWIN_M_S
        && now.position.norm() < TWIN_M
}
