//! Who will come near whom: every pair of aircraft flown straight on, with the probability that one enters the volume of the
//! other.
//!
//! Sans-IO, told the pictures and their times. The geometry is that of G. Fasano et al., *Radar/electro-optical data fusion for
//! non-cooperative UAS sense and avoid*, eq. 4; probabilities are those of a mixture of two normal errors: of a pair that
//! flies straight on, which is known better than stated, and of one that turns, whose errors grow by random acceleration
//! (docs/CONFLICTS.md).

mod encounter;
mod level;
mod normal;
mod pairs;
mod volume;

use std::collections::BTreeMap;

use nalgebra::{Matrix4, Vector3};

use crate::frames::Enu;
use crate::time::Time;
use level::{Levels, Say};
use pairs::Pairs;

pub use encounter::{Approach, Relative, Vertical};
pub use level::Level;
pub use volume::{Kind, Preset, Side, Volume};

/// Share of a level's probability down to which it is kept.
const KEPT_PROBABILITY: f64 = 0.5;
/// A violation is kept within a volume larger by this factor.
const KEPT_VOLUME: f64 = 1.1;
/// Drones whose relative position has a larger standard deviation than this share of a volume's radius reach no level of it.
/// Where somebody is on board the probability alone decides: many who state no accuracy have a good one.
const KNOWN_SHARE: f64 = 0.44;
/// Probability from which a pair is worth a line where no level holds; what is less counts as none.
const WORTH_A_LINE: f64 = 0.01;

/// What tells an aircraft from all others: its track number, which comes again, and since when it is that one's.
pub type Key = (u32, Time);

/// An aircraft of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Aircraft {
    /// Which one.
    pub key: Key,
    /// Where, in the site's axes.
    pub position: Enu,
    /// East, north, up, metres a second.
    pub velocity: Vector3<f64>,
    /// Covariance of east and north (metres) and their rates (metres a second).
    pub covariance: Matrix4<f64>,
    /// Variance of the height, its covariance with the climb, variance of the climb: m², m²/s, m²/s². `None`: the height is
    /// not known.
    pub vertical: Option<[f64; 3]>,
    /// What it is.
    pub kind: Kind,
    /// Track numbers of those that claim to be the same aircraft elsewhere: nobody meets himself.
    pub disputed: Vec<u32>,
}

impl Aircraft {
    /// The same `age_s` later.
    #[must_use]
    pub fn moved(mut self, age_s: f64, ahead: &Ahead) -> Self {
        let grown_m2 = ahead.grown_m2(age_s);
        let mut flight = Matrix4::identity();
        (flight[(0, 2)], flight[(1, 3)]) = (age_s, age_s);
        self.position = Enu::from(self.position.0 + self.velocity * age_s);
        self.covariance = flight * self.covariance * flight.transpose();
        for axis in [0, 1] {
            self.covariance[(axis, axis)] += grown_m2;
        }
        self.vertical = self
            .vertical
            .map(|[hh, hc, cc]| [hh + 2.0 * age_s * hc + age_s * age_s * cc, hc + age_s * cc, cc]);
        self
    }

    /// Whether both claim to be the same aircraft.
    fn is_also(&self, other: &Self) -> bool {
        self.disputed.contains(&other.key.0) || other.disputed.contains(&self.key.0)
    }

    /// Whether its numbers are finite and its covariance is that of something.
    fn is_sound(&self) -> bool {
        let is_finite = self.position.0.iter().chain(self.velocity.iter()).all(|number| number.is_finite());
        let vertical = self.vertical.unwrap_or([1.0, 0.0, 1.0]);
        let is_variance =
            vertical[0] > 0.0 && vertical[2] > 0.0 && vertical.iter().all(|number| number.is_finite());
        is_finite && is_variance && self.covariance.cholesky().is_some()
    }
}

/// When a level is reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    /// Least probability.
    pub probability: f64,
    /// Most time to the closest point of approach, seconds.
    pub time_s: f64,
}

/// How aircraft fly on: straight for a while, then they turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ahead {
    /// How far ahead is looked, seconds.
    pub horizon_s: f64,
    /// Power spectral density of the acceleration over ground of those that turn, m²/s³ an axis.
    pub acceleration: f64,
    /// Mean time for which a pair flies straight on, seconds.
    pub straight_s: f64,
    /// How much better those are known that fly straight on.
    pub steady: Steady,
}

/// Shares of the stated standard deviations that are real while an aircraft flies straight on: the rest is what the filter
/// allows for those that have just begun to turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steady {
    /// Of the position over ground.
    pub place: f64,
    /// Of the velocity over ground.
    pub velocity: f64,
    /// Of the height, whether it turns or not.
    pub height: f64,
    /// Of the climb, whether it turns or not.
    pub climb: f64,
}

impl Steady {
    /// As simulated flights show it (docs/CONFLICTS.md).
    pub const MEASURED: Self = Self { place: 0.45, velocity: 0.2, height: 0.6, climb: 0.25 };
}

impl Ahead {
    /// What random acceleration adds in `t` seconds to the variance of a position over ground, m² an axis.
    fn grown_m2(&self, t: f64) -> f64 {
        self.acceleration * t.powi(3) / 3.0
    }
}

/// What counts as a conflict.
#[derive(Clone, Debug, PartialEq)]
pub struct Rules {
    /// The volumes.
    pub volumes: Vec<Volume>,
    /// How they fly on.
    pub ahead: Ahead,
    /// When an advisory is given.
    pub advisory: Threshold,
    /// When a warning is given.
    pub warning: Threshold,
}

impl Rules {
    /// What the figures of a pair say of each level.
    fn said(&self, volume: &Volume, relative: &Relative, approach: &Approach, probability: f64) -> [Say; 3] {
        let is_entered = volume.is_entered(relative, approach, 1.0);
        let is_kept = volume.is_entered(relative, approach, KEPT_VOLUME);
        let by = |threshold: Threshold| Say {
            reached: is_entered
                || (probability >= threshold.probability && approach.t_cpa_s <= threshold.time_s),
            kept: is_kept || probability >= KEPT_PROBABILITY * threshold.probability,
        };
        [by(self.advisory), by(self.warning), Say { reached: is_entered, kept: is_kept }]
    }
}

/// A pair and a volume in one evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conflict {
    /// The same for a pair as long as any level holds for it; `None`: none does.
    pub id: Option<u64>,
    /// Indices of both among the aircraft of the evaluation, the lower first.
    pub pair: [usize; 2],
    /// Index of the volume.
    pub volume: usize,
    /// The level, and since when it holds.
    pub level: Option<(Level, Time)>,
    /// b seen from a now.
    pub relative: Relative,
    /// The closest point of approach.
    pub approach: Approach,
    /// Of being within the volume then; 0 where it is less than 0.01.
    pub probability: f64,
}

/// What an evaluation found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evaluation {
    /// Those that took part, by key.
    pub aircraft: Vec<Aircraft>,
    /// Those with a level, or with a probability of at least 0.01; by pair, then by volume.
    pub conflicts: Vec<Conflict>,
    /// Those that hold although one of both is missing.
    pub unseen: Vec<Unseen>,
    /// Pairs that were near enough to be looked at.
    pub tested: usize,
    /// Aircraft that were left out, because their covariance is none.
    pub left_out: usize,
}

/// A level that holds although one of both is missing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unseen {
    /// Of the conflict.
    pub id: u64,
    /// Index of the volume.
    pub volume: usize,
    /// The level, and since when it holds.
    pub level: (Level, Time),
}

/// A pair that is remembered.
#[derive(Clone, Debug)]
struct Known {
    id: Option<u64>,
    /// By volume.
    levels: Vec<Levels>,
    /// The last evaluation in which both were there.
    judged: Time,
}

/// Finds conflicts, evaluation by evaluation, a second apart.
#[derive(Debug)]
pub struct Conflicts {
    rules: Rules,
    next_id: u64,
    known: BTreeMap<(Key, Key), Known>,
    /// The last evaluation.
    time: Option<Time>,
    pairs: Pairs,
}

impl Conflicts {
    /// By these rules.
    pub fn new(rules: Rules) -> Self {
        Self { rules, next_id: 1, known: BTreeMap::new(), time: None, pairs: Pairs::default() }
    }

    /// The rules.
    pub fn rules(&self) -> &Rules {
        &self.rules
    }

    /// Evaluates the aircraft of a picture, each key at most once. A time before the last one begins anew.
    pub fn evaluate(&mut self, time: Time, mut aircraft: Vec<Aircraft>) -> Evaluation {
        if self.time.replace(time).is_some_and(|before| time < before) {
            self.known.clear();
        }
        let given = aircraft.len();
        aircraft.retain(Aircraft::is_sound);
        let left_out = given - aircraft.len();
        aircraft.sort_by_key(|one| one.key);
        let (mut pairs, tested) = self.pairs.find(&aircraft, &self.rules);
        let known = self.known_among(&aircraft);
        pairs.extend(&known);
        pairs.sort_unstable();
        pairs.dedup();
        let mut known = known.into_iter().peekable();
        let mut conflicts = Vec::new();
        for pair in pairs {
            let is_known = known.next_if_eq(&pair).is_some();
            self.judge(time, &aircraft, pair, is_known, &mut conflicts);
        }
        let mut unseen = Vec::new();
        self.known.retain(|_, known| {
            if known.judged != time {
                known.levels.iter_mut().for_each(|levels| levels.note(time, [Say::default(); 3]));
                known.drop_id();
                unseen.extend(known.held());
            }
            !known.levels.iter().all(Levels::is_blank)
        });
        Evaluation { aircraft, conflicts, unseen, tested, left_out }
    }

    /// The pairs that are remembered, wherever both are by now, in order.
    fn known_among(&self, aircraft: &[Aircraft]) -> Vec<(usize, usize)> {
        let place = |key: &Key| aircraft.binary_search_by_key(key, |one| one.key).ok();
        self.known.keys().filter_map(|(a, b)| Some((place(a)?, place(b)?))).collect()
    }

    fn judge(
        &mut self,
        time: Time,
        aircraft: &[Aircraft],
        (a, b): (usize, usize),
        is_known: bool,
        conflicts: &mut Vec<Conflict>,
    ) {
        let (one, other) = (&aircraft[a], &aircraft[b]);
        if one.is_also(other) {
            return;
        }
        let relative = Relative::of(one, other);
        let approach = relative.approach(&self.rules.ahead);
        let key = (one.key, other.key);
        let mut known = is_known.then(|| self.known.remove(&key)).flatten();
        let first = conflicts.len();
        let is_crewed = [one.kind, other.kind].contains(&Kind::Crewed);
        for (index, volume) in self.rules.volumes.iter().enumerate() {
            if !volume.is_between(one.kind, other.kind) {
                continue;
            }
            let probability = approach.probability(volume.horizontal_m, volume.vertical_m, WORTH_A_LINE);
            // Those that are known too poorly would come and go.
            let is_certain = is_crewed || relative.sigma_m() < KNOWN_SHARE * volume.horizontal_m;
            let said = match is_certain {
                true => self.rules.said(volume, &relative, &approach, probability),
                false => Default::default(),
            };
            // Most pairs have nothing to remember.
            if known.is_none() && said.iter().any(|say| say.reached) {
                known = Some(Known::new(&self.rules, time));
            }
            let level = known.as_mut().and_then(|known| {
                known.levels[index].note(time, said);
                known.levels[index].worst()
            });
            if level.is_some() || probability > 0.0 {
                let pair = [a, b];
                let new = Conflict { id: None, pair, volume: index, level, relative, approach, probability };
                conflicts.push(new);
            }
        }
        let Some(mut known) = known else { return };
        known.judged = time;
        known.drop_id();
        if known.id.is_none() && known.levels.iter().any(|levels| levels.worst().is_some()) {
            known.id = Some(self.next_id);
            self.next_id += 1;
        }
        for conflict in conflicts[first..].iter_mut().filter(|conflict| conflict.level.is_some()) {
            conflict.id = known.id;
        }
        if !known.levels.iter().all(Levels::is_blank) {
            self.known.insert(key, known);
        }
    }
}

impl Known {
    fn new(rules: &Rules, time: Time) -> Self {
        Self { id: None, levels: vec![Levels::default(); rules.volumes.len()], judged: time }
    }

    /// The levels that hold.
    fn held(&self) -> impl Iterator<Item = Unseen> {
        let volumes = self.levels.iter().enumerate();
        volumes.filter_map(|(volume, levels)| Some(Unseen { id: self.id?, volume, level: levels.worst()? }))
    }

    /// Without a level it is no conflict any more.
    fn drop_id(&mut self) {
        if self.levels.iter().all(|levels| levels.worst().is_none()) {
            self.id = None;
        }
    }
}

#[cfg(test)]
mod tests;
