//! `swapped`: two identities break off at once, and each goes on where the other one would have.

use std::collections::VecDeque;

use jiff::SignedDuration;

use super::edge::Miss;
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
/// As in `jump`, m/s².
const TURN_M_S2: f64 = 6.0;
const KEPT_M_S2: f64 = 0.5;
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
    pub(super) fn swapped(&mut self, deadline: Time) -> Vec<(Identity, Identity, Time)> {
        let mut swapped = Vec::new();
        for at in self.lately.len() - self.fresh..self.lately.len() {
            let (one, found) = &self.lately[at];
            for (other, earlier) in self.lately.range(..at) {
                if one != other && have_swapped(found, earlier) {
                    swapped.push((*one, *other, found.after.time.max(earlier.after.time)));
                }
            }
        }
        self.fresh = 0;
        self.lately.retain(|(_, found)| found.after.time >= deadline - KNOWN_WITHIN);
        swapped
    }
}

fn have_swapped(one: &Break, other: &Break) -> bool {
    let apart = one.after.time - other.after.time;
    let goes_on = |from: &Break, to: &Break| {
        let miss = Miss::between(&from.before, &to.after);
        let noise_m = from.noise_m.max(to.noise_m) * miss.noise_gain;
        let limit_m = RECEIVERS_M + NOISE_SIGMAS * noise_m + miss.by_turns_m(TURN_M_S2, KEPT_M_S2);
        let better_m = from.miss_m.min(to.miss_m) / BETTER;
        miss.gap_s > 0.0 && miss.distance_m <= limit_m.min(better_m)
    };
    apart.abs() <= TOGETHER && goes_on(one, other) && goes_on(other, one)
}
