//! Conflict prediction: extrapolates every pair of aircraft in a straight line and computes the probability that one
//! enters the volume of the other.
//!
//! Sans-IO: the caller passes the pictures and their times. The closest approach follows G. Fasano et al.,
//! *Radar/electro-optical data fusion for non-cooperative UAS sense and avoid*, eq. 4; the volumes in space and time follow
//! DO-365. Probabilities are those of a
//! mixture of two normal errors: of a pair that flies straight on, whose real errors are smaller than stated, and of one
//! that turns, whose errors grow by random acceleration (docs/CONFLICTS.md).

mod encounter;
mod interval;
mod level;
mod normal;
mod pairs;
mod passage;
mod volume;

use std::collections::BTreeMap;

use nalgebra::{Matrix4, Vector3};

use crate::frames::Enu;
use crate::time::Time;
use level::{LevelVote, Levels};
use pairs::SortedAircraft;

pub use encounter::{Approach, Relative, Vertical};
pub use interval::{Interval, interval_in_height, interval_over_ground};
pub use level::Level;
pub use passage::Passage;
pub use volume::{AcceptedKinds, Preset, TrafficKind, Volume};

/// Share of a level's probability down to which the level is kept.
const KEPT_PROBABILITY: f64 = 0.5;
/// Factor on the size of a volume within which a violation is kept.
const KEPT_VOLUME: f64 = 1.1;
/// Maximum standard deviation of the relative position of two drones for any level, as a share of the volume's radius.
/// Pairs with a crewed aircraft have no such limit: many of those that state no accuracy have a good one.
const KNOWN_SHARE: f64 = 0.44;
/// Minimum probability of a pair that is listed without a level; a lower one counts as zero.
const WORTH_A_LINE: f64 = 0.01;

/// Unique key of an aircraft: its track number, which may be reused, and the time since which it has that number.
pub type ConflictKey = (u32, Time);

/// An aircraft of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct ConflictAircraft {
    /// Unique key.
    pub key: ConflictKey,
    /// Position in the site's axes.
    pub position: Enu,
    /// Velocity east, north and up, metres a second.
    pub velocity: Vector3<f64>,
    /// Covariance of east and north (metres) and their rates (metres a second).
    pub covariance: Matrix4<f64>,
    /// Variance of the height, covariance of height and climb, variance of the climb: m², m²/s, m²/s². `None`: the
    /// height is not known.
    pub vertical: Option<[f64; 3]>,
    /// Crewed aircraft or drone.
    pub kind: TrafficKind,
    /// Track numbers of tracks that claim to be the same aircraft at another position; they are in no conflict with it.
    pub disputed: Vec<u32>,
}

impl ConflictAircraft {
    /// This aircraft, extrapolated by `age_s`, in seconds.
    #[must_use]
    pub fn moved(mut self, age_s: f64, ahead: &Extrapolation) -> Self {
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

    /// Whether all numbers are finite and the covariance is positive definite.
    fn is_sound(&self) -> bool {
        let is_finite = self.position.0.iter().chain(self.velocity.iter()).all(|number| number.is_finite());
        let vertical = self.vertical.unwrap_or([1.0, 0.0, 1.0]);
        let is_variance =
            vertical[0] > 0.0 && vertical[2] > 0.0 && vertical.iter().all(|number| number.is_finite());
        is_finite && is_variance && self.covariance.cholesky().is_some()
    }
}

/// Thresholds of a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelThreshold {
    /// Minimum probability.
    pub probability: f64,
    /// Maximum time to the entry of the volume, seconds.
    pub time_s: f64,
}

/// Assumed motion of aircraft: straight on for a while, then a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extrapolation {
    /// Prediction horizon, seconds.
    pub horizon_s: f64,
    /// Power spectral density of the acceleration over ground of turning aircraft, m²/s³ on each axis.
    pub acceleration: f64,
    /// Mean time for which a pair flies straight on, seconds.
    pub straight_s: f64,
    /// Reduced errors of aircraft that fly straight on.
    pub steady: SteadyFlightRatios,
}

/// Ratios of real to stated standard deviations while an aircraft flies straight on. The stated ones include the
/// filter's allowance for a turn that has just begun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyFlightRatios {
    /// Ratio of the position over ground.
    pub place: f64,
    /// Ratio of the velocity over ground.
    pub velocity: f64,
    /// Ratio of the height, in straight flight and in turns.
    pub height: f64,
    /// Ratio of the climb, in straight flight and in turns.
    pub climb: f64,
}

impl SteadyFlightRatios {
    /// Ratios found in simulated flights (docs/CONFLICTS.md).
    pub const MEASURED: Self = Self { place: 0.45, velocity: 0.2, height: 0.6, climb: 0.25 };
}

impl Extrapolation {
    /// Variance that random acceleration adds to a position over ground in `t` seconds, m² on each axis.
    fn grown_m2(&self, t: f64) -> f64 {
        self.acceleration * t.powi(3) / 3.0
    }
}

/// Definition of conflicts.
#[derive(Clone, Debug, PartialEq)]
pub struct ConflictRules {
    /// The volumes.
    pub volumes: Vec<Volume>,
    /// Assumed motion of the aircraft.
    pub ahead: Extrapolation,
    /// Thresholds of an advisory.
    pub advisory: LevelThreshold,
    /// Thresholds of a warning.
    pub warning: LevelThreshold,
}

impl ConflictRules {
    /// Result for each level.
    fn level_votes(&self, volume: &Volume, relative: &Relative, passage: &Passage) -> [LevelVote; 3] {
        let is_entered = volume.is_entered(relative, 1.0);
        let is_kept = is_entered || volume.is_entered(relative, KEPT_VOLUME);
        let Passage { probability, entry_s, .. } = *passage;
        let by = |threshold: LevelThreshold| LevelVote {
            reached: is_entered || (probability >= threshold.probability && entry_s <= threshold.time_s),
            kept: is_kept || probability >= KEPT_PROBABILITY * threshold.probability,
        };
        [by(self.advisory), by(self.warning), LevelVote { reached: is_entered, kept: is_kept }]
    }
}

/// A pair and a volume in one evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedConflict {
    /// Identifier of the pair while any level holds for it; `None`: no level holds.
    pub id: Option<u64>,
    /// Indices of both aircraft in [`ConflictEvaluation::aircraft`], the lower first.
    pub pair: [usize; 2],
    /// Index of the volume.
    pub volume: usize,
    /// The level, and the time since which it holds.
    pub level: Option<(Level, Time)>,
    /// Present state of b relative to a.
    pub relative: Relative,
    /// The closest point of approach.
    pub approach: Approach,
    /// Probability of being inside the volume at any time within the horizon; 0 if it is less than 0.01.
    pub probability: f64,
    /// Time to the expected entry, seconds ([`Passage::entry_s`]).
    pub entry_s: f64,
    /// Time to the expected exit, seconds ([`Passage::exit_s`]).
    pub exit_s: Option<f64>,
}

/// Result of an evaluation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConflictEvaluation {
    /// The aircraft that took part, by key.
    pub aircraft: Vec<ConflictAircraft>,
    /// Pairs with a level, or with a probability of at least 0.01; by pair, then by volume.
    pub conflicts: Vec<PredictedConflict>,
    /// Levels that hold although one of the pair is missing.
    pub unseen: Vec<HeldLevel>,
    /// Number of pairs that were near enough to be tested.
    pub tested: usize,
    /// Number of aircraft excluded because of an invalid covariance.
    pub left_out: usize,
}

/// A level that holds although one of the pair is missing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldLevel {
    /// Identifier of the conflict.
    pub id: u64,
    /// Index of the volume.
    pub volume: usize,
    /// The level, and the time since which it holds.
    pub level: (Level, Time),
}

/// A pair with remembered levels.
#[derive(Clone, Debug)]
struct PairHistory {
    id: Option<u64>,
    /// Levels by volume.
    levels: Vec<Levels>,
    /// Time of the last evaluation that contained both.
    judged: Time,
}

/// Finds conflicts in successive evaluations, one second apart.
#[derive(Debug)]
pub struct Conflicts {
    rules: ConflictRules,
    next_id: u64,
    known: BTreeMap<(ConflictKey, ConflictKey), PairHistory>,
    /// Time of the last evaluation.
    time: Option<Time>,
    pairs: SortedAircraft,
}

impl Conflicts {
    /// Creates a predictor with these rules.
    pub fn new(rules: ConflictRules) -> Self {
        Self { rules, next_id: 1, known: BTreeMap::new(), time: None, pairs: SortedAircraft::default() }
    }

    /// The rules.
    pub fn rules(&self) -> &ConflictRules {
        &self.rules
    }

    /// Evaluates the aircraft of a picture; each key occurs at most once. A time before the last one discards all
    /// levels.
    pub fn evaluate(&mut self, time: Time, mut aircraft: Vec<ConflictAircraft>) -> ConflictEvaluation {
        if self.time.replace(time).is_some_and(|before| time < before) {
            self.known.clear();
        }
        let given = aircraft.len();
        aircraft.retain(ConflictAircraft::is_sound);
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
            self.evaluate_pair(time, &aircraft, pair, is_known, &mut conflicts);
        }
        let mut unseen = Vec::new();
        self.known.retain(|_, known| {
            if known.judged != time {
                known.levels.iter_mut().for_each(|levels| levels.update(time, [LevelVote::default(); 3]));
                known.drop_id();
                unseen.extend(known.held());
            }
            !known.levels.iter().all(Levels::is_blank)
        });
        ConflictEvaluation { aircraft, conflicts, unseen, tested, left_out }
    }

    /// The remembered pairs that are present, at any distance, in order.
    fn known_among(&self, aircraft: &[ConflictAircraft]) -> Vec<(usize, usize)> {
        let place = |key: &ConflictKey| aircraft.binary_search_by_key(key, |one| one.key).ok();
        self.known.keys().filter_map(|(a, b)| Some((place(a)?, place(b)?))).collect()
    }

    fn evaluate_pair(
        &mut self,
        time: Time,
        aircraft: &[ConflictAircraft],
        (a, b): (usize, usize),
        is_known: bool,
        conflicts: &mut Vec<PredictedConflict>,
    ) {
        let (one, other) = (&aircraft[a], &aircraft[b]);
        if one.is_also(other) {
            return;
        }
        let relative = Relative::of(one, other);
        let key = (one.key, other.key);
        let mut known = is_known.then(|| self.known.remove(&key)).flatten();
        let first = conflicts.len();
        let is_crewed = [one.kind, other.kind].contains(&TrafficKind::Crewed);
        for (index, volume) in self.rules.volumes.iter().enumerate() {
            if !volume.is_between(one.kind, other.kind) {
                continue;
            }
            let passage = relative.passage(volume, &self.rules.ahead, WORTH_A_LINE);
            // Levels of pairs with uncertain positions would come and go.
            let is_certain = is_crewed || relative.sigma_m() < KNOWN_SHARE * volume.horizontal_m;
            let said = match is_certain {
                true => self.rules.level_votes(volume, &relative, &passage),
                false => Default::default(),
            };
            // Most pairs have nothing to remember.
            if known.is_none() && said.iter().any(|say| say.reached) {
                known = Some(PairHistory::new(&self.rules, time));
            }
            let level = known.as_mut().and_then(|known| {
                known.levels[index].update(time, said);
                known.levels[index].worst()
            });
            if level.is_some() || passage.probability > 0.0 {
                let approach = relative.approach(&self.rules.ahead);
                let (pair, Passage { probability, entry_s, exit_s }) = ([a, b], passage);
                conflicts.push(PredictedConflict {
                    id: None,
                    pair,
                    volume: index,
                    level,
                    relative,
                    approach,
                    probability,
                    entry_s,
                    exit_s,
                });
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

impl PairHistory {
    fn new(rules: &ConflictRules, time: Time) -> Self {
        Self { id: None, levels: vec![Levels::default(); rules.volumes.len()], judged: time }
    }

    /// The levels that hold.
    fn held(&self) -> impl Iterator<Item = HeldLevel> {
        let volumes = self.levels.iter().enumerate();
        volumes
            .filter_map(|(volume, levels)| Some(HeldLevel { id: self.id?, volume, level: levels.worst()? }))
    }

    /// Removes the identifier if no level holds.
    fn drop_id(&mut self) {
        if self.levels.iter().all(|levels| levels.worst().is_none()) {
            self.id = None;
        }
    }
}

#[cfg(test)]
mod tests;
