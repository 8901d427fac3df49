//! `frozen`: exactly the same position is reported repeatedly, after positions that differed.

use serde::{Deserialize, Serialize};

use super::history::{ReportHistory, TimedReport};
use crate::time::Time;

/// Minimum number of reports at one position, and minimum duration, seconds. Real receivers on the ground have repeated
/// one for 6 s.
const REPORTS: u32 = 5;
const LASTS_S: f64 = 12.0;
/// Minimum duration for a receiver whose behaviour at rest is unknown, seconds.
const UNKNOWN_LASTS_S: f64 = 20.0;
/// Number of slow steps to another position after which the behaviour at rest is known.
const WANDERED: u32 = 3;
/// Minimum ratio of the duration to the longest honest rest of the receiver.
const LONGER_THAN_EVER: f64 = 3.0;
/// Maximum step of an aircraft at rest, metres, and its maximum speed, metres a second.
const REST_STEP_M: f64 = 2.0;
const REST_SPEED_M_S: f64 = 1.0;
/// Minimum reported speed of an aircraft that moves, m/s.
const MOVING_M_S: f64 = 1.0;

/// Evidence that the position of an identity is frozen.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Frozen {
    run: Option<FrozenRun>,
    /// Whether the position has ever changed.
    has_moved: bool,
    /// Whether the reported velocity has ever changed: some transponders always report the same.
    has_turned: bool,
    /// Number of slow steps to another position, up to `WANDERED`.
    wandered: u32,
    /// Longest rest at one position from which the motion continued, seconds.
    rested_s: f64,
}

/// Reports at one position, up to the newest one.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct FrozenRun {
    first: TimedReport,
    last: TimedReport,
    reports: u32,
    /// Number of reports with a velocity above `MOVING_M_S`.
    moving: u32,
}

impl FrozenRun {
    fn of(heard: TimedReport) -> Self {
        Self { first: heard, last: heard, reports: 1, moving: u32::from(is_moving(&heard)) }
    }

    fn extend(&mut self, heard: TimedReport) {
        self.last = heard;
        self.reports += 1;
        self.moving += u32::from(is_moving(&heard));
    }

    fn lasts_s(&self) -> f64 {
        self.last.apart_s(&self.first)
    }

    fn is_still(&self) -> bool {
        self.reports >= REPORTS && self.lasts_s() >= LASTS_S
    }
}

fn is_moving(heard: &TimedReport) -> bool {
    heard.velocity.is_some_and(|velocity| velocity.norm() > MOVING_M_S)
}

impl Frozen {
    /// Adds the report at index `at` of the history.
    pub(super) fn add_report(&mut self, history: &ReportHistory, at: usize) {
        let Some(&heard) = history.get(at) else { return };
        let Some(run) = &mut self.run else {
            self.run = Some(FrozenRun::of(heard));
            return;
        };
        self.has_turned |= heard.velocity.is_some() && heard.velocity != run.last.velocity;
        let is_same = heard.place() == run.last.place();
        if at + 1 < history.len() {
            // A late report at the same position only adds to the counts; at another position the run began after it.
            let within = heard.time > run.first.time;
            if is_same && within {
                run.reports += 1;
                run.moving += u32::from(is_moving(&heard));
            } else if !is_same && within {
                self.has_moved = true;
                self.run = run_from(history, at + 1);
            }
        } else if is_same {
            run.extend(heard);
        } else {
            let ended = *run;
            self.run = Some(FrozenRun::of(heard));
            self.end(&ended, &heard);
        }
    }

    /// Updates the receiver's behaviour at rest when a run ends: a rest is honest if the motion continues from its
    /// position.
    fn end(&mut self, run: &FrozenRun, next: &TimedReport) {
        self.has_moved = true;
        let rest_m = REST_STEP_M + REST_SPEED_M_S * next.apart_s(&run.last);
        if next.distance_m(&run.last) <= rest_m {
            self.wandered = (self.wandered + 1).min(WANDERED);
            self.rested_s = self.rested_s.max(run.lasts_s());
        }
    }

    /// Time since which the position is constant.
    pub(super) fn still_since(&self) -> Option<Time> {
        self.run.filter(|run| self.has_moved && run.is_still()).map(|run| run.first.time)
    }

    /// Whether the position is constant for longer than any honest receiver's.
    pub(super) fn is_suspect(&self) -> bool {
        let known_s = if self.wandered >= WANDERED { LASTS_S } else { UNKNOWN_LASTS_S };
        let lasts_s = known_s.max(LONGER_THAN_EVER * self.rested_s);
        self.still_since().is_some() && self.run.is_some_and(|run| run.lasts_s() >= lasts_s)
    }

    /// Whether the position is constant while a velocity is reported.
    pub(super) fn has_failed(&self) -> bool {
        self.has_turned && self.still_since().is_some() && self.run.is_some_and(|run| run.moving >= REPORTS)
    }
}

/// The run of the reports from `at` on, which are at one position.
fn run_from(history: &ReportHistory, at: usize) -> Option<FrozenRun> {
    let mut reports = history.from(at);
    let mut run = FrozenRun::of(*reports.next()?);
    reports.for_each(|heard| run.extend(*heard));
    Some(run)
}
