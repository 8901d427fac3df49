//! Scores conflict predictions: `evaluate --conflicts`.

mod encounter;
mod paths;
mod tally;

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

pub use encounter::{ClosestApproach, Encounter, PredictedApproach, encounter};
pub use tally::ReliabilityBin;

use super::labels::Labels;
use super::track_owners::TrackOwners;
use super::truth::Truth;
use super::types::{OutputPoint, Scoring};
use conflict::Level;
use fusion::time::{SECOND, Time};
use paths::{Meeting, TruePaths};
use picture::conflicts::Conflict;

/// Time before a violation at which a warning has to be active, seconds.
const WARNED_S: i64 = 10;
/// A warning is false if the drones never come within this distance over ground, metres.
const NEAR_M: f64 = 100.0;
/// Prediction horizon, seconds. A warning is false if the drones do not come near within it.
const HORIZON_S: f64 = 60.0;
/// Times before the closest point of approach at which its prediction is scored, seconds.
const JUDGED_S: std::ops::RangeInclusive<f64> = 10.0..=30.0;
/// Minimum predicted probability at which a closest point is scored.
const JUDGED_PROBABILITY: f64 = 0.1;
/// Number of standard deviations within which the true miss distance should lie.
const SIGMAS: f64 = 2.0;

/// Prediction for one pair at one second.
#[derive(Clone, Debug, PartialEq)]
pub struct ConflictPrediction {
    /// Time of the prediction.
    pub time: Time,
    /// Whether both aircraft were present. If one is missing, a level may still be active; the other values are those
    /// of the last prediction.
    pub is_seen: bool,
    /// Id of the conflict, while a level is active.
    pub id: Option<u64>,
    /// Published track numbers of both aircraft.
    pub numbers: [u32; 2],
    /// Level of the conflict.
    pub level: Option<Level>,
    /// Time to the closest point of approach, seconds.
    pub t_cpa_s: f64,
    /// Time to the entry of the volume, seconds.
    pub t_entry_s: f64,
    /// Probability of entering the volume.
    pub probability: f64,
    /// Miss distance across the relative velocity, metres, and its variance, m².
    pub across: (f64, f64),
    /// Position over ground (metres) and velocity (metres per second) of b relative to a, east and north.
    pub relative: [[f64; 2]; 2],
}

impl From<&Conflict> for ConflictPrediction {
    fn from(conflict: &Conflict) -> Self {
        let found = &conflict.found;
        let approach = &found.approach;
        Self {
            time: conflict.time,
            is_seen: conflict.is_seen(),
            id: found.id,
            numbers: conflict.numbers,
            level: conflict.level(),
            t_cpa_s: approach.t_cpa_s,
            t_entry_s: found.entry_s,
            probability: found.probability,
            across: (approach.across.dot(&approach.miss), approach.across_m2()),
            relative: [found.relative.position.into(), found.relative.velocity.into()],
        }
    }
}

/// Prediction for two tracks, with their drones; `None` if a track is not a drone.
type PairPrediction<'a> = (&'a ConflictPrediction, Option<[usize; 2]>);

/// Inputs for scoring a flight's conflicts.
#[derive(Clone, Copy, Debug)]
pub struct ConflictFlight<'a> {
    /// True paths of the drones.
    pub truth: &'a Truth,
    /// The drone behind each plot and each report.
    pub labels: &'a Labels,
    /// The output.
    pub output: &'a [OutputPoint],
    /// Predictions for one volume, in order of time.
    pub foreseen: &'a [ConflictPrediction],
    /// Radius and half height of the volume, metres.
    pub volume: (f64, f64),
    /// Slot grid and latency.
    pub settings: &'a Scoring,
}

/// Scores of conflict predictions; scores of several flights can be added.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ConflictScore {
    /// Number of times that two equipped drones came within the volume of each other.
    pub violations: u64,
    /// Number of violations with a warning 10 s before.
    pub warned: u64,
    /// Number of violations that follow from the true positions and velocities 10 s before, by straight flight.
    pub foreseeable: u64,
    /// Number of warnings.
    pub warnings: u64,
    /// Number of false warnings: the two did not come within 100 m over ground in 60 s, or one is not a drone.
    pub false_warnings: u64,
    /// Flight time of drones, hours.
    pub drone_h: f64,
    /// Predicted probabilities in bins of 0.1, with the observed frequencies.
    pub bins: [ReliabilityBin; 10],
    /// Number of closest points of approach scored, 10 to 30 s before.
    pub judged: u64,
    /// Sum of the squared errors of the predicted times of these closest points, s².
    pub squares_s2: f64,
    /// Number of these closest points whose true miss distance was within 2 sigma.
    pub within: u64,
    /// Number of entries scored, 10 to 30 s before.
    pub entries: u64,
    /// Sum of the squared errors of the predicted times of these entries, s².
    pub entry_squares_s2: f64,
    /// Number of conflicts.
    pub encounters: u64,
    /// Number of changes of level in these conflicts.
    pub changes: u64,
}

/// Scores the predictions of a flight.
pub fn score_conflicts(flight: &ConflictFlight<'_>) -> ConflictScore {
    let ConflictFlight { truth, labels, output, foreseen, volume, settings } = *flight;
    let paths = TruePaths::of(truth);
    let owners = TrackOwners::of(truth, labels, output, settings.grid);
    let mut score = ConflictScore { drone_h: paths.hours(), ..ConflictScore::default() };
    // Levels of each pair of drones, by time.
    let mut by_pair: BTreeMap<[usize; 2], BTreeMap<Time, Option<Level>>> = BTreeMap::new();
    let mut by_id: BTreeMap<u64, Vec<PairPrediction<'_>>> = BTreeMap::new();
    for one in foreseen {
        let pair = owners.pair(one.numbers, one.time);
        if let Some(id) = one.id {
            by_id.entry(id).or_default().push((one, pair));
        }
        let Some(pair) = pair else { continue };
        let known = by_pair.entry(pair).or_default().entry(one.time).or_default();
        *known = (*known).max(one.level);
        if one.is_seen {
            score.judge(one, pair, &paths, volume);
        }
    }
    for Meeting { pair, begin } in paths.meetings(&equipped(labels, truth), volume) {
        let before = Time::from_nanos(begin.nanos() - WARNED_S * SECOND);
        let Some(relative) = paths.relative(pair, before) else { continue };
        score.violations += 1;
        score.foreseeable += u64::from(relative.leads_into(volume, HORIZON_S));
        score.warned += u64::from(by_pair.get(&pair).is_some_and(|known| warned(known, before)));
    }
    for predictions in by_id.values() {
        score.count(predictions, &paths);
    }
    score
}

/// Indices of the drones that carry a transponder.
fn equipped(labels: &Labels, truth: &Truth) -> BTreeSet<usize> {
    labels.equipped().iter().filter_map(|id| truth.index_of(id)).collect()
}

/// Whether the latest level at `at`, at most 1 s old, was a warning.
fn warned(known: &BTreeMap<Time, Option<Level>>, at: Time) -> bool {
    let last = known.range(..=at).next_back();
    last.is_some_and(|(time, level)| at.nanos() - time.nanos() <= SECOND && *level >= Some(Level::Warning))
}

impl ConflictScore {
    /// Scores the predictions of one second.
    fn judge(
        &mut self,
        one: &ConflictPrediction,
        pair: [usize; 2],
        paths: &TruePaths<'_>,
        volume: (f64, f64),
    ) {
        let Some(closest) = paths.approach(pair, one.time, HORIZON_S, volume) else { return };
        ReliabilityBin::note(&mut self.bins, one.probability, closest.entry_s.is_some());
        let entry_s = closest.entry_s.filter(|after_s| JUDGED_S.contains(after_s));
        if let Some(entry_s) = entry_s.filter(|_| one.probability >= JUDGED_PROBABILITY) {
            self.entries += 1;
            self.entry_squares_s2 += (one.t_entry_s - entry_s).powi(2);
        }
        if one.probability < JUDGED_PROBABILITY || !JUDGED_S.contains(&closest.after_s) {
            return;
        }
        let [position, velocity] = one.relative.map(nalgebra::Vector2::from);
        let Some(across) = nalgebra::Vector2::new(-velocity.y, velocity.x).try_normalize(0.0) else { return };
        let across = if across.dot(&position) < 0.0 { -across } else { across };
        self.judged += 1;
        self.squares_s2 += (one.t_cpa_s - closest.after_s).powi(2);
        let (stated_m, variance_m2) = one.across;
        let error_m = across.dot(&closest.miss) - stated_m;
        self.within += u64::from(error_m.abs() <= SIGMAS * variance_m2.sqrt());
    }

    /// Scores one conflict from beginning to end.
    fn count(&mut self, predictions: &[PairPrediction<'_>], paths: &TruePaths<'_>) {
        let levels: Vec<Option<Level>> = predictions.iter().map(|(one, _)| one.level).collect();
        self.encounters += 1;
        self.changes += levels.windows(2).filter(|two| two[0] != two[1]).count() as u64;
        let is_warning = |one: &ConflictPrediction| one.level >= Some(Level::Warning);
        let mut before = false;
        for (one, pair) in predictions {
            if is_warning(one) && !before {
                let closest = pair.map(|pair| paths.approach(pair, one.time, HORIZON_S, (NEAR_M, NEAR_M)));
                // Skip warnings for which the truth ends too early.
                if closest.as_ref().is_none_or(Option::is_some) {
                    let came_near = closest.flatten().is_some_and(|closest| closest.miss.norm() < NEAR_M);
                    self.warnings += 1;
                    self.false_warnings += u64::from(!came_near);
                }
            }
            before = is_warning(one);
        }
    }

    /// Adds the scores of another flight.
    #[must_use]
    pub fn and(self, other: &Self) -> Self {
        Self {
            violations: self.violations + other.violations,
            warned: self.warned + other.warned,
            foreseeable: self.foreseeable + other.foreseeable,
            warnings: self.warnings + other.warnings,
            false_warnings: self.false_warnings + other.false_warnings,
            drone_h: self.drone_h + other.drone_h,
            bins: std::array::from_fn(|index| self.bins[index].and(&other.bins[index])),
            judged: self.judged + other.judged,
            squares_s2: self.squares_s2 + other.squares_s2,
            within: self.within + other.within,
            entries: self.entries + other.entries,
            entry_squares_s2: self.entry_squares_s2 + other.entry_squares_s2,
            encounters: self.encounters + other.encounters,
            changes: self.changes + other.changes,
        }
    }

    /// Share of violations with a warning.
    pub fn warned_share(&self) -> Option<f64> {
        share(self.warned, self.violations)
    }

    /// Share of violations that are foreseeable.
    pub fn foreseeable_share(&self) -> Option<f64> {
        share(self.foreseeable, self.violations)
    }

    /// False warnings per drone flight hour.
    pub fn false_per_h(&self) -> Option<f64> {
        (self.drone_h > 0.0).then(|| self.false_warnings as f64 / self.drone_h)
    }

    /// Largest difference between observed frequency and mean predicted probability, among bins with at least `least`
    /// predictions.
    pub fn unreliability(&self, least: u64) -> Option<f64> {
        self.bins
            .iter()
            .filter(|bin| bin.stated >= least)
            .filter_map(ReliabilityBin::difference)
            .reduce(f64::max)
    }

    /// Root mean square error of the predicted times of the closest point of approach, seconds.
    pub fn t_cpa_rms_s(&self) -> Option<f64> {
        (self.judged > 0).then(|| (self.squares_s2 / self.judged as f64).sqrt())
    }

    /// Root mean square error of the predicted times of entries, seconds.
    pub fn t_entry_rms_s(&self) -> Option<f64> {
        (self.entries > 0).then(|| (self.entry_squares_s2 / self.entries as f64).sqrt())
    }

    /// Share of scored closest points whose true miss distance was within 2 sigma.
    pub fn within_share(&self) -> Option<f64> {
        share(self.within, self.judged)
    }

    /// Mean number of changes of level per conflict.
    pub fn changes_each(&self) -> Option<f64> {
        share(self.changes, self.encounters)
    }
}

fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

#[cfg(test)]
mod tests;
