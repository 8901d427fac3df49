//! An operator's decisions on their way to the engine, and which of them are in force.

use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, SyncSender, TrySendError};

use tokio::sync::{oneshot, watch};

use super::driver::Driver;
use fusion::operational::{Correlation, HeldCorrelation, NotCorrelated, Verdict};
use fusion::slots::Slot;
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
    NotCorrelated(#[from] NotCorrelated),
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
pub type AllCorrelations = Arc<Vec<HeldCorrelation>>;

struct Asked {
    wish: Wish,
    answer: oneshot::Sender<Result<AllCorrelations, Denied>>,
}

/// The operators' side; cheap to clone.
#[derive(Clone, Debug)]
pub struct Correlator {
    asked: SyncSender<Asked>,
    held: watch::Receiver<AllCorrelations>,
}

/// The engine's side.
#[derive(Debug)]
pub struct Correlations {
    asked: Receiver<Asked>,
    held: watch::Sender<AllCorrelations>,
}

/// Both sides.
pub(super) fn correlations() -> (Correlations, Correlator) {
    let (sender, asked) = mpsc::sync_channel(QUEUE);
    let (held, watched) = watch::channel(AllCorrelations::default());
    (Correlations { asked, held }, Correlator { asked: sender, held: watched })
}

impl Correlator {
    /// Asks the engine, which looks up several times a second; what is in force then comes back.
    ///
    /// # Errors
    /// Too many wait, or nobody is there.
    pub fn ask(&self, wish: Wish) -> Result<oneshot::Receiver<Result<AllCorrelations, Denied>>, Denied> {
        let (answer, answered) = oneshot::channel();
        match self.asked.try_send(Asked { wish, answer }) {
            Ok(()) => Ok(answered),
            Err(TrySendError::Full(_)) => Err(Denied::Busy),
            Err(TrySendError::Disconnected(_)) => Err(Denied::Gone),
        }
    }

    /// What is in force, as of the latest slot or decision.
    pub fn held(&self) -> AllCorrelations {
        self.held.borrow().clone()
    }
}

impl Correlations {
    /// Does what was asked for; what was decided, each with the first slot that is put out by it.
    pub fn obey(&self, driver: &mut Driver) -> Vec<(Slot, Correlation)> {
        let mut made = Vec::new();
        while let Ok(Asked { wish, answer }) = self.asked.try_recv() {
            // Who waits no longer has been told that nothing was decided.
            if answer.is_closed() {
                continue;
            }
            let correlated = correlate(&wish, driver);
            let answered = correlated.map(|correlated| {
                made.push(correlated);
                self.tell(driver.pipeline().engine().correlations());
                self.held.borrow().clone()
            });
            // Who has asked may have gone this very moment.
            let _ = answer.send(answered);
        }
        made
    }

    /// Tells what is in force; whether it has changed.
    pub fn tell(&self, held: Vec<HeldCorrelation>) -> bool {
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

fn correlate(wish: &Wish, driver: &mut Driver) -> Result<(Slot, Correlation), Denied> {
    let engine = driver.pipeline().engine();
    // What something was decided of may have fallen silent since.
    let correlated = engine.correlations().into_iter().map(|held| held.correlation.transponder);
    let mut found: Vec<Identity> =
        engine.transponders().chain(correlated).filter(|identity| wish.means(*identity)).collect();
    found.sort_unstable();
    found.dedup();
    let transponder = match found[..] {
        [transponder] => transponder,
        [] if driver.knows_correlations() => return Err(NotCorrelated::NoTransponder.into()),
        [] => return Err(NotCorrelated::Reference.into()),
        _ => return Err(Denied::Ambiguous(found.iter().map(country).collect())),
    };
    let correlation = Correlation { radar: wish.radar, transponder, verdict: wish.verdict };
    Ok((driver.correlate(correlation)?, correlation))
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
