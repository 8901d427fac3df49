//! Conflict prediction: extrapolates every pair of aircraft in a straight line and computes the probability that one
//! enters the volume of the other.
//!
//! Sans-IO: the caller passes the pictures and their times. The closest approach follows G. Fasano et al.,
//! *Radar/electro-optical data fusion for non-cooperative UAS sense and avoid*, eq. 4; the volumes in space and time follow
//! DO-365. Probabilities are those of a mixture of normal errors: of a pair that flies straight on, along the lines fitted to
//! its past positions, and of one that turns, whose errors grow by random acceleration (docs/CONFLICTS.md).

mod aircraft;
mod encounter;
mod extrapolation;
mod history;
mod interval;
mod level;
mod line;
mod motion;
mod normal;
mod outlook;
mod pairs;
mod passage;
mod rules;
mod volume;

use std::collections::BTreeMap;

use fusion::time::{SECOND, Time};
use history::FlightHistory;
use level::{LevelVote, Levels};
use motion::{Motion, PairMotion, are_twins};
use pairs::SortedAircraft;
use rules::WORTH_A_LINE;

pub use aircraft::{ConflictAircraft, ConflictKey};
pub use encounter::{Approach, Relative, Vertical};
pub use extrapolation::{Extrapolation, SteadyFlightRatios};
pub use interval::{Interval, interval_in_height, interval_over_ground};
pub use level::Level;
pub use passage::Passage;
pub use rules::{ConflictRules, LevelThreshold};
pub use volume::{AcceptedKinds, Preset, TrafficKind, Volume};

/// Time after which an aircraft that is no longer given is forgotten, nanoseconds.
const FORGOTTEN_NS: u64 = 20 * SECOND as u64;

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
    histories: BTreeMap<ConflictKey, FlightHistory>,
    /// Expected motion of the aircraft of this evaluation.
    motions: Vec<Motion>,
}

impl Conflicts {
    /// Creates a predictor with these rules.
    pub fn new(rules: ConflictRules) -> Self {
        Self {
            rules,
            next_id: 1,
            known: BTreeMap::new(),
            time: None,
            pairs: SortedAircraft::default(),
            histories: BTreeMap::new(),
            motions: Vec::new(),
        }
    }

    /// The rules.
    pub fn rules(&self) -> &ConflictRules {
        &self.rules
    }

    /// Evaluates the aircraft of a picture; each key occurs at most once. A time before the last one discards all
    /// levels and histories.
    pub fn evaluate(&mut self, time: Time, mut aircraft: Vec<ConflictAircraft>) -> ConflictEvaluation {
        if self.time.replace(time).is_some_and(|before| time < before) {
            self.known.clear();
            self.histories.clear();
        }
        let given = aircraft.len();
        aircraft.retain(ConflictAircraft::is_sound);
        let left_out = given - aircraft.len();
        aircraft.sort_by_key(|one| one.key);
        self.expect(time, &mut aircraft);
        let (mut pairs, tested) = self.pairs.find(&aircraft, &self.motions, &self.rules);
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

    /// Adds the aircraft to their histories and determines their expected motions. Those that are not shown and cannot be
    /// followed are removed.
    fn expect(&mut self, time: Time, aircraft: &mut Vec<ConflictAircraft>) {
        let Self { rules: ConflictRules { ahead, .. }, histories, motions, .. } = self;
        motions.clear();
        aircraft.retain(|one| {
            let history = histories.entry(one.key).or_insert_with(|| FlightHistory::new(time));
            history.add(time, one, &ahead.steady);
            let motion = Motion::of(history, time, one, ahead);
            let takes_part = one.is_shown || motion.is_coasting();
            if takes_part {
                motions.push(motion);
            }
            takes_part
        });
        histories.retain(|_, history| time.nanos().abs_diff(history.seen.nanos()) <= FORGOTTEN_NS);
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
        let pair = [(one, &self.motions[a]), (other, &self.motions[b])];
        if are_twins(&relative, pair[0], pair[1]) {
            return;
        }
        let motion = PairMotion::of(&relative, pair[0], pair[1], &self.rules.ahead);
        let key = (one.key, other.key);
        let mut known = is_known.then(|| self.known.remove(&key)).flatten();
        let first = conflicts.len();
        for (index, volume) in self.rules.volumes.iter().enumerate() {
            if !volume.is_between(one.kind, other.kind) {
                continue;
            }
            let passage = motion.passage(volume, &self.rules.ahead, WORTH_A_LINE);
            let said = self.rules.level_votes(volume, &relative, &passage, &motion);
            // Most pairs have nothing to remember.
            if known.is_none() && said.iter().any(|say| say.reached) {
                known = Some(PairHistory::new(&self.rules, time));
            }
            let level = known.as_mut().and_then(|known| {
                known.levels[index].update(time, said);
                known.levels[index].worst()
            });
            if level.is_some() || passage.probability > 0.0 {
                let approach = motion.approach(&self.rules.ahead);
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
