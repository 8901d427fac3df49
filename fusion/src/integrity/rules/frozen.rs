//! `frozen`: the same place to the octet again and again, after places that differed.

use serde::{Deserialize, Serialize};

use super::history::{Heard, History};
use crate::time::Time;

/// So many reports at one place, over so long: real receivers on the ground have been seen to repeat one for 6 s.
const REPORTS: u32 = 5;
const LASTS_S: f64 = 12.0;
/// The same of a receiver of which it is not known how it wanders at rest.
const UNKNOWN_LASTS_S: f64 = 20.0;
/// Steps between two slow reports that differ: from so many on it is known.
const WANDERED: u32 = 3;
/// It has to last so many times longer than the receiver has ever rested honestly.
const LONGER_THAN_EVER: f64 = 3.0;
/// A step that an aircraft at rest makes, metres, and metres a second.
const REST_STEP_M: f64 = 2.0;
const REST_SPEED_M_S: f64 = 1.0;
/// What states to be faster than this does not stand, m/s.
const MOVING_M_S: f64 = 1.0;

/// How an identity's place stands still.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Frozen {
    run: Option<Run>,
    /// Whether its place has ever changed.
    has_moved: bool,
    /// Whether what it states of its velocity has ever changed: some transponders state the same for good.
    has_turned: bool,
    /// Slow steps to another place, as far as they matter.
    wandered: u32,
    /// The longest rest at one place that went on from there, seconds.
    rested_s: f64,
}

/// Reports at one place, up to the newest one.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Run {
    first: Heard,
    last: Heard,
    reports: u32,
    /// How many of them state that they move.
    moving: u32,
}

impl Run {
    fn of(heard: Heard) -> Self {
        Self { first: heard, last: heard, reports: 1, moving: u32::from(is_moving(&heard)) }
    }

    fn extend(&mut self, heard: Heard) {
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

fn is_moving(heard: &Heard) -> bool {
    heard.velocity.is_some_and(|velocity| velocity.norm() > MOVING_M_S)
}

impl Frozen {
    /// Takes the report that is now at `at` of the history.
    pub(super) fn hear(&mut self, history: &History, at: usize) {
        let Some(&heard) = history.get(at) else { return };
        let Some(run) = &mut self.run else {
            self.run = Some(Run::of(heard));
            return;
        };
        self.has_turned |= heard.velocity.is_some() && heard.velocity != run.last.velocity;
        let is_same = heard.place() == run.last.place();
        if at + 1 < history.len() {
            // A late one: at the same place it changes nothing but the count; elsewhere the run began after it.
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
            self.run = Some(Run::of(heard));
            self.end(&ended, &heard);
        }
    }

    /// What a run shows of the receiver once it has ended: a rest is honest that goes on from where it was.
    fn end(&mut self, run: &Run, next: &Heard) {
        self.has_moved = true;
        let rest_m = REST_STEP_M + REST_SPEED_M_S * next.apart_s(&run.last);
        if next.distance_m(&run.last) <= rest_m {
            self.wandered = (self.wandered + 1).min(WANDERED);
            self.rested_s = self.rested_s.max(run.lasts_s());
        }
    }

    /// Since when it stands still.
    pub(super) fn still_since(&self) -> Option<Time> {
        self.run.filter(|run| self.has_moved && run.is_still()).map(|run| run.first.time)
    }

    /// Whether it stands still as no receiver does.
    pub(super) fn is_suspect(&self) -> bool {
        let known_s = if self.wandered >= WANDERED { LASTS_S } else { UNKNOWN_LASTS_S };
        let lasts_s = known_s.max(LONGER_THAN_EVER * self.rested_s);
        self.still_since().is_some() && self.run.is_some_and(|run| run.lasts_s() >= lasts_s)
    }

    /// Whether it stands still and states that it moves.
    pub(super) fn has_failed(&self) -> bool {
        self.has_turned && self.still_since().is_some() && self.run.is_some_and(|run| run.moving >= REPORTS)
    }
}

/// The reports from `at` on, which are at one place.
fn run_from(history: &History, at: usize) -> Option<Run> {
    let mut reports = history.from(at);
    let mut run = Run::of(*reports.next()?);
    reports.for_each(|heard| run.extend(*heard));
    Some(run)
}
