//! Situations: aircraft in conflict with one another, connected by their pairs, are one alert.

use std::collections::{BTreeMap, BTreeSet};

use super::details::ClosestPair;
use conflict::Level;
use fusion::time::{SECOND, Time};
use picture::conflicts::Conflict;

/// Minimum time for which a pair stays in its situation after its last warning, in nanoseconds.
const REMEMBERED_NS: u64 = 10 * SECOND as u64;

/// Ids of the tracks of a pair, in order.
pub(super) type PairIds = [String; 2];

/// Situations by subject: the pair that began each, and its volume.
#[derive(Debug, Default)]
pub(super) struct Situations(BTreeMap<String, Situation>);

/// Aircraft in conflict with one another.
#[derive(Debug)]
pub(super) struct Situation {
    began: Time,
    pairs: BTreeMap<PairIds, Pair>,
    /// Tracks that were in a violation so far.
    pub(super) endangered: BTreeSet<String>,
    /// The closest approach of all pairs so far.
    pub(super) closest: ClosestApproach,
}

/// Two aircraft of a situation.
#[derive(Clone, Debug)]
struct Pair {
    /// Time of the last warning or violation.
    last: Time,
    /// Their closest approach so far.
    closest: ClosestApproach,
}

/// Closest approach of a pair, with the distance as a share of the volume.
#[derive(Clone, Debug)]
pub(super) struct ClosestApproach {
    pub(super) names: [String; 2],
    pub(super) volume: String,
    pub(super) pair: ClosestPair,
    closeness: f64,
}

impl ClosestApproach {
    fn of(conflict: &Conflict) -> Self {
        let now = &conflict.found.relative;
        let vertical = now.vertical.map(|vertical| vertical.height_m.abs());
        let pair = ClosestPair { at: conflict.seen, horizontal_m: now.position.norm(), vertical_m: vertical };
        let (names, volume) = (conflict.names.clone(), conflict.volume.clone());
        Self { names, volume, pair, closeness: conflict.closeness() }
    }

    /// Takes the other one if it is closer.
    fn note(&mut self, other: &Self) {
        if other.closeness < self.closeness {
            *self = other.clone();
        }
    }
}

/// Identifies a pair.
pub(super) fn pair_ids(conflict: &Conflict) -> PairIds {
    let [a, b] = conflict.tracks.clone();
    if a < b { [a, b] } else { [b, a] }
}

impl Situations {
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Assigns the conflicts of one evaluation, the worst first, to situations. `hold_ns` is the time for which an alert is held
    /// without a conflict. Returns the conflicts by subject, in the order given, and the subjects of each situation that became
    /// part of another and of that other one, in the order in which they did.
    pub(super) fn assign<'a>(
        &mut self,
        conflicts: &[&'a Conflict],
        now: Time,
        hold_ns: u64,
    ) -> (BTreeMap<String, Vec<&'a Conflict>>, Vec<[String; 2]>) {
        let mut merged = Vec::new();
        let remembered_ns = hold_ns.max(REMEMBERED_NS);
        for situation in self.0.values_mut() {
            situation.pairs.retain(|_, pair| now.nanos().abs_diff(pair.last.nanos()) <= remembered_ns);
        }
        self.0.retain(|_, situation| !situation.pairs.is_empty());
        for conflict in conflicts {
            let pair = pair_ids(conflict);
            let mut concerned: Vec<(Time, String)> = self.concerned(&pair);
            concerned.sort();
            let mut concerned = concerned.into_iter().map(|(_, subject)| subject);
            let subject = concerned.next().unwrap_or_else(|| subject(conflict));
            let others: Vec<Situation> = concerned
                .filter_map(|other| {
                    let situation = self.0.remove(&other)?;
                    merged.push([other, subject.clone()]);
                    Some(situation)
                })
                .collect();
            let closest = ClosestApproach::of(conflict);
            let new = || Situation {
                began: now,
                pairs: BTreeMap::new(),
                endangered: BTreeSet::new(),
                closest: closest.clone(),
            };
            let situation = self.0.entry(subject).or_insert_with(new);
            for other in others {
                situation.pairs.extend(other.pairs);
                situation.endangered.extend(other.endangered);
                situation.closest.note(&other.closest);
            }
            if conflict.level() == Some(Level::Violation) {
                situation.endangered.extend(pair.iter().cloned());
            }
            let known =
                situation.pairs.entry(pair).or_insert_with(|| Pair { last: now, closest: closest.clone() });
            known.last = now;
            known.closest.note(&closest);
            situation.closest.note(&closest);
        }
        let mut found: BTreeMap<String, Vec<&Conflict>> = BTreeMap::new();
        for conflict in conflicts {
            let pair = pair_ids(conflict);
            let mut all = self.0.iter();
            if let Some((subject, _)) = all.find(|(_, situation)| situation.pairs.contains_key(&pair)) {
                found.entry(subject.clone()).or_default().push(conflict);
            }
        }
        (found, merged)
    }

    /// Start and subject of each situation with an aircraft of the pair.
    fn concerned(&self, pair: &PairIds) -> Vec<(Time, String)> {
        let has = |situation: &Situation| situation.pairs.keys().flatten().any(|track| pair.contains(track));
        let concerned = self.0.iter().filter(|(_, situation)| has(situation));
        concerned.map(|(subject, situation)| (situation.began, subject.clone())).collect()
    }

    /// The situation of a subject.
    pub(super) fn get(&self, subject: &str) -> Option<&Situation> {
        self.0.get(subject)
    }
}

impl Situation {
    /// The closest approach of this pair so far; that of the situation if the pair is not part of it.
    pub(super) fn closest_of(&self, pair: &PairIds) -> &ClosestApproach {
        self.pairs.get(pair).map_or(&self.closest, |pair| &pair.closest)
    }

    /// Tracks of all pairs, those of `first` in front.
    pub(super) fn tracks(&self, first: &Conflict) -> Vec<String> {
        let mut tracks = first.tracks.to_vec();
        let others: BTreeSet<&String> = self.pairs.keys().flatten().collect();
        tracks.extend(others.into_iter().filter(|track| !first.tracks.contains(track)).cloned());
        tracks
    }
}

/// Identifies the situation that a conflict begins, across runs of the service: both tracks and the volume.
fn subject(conflict: &Conflict) -> String {
    let [a, b] = pair_ids(conflict);
    format!("{a} {b} {}", conflict.volume)
}
