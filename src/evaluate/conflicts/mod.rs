//! How well an output says who will come near whom: `evaluate --conflicts`.

mod encounter;
mod owners;
mod paths;
mod tally;

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

pub use encounter::{Encounter, Outlook, Stated, encounter};
pub use tally::Bin;

use super::labels::Labels;
use super::truth::Truth;
use super::types::{OutputPoint, Scoring};
use crate::conflicts::Conflict;
use fusion::conflicts::Level;
use fusion::time::{SECOND, Time};
use owners::Owners;
use paths::{Meeting, Paths};

/// A warning counts where it holds so long before, seconds.
const WARNED_S: i64 = 10;
/// A warning is false where the two never come so near over ground, metres,
const NEAR_M: f64 = 100.0;
/// within this time, seconds: as far as is looked ahead.
const HORIZON_S: f64 = 60.0;
/// The closest point of approach is judged so long before it, seconds.
const JUDGED_S: std::ops::RangeInclusive<f64> = 10.0..=30.0;
/// And where this probability is stated.
const JUDGED_PROBABILITY: f64 = 0.1;
/// Standard deviations within which the true miss is to be.
const SIGMAS: f64 = 2.0;

/// A pair in one second, as it was foreseen.
#[derive(Clone, Debug, PartialEq)]
pub struct Foreseen {
    /// The time of the evaluation.
    pub time: Time,
    /// Whether both were there; where one is missing a level may still hold, and the rest is as it was.
    pub is_seen: bool,
    /// The conflict, where a level holds.
    pub id: Option<u64>,
    /// The published numbers of both tracks.
    pub numbers: [u32; 2],
    /// The level.
    pub level: Option<Level>,
    /// Time to the closest point of approach, seconds.
    pub t_cpa_s: f64,
    /// Of entering the volume.
    pub probability: f64,
    /// The miss across the relative velocity, metres, and its variance, m².
    pub across: (f64, f64),
    /// b minus a: position over ground (metres), and velocity (metres a second), east and north.
    pub relative: [[f64; 2]; 2],
}

impl From<&Conflict> for Foreseen {
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
            probability: found.probability,
            across: (approach.across.dot(&approach.miss), approach.across_m2()),
            relative: [found.relative.position.into(), found.relative.velocity.into()],
        }
    }
}

/// What was foreseen of two tracks, and the drones that they are; `None`: one is none.
type Told<'a> = (&'a Foreseen, Option<[usize; 2]>);

/// What a flight's conflicts are scored by.
#[derive(Clone, Copy, Debug)]
pub struct ConflictFlight<'a> {
    /// Where the drones were.
    pub truth: &'a Truth,
    /// Which drone each plot and each report was.
    pub labels: &'a Labels,
    /// The output.
    pub output: &'a [OutputPoint],
    /// What was foreseen, of one volume, in the order of time.
    pub foreseen: &'a [Foreseen],
    /// Radius and half height of that volume, metres.
    pub volume: (f64, f64),
    /// Slots and latency.
    pub settings: &'a Scoring,
}

/// How well conflicts were foreseen; flights are added up.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Foresight {
    /// Times that two equipped drones came within the volume of each other.
    pub violations: u64,
    /// Those of which was warned 10 s before.
    pub warned: u64,
    /// Those that the true positions and velocities of 10 s before, flown straight on, lead to.
    pub foreseeable: u64,
    /// Warnings that began.
    pub warnings: u64,
    /// Those after which the two never came within 100 m over ground in 60 s, or one of them is no drone.
    pub false_warnings: u64,
    /// Hours that drones flew.
    pub drone_h: f64,
    /// Probabilities that were stated, in tenths, and what happened.
    pub bins: [Bin; 10],
    /// Closest points of approach that were judged 10 to 30 s before, and the sum of the squared errors of their times, s².
    pub judged: u64,
    /// See [`Foresight::judged`].
    pub squares_s2: f64,
    /// Those of which the true miss was within 2 sigma.
    pub within: u64,
    /// Conflicts, and their changes from one level to another.
    pub encounters: u64,
    /// See [`Foresight::encounters`].
    pub changes: u64,
}

/// Scores what was foreseen.
pub fn foresight(flight: &ConflictFlight<'_>) -> Foresight {
    let ConflictFlight { truth, labels, output, foreseen, volume, settings } = *flight;
    let paths = Paths::of(truth);
    let owners = Owners::of(truth, labels, output, settings.grid);
    let mut score = Foresight { drone_h: paths.hours(), ..Foresight::default() };
    // What was known of each pair of drones, by time.
    let mut by_pair: BTreeMap<[usize; 2], BTreeMap<Time, Option<Level>>> = BTreeMap::new();
    let mut by_id: BTreeMap<u64, Vec<Told<'_>>> = BTreeMap::new();
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
    for told in by_id.values() {
        score.count(told, &paths);
    }
    score
}

/// The drones that carry a transponder.
fn equipped(labels: &Labels, truth: &Truth) -> BTreeSet<usize> {
    labels.equipped().iter().filter_map(|id| truth.index_of(id)).collect()
}

/// Whether the last that was known by then, a second ago at most, was a warning.
fn warned(known: &BTreeMap<Time, Option<Level>>, at: Time) -> bool {
    let last = known.range(..=at).next_back();
    last.is_some_and(|(time, level)| at.nanos() - time.nanos() <= SECOND && *level >= Some(Level::Warning))
}

impl Foresight {
    /// The statements of one second.
    fn judge(&mut self, one: &Foreseen, pair: [usize; 2], paths: &Paths<'_>, volume: (f64, f64)) {
        let Some(closest) = paths.closest(pair, one.time, HORIZON_S) else { return };
        Bin::note(&mut self.bins, one.probability, closest.is_within(volume));
        if one.probability < JUDGED_PROBABILITY || !JUDGED_S.contains(&closest.after_s) {
            return;
        }
        self.judged += 1;
        self.squares_s2 += (one.t_cpa_s - closest.after_s).powi(2);
        let [position, velocity] = one.relative.map(nalgebra::Vector2::from);
        let across = nalgebra::Vector2::new(-velocity.y, velocity.x).normalize();
        let across = if across.dot(&position) < 0.0 { -across } else { across };
        let (stated_m, variance_m2) = one.across;
        let error_m = across.dot(&closest.miss) - stated_m;
        self.within += u64::from(error_m.abs() <= SIGMAS * variance_m2.sqrt());
    }

    /// One conflict from its beginning to its end.
    fn count(&mut self, told: &[Told<'_>], paths: &Paths<'_>) {
        let levels: Vec<Option<Level>> = told.iter().map(|(one, _)| one.level).collect();
        self.encounters += 1;
        self.changes += levels.windows(2).filter(|two| two[0] != two[1]).count() as u64;
        let is_warning = |one: &Foreseen| one.level >= Some(Level::Warning);
        let mut before = false;
        for (one, pair) in told {
            if is_warning(one) && !before {
                let closest = pair.map(|pair| paths.closest(pair, one.time, HORIZON_S));
                // Where the truth ends before nobody knows.
                if closest.as_ref().is_none_or(Option::is_some) {
                    let came_near = closest.flatten().is_some_and(|closest| closest.miss.norm() < NEAR_M);
                    self.warnings += 1;
                    self.false_warnings += u64::from(!came_near);
                }
            }
            before = is_warning(one);
        }
    }

    /// Both together.
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
            encounters: self.encounters + other.encounters,
            changes: self.changes + other.changes,
        }
    }

    /// Share of the violations of which was warned.
    pub fn warned_share(&self) -> Option<f64> {
        share(self.warned, self.violations)
    }

    /// The same of those that are foreseeable.
    pub fn foreseeable_share(&self) -> Option<f64> {
        share(self.foreseeable, self.violations)
    }

    /// False warnings in an hour of a drone.
    pub fn false_per_h(&self) -> Option<f64> {
        (self.drone_h > 0.0).then(|| self.false_warnings as f64 / self.drone_h)
    }

    /// Largest difference of what happened and what was stated, of bins with so many statements.
    pub fn unreliability(&self, least: u64) -> Option<f64> {
        self.bins.iter().filter(|bin| bin.stated >= least).filter_map(Bin::difference).reduce(f64::max)
    }

    /// Root of the mean squared error of the time of the closest point of approach, seconds.
    pub fn t_cpa_rms_s(&self) -> Option<f64> {
        (self.judged > 0).then(|| (self.squares_s2 / self.judged as f64).sqrt())
    }

    /// Share of the judged ones with the true miss within 2 sigma.
    pub fn within_share(&self) -> Option<f64> {
        share(self.within, self.judged)
    }

    /// Changes of level in a conflict.
    pub fn changes_each(&self) -> Option<f64> {
        share(self.changes, self.encounters)
    }
}

fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

#[cfg(test)]
mod tests;
