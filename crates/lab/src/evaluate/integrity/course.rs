//! Course of an attack: when it becomes visible, whether a radar observes the drone, whether reports arrive.

use std::collections::BTreeSet;

use fusion::time::{SECOND, Time};

use super::IntegrityFlight;
use super::attacks::{Attack, AttackKind};
use crate::evaluate::truth::TrueTrack;
use crate::evaluate::types::OutputPoint;

/// Offset from which a drift counts as visible, metres. `DELAY_FROM_M` is the offset at which its detection delay begins.
const VISIBLE_M: f64 = 20.0;
const DELAY_FROM_M: f64 = 40.0;
/// Time after the beginning during which plots count, seconds; such a plot's slot is published 6.25 s later, so 45 s
/// after the beginning.
const OBSERVED_FOR_S: f64 = 38.75;
/// Time during which plots count for a shift in time, seconds; published 90 s after the beginning.
const SHIFT_OBSERVED_FOR_S: f64 = 83.75;
/// Minimum speed of a drone for a shift in time to be visible, metres per second.
const SHIFT_SHOWS_M_S: f64 = 8.0;
/// Minimum number of distinct seconds with a plot for an attack to be observable.
const OBSERVABLE_S: usize = 10;
/// Silence of a transponder that excuses rules on reports alone, seconds.
const SILENCE_S: f64 = 8.0;

/// Course of one attack.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AttackCourse {
    /// Time from which delays count: the time stamp of the first false report, or for a drift the time when its offset
    /// passes 40 m. `None`: there is no such time.
    pub(super) begin: Option<Time>,
    /// Number of distinct seconds in which a radar saw the drone while plots count.
    pub(super) seen_s: usize,
    /// Whether a silence prevents rules on reports alone from detecting the attack in time.
    pub(super) is_silent: bool,
}

impl AttackCourse {
    /// Course of an attack. `reports` are those under its number, by time; `drone` is the true track of its drone.
    pub(super) fn of(
        attack: &Attack,
        reports: &[&OutputPoint],
        drone: &TrueTrack,
        flight: &IntegrityFlight<'_>,
    ) -> Self {
        let (visible, begin) = match attack.kind {
            AttackKind::Drift => {
                let passes = |offset_m| passing(attack, reports, drone, offset_m);
                (passes(VISIBLE_M), passes(DELAY_FROM_M))
            }
            AttackKind::Jammed => (None, Some(attack.from)),
            AttackKind::Time => (Some(attack.from), first_false_report(attack, reports, flight)),
            _ => {
                let first = first_false_report(attack, reports, flight);
                (first, first)
            }
        };
        let until = match attack.kind {
            AttackKind::Time => Some(later(attack.from, SHIFT_OBSERVED_FOR_S)),
            _ => begin.map(|begin| later(begin, OBSERVED_FOR_S)),
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

/// Time stamp of the first false report: the first report under this number that the drone did not send, else the first
/// report stamped within the attack.
fn first_false_report(
    attack: &Attack,
    reports: &[&OutputPoint],
    flight: &IntegrityFlight<'_>,
) -> Option<Time> {
    let within = |time: &Time| (attack.from..attack.until).contains(time);
    let another = flight.labels.reports_of(attack.number);
    let another = another.filter(|row| row.id.as_deref() != Some(&attack.id)).map(|row| row.time);
    another.filter(within).min().or_else(|| reports.iter().map(|report| report.time).find(within))
}

/// Time at which the horizontal distance of the reports from the truth first passes `offset_m`; interpolated between
/// two reports.
fn passing(attack: &Attack, reports: &[&OutputPoint], drone: &TrueTrack, offset_m: f64) -> Option<Time> {
    let mut before = (attack.from, 0.0);
    let false_reports = reports.iter().filter(|report| (attack.from..attack.until).contains(&report.time));
    for report in false_reports {
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
