//! An operator's decisions on their way to the engine, and which of them are in force.

use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, SyncSender, TrySendError};

use tokio::sync::{oneshot, watch};

use super::driver::Driver;
use fusion::Slot;
use fusion::operational::{Decision, Held, Undecided, Verdict};
use fusion::{Identity, RadarTrackKey};

/// Wishes that may wait for the engine.
const QUEUE: usize = 64;

/// What an operator asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wish {
    /// The radar track as it is now.
    pub radar: RadarTrackKey,
    /// The transponder's serial number, as it is shown.
    pub serial: String,
    /// Its registration country, as it is shown; needed where several have that serial number.
    pub country: Option<String>,
    /// What is said of them.
    pub verdict: Verdict,
}

/// Why a wish is not fulfilled.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Denied {
    /// The engine says no.
    #[error(transparent)]
    Undecided(#[from] Undecided),
    /// Several transponders have that serial number.
    #[error("several transponders have this serial number; their registration countries: {}", .0.join(", "))]
    Ambiguous(Vec<String>),
    /// Too many wait.
    #[error("too many decisions wait for the engine")]
    Busy,
    /// Nobody is there to decide.
    #[error("the engine does not answer")]
    Gone,
}

/// What is in force.
pub type AllHeld = Arc<Vec<Held>>;

struct Asked {
    wish: Wish,
    answer: oneshot::Sender<Result<AllHeld, Denied>>,
}

/// The operators' side; cheap to clone.
#[derive(Clone, Debug)]
pub struct Decider {
    asked: SyncSender<Asked>,
    held: watch::Receiver<AllHeld>,
}

/// The engine's side.
#[derive(Debug)]
pub struct Decisions {
    asked: Receiver<Asked>,
    held: watch::Sender<AllHeld>,
}

/// Both sides.
pub(super) fn decisions() -> (Decisions, Decider) {
    let (sender, asked) = mpsc::sync_channel(QUEUE);
    let (held, watched) = watch::channel(AllHeld::default());
    (Decisions { asked, held }, Decider { asked: sender, held: watched })
}

impl Decider {
    /// Asks the engine, which looks up several times a second; what is in force then comes back.
    ///
    /// # Errors
    /// Too many wait, or nobody is there.
    pub fn ask(&self, wish: Wish) -> Result<oneshot::Receiver<Result<AllHeld, Denied>>, Denied> {
        let (answer, answered) = oneshot::channel();
        match self.asked.try_send(Asked { wish, answer }) {
            Ok(()) => Ok(answered),
            Err(TrySendError::Full(_)) => Err(Denied::Busy),
            Err(TrySendError::Disconnected(_)) => Err(Denied::Gone),
        }
    }

    /// What is in force, as of the latest slot or decision.
    pub fn held(&self) -> AllHeld {
        self.held.borrow().clone()
    }
}

impl Decisions {
    /// Does what was asked for; what was decided, each with the first slot that is put out by it.
    pub fn obey(&self, driver: &mut Driver) -> Vec<(Slot, Decision)> {
        let mut made = Vec::new();
        while let Ok(Asked { wish, answer }) = self.asked.try_recv() {
            // Who waits no longer has been told that nothing was decided.
            if answer.is_closed() {
                continue;
            }
            let decided = decide(&wish, driver);
            let answered = decided.map(|decided| {
                made.push(decided);
                self.tell(driver.pipeline().engine().decisions());
                self.held.borrow().clone()
            });
            // Who has asked may have gone this very moment.
            let _ = answer.send(answered);
        }
        made
    }

    /// Tells what is in force; whether it has changed.
    pub fn tell(&self, held: Vec<Held>) -> bool {
        self.held.send_if_modified(|known| {
            let is_new = **known != held;
            if is_new {
                *known = Arc::new(held);
            }
            is_new
        })
    }
}

impl std::fmt::Debug for Asked {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.wish.fmt(f)
    }
}

fn decide(wish: &Wish, driver: &mut Driver) -> Result<(Slot, Decision), Denied> {
    let engine = driver.pipeline().engine();
    // What something was decided of may have fallen silent since.
    let decided = engine.decisions().into_iter().map(|held| held.decision.transponder);
    let mut found: Vec<Identity> =
        engine.transponders().chain(decided).filter(|identity| wish.means(*identity)).collect();
    found.sort_unstable();
    found.dedup();
    let transponder = match found[..] {
        [transponder] => transponder,
        [] if driver.knows_decisions() => return Err(Undecided::NoTransponder.into()),
        [] => return Err(Undecided::Reference.into()),
        _ => return Err(Denied::Ambiguous(found.iter().map(country).collect())),
    };
    let decision = Decision { radar: wish.radar, transponder, verdict: wish.verdict };
    Ok((driver.decide(decision)?, decision))
}

fn country(identity: &Identity) -> String {
    match identity.country() {
        [] => "none".to_owned(),
        octets => octets.escape_ascii().to_string(),
    }
}

impl Wish {
    fn means(&self, identity: Identity) -> bool {
        let is_serial = identity.serial().escape_ascii().to_string() == self.serial;
        is_serial && self.country.as_ref().is_none_or(|wanted| *wanted == country(&identity))
    }
}
