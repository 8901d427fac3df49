//! Past positions of an aircraft: the straight leg that fits the latest ones, and the durations of earlier legs.

use nalgebra::Vector2;

use super::aircraft::ConflictAircraft;
use super::encounter::Vertical;
use super::extrapolation::SteadyFlightRatios;
use super::line::{FittedLine, LineFit, after};
use super::outlook::{LEGS, LegOutlook};
use fusion::time::{SECOND, Time};

/// Maximum number of positions that are remembered.
const FIXES: usize = 32;
/// Minimum number of positions of a leg.
const LEAST: usize = 3;
/// Maximum duration of the part of a leg to which a line is fitted over ground, and in height, seconds.
const FITTED_S: f64 = 60.0;
const FITTED_HEIGHT_S: f64 = 20.0;
/// Growth of the stated variance between two pictures above which the second one has no new measurement.
const EXTRAPOLATED: f64 = 1.02;
/// Minimum variances of a position over ground and of a height, m².
const LEAST_M2: f64 = 1.0;
const LEAST_HEIGHT_M2: f64 = 4.0;
/// Factor on the variance of the stated velocity and climb, which depend on the positions.
const DEPENDENT: f64 = 4.0;
/// Normalised square of the distance from the line above which a position does not fit, over ground and in height.
const UNFIT: f64 = 6.0;
/// Number of successive positions that do not fit after which the leg is taken to begin.
const ENDS: usize = 2;
/// Factors on the variances of fitted lines, because errors of successive positions depend on each other.
const CORRELATED: f64 = 1.5;
const CORRELATED_HEIGHT: f64 = 2.0;
/// Variance of slow errors that no fit reduces: position and velocity over ground, height and climb (m², m²/s²).
const SLOW: [f64; 2] = [6.0, 0.01];
const SLOW_HEIGHT: [f64; 2] = [3.0, 0.003];
/// Number of expected squares that is added when the variance is compared with the distances from the line.
const EXPECTED: f64 = 6.0;
/// Minimum duration of a leg whose end is a turn, and of the next one before the turn counts, seconds.
const LEG_S: f64 = 12.0;
const CONFIRMED_S: f64 = 7.0;
/// Change of the velocity that is a turn, as a share of the larger one, and the minimum of that one, metres a second.
const TURN: f64 = 0.4;
const TURN_M_S: f64 = 3.0;

/// A measured position.
#[derive(Clone, Copy, Debug)]
struct Fix {
    time: Time,
    place: Vector2<f64>,
    /// Variance of the position over ground, mean of the axes, m².
    ground_m2: f64,
    height_m: f64,
    /// Variance of the height, m²; infinite if it is not known.
    height_m2: f64,
}

/// Straight flight of an aircraft, fitted to its latest positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StraightLeg {
    /// Position over ground in the site's axes, metres.
    pub(super) position: Vector2<f64>,
    /// Velocity over ground, metres a second.
    pub(super) velocity: Vector2<f64>,
    /// Variance of the position, covariance of position and velocity, variance of the velocity on each axis: m², m²/s,
    /// m²/s².
    pub(super) ground: [f64; 3],
    /// Height and climb; `None`: not known.
    pub(super) vertical: Option<Vertical>,
    /// Duration of the part to which the line was fitted, until now, seconds.
    pub(super) lasted_s: f64,
    /// Time since the last measured position, seconds.
    pub(super) age_s: f64,
}

impl StraightLeg {
    /// Speed over ground, metres a second.
    pub(super) fn speed(&self) -> f64 {
        self.velocity.norm()
    }

    fn moved(self, t: f64) -> Self {
        let vertical = self.vertical.map(|Vertical { height_m, climb, covariance }| Vertical {
            height_m: height_m + climb * t,
            climb,
            covariance: after(covariance, t),
        });
        Self {
            position: self.position + self.velocity * t,
            ground: after(self.ground, t),
            vertical,
            lasted_s: self.lasted_s + t,
            age_s: self.age_s + t,
            ..self
        }
    }
}

/// Past of an aircraft.
#[derive(Clone, Debug)]
pub(super) struct FlightHistory {
    /// The last positions; `next` is the place of the next one.
    fixes: [Fix; FIXES],
    count: usize,
    next: usize,
    /// Stated variance in the last picture, m².
    stated_m2: f64,
    /// Leg at the time of the last position.
    leg: Option<StraightLeg>,
    /// Times of the first and the last picture.
    pub(super) first: Time,
    pub(super) seen: Time,
    legs: LegDurations,
}

impl FlightHistory {
    pub(super) fn new(time: Time) -> Self {
        let none =
            Fix { time, place: Vector2::zeros(), ground_m2: 0.0, height_m: 0.0, height_m2: f64::INFINITY };
        Self {
            fixes: [none; FIXES],
            count: 0,
            next: 0,
            stated_m2: f64::INFINITY,
            leg: None,
            first: time,
            seen: time,
            legs: LegDurations::new(time),
        }
    }

    /// Adds the state of a picture.
    pub(super) fn add(&mut self, time: Time, one: &ConflictAircraft, steady: &SteadyFlightRatios) {
        let stated_m2 = one.covariance[(0, 0)] + one.covariance[(1, 1)];
        let is_measured = stated_m2 <= EXTRAPOLATED * self.stated_m2;
        (self.stated_m2, self.seen) = (stated_m2, time);
        if !is_measured {
            return;
        }
        let SteadyFlightRatios { place, height, .. } = steady;
        self.fixes[self.next] = Fix {
            time,
            place: one.position.0.xy(),
            ground_m2: (place * place * stated_m2 / 2.0).max(LEAST_M2),
            height_m: one.position.up(),
            height_m2: one
                .vertical
                .map_or(f64::INFINITY, |[hh, ..]| (height * height * hh).max(LEAST_HEIGHT_M2)),
        };
        self.next = (self.next + 1) % FIXES;
        self.count = (self.count + 1).min(FIXES);
        self.leg = self.fitted(time, one, steady);
        self.legs.update(time, self.leg.as_ref());
    }

    /// The present leg; `None` if the latest positions are on no line.
    pub(super) fn leg(&self, now: Time) -> Option<StraightLeg> {
        let last = &self.fixes[(self.next + FIXES - 1) % FIXES];
        self.leg.map(|leg| leg.moved(now.seconds_since(last.time)))
    }

    /// Whether there are enough positions to distinguish straight flight from turns.
    pub(super) fn is_known(&self) -> bool {
        self.count >= LEAST
    }

    /// Expectation of how long a leg lasts. `prior_s`: mean duration, seconds.
    pub(super) fn outlook(&self, now: Time, leg: &StraightLeg, prior_s: f64) -> LegOutlook {
        self.legs.outlook(now, leg, prior_s)
    }

    fn newest(&self) -> impl Iterator<Item = &Fix> {
        (1..=self.count).map(|back| &self.fixes[(self.next + FIXES - back) % FIXES])
    }

    /// The leg that ends now, with the last position: a line through as many of the latest positions as fit.
    fn fitted(&self, now: Time, one: &ConflictAircraft, steady: &SteadyFlightRatios) -> Option<StraightLeg> {
        let mut fixes = self.newest();
        let last = fixes.next()?;
        let stated_m2s2 = (one.covariance[(2, 2)] + one.covariance[(3, 3)]) / 2.0;
        let rate_m2s2 = DEPENDENT * steady.velocity * steady.velocity * stated_m2s2;
        let mut fit =
            LineFit::new(0.0, last.place.into(), last.ground_m2, one.velocity.xy().into(), rate_m2s2);
        let (mut count, mut lasted_s, mut squares, mut unfit) = (1, 0.0, 0.0, 0);
        for fix in fixes {
            let (t, place) = (fix.time.seconds_since(now), fix.place.into());
            let square = fit.away(t, place, fix.ground_m2);
            if square > UNFIT {
                unfit += 1;
                if unfit >= ENDS {
                    break;
                }
                continue;
            }
            (unfit, count, lasted_s, squares) = (0, count + 1, -t, squares + square);
            fit.add(t, place, fix.ground_m2);
            if lasted_s > FITTED_S {
                break;
            }
        }
        if count < LEAST {
            return None;
        }
        let FittedLine { position, rate, covariance } = fit.solve();
        // Real errors may be larger than stated.
        let larger = ((squares + EXPECTED) / (count as f64 - 1.0 + EXPECTED)).max(1.0);
        let [pp, pv, vv] = covariance.map(|part| CORRELATED * larger * part);
        Some(StraightLeg {
            position: position.into(),
            velocity: rate.into(),
            ground: [pp + SLOW[0], pv, vv + SLOW[1]],
            vertical: one.vertical.and_then(|[.., cc]| self.fitted_height(now, one.velocity.z, cc, steady)),
            lasted_s,
            age_s: 0.0,
        })
    }

    /// Height and climb on a line through as many of the latest heights as fit. `climb` is as stated, with its variance.
    fn fitted_height(
        &self,
        now: Time,
        climb: f64,
        climb_m2s2: f64,
        steady: &SteadyFlightRatios,
    ) -> Option<Vertical> {
        let mut fixes = self.newest().filter(|fix| fix.height_m2.is_finite());
        let last = fixes.next()?;
        let rate_m2s2 = DEPENDENT * steady.climb * steady.climb * climb_m2s2;
        let t = last.time.seconds_since(now);
        let mut fit = LineFit::new(t, [last.height_m], last.height_m2, [climb], rate_m2s2);
        let mut unfit = 0;
        for fix in fixes {
            let t = fix.time.seconds_since(now);
            if fit.away(t, [fix.height_m], fix.height_m2) > UNFIT {
                unfit += 1;
                if unfit >= ENDS {
                    break;
                }
                continue;
            }
            unfit = 0;
            fit.add(t, [fix.height_m], fix.height_m2);
            if -t > FITTED_HEIGHT_S {
                break;
            }
        }
        let FittedLine { position: [height_m], rate: [climb], covariance } = fit.solve();
        let [hh, hc, cc] = covariance.map(|part| CORRELATED_HEIGHT * part);
        Some(Vertical { height_m, climb, covariance: [hh + SLOW_HEIGHT[0], hc, cc + SLOW_HEIGHT[1]] })
    }
}

/// Durations of the legs of an aircraft between its turns.
#[derive(Clone, Debug)]
struct LegDurations {
    /// Begin of the present leg.
    begin: Time,
    /// Duration of the fitted part, seconds, and velocity, when last seen.
    lasted_s: f64,
    velocity: Vector2<f64>,
    /// Velocity before a turn that is not confirmed yet.
    turning: Option<Vector2<f64>>,
    /// Durations of the last legs, seconds; in a ring of which `count` were written.
    before_s: [f64; LEGS],
    count: usize,
}

impl LegDurations {
    fn new(time: Time) -> Self {
        Self {
            begin: time,
            lasted_s: 0.0,
            velocity: Vector2::zeros(),
            turning: None,
            before_s: [0.0; LEGS],
            count: 0,
        }
    }

    fn update(&mut self, now: Time, leg: Option<&StraightLeg>) {
        let lasted_s = leg.map_or(0.0, |leg| leg.lasted_s);
        // The line to which the positions were fitted does not fit any more.
        if self.lasted_s >= LEG_S && lasted_s < self.lasted_s / 2.0 {
            self.turning.get_or_insert(self.velocity);
        }
        self.lasted_s = lasted_s;
        let Some(leg) = leg else { return };
        if let Some(before) = self.turning.filter(|_| lasted_s >= CONFIRMED_S) {
            self.turning = None;
            let larger = before.norm().max(leg.speed()).max(TURN_M_S);
            if (leg.velocity - before).norm() > TURN * larger {
                let begin = Time::from_nanos(now.nanos() - (lasted_s * SECOND as f64) as i64);
                if before.norm() >= TURN_M_S {
                    self.before_s[self.count % LEGS] = begin.seconds_since(self.begin);
                    self.count += 1;
                }
                self.begin = begin;
            }
        }
        if lasted_s >= LEG_S {
            self.velocity = leg.velocity;
        }
    }

    fn outlook(&self, now: Time, leg: &StraightLeg, prior_s: f64) -> LegOutlook {
        let lasted_s = now.seconds_since(self.begin).max(leg.lasted_s);
        LegOutlook::after(lasted_s, prior_s, &self.before_s[..self.count.min(LEGS)])
    }
}
