//! `swapped`: two identities break off at once, and each goes on where the other one would have.

use std::collections::{BTreeMap, VecDeque};

use jiff::SignedDuration;

use super::Ledger;
use super::edge::{Edge, Miss};
use super::history::History;
use super::jump::Break;
use crate::report::Identity;
use crate::time::Time;

/// Both break off within this time.
const TOGETHER: SignedDuration = SignedDuration::from_secs(10);
/// How long after it a break may still become known, by late reports and slow periods.
const KNOWN_WITHIN: SignedDuration = SignedDuration::from_secs(40);
/// Breaks that are remembered.
const BREAKS_MAX: usize = 64;
/// Errors of two transponders that differ, metres, beside noise and turns: slow errors of both receivers.
const RECEIVERS_M: f64 = 10.0;
/// Noise in standard deviations.
const NOISE_SIGMAS: f64 = 4.0;
/// What is over a longer gap than this, seconds, may be anyone's motion.
const GAP_MAX_S: f64 = 8.0;
/// An identity has vanished when it has missed so many of its periods, and so much time, seconds.
const VANISHED_PERIODS: f64 = 2.0;
const VANISHED_S: f64 = 4.0;
/// A motion goes on the other way so much better than its own, at least.
const BETTER: f64 = 2.0;
/// It holds so long, unless they change back: nothing of their motion shows it any longer.
const HOLDS: SignedDuration = SignedDuration::from_mins(5);
/// The same change, found again at another receiver.
const SAME_CHANGE: SignedDuration = SignedDuration::from_secs(15);

/// An identity sends what another one's aircraft does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Swap {
    with: Identity,
    at: Time,
}

impl Swap {
    /// Notes that an identity changed places with `with`. If it had done so before, it is itself again.
    pub(super) fn note(swap: Option<&mut Option<Self>>, with: Identity, at: Time) {
        let Some(swap) = swap else { return };
        match swap {
            Some(known) if known.with == with && at - known.at <= SAME_CHANGE => {}
            Some(known) if known.with == with => *swap = None,
            Some(_) | None => *swap = Some(Self { with, at }),
        }
    }

    pub(super) fn holds(&self, deadline: Time) -> bool {
        deadline <= self.at + HOLDS
    }
}

/// Where motions broke off lately.
#[derive(Debug, Default)]
pub(super) struct Breaks {
    lately: VecDeque<(Identity, Break)>,
    /// How many of them, the last, have not been compared.
    fresh: usize,
}

impl Breaks {
    pub(super) fn add(&mut self, identity: Identity, found: Break) {
        if self.lately.len() == BREAKS_MAX {
            self.lately.pop_front();
        }
        self.lately.push_back((identity, found));
        self.fresh = (self.fresh + 1).min(BREAKS_MAX);
    }

    /// Who has changed places as far as is known now, and when; who was found before is not found again.
    pub(super) fn swapped(
        &mut self,
        ledgers: &BTreeMap<Identity, Ledger>,
        deadline: Time,
    ) -> Vec<(Identity, Identity, Time)> {
        let mut swapped = Vec::new();
        for at in self.lately.len() - self.fresh..self.lately.len() {
            let (one, found) = &self.lately[at];
            for (other, earlier) in self.lately.range(..at).filter(|(other, _)| other != one) {
                if have_swapped(found, earlier) {
                    swapped.push((*one, *other, found.after.time.max(earlier.after.time)));
                }
            }
            for (other, ledger) in ledgers.iter().filter(|(other, _)| *other != one) {
                if ledger.latest().is_some_and(|history| has_become(history, found, deadline)) {
                    swapped.push((*one, *other, found.after.time));
                }
            }
        }
        self.fresh = 0;
        self.lately.retain(|(_, found)| found.after.time >= deadline - KNOWN_WITHIN);
        swapped
    }
}

/// Whether two that broke off went on as each other: one of them beyond doubt.
fn have_swapped(one: &Break, other: &Break) -> bool {
    let apart = one.after.time - other.after.time;
    let [forth, back] = [(one, other), (other, one)].map(|(from, to)| {
        let miss = Miss::between(&from.before, &to.after);
        goes_on(&miss, from.noise_m.max(to.noise_m), from.miss_m.min(to.miss_m)).then_some(miss.gap_s)
    });
    let is_certain = |gaps_s: (f64, f64)| gaps_s.0.min(gaps_s.1) <= GAP_MAX_S;
    apart.abs() <= TOGETHER && forth.zip(back).is_some_and(is_certain)
}

/// Whether what broke off went on as one that was never heard again.
fn has_become(history: &History, found: &Break, deadline: Time) -> bool {
    let Some(newest) = history.newest() else { return false };
    let gap_s = found.after.time.seconds_since(newest.time);
    if !(0.0..=GAP_MAX_S).contains(&gap_s) {
        return false;
    }
    let missed_s = (VANISHED_PERIODS * history.period_s().unwrap_or_default()).max(VANISHED_S);
    let Some(before) = Edge::new(history.before(history.len()), gap_s).filter(Edge::is_whole) else { return false };
    let miss = Miss::between(&before, &found.after);
    deadline.seconds_since(newest.time) > missed_s && goes_on(&miss, found.noise_m, found.miss_m)
}

/// Whether a motion goes on over a gap, and so much better than the one that it is said to be, which is `own_m` off.
fn goes_on(miss: &Miss, noise_m: f64, own_m: f64) -> bool {
    let limit_m = RECEIVERS_M + NOISE_SIGMAS * noise_m * miss.noise_gain + miss.by_turns_m;
    miss.gap_s > 0.0 && miss.distance_m <= limit_m.min(own_m / BETTER)
}
