//! Jamming: more identities fall silent at the same time than chance explains.

use std::collections::BTreeMap;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::ledger::IdentityLedger;
use crate::frames::Enu;
use crate::report::Identity;
use crate::time::Time;

/// Period within which identities count as falling silent at the same time.
const AT_ONCE: SignedDuration = SignedDuration::from_secs(15);
/// Like `AT_ONCE`, for a sudden interruption: all were received within one reporting period, which is at most 4 s for
/// most transponders.
const WITHIN_A_PERIOD: SignedDuration = SignedDuration::from_secs(5);
/// Minimum number of silent identities.
const IDENTITIES: usize = 3;
/// Minimum share of the identities received lately.
const SHARE: f64 = 0.3;
/// Period for which an identity counts as received lately.
const LATELY: SignedDuration = SignedDuration::from_secs(60);
/// Maximum probability of that many silences by chance, at the rate of single silences observed here.
const BY_CHANCE: f64 = 1e-4;
/// Prior of that rate: one silence in this many identity-seconds.
const ASSUMED_S: f64 = 900.0;
/// Time constant with which the rate is forgotten (to 1/e), seconds.
const FORGOTTEN_S: f64 = 3600.0;
/// Maximum duration, after which jamming ends even if the identities stay silent: they have landed.
const LASTS_MAX: SignedDuration = SignedDuration::from_mins(10);

/// Pause in the reports of all identities after which no jamming is detected for the same time. A clock that was set
/// ahead or a line that was interrupted explains more silences than jamming does.
const QUIET: SignedDuration = SignedDuration::from_secs(6);
/// Pause in the reports of all identities beyond which jamming is detected nevertheless: no clock step that the window
/// tolerates lasts as long.
const ALL_QUIET: SignedDuration = SignedDuration::from_secs(32);

/// Identities that fell silent at the same time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Jammed {
    pub(crate) identities: Vec<Identity>,
    /// Positions of their last reports, in the order of `identities`.
    pub(crate) places: Vec<Enu>,
    /// Earliest of their last reports.
    pub(crate) since: Time,
}

/// Jammed identities, and the rate of single silences.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Jamming {
    jammed: Option<Jammed>,
    /// Number of silences, and the identity-seconds in which they began.
    silences: f64,
    heard_s: f64,
    looked: Option<Time>,
    /// Last deadline at which all identities had paused for longer than [`QUIET`].
    quiet: Option<Time>,
    /// Whether there are silences that were not evaluated yet.
    waits: bool,
}

/// An identity that fell silent.
struct SilentIdentity {
    newest: Time,
    identity: Identity,
    place: Enu,
}

impl Jamming {
    pub(super) fn evaluate(&mut self, ledgers: &BTreeMap<Identity, IdentityLedger>, deadline: Time) {
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
        let last = ledgers.values().filter_map(|ledger| ledger.silence.since()).max();
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

    /// Ends the jamming when half of the identities are received again.
    fn end(&mut self, ledgers: &BTreeMap<Identity, IdentityLedger>, deadline: Time) {
        let is_over = |jammed: &Jammed| {
            let is_back =
                |identity: &&Identity| ledgers.get(identity).is_some_and(|ledger| !ledger.silence.is_silent);
            let back = jammed.identities.iter().filter(is_back).count();
            2 * back >= jammed.identities.len() || deadline > jammed.since + LASTS_MAX
        };
        self.jammed.take_if(|jammed| is_over(jammed));
    }

    /// Searches for identities that fell silent at the same time; a present jamming is extended by those that fell
    /// silent with it.
    fn begin(&mut self, ledgers: &BTreeMap<Identity, IdentityLedger>, deadline: Time) {
        let lately = |ledger: &&IdentityLedger| ledger.newest >= deadline - LATELY;
        let of_late = ledgers.values().filter(lately).filter(|ledger| ledger.silence.is_known).count();
        let silent = |(&identity, ledger): (&Identity, &IdentityLedger)| {
            let place = Enu::from(ledger.latest()?.newest()?.position);
            let counts = ledger.silence.long_since.is_some() && lately(&ledger) && !ledger.has_landed();
            counts.then_some(SilentIdentity { newest: ledger.newest, identity, place })
        };
        let mut silent: Vec<SilentIdentity> = ledgers.iter().filter_map(silent).collect();
        silent.sort_by_key(|silent| (silent.newest, silent.identity));
        for lasts in [WITHIN_A_PERIOD, AT_ONCE] {
            let windows = (0..silent.len()).map(|from| {
                let until = silent[from].newest + lasts;
                from..silent.partition_point(|silent| silent.newest <= until)
            });
            // The first of equally full windows: the result does not depend on later silences.
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

    /// Probability that `many` of `all` fall silent independently `within` that time (binomial).
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
