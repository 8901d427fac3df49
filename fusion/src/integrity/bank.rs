//! Does a transponder lie, and since when? A bank of change times (generalised likelihood ratio): one row that it is honest,
//! and for every few seconds of the last minutes rows that it has begun to lie then. Every row is a Kalman filter of the same
//! state over the same looks of radar tracks; the rows' likelihoods are compared.
//!
//! A. S. Willsky, H. L. Jones, *A generalized likelihood ratio approach to the detection and estimation of jumps in linear
//! systems* (IEEE Trans. Automatic Control 21, 1976).

mod row;
#[cfg(test)]
mod tests;

use jiff::SignedDuration;
use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use crate::report::SensorIndex;
use crate::time::Time;
use row::{Kind, Leaving, Passage, Row, Sight};

/// Rows begin so far apart, seconds; those of a shifted time.
const BEGIN_EVERY_S: f64 = 5.0;
const LATE_EVERY_S: f64 = 30.0;
/// A row is kept so long, seconds, or while it leads by this.
const KEPT_S: f64 = 150.0;
const LEADS: f64 = 3.0;
/// Of the rows older than this every second is kept, of those older than the other every fourth, seconds.
const THINNED_S: [f64; 2] = [30.0, 75.0];
/// A row that is behind by more than this is given up once it is older than `BEHIND_AFTER_S`.
const BEHIND: f64 = -12.0;
const BEHIND_AFTER_S: f64 = 20.0;
/// Where a radar track of another aircraft may be: sigma of the offset, each axis, metres.
pub(crate) const ELSEWHERE_M: f64 = 150.0;
/// The protection level is that of a lie which began at least this long ago.
const PROTECTION: SignedDuration = SignedDuration::from_secs(60);
/// A radar track walks off for no longer than this, seconds; that it begins to within five of them costs so much, natural
/// logarithm.
const WALK_MAX_S: f64 = 14.0;
const WALK_COST: f64 = 2.6;
/// A jump shows in the reports themselves: a row of one that did not begins behind by this, natural logarithm.
const JUMP_COST: f64 = 3.0;
/// A stamp that is this late or early is wrong, seconds.
const LATE_MIN_S: f64 = 0.5;
/// It is by more than so many standard deviations.
const LATE_SIGMAS: f64 = 2.0;
/// A standard normal variable is below this with a probability of 95 %.
const NORMAL_95: f64 = 1.644_853_626_951_472;

/// What a radar track shows of an aircraft within a second.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Look {
    /// Middle of the second.
    pub(crate) time: Time,
    /// The radar, and its track: when that began, and its number.
    pub(crate) radar: SensorIndex,
    pub(crate) track: (Time, u16),
    /// Mean of the plots less the transponder's curve at their times: outward and clockwise, metres.
    pub(crate) offset_m: [f64; 2],
    /// Variance of these that is new with each look, m².
    pub(crate) white_m2: [f64; 2],
    /// Unit vectors outward and clockwise, and the distance over ground, metres.
    pub(crate) axes: [Vector2<f64>; 2],
    pub(crate) range_m: f64,
    /// Velocity of the curve, metres a second.
    pub(crate) velocity: Vector2<f64>,
    /// The slow errors of a track of the radar.
    pub(crate) slow: Slow,
    /// Standard deviations of its alignment: range, metres, and azimuth, radians.
    pub(crate) alignment: [f64; 2],
}

/// The errors of a radar track that last for a while: standard deviations, and correlation time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Slow {
    /// Metres.
    pub(crate) range_m: f64,
    /// Radians.
    pub(crate) azimuth: f64,
    /// Seconds.
    pub(crate) lasts_s: f64,
}

impl Slow {
    /// Before any radar track was looked at.
    const NONE: Self = Self { range_m: 0.0, azimuth: 0.0, lasts_s: 1.0 };
}

/// How late a transponder's stamps are by what is known without looking: mean and standard deviation, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Delay {
    pub(crate) mean_s: f64,
    pub(crate) sigma_s: f64,
}

/// The rows.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Bank {
    honest: Row,
    /// Honest, while the radar track walks off.
    walks: Vec<Row>,
    /// Each by itself: it has some 1.5 kB, a city's drones have thousands, and the room for those that went would stay.
    #[expect(clippy::vec_box, reason = "a row by itself is given back by itself")]
    lies: Vec<Box<Row>>,
    /// A drift that began while nobody looked: it bounds what could hide until one that was looked at is old enough.
    unseen: Option<Row>,
    /// The time of the last look, and that of the last rows.
    looked: Option<Time>,
    begun: Option<Time>,
    begun_late: Option<Time>,
    /// How many times rows were begun.
    count: u32,
    track: Option<(SensorIndex, (Time, u16))>,
    slow: Slow,
}

impl Bank {
    /// Nothing is known of the transponder but how late its stamps are; what it had looked at would be from `time` on.
    pub(crate) fn new(time: Time, delay: Delay) -> Self {
        Self {
            honest: Row::honest(time, delay),
            walks: Vec::new(),
            lies: Vec::new(),
            unseen: None,
            looked: None,
            begun: None,
            begun_late: None,
            count: 0,
            track: None,
            slow: Slow::NONE,
        }
    }

    /// A look at a radar track. `own`: probability that it is the aircraft's own before it is looked at. `other`:
    /// log-likelihood of the look if it is another aircraft.
    pub(crate) fn take(&mut self, look: &Look, own: f64, other: f64) {
        let is_new = self.track != Some((look.radar, look.track));
        self.see(look, is_new.then_some(own), other);
    }

    /// The same for a radar track that goes on with the aircraft of the last one: whose that is was found out before.
    pub(crate) fn go_on(&mut self, look: &Look, other: f64) {
        self.see(look, None, other);
    }

    /// `own`: as of [`Self::take`], where a radar track begins; `None`: it goes on.
    fn see(&mut self, look: &Look, own: Option<f64>, other: f64) {
        let dt = self.looked.map_or(1.0, |looked| look.time.seconds_since(looked));
        if own.is_some() {
            self.end_track();
        }
        self.turn_to(look);
        let (sights, leaving) = (Sight::of_look(look), Leaving::within(dt));
        for row in self.all() {
            match own {
                Some(own) => row.begin_track(look, &sights, own),
                None => row.take(look, &sights, other, &leaving),
            }
        }
        self.looked = Some(look.time);
        self.tidy(look.time);
    }

    /// The radar track that is looked at, where the likeliest row has it for the aircraft's own.
    pub(crate) fn is_own(&self) -> bool {
        let best = self.best(|_| true).filter(|best| best.log() > self.honest.log());
        best.unwrap_or(&self.honest).is_own()
    }

    /// Whether the radar track that is looked at is rather the aircraft's own, if the transponder is honest.
    pub(crate) fn agrees(&self) -> bool {
        self.honest.is_own()
    }

    /// How much likelier a lie of this kind is than honesty, natural logarithm.
    fn index_of(&self, is_kind: impl Fn(Kind) -> bool) -> f64 {
        let count = self.lies.iter().filter(|row| is_kind(row.kind)).count();
        match self.best(is_kind) {
            Some(best) => best.log() - self.honest_log() - 0.5 * (count as f64).ln(),
            None => 0.0,
        }
    }

    fn honest_log(&self) -> f64 {
        self.walks.iter().map(Row::log).fold(self.honest.log(), f64::max)
    }

    fn best(&self, is_kind: impl Fn(Kind) -> bool) -> Option<&Row> {
        let lies = self.lies.iter().map(|row| &**row);
        lies.filter(|row| is_kind(row.kind)).max_by(|a, b| a.log().total_cmp(&b.log()))
    }

    /// How much likelier it is that the place is a lie than that it is not, natural logarithm.
    pub(crate) fn index(&self) -> f64 {
        self.index_of(|kind| kind != Kind::Late)
    }

    /// The same for the time, where the stamps would be wrong by enough.
    pub(crate) fn late_index(&self) -> Option<f64> {
        let best = self.best(|kind| kind == Kind::Late)?;
        let (mean_s, sigma_s) = best.late_s();
        (mean_s.abs() - LATE_SIGMAS * sigma_s > LATE_MIN_S).then(|| self.index_of(|kind| kind == Kind::Late))
    }

    /// The offset of the likeliest lie at `time`, east and north, metres, with its covariance, m².
    pub(crate) fn offset(&self, time: Time) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        Some(self.best(|kind| kind != Kind::Late)?.offset(time))
    }

    /// The lie that radar would not have shown at `time`, metres: radius that holds 95 %. `None`: any lie.
    pub(crate) fn protection_level_m(&self, time: Time) -> Option<f64> {
        let is_drift = |row: &&Row| row.kind == Kind::Drift;
        let drifts = || self.unseen.iter().chain(self.lies.iter().map(|row| &**row)).filter(is_drift);
        let begun = time + -PROTECTION;
        // The youngest that is old enough; where all of these were given up, the oldest.
        let old_enough = drifts().filter(|row| row.since <= begun).max_by_key(|row| row.since);
        let (mean, covariance) = old_enough.or_else(|| drifts().min_by_key(|row| row.since))?.offset(time);
        Some(radius_95_m(&mean, &covariance))
    }

    /// The last look.
    pub(crate) fn looked(&self) -> Option<Time> {
        self.looked
    }

    /// Brings all rows to the look's time, and to its radar track; begins new ones.
    fn turn_to(&mut self, look: &Look) {
        let (radar, track) = (self.track.map(|track| track.0), self.track.map(|track| track.1));
        let is_new = track != Some(look.track);
        let rest_s = self.looked.map_or(0.0, |looked| look.time.seconds_since(looked));
        if rest_s >= BEGIN_EVERY_S {
            // It may have begun while nobody looked.
            self.begin(self.honest.at);
        }
        let unseen = self.begun_unseen(look);
        // All rows are at one time.
        let passage = Passage::between(self.honest.at, look.time, self.slow);
        self.all().for_each(|row| passage.iter().for_each(|passage| row.turn(passage)));
        self.unseen = unseen.or(self.unseen.take());
        for row in self.all() {
            if radar != Some(look.radar) {
                row.meet_radar(look);
            }
            if is_new {
                row.meet_track(look);
            }
        }
        (self.track, self.slow) = (Some((look.radar, look.track)), look.slow);
        if self.begun.is_none_or(|begun| look.time.seconds_since(begun) >= BEGIN_EVERY_S) {
            self.begin(look.time);
            let mut walk = self.honest.branch(Kind::Walk, look.time);
            walk.relate(WALK_COST);
            self.walks.push(walk);
        }
        if self.begun_late.is_none_or(|begun| look.time.seconds_since(begun) >= LATE_EVERY_S) {
            self.lies.push(Box::new(self.honest.branch(Kind::Late, look.time)));
            self.begun_late = Some(look.time);
        }
    }

    /// A drift that began a minute ago, where nobody has looked since.
    fn begun_unseen(&self, look: &Look) -> Option<Row> {
        let since = look.time + -PROTECTION;
        if self.looked.is_some_and(|looked| looked > since) {
            return None;
        }
        let mut honest = self.honest.clone();
        let turn = |row: &mut Row, from, until| {
            Passage::between(from, until, self.slow).iter().for_each(|passage| row.turn(passage));
        };
        turn(&mut honest, self.honest.at, since);
        let mut unseen = honest.branch(Kind::Drift, since);
        turn(&mut unseen, since, look.time.max(self.honest.at));
        Some(unseen)
    }

    /// The radar track has ended: if it had walked off, honesty is as likely as that.
    fn end_track(&mut self) {
        let walked = self.walks.drain(..).map(|row| row.log()).fold(f64::NEG_INFINITY, f64::max);
        if walked > self.honest.log() {
            self.honest.end_walked(walked);
        }
        self.all().for_each(Row::end_track);
    }

    fn all(&mut self) -> impl Iterator<Item = &mut Row> {
        let lies = self.lies.iter_mut().map(|row| &mut **row);
        [&mut self.honest].into_iter().chain(&mut self.walks).chain(lies).chain(&mut self.unseen)
    }

    /// Rows of lies that begin then.
    fn begin(&mut self, time: Time) {
        self.count = self.count.wrapping_add(1);
        for kind in [Kind::Drift, Kind::Jump] {
            let mut row = self.honest.branch(kind, time);
            row.number = self.count;
            if kind == Kind::Jump {
                row.relate(JUMP_COST);
            }
            self.lies.push(Box::new(row));
        }
        self.begun = Some(time);
    }

    /// Gives up the rows that say nothing any more; likelihoods are relative to that of honesty.
    fn tidy(&mut self, time: Time) {
        let honest = self.honest.log();
        let best = self.best(|_| true).map_or(0.0, Row::log);
        self.lies.retain(|row| {
            let (age_s, lead) = (time.seconds_since(row.since), row.log() - honest);
            let is_thin = (age_s > THINNED_S[0] && row.number % 2 != 0)
                || (age_s > THINNED_S[1] && row.number % 4 != 0);
            let is_thinned = is_thin && row.kind != Kind::Late && row.log() < best;
            let is_behind = lead < BEHIND && age_s > BEHIND_AFTER_S;
            !is_thinned && (lead > LEADS || age_s <= KEPT_S && !is_behind)
        });
        self.unseen.take_if(|row| time.seconds_since(row.since) > KEPT_S);
        self.walks.retain(|row| time.seconds_since(row.since) <= WALK_MAX_S);
        self.all().for_each(|row| row.relate(honest));
    }
}

/// Radius around nothing that holds 95 % of a normal distribution over ground. The squared distance is nearly a χ² variable,
/// shifted and scaled to its first three cumulants (J. P. Imhof, *Computing the distribution of quadratic forms in normal
/// variables*, Biometrika 48, 1961), and the cube root of that nearly a normal one (E. B. Wilson, M. M. Hilferty, *The
/// distribution of chi-square*, Proc. National Academy of Sciences 17, 1931): 94.6 to 95.7 % are held.
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
