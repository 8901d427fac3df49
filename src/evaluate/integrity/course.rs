//! How an attack runs its course: when it begins to show, whether a radar looks, whether its reports come.

use std::collections::BTreeSet;

use fusion::time::{SECOND, Time};

use super::Flight;
use super::attacks::{Attack, AttackKind};
use crate::evaluate::truth::TrueTrack;
use crate::evaluate::types::OutputPoint;

/// Offset from which on a drift counts as visible, and at which its delay begins, metres.
const VISIBLE_M: f64 = 20.0;
const COUNTS_M: f64 = 40.0;
/// How long after that a plot counts, seconds: its slot is published 6.25 s later, 45 s after it.
const LOOKED_AT_S: f64 = 38.75;
/// The same for a shift in time: published 90 s after it.
const SHIFT_LOOKED_AT_S: f64 = 83.75;
/// Slower drones do not show a shift in time, metres a second.
const SHIFT_SHOWS_M_S: f64 = 8.0;
/// So many distinct seconds with a plot make an attack observable.
const OBSERVABLE_S: usize = 10;
/// A silence that excuses the rules on reports alone, seconds.
const SILENCE_S: f64 = 8.0;

/// The course of one attack.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Course {
    /// From when delays count: the stamp of the first lying report; of a drift when its offset passes 40 m. `None`: it never
    /// came so far.
    pub(super) begin: Option<Time>,
    /// Distinct seconds in which a radar saw the drone while that counts.
    pub(super) seen_s: usize,
    /// Whether a silence keeps the rules on reports alone from finding it in time.
    pub(super) is_silent: bool,
}

impl Course {
    /// Of an attack; `reports` are those under its number, by time, and `drone` is the true track of its drone.
    pub(super) fn of(
        attack: &Attack,
        reports: &[&OutputPoint],
        drone: &TrueTrack,
        flight: &Flight<'_>,
    ) -> Self {
        let (visible, begin) = match attack.kind {
            AttackKind::Drift => {
                let passes = |offset_m| passing(attack, reports, drone, offset_m);
                (passes(VISIBLE_M), passes(COUNTS_M))
            }
            AttackKind::Jammed => (None, Some(attack.from)),
            AttackKind::Time => (Some(attack.from), first_lying(attack, reports, flight)),
            _ => {
                let first = first_lying(attack, reports, flight);
                (first, first)
            }
        };
        let until = match attack.kind {
            AttackKind::Time => Some(later(attack.from, SHIFT_LOOKED_AT_S)),
            _ => begin.map(|begin| later(begin, LOOKED_AT_S)),
        };
        let shows = |time: Time| {
            attack.kind != AttackKind::Time
                || drone.speed_m_s(time).is_some_and(|speed_m_s| speed_m_s > SHIFT_SHOWS_M_S)
        };
        let seen_s = visible.zip(until).map_or(0, |(from, until)| {
            let plots = flight.labels.plots_of(&attack.id);
            let counts = plots.filter(|plot| !plot.seduced && (from..=until).contains(&plot.time));
            let seconds =
                counts.filter(|plot| shows(plot.time)).map(|plot| plot.time.nanos().div_euclid(SECOND));
            seconds.collect::<BTreeSet<_>>().len()
        });
        let is_silent = attack.kind.limit_s().zip(begin).is_some_and(|(limit_s, begin)| {
            let mut ends = reports.windows(2).map(|pair| (pair[0].time, pair[1].time));
            let ends_early = reports.last().is_none_or(|last| last.time < later(begin, limit_s));
            ends_early
                || ends.any(|(from, until)| {
                    until.seconds_since(from) > SILENCE_S && until >= begin && from < later(begin, limit_s)
                })
        });
        Self { begin, seen_s, is_silent }
    }

    pub(super) fn is_observable(&self) -> bool {
        self.seen_s >= OBSERVABLE_S
    }
}

/// The stamp of the first report that lies: the first under this number that is not the drone's own, else the first that is
/// stamped after the beginning.
fn first_lying(attack: &Attack, reports: &[&OutputPoint], flight: &Flight<'_>) -> Option<Time> {
    let within = |time: &Time| (attack.from..attack.until).contains(time);
    let another = flight.labels.reports_of(attack.number);
    let another = another.filter(|row| row.id.as_deref() != Some(&attack.id)).map(|row| row.time);
    another.filter(within).min().or_else(|| reports.iter().map(|report| report.time).find(within))
}

/// When the reports' distance from the truth, over ground, first passes this one; linear between two reports.
fn passing(attack: &Attack, reports: &[&OutputPoint], drone: &TrueTrack, offset_m: f64) -> Option<Time> {
    let mut before = (attack.from, 0.0);
    let lying = reports.iter().filter(|report| (attack.from..attack.until).contains(&report.time));
    for report in lying {
        let Some(truth) = drone.at(report.time) else { continue };
        let after = (report.time, report.place.offset_from(&truth).horizontal_m());
        if after.1 >= offset_m {
            let share = (offset_m - before.1) / (after.1 - before.1);
            return Some(later(before.0, share.clamp(0.0, 1.0) * after.0.seconds_since(before.0)));
        }
        before = after;
    }
    None
}

pub(super) fn later(time: Time, seconds: f64) -> Time {
    Time::from_nanos(time.nanos() + (seconds * 1e9) as i64)
}
