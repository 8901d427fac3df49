//! `swapped`: an identity breaks off and goes on where another one would have, and that one does not.

use std::collections::BTreeMap;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::Ledger;
use super::edge::{Edge, Miss};
use super::history::{Heard, History};
use super::jump::Break;
use crate::report::Identity;
use crate::time::Time;

/// From the last report of the one to the first of the other, seconds: what is over a longer gap may be anyone's motion.
const GAP_MAX_S: f64 = 8.0;
/// Breaks that are looked into at a slot.
const BREAKS_MAX: usize = 32;
/// Errors of two transponders that differ, metres, beside noise and turns: slow errors of both receivers.
const RECEIVERS_M: f64 = 10.0;
/// Errors of a receiver that lead it off its own motion, metres.
const RECEIVER_M: f64 = 20.0;
/// So many times as far where the other one was only not heard for long, and may have flown there.
const UNCERTAIN: f64 = 2.0;
/// Noise in standard deviations.
const NOISE_SIGMAS: f64 = 4.0;
/// A motion goes on so many times better as another identity than as its own, at least.
const BETTER: f64 = 2.0;
/// An identity has vanished when it has missed so many of its periods, and so much time, seconds.
const VANISHED_PERIODS: f64 = 2.0;
const VANISHED_S: f64 = 4.0;
/// The other way round: an aircraft gets there, m/s and metres.
const SPEED_MAX_M_S: f64 = 60.0;
const REACH_M: f64 = 30.0;
/// It holds so long, unless they change back: nothing of their motion shows it any longer.
const HOLDS: SignedDuration = SignedDuration::from_mins(5);
/// The same change, found again by the other one's reports or at another receiver.
const SAME_CHANGE: SignedDuration = SignedDuration::from_secs(30);

/// An identity sends what another one's aircraft does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Swap {
    with: Identity,
    /// When they changed places last.
    at: Time,
    /// Whether they have not changed back.
    lasts: bool,
}

impl Swap {
    /// Notes that an identity changed places with `with`. If it had done so before, it is itself again.
    fn note(swap: &mut Option<Self>, with: Identity, at: Time) {
        let known = swap.filter(|known| known.with == with);
        let lasts = match known {
            Some(known) if (at - known.at).abs() <= SAME_CHANGE => return,
            Some(known) => !known.lasts,
            None => true,
        };
        *swap = Some(Self { with, at, lasts });
    }

    pub(super) fn holds(&self, deadline: Time) -> bool {
        self.lasts && deadline <= self.at + HOLDS
    }
}

/// How well an identity explains where another one goes on: the greater the better.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
struct Likeness {
    /// It was heard elsewhere since; else it has vanished.
    departed: bool,
    /// How much is left of the limit, metres.
    left_m: f64,
}

/// The breaks that have not been looked into.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Breaks(Vec<(Identity, Break)>);

impl Breaks {
    pub(super) fn add(&mut self, identity: Identity, found: Break) {
        if self.0.len() < BREAKS_MAX {
            self.0.push((identity, found));
        }
    }

    /// Notes who changed places, as far as the breaks since the last call show.
    pub(super) fn look(&mut self, ledgers: &mut BTreeMap<Identity, Ledger>, deadline: Time) {
        for (one, found) in self.0.drain(..) {
            if ledgers.get(&one).is_some_and(|ledger| ledger.is_several(deadline)) {
                continue;
            }
            let liken = |(&other, ledger): (&Identity, &Ledger)| {
                let histories = ledger.streams.iter().map(|stream| &stream.history);
                let best =
                    histories.filter_map(|history| liken(history, &found, deadline)).max_by(compare)?;
                (other != one && !ledger.is_several(deadline)).then_some((other, best))
            };
            let Some((other, likeness)) =
                ledgers.iter().filter_map(liken).max_by(|(_, one), (_, other)| compare(one, other))
            else {
                continue;
            };
            let mut note = |who, with| {
                if let Some(ledger) = ledgers.get_mut(who) {
                    Swap::note(&mut ledger.swap, with, found.after.time);
                }
            };
            note(&one, other);
            // Who has vanished sends nothing that could be wrong.
            if likeness.departed {
                note(&other, one);
            }
        }
    }
}

fn compare(one: &Likeness, other: &Likeness) -> std::cmp::Ordering {
    one.departed.cmp(&other.departed).then(one.left_m.total_cmp(&other.left_m))
}

/// Whether what broke off went on as this identity would have, which did not.
fn liken(history: &History, found: &Break, deadline: Time) -> Option<Likeness> {
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
        let Some(left_m) = Edge::new(history.before(at), gap_s).and_then(|before| {
            let left_m = goes_on(&before, found)?;
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

/// Whether a motion goes on where another one broke off to, and so much better than that one itself: how much is left of the
/// limit, metres.
fn goes_on(before: &Edge, found: &Break) -> Option<f64> {
    let miss = Miss::between(before, &found.after)?;
    let limit_m = RECEIVERS_M + NOISE_SIGMAS * found.noise_m * miss.noise_gain + miss.by_turns_m;
    let left_m = limit_m.min(found.miss_m / BETTER) - miss.distance_m;
    (miss.gap_s > 0.0 && left_m >= 0.0).then_some(left_m)
}

/// Whether the next report of an identity is not of its own motion, and may be of that which broke off.
fn departs(before: &Edge, next: &Heard, found: &Break) -> bool {
    let (miss_m, by_turns_m) = before.miss_m(next);
    let since_s = next.time.seconds_since(found.before.time);
    let reach_m = REACH_M + SPEED_MAX_M_S * since_s;
    let far_m = (next.position.xy() - found.before.place).norm();
    let sure = if found.is_certain { 1.0 } else { UNCERTAIN };
    miss_m > sure * (RECEIVER_M + by_turns_m) && since_s > 0.0 && far_m <= reach_m
}

/// Whether it should have been heard again by now.
fn has_vanished(history: &History, deadline: Time) -> bool {
    let missed_s = (VANISHED_PERIODS * history.period_s().unwrap_or_default()).max(VANISHED_S);
    history.newest().is_some_and(|newest| deadline.seconds_since(newest.time) > missed_s)
}
