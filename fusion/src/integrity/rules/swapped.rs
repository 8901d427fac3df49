//! `swapped`: the motion of an identity breaks off and continues where another identity's would, while that one departs
//! from it.

use std::collections::BTreeMap;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::edge::{GapEdge, GapMiss};
use super::history::{ReportHistory, TimedReport};
use super::jump::MotionBreak;
use super::ledger::IdentityLedger;
use crate::report::Identity;
use crate::time::Time;

/// Longest gap between the last report of one identity and the first of the other, seconds: a longer one allows any
/// motion.
const GAP_MAX_S: f64 = 8.0;
/// Maximum number of breaks evaluated in a slot.
const BREAKS_MAX: usize = 32;
/// Maximum difference of two receivers' persistent errors, metres, in addition to noise and turns.
const RECEIVERS_M: f64 = 10.0;
/// Maximum error of a receiver relative to its own motion, metres.
const RECEIVER_M: f64 = 20.0;
/// Factor on that error if the other identity only had a long gap, and may have flown there.
const UNCERTAIN: f64 = 2.0;
/// Number of standard deviations allowed for noise.
const NOISE_SIGMAS: f64 = 4.0;
/// Minimum ratio by which a motion continues better as another identity than as its own.
const BETTER: f64 = 2.0;
/// Minimum silence of an identity that has vanished: number of its periods, and seconds.
const VANISHED_PERIODS: f64 = 2.0;
const VANISHED_S: f64 = 4.0;
/// Speed, m/s, and margin, metres, within which the other identity must have been able to reach the broken motion.
const SPEED_MAX_M_S: f64 = 60.0;
const REACH_M: f64 = 30.0;
/// Time for which a swap holds, unless it is reversed: later their motion does not show it any more.
const HOLDS: SignedDuration = SignedDuration::from_mins(5);
/// Period within which the same swap may be found again, from the other identity's reports or at another receiver.
const SAME_CHANGE: SignedDuration = SignedDuration::from_secs(30);

/// An identity sends the positions of another identity's aircraft.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Swap {
    with: Identity,
    /// Time of their last swap.
    at: Time,
    /// Whether the swap is not reversed.
    lasts: bool,
}

impl Swap {
    /// Records a swap of an identity with `with`. A second swap with the same one reverses it.
    fn record(swap: &mut Option<Self>, with: Identity, at: Time) {
        let known = swap.filter(|known| known.with == with);
        let lasts = match known {
            Some(known) if (at - known.at).abs() <= SAME_CHANGE => return,
            Some(known) => !known.lasts,
            None => true,
        };
        *swap = Some(Self { with, at, lasts });
    }

    pub(super) fn is_active(&self, deadline: Time) -> bool {
        self.lasts && deadline <= self.at + HOLDS
    }
}

/// Quality with which an identity explains where another one continues; greater is better.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
struct Likeness {
    /// Whether it was received elsewhere since; otherwise it has vanished.
    departed: bool,
    /// Margin to the limit, metres.
    left_m: f64,
}

/// The breaks that are not evaluated yet.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct PendingBreaks(Vec<(Identity, MotionBreak)>);

impl PendingBreaks {
    pub(super) fn add(&mut self, identity: Identity, found: MotionBreak) {
        if self.0.len() < BREAKS_MAX {
            self.0.push((identity, found));
        }
    }

    /// Records the swaps that the breaks since the last call show.
    pub(super) fn evaluate(&mut self, ledgers: &mut BTreeMap<Identity, IdentityLedger>, deadline: Time) {
        for (one, found) in self.0.drain(..) {
            if ledgers.get(&one).is_some_and(|ledger| ledger.is_several(deadline)) {
                continue;
            }
            let liken = |(&other, ledger): (&Identity, &IdentityLedger)| {
                let histories = ledger.streams.iter().map(|stream| &stream.history);
                let best = histories
                    .filter_map(|history| compare_with_break(history, &found, deadline))
                    .max_by(compare)?;
                (other != one && !ledger.is_several(deadline)).then_some((other, best))
            };
            let Some((other, likeness)) =
                ledgers.iter().filter_map(liken).max_by(|(_, one), (_, other)| compare(one, other))
            else {
                continue;
            };
            let mut note = |who, with| {
                if let Some(ledger) = ledgers.get_mut(who) {
                    Swap::record(&mut ledger.swap, with, found.after.time);
                }
            };
            note(&one, other);
            // An identity that has vanished sends nothing that could be wrong.
            if likeness.departed {
                note(&other, one);
            }
        }
    }
}

fn compare(one: &Likeness, other: &Likeness) -> std::cmp::Ordering {
    one.departed.cmp(&other.departed).then(one.left_m.total_cmp(&other.left_m))
}

/// Compares a break with an identity: its motion must lead to where the break continues, while its own reports do not.
fn compare_with_break(history: &ReportHistory, found: &MotionBreak, deadline: Time) -> Option<Likeness> {
    let resumed = found.after.time;
    if history.newest()?.time.seconds_since(resumed) < -GAP_MAX_S {
        return None;
    }
    let mut best: Option<Likeness> = None;
    for at in (1..=history.after(resumed)).rev() {
        let gap_s = resumed.seconds_since(history.get(at - 1)?.time);
        if gap_s > GAP_MAX_S {
            break;
        }
        let Some(left_m) = GapEdge::new(history.before(at), gap_s).and_then(|before| {
            let left_m = continuation(&before, found)?;
            let departed = history.get(at).is_none_or(|next| departs(&before, next, found));
            departed.then_some(left_m)
        }) else {
            continue;
        };
        let departed = history.get(at).is_some();
        if departed || found.is_certain && has_vanished(history, deadline) {
            let likeness = Likeness { departed, left_m };
            best = best.filter(|best| compare(best, &likeness).is_ge()).or(Some(likeness));
        }
    }
    best
}

/// Whether a motion continues at the position of a break, and that much better than the broken motion itself; returns
/// the margin to the limit, metres.
fn continuation(before: &GapEdge, found: &MotionBreak) -> Option<f64> {
    let miss = GapMiss::between(before, &found.after)?;
    let limit_m = RECEIVERS_M + NOISE_SIGMAS * found.noise_m * miss.noise_gain + miss.by_turns_m;
    let left_m = limit_m.min(found.miss_m / BETTER) - miss.distance_m;
    (miss.gap_s > 0.0 && left_m >= 0.0).then_some(left_m)
}

/// Whether the next report of an identity departs from its own motion, and may continue the broken one.
fn departs(before: &GapEdge, next: &TimedReport, found: &MotionBreak) -> bool {
    let (miss_m, by_turns_m) = before.miss_m(next);
    let since_s = next.time.seconds_since(found.before.time);
    let reach_m = REACH_M + SPEED_MAX_M_S * since_s;
    let far_m = (next.position.xy() - found.before.place).norm();
    let sure = if found.is_certain { 1.0 } else { UNCERTAIN };
    miss_m > sure * (RECEIVER_M + by_turns_m) && since_s > 0.0 && far_m <= reach_m
}

/// Whether it should have been received again by now.
fn has_vanished(history: &ReportHistory, deadline: Time) -> bool {
    let missed_s = (VANISHED_PERIODS * history.period_s().unwrap_or_default()).max(VANISHED_S);
    history.newest().is_some_and(|newest| deadline.seconds_since(newest.time) > missed_s)
}
