//! Jamming: many identities fall silent at once, more than by chance.

use std::collections::BTreeMap;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::{Jammed, Ledger};
use crate::frames::Enu;
use crate::report::Identity;
use crate::time::Time;

/// Who fell silent within this time fell silent at once.
const AT_ONCE: SignedDuration = SignedDuration::from_secs(15);
/// Who is cut off at one moment was heard last within a period, which is 4 s at most with most transponders.
const WITHIN_A_PERIOD: SignedDuration = SignedDuration::from_secs(5);
/// So many of them at least,
const IDENTITIES: usize = 3;
/// and such a share of those heard
const SHARE: f64 = 0.3;
/// within this time.
const LATELY: SignedDuration = SignedDuration::from_secs(60);
/// Probability of as many by chance, at the rate at which single ones have fallen silent here.
const BY_CHANCE: f64 = 1e-4;
/// That rate is as if one had fallen silent in so many identity-seconds before the first, and
const ASSUMED_S: f64 = 900.0;
/// is forgotten to 1/e in so many seconds.
const FORGOTTEN_S: f64 = 3600.0;
/// It is over without an end after this time: they have landed.
const LASTS_MAX: SignedDuration = SignedDuration::from_mins(10);

/// While no identity at all is heard for longer than this, and for as long after it, a clock that was set ahead or a line that was
/// away explains more than jamming does.
const QUIET: SignedDuration = SignedDuration::from_secs(6);
/// A silence of all that lasts for longer than a step of the clock that the window bears.
const ALL_QUIET: SignedDuration = SignedDuration::from_secs(32);

/// Who is jammed, and how often one falls silent by itself.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Jamming {
    jammed: Option<Jammed>,
    /// Silences, and the identity-seconds in which they began.
    silences: f64,
    heard_s: f64,
    looked: Option<Time>,
    /// The last deadline at which no identity had been heard for longer than [`QUIET`].
    quiet: Option<Time>,
    /// Whether identities fell silent that were not looked at yet.
    waits: bool,
}

/// An identity that fell silent.
struct Silent {
    newest: Time,
    identity: Identity,
    place: Enu,
}

impl Jamming {
    pub(super) fn look(&mut self, ledgers: &BTreeMap<Identity, Ledger>, deadline: Time) {
        let passed_s = self
            .looked
            .replace(deadline)
            .map_or(0.0, |looked| deadline.seconds_since(looked).clamp(0.0, 1.0));
        let (mut heard, mut began) = (0, 0);
        for ledger in ledgers.values() {
            heard += usize::from(ledger.silence.is_known && !ledger.silence.is_silent);
            began += usize::from(ledger.silence.long_since == Some(deadline));
        }
        let kept = (-passed_s / FORGOTTEN_S).exp();
        self.heard_s = kept * self.heard_s + passed_s * heard as f64;
        self.silences = kept * self.silences + began as f64;
        self.end(ledgers, deadline);
        self.waits |= began > 0;
        let last = ledgers.values().filter_map(|ledger| ledger.silence.heard()).max();
        let quiet = last.map_or(SignedDuration::ZERO, |last| deadline - last);
        if quiet > QUIET {
            self.quiet = Some(deadline);
        }
        let is_quiet = quiet <= ALL_QUIET && self.quiet.is_some_and(|since| deadline - since <= QUIET);
        if self.waits && !is_quiet {
            self.waits = false;
            self.begin(ledgers, deadline);
        }
    }

    pub(super) fn jammed(&self) -> Option<&Jammed> {
        self.jammed.as_ref()
    }

    /// Ends it when half of them are back.
    fn end(&mut self, ledgers: &BTreeMap<Identity, Ledger>, deadline: Time) {
        let is_over = |jammed: &Jammed| {
            let is_back =
                |identity: &&Identity| ledgers.get(identity).is_some_and(|ledger| !ledger.silence.is_silent);
            let back = jammed.identities.iter().filter(is_back).count();
            2 * back >= jammed.identities.len() || deadline > jammed.since + LASTS_MAX
        };
        self.jammed.take_if(|jammed| is_over(jammed));
    }

    /// Looks for those who fell silent at once; a jamming that lasts grows by those who fell silent with it.
    fn begin(&mut self, ledgers: &BTreeMap<Identity, Ledger>, deadline: Time) {
        let lately = |ledger: &&Ledger| ledger.newest >= deadline - LATELY;
        let of_late = ledgers.values().filter(lately).filter(|ledger| ledger.silence.is_known).count();
        let silent = |(&identity, ledger): (&Identity, &Ledger)| {
            let place = Enu::from(ledger.latest()?.newest()?.position);
            let counts = ledger.silence.long_since.is_some() && lately(&ledger) && !ledger.has_landed();
            counts.then_some(Silent { newest: ledger.newest, identity, place })
        };
        let mut silent: Vec<Silent> = ledgers.iter().filter_map(silent).collect();
        silent.sort_by_key(|silent| (silent.newest, silent.identity));
        for lasts in [WITHIN_A_PERIOD, AT_ONCE] {
            let windows = (0..silent.len()).map(|from| {
                let until = silent[from].newest + lasts;
                from..silent.partition_point(|silent| silent.newest <= until)
            });
            // Of windows that are as full the first: nothing depends on what came behind it.
            let Some(fullest) = windows.rev().max_by_key(ExactSizeIterator::len) else { return };
            let at_once = &silent[fullest];
            let is_many = at_once.len() >= IDENTITIES && at_once.len() as f64 >= SHARE * of_late as f64;
            let is_growing = self.jammed.as_ref().is_some_and(|jammed| {
                at_once[0].newest <= jammed.since + AT_ONCE && at_once.len() > jammed.identities.len()
            });
            let may_begin = self.jammed.is_none() && self.chance(at_once.len(), of_late, lasts) <= BY_CHANCE;
            if is_many && (is_growing || may_begin) {
                self.jammed = Some(Jammed {
                    identities: at_once.iter().map(|silent| silent.identity).collect(),
                    places: at_once.iter().map(|silent| silent.place).collect(),
                    since: at_once[0].newest,
                });
            }
        }
    }

    /// Probability that as many of `all` fall silent within so long by themselves (binomial).
    fn chance(&self, many: usize, all: usize, within: SignedDuration) -> f64 {
        let before = (self.silences - many as f64).max(0.0);
        let rate = (before + 1.0) / (self.heard_s + ASSUMED_S);
        let one = 1.0 - (-rate * within.as_secs_f64()).exp();
        let mut term = (1.0 - one).powi(all as i32);
        let mut fewer = 0.0;
        for count in 0..many {
            fewer += term;
            term *= (all - count) as f64 / (count + 1) as f64 * one / (1.0 - one);
        }
        1.0 - fewer
    }
}
