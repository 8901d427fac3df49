//! Detects whether a transponder's reports are false, and since when, by a bank of change times (generalised likelihood
//! ratio). One hypothesis (`Hypothesis`) is that the transponder is honest. The others, started every few seconds over the
//! last minutes, are that its reports have been false since then. Each hypothesis is a Kalman filter of the same state,
//! updated by the same observations of radar tracks; the likelihoods of the hypotheses are compared.
//!
//! A. S. Willsky, H. L. Jones, *A generalized likelihood ratio approach to the detection and estimation of jumps in
//! linear systems* (IEEE Trans. Automatic Control 21, 1976).

mod hypothesis;
#[cfg(test)]
mod tests;

use jiff::SignedDuration;
use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use crate::report::SensorIndex;
use crate::time::Time;
use hypothesis::{AxisRow, DriftLogProbabilities, ElapsedTime, Hypothesis, HypothesisKind};

/// Interval between the starts of new hypotheses, seconds: of a false position, and of shifted time stamps.
const BEGIN_EVERY_S: f64 = 5.0;
const LATE_EVERY_S: f64 = 30.0;
/// Age up to which a hypothesis is kept, seconds, and lead in log-likelihood with which it is kept longer.
const KEPT_S: f64 = 150.0;
const LEADS: f64 = 3.0;
/// Ages from which only every second, and only every fourth, hypothesis is kept, seconds.
const THINNED_S: [f64; 2] = [30.0, 75.0];
/// Log-likelihood relative to honesty below which a hypothesis is removed, once it is older than `BEHIND_AFTER_S`.
const BEHIND: f64 = -12.0;
const BEHIND_AFTER_S: f64 = 20.0;
/// Standard deviation of the offset of another aircraft's radar track, each axis, metres.
pub(crate) const ELSEWHERE_M: f64 = 150.0;
/// Time that a false position must have lasted to count for the protection level.
const PROTECTION: SignedDuration = SignedDuration::from_secs(60);
/// Maximum duration for which a radar track drifts away from its aircraft, seconds, and cost in log-likelihood of such
/// a drift beginning within 5 s.
const WALK_MAX_S: f64 = 14.0;
const WALK_COST: f64 = 2.6;
/// Cost in log-likelihood of a jump, which should also be visible in the reports themselves.
const JUMP_COST: f64 = 3.0;
/// Minimum error of a time stamp that counts as wrong, seconds.
const LATE_MIN_S: f64 = 0.5;
/// Number of standard deviations by which that minimum must be exceeded.
const LATE_SIGMAS: f64 = 2.0;
/// 95 % quantile of the standard normal distribution.
const NORMAL_95: f64 = 1.644_853_626_951_472;

/// One second's observation of a radar track relative to a transponder.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct TrackObservation {
    /// Middle of the second.
    pub(crate) time: Time,
    /// The radar, and its track: time of the track's start, and its number.
    pub(crate) radar: SensorIndex,
    pub(crate) track: (Time, u16),
    /// Mean offset of the plots from the transponder's curve at their times: outward and clockwise, metres.
    pub(crate) offset_m: [f64; 2],
    /// Variance of the offset that is independent between observations, m².
    pub(crate) white_m2: [f64; 2],
    /// Unit vectors outward and clockwise, and the distance over ground, metres.
    pub(crate) axes: [Vector2<f64>; 2],
    pub(crate) range_m: f64,
    /// Velocity of the transponder's curve, metres a second.
    pub(crate) velocity: Vector2<f64>,
    /// Persistent errors of a track of the radar.
    pub(crate) slow: PersistentErrors,
    /// Standard deviations of the radar's alignment: range, metres, and azimuth, radians.
    pub(crate) alignment: [f64; 2],
}

/// Persistent errors of a radar track: standard deviations, and correlation time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PersistentErrors {
    /// Error of the range, metres.
    pub(crate) range_m: f64,
    /// Error of the azimuth, radians.
    pub(crate) azimuth: f64,
    /// Correlation time, seconds.
    pub(crate) lasts_s: f64,
}

impl PersistentErrors {
    /// Initial value, before any radar track is observed.
    const NONE: Self = Self { range_m: 0.0, azimuth: 0.0, lasts_s: 1.0 };
}

/// Prior of the delay of a transponder's time stamps: mean and standard deviation, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StampDelay {
    pub(crate) mean_s: f64,
    pub(crate) sigma_s: f64,
}

/// The hypotheses about one transponder.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct HypothesisBank {
    honest: Hypothesis,
    /// Hypotheses that the transponder is honest and the radar track drifts away from the aircraft.
    walks: Vec<Hypothesis>,
    /// Hypotheses of false reports. Each is boxed, because it has about 1.5 kB, a city has thousands, and a vector
    /// would keep its peak capacity.
    #[expect(clippy::vec_box, reason = "a row by itself is given back by itself")]
    lies: Vec<Box<Hypothesis>>,
    /// Hypothesis of a drift that began without observations. It gives the protection level until an observed one is
    /// old enough.
    unseen: Option<Hypothesis>,
    /// Times of the last observation and of the last new hypotheses of each kind.
    looked: Option<Time>,
    begun: Option<Time>,
    begun_late: Option<Time>,
    /// Number of times that hypotheses were started.
    count: u32,
    track: Option<(SensorIndex, (Time, u16))>,
    slow: PersistentErrors,
}

impl HypothesisBank {
    /// Creates a bank at `time` with only the prior of the time stamps' delay.
    pub(crate) fn new(time: Time, delay: StampDelay) -> Self {
        Self {
            honest: Hypothesis::honest(time, delay),
            walks: Vec::new(),
            lies: Vec::new(),
            unseen: None,
            looked: None,
            begun: None,
            begun_late: None,
            count: 0,
            track: None,
            slow: PersistentErrors::NONE,
        }
    }

    /// Adds an observation of a radar track. `own` is the prior probability that a new track is of this aircraft;
    /// `other` is the log-likelihood of the observation if it is of another aircraft.
    pub(crate) fn observe(&mut self, look: &TrackObservation, own: f64, other: f64) {
        let is_new = self.track != Some((look.radar, look.track));
        self.update(look, is_new.then_some(own), other);
    }

    /// Adds an observation of a radar track that continues the aircraft of the previous track, whose assignment is
    /// already estimated.
    pub(crate) fn observe_continuation(&mut self, look: &TrackObservation, other: f64) {
        self.update(look, None, other);
    }

    /// `own`: as for [`Self::observe`] if a radar track begins; `None` if it continues.
    fn update(&mut self, look: &TrackObservation, own: Option<f64>, other: f64) {
        let dt = self.looked.map_or(1.0, |looked| look.time.seconds_since(looked));
        if own.is_some() {
            self.end_track();
        }
        self.predict(look);
        let (sights, leaving) = (AxisRow::of_look(look), DriftLogProbabilities::within(dt));
        for row in self.all() {
            match own {
                Some(own) => row.begin_track(look, &sights, own),
                None => row.update(look, &sights, other, &leaving),
            }
        }
        self.looked = Some(look.time);
        self.tidy(look.time);
    }

    /// Whether the likeliest hypothesis assigns the observed radar track to this aircraft.
    pub(crate) fn is_own(&self) -> bool {
        let best = self.best(|_| true).filter(|best| best.log() > self.honest.log());
        best.unwrap_or(&self.honest).is_own()
    }

    /// Whether the observed radar track is more likely of this aircraft than of another, if the transponder is honest.
    pub(crate) fn agrees(&self) -> bool {
        self.honest.is_own()
    }

    /// Log-likelihood ratio of false reports of these kinds to honesty.
    fn index_of(&self, is_kind: impl Fn(HypothesisKind) -> bool) -> f64 {
        let count = self.lies.iter().filter(|row| is_kind(row.kind)).count();
        match self.best(is_kind) {
            Some(best) => best.log() - self.honest_log() - 0.5 * (count as f64).ln(),
            None => 0.0,
        }
    }

    fn honest_log(&self) -> f64 {
        self.walks.iter().map(Hypothesis::log).fold(self.honest.log(), f64::max)
    }

    fn best(&self, is_kind: impl Fn(HypothesisKind) -> bool) -> Option<&Hypothesis> {
        let lies = self.lies.iter().map(|row| &**row);
        lies.filter(|row| is_kind(row.kind)).max_by(|a, b| a.log().total_cmp(&b.log()))
    }

    /// Log-likelihood ratio of a false position to honesty.
    pub(crate) fn index(&self) -> f64 {
        self.index_of(|kind| kind != HypothesisKind::Late)
    }

    /// Log-likelihood ratio of wrong time stamps to honesty, if their error is large enough.
    pub(crate) fn late_index(&self) -> Option<f64> {
        let best = self.best(|kind| kind == HypothesisKind::Late)?;
        let (mean_s, sigma_s) = best.late_s();
        (mean_s.abs() - LATE_SIGMAS * sigma_s > LATE_MIN_S)
            .then(|| self.index_of(|kind| kind == HypothesisKind::Late))
    }

    /// Offset of the likeliest false position at `time`, east and north, metres, with its covariance, m².
    pub(crate) fn offset(&self, time: Time) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        Some(self.best(|kind| kind != HypothesisKind::Late)?.offset(time))
    }

    /// Protection level at `time`, metres: 95 % radius of a false position that radar would not have detected. `None`:
    /// unlimited.
    pub(crate) fn protection_level_m(&self, time: Time) -> Option<f64> {
        let is_drift = |row: &&Hypothesis| row.kind == HypothesisKind::Drift;
        let drifts = || self.unseen.iter().chain(self.lies.iter().map(|row| &**row)).filter(is_drift);
        let begun = time + -PROTECTION;
        // The youngest hypothesis that is old enough; if all of these were removed, the oldest.
        let old_enough = drifts().filter(|row| row.since <= begun).max_by_key(|row| row.since);
        let (mean, covariance) = old_enough.or_else(|| drifts().min_by_key(|row| row.since))?.offset(time);
        Some(radius_95_m(&mean, &covariance))
    }

    /// Time of the last observation.
    pub(crate) fn last_observed(&self) -> Option<Time> {
        self.looked
    }

    /// Predicts all hypotheses to the observation's time, prepares them for its radar track, and starts new ones.
    fn predict(&mut self, look: &TrackObservation) {
        let (radar, track) = (self.track.map(|track| track.0), self.track.map(|track| track.1));
        let is_new = track != Some(look.track);
        let rest_s = self.looked.map_or(0.0, |looked| look.time.seconds_since(looked));
        if rest_s >= BEGIN_EVERY_S {
            // The false reports may have begun during the gap in observations.
            self.begin(self.honest.at);
        }
        let unseen = self.begun_unseen(look);
        // All hypotheses have the same time.
        let passage = ElapsedTime::between(self.honest.at, look.time, self.slow);
        self.all().for_each(|row| passage.iter().for_each(|passage| row.predict(passage)));
        self.unseen = unseen.or(self.unseen.take());
        for row in self.all() {
            if radar != Some(look.radar) {
                row.reset_radar(look);
            }
            if is_new {
                row.reset_track(look);
            }
        }
        (self.track, self.slow) = (Some((look.radar, look.track)), look.slow);
        if self.begun.is_none_or(|begun| look.time.seconds_since(begun) >= BEGIN_EVERY_S) {
            self.begin(look.time);
            let mut walk = self.honest.branch(HypothesisKind::Walk, look.time);
            walk.subtract_log(WALK_COST);
            self.walks.push(walk);
        }
        if self.begun_late.is_none_or(|begun| look.time.seconds_since(begun) >= LATE_EVERY_S) {
            self.lies.push(Box::new(self.honest.branch(HypothesisKind::Late, look.time)));
            self.begun_late = Some(look.time);
        }
    }

    /// Hypothesis of a drift that began a minute ago, if there were no observations since.
    fn begun_unseen(&self, look: &TrackObservation) -> Option<Hypothesis> {
        let since = look.time + -PROTECTION;
        if self.looked.is_some_and(|looked| looked > since) {
            return None;
        }
        let mut honest = self.honest.clone();
        let turn = |row: &mut Hypothesis, from, until| {
            ElapsedTime::between(from, until, self.slow).iter().for_each(|passage| row.predict(passage));
        };
        turn(&mut honest, self.honest.at, since);
        let mut unseen = honest.branch(HypothesisKind::Drift, since);
        turn(&mut unseen, since, look.time.max(self.honest.at));
        Some(unseen)
    }

    /// Ends the radar track: if it drifted away from the aircraft, honesty gets the likelihood of that.
    fn end_track(&mut self) {
        let walked = self.walks.drain(..).map(|row| row.log()).fold(f64::NEG_INFINITY, f64::max);
        if walked > self.honest.log() {
            self.honest.end_walked(walked);
        }
        self.all().for_each(Hypothesis::end_track);
    }

    fn all(&mut self) -> impl Iterator<Item = &mut Hypothesis> {
        let lies = self.lies.iter_mut().map(|row| &mut **row);
        [&mut self.honest].into_iter().chain(&mut self.walks).chain(lies).chain(&mut self.unseen)
    }

    /// Starts hypotheses of false positions at `time`.
    fn begin(&mut self, time: Time) {
        self.count = self.count.wrapping_add(1);
        for kind in [HypothesisKind::Drift, HypothesisKind::Jump] {
            let mut row = self.honest.branch(kind, time);
            row.number = self.count;
            if kind == HypothesisKind::Jump {
                row.subtract_log(JUMP_COST);
            }
            self.lies.push(Box::new(row));
        }
        self.begun = Some(time);
    }

    /// Removes irrelevant hypotheses; makes likelihoods relative to honesty.
    fn tidy(&mut self, time: Time) {
        let honest = self.honest.log();
        let best = self.best(|_| true).map_or(0.0, Hypothesis::log);
        self.lies.retain(|row| {
            let (age_s, lead) = (time.seconds_since(row.since), row.log() - honest);
            let is_thin = (age_s > THINNED_S[0] && row.number % 2 != 0)
                || (age_s > THINNED_S[1] && row.number % 4 != 0);
            let is_thinned = is_thin && row.kind != HypothesisKind::Late && row.log() < best;
            let is_behind = lead < BEHIND && age_s > BEHIND_AFTER_S;
            !is_thinned && (lead > LEADS || age_s <= KEPT_S && !is_behind)
        });
        self.unseen.take_if(|row| time.seconds_since(row.since) > KEPT_S);
        self.walks.retain(|row| time.seconds_since(row.since) <= WALK_MAX_S);
        self.all().for_each(|row| row.subtract_log(honest));
    }
}

/// Radius around the origin that contains 95 % of a normal distribution over ground. The squared distance is
/// approximately a χ² variable, shifted and scaled to its first three cumulants (J. P. Imhof, *Computing the
/// distribution of quadratic forms in normal variables*, Biometrika 48, 1961), and the cube root of that is
/// approximately normal (E. B. Wilson, M. M. Hilferty, *The distribution of chi-square*, Proc. National Academy of
/// Sciences 17, 1931). The radius contains 94.6 to 95.7 %.
fn radius_95_m(mean: &Vector2<f64>, covariance: &Matrix2<f64>) -> f64 {
    let square = covariance * covariance;
    let first = covariance.trace() + mean.norm_squared();
    let second = square.trace() + 2.0 * mean.dot(&(covariance * mean));
    let third = (square * covariance).trace() + 3.0 * mean.dot(&(square * mean));
    let freedom = second.powi(3) / third.powi(2);
    let ninth = 2.0 / (9.0 * freedom);
    let quantile = freedom * (1.0 - ninth + NORMAL_95 * ninth.sqrt()).powi(3);
    (first + (quantile - freedom) * (second / freedom).sqrt()).max(0.0).sqrt()
}
