//! What operators ask of the engine, and what is in force: one queue, looked at several times a second, and one picture of
//! what holds.

use std::fmt;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, SyncSender, TrySendError};

use tokio::sync::{oneshot, watch};

use fusion::operational::NotCorrelated;

/// Most requests that may wait for the engine.
const QUEUE: usize = 64;

/// Why something is not decided.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Denied {
    /// The engine refuses it.
    #[error(transparent)]
    NotCorrelated(#[from] NotCorrelated),
    /// Several transponders have that serial number.
    #[error("several transponders have this serial number; their registration countries: {}", .0.join(", "))]
    Ambiguous(Vec<String>),
    /// Whether transponders can be trusted is not judged.
    #[error(
        "transponders are not judged here: the reference profile does not, nor does the operational one with [integrity] \
         action = \"off\""
    )]
    NotJudged,
    /// The picture is made on other machines, of which none is heard.
    #[error("nobody who makes the picture is heard: nothing can be decided now")]
    Unheard,
    /// Too many wait.
    #[error("too many decisions wait for the engine")]
    Busy,
    /// The engine has ended.
    #[error("the engine does not answer")]
    Gone,
}

struct Asked<W, H> {
    wish: W,
    answer: oneshot::Sender<Result<Arc<H>, Denied>>,
}

impl<W: fmt::Debug, H> fmt::Debug for Asked<W, H> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.wish.fmt(f)
    }
}

/// The operators' side, where `W` is asked for and `H` is in force; cheap to clone.
#[derive(Debug)]
pub struct Operators<W, H> {
    asked: SyncSender<Asked<W, H>>,
    held: watch::Receiver<Arc<H>>,
}

impl<W, H> Clone for Operators<W, H> {
    fn clone(&self) -> Self {
        Self { asked: self.asked.clone(), held: self.held.clone() }
    }
}

/// The engine's side.
#[derive(Debug)]
pub(super) struct Requests<W, H> {
    asked: Receiver<Asked<W, H>>,
    held: watch::Sender<Arc<H>>,
}

/// Both sides.
pub(super) fn requests<W, H: Default>() -> (Requests<W, H>, Operators<W, H>) {
    let (sender, asked) = mpsc::sync_channel(QUEUE);
    let (held, watched) = watch::channel(Arc::default());
    (Requests { asked, held }, Operators { asked: sender, held: watched })
}

impl<W, H> Operators<W, H> {
    /// Asks the engine; the answer holds what is then in force.
    ///
    /// # Errors
    /// Too many wait, or the engine has ended.
    pub fn ask(&self, wish: W) -> Result<oneshot::Receiver<Result<Arc<H>, Denied>>, Denied> {
        let (answer, answered) = oneshot::channel();
        match self.asked.try_send(Asked { wish, answer }) {
            Ok(()) => Ok(answered),
            Err(TrySendError::Full(_)) => Err(Denied::Busy),
            Err(TrySendError::Disconnected(_)) => Err(Denied::Gone),
        }
    }

    /// What is in force, as of the latest slot or decision.
    pub fn held(&self) -> Arc<H> {
        self.held.borrow().clone()
    }

    /// Changes whenever that does.
    pub fn changes(&self) -> watch::Receiver<Arc<H>> {
        self.held.clone()
    }
}

impl<W, H> Requests<W, H> {
    /// Carries out what was asked for: what was decided, and what is in force since.
    pub(super) fn obey<T>(&self, mut carry_out: impl FnMut(&W) -> Result<(T, H), Denied>) -> Vec<T> {
        let mut made = Vec::new();
        while let Ok(Asked { wish, answer }) = self.asked.try_recv() {
            // A caller that gave up has been told that nothing was decided.
            if answer.is_closed() {
                continue;
            }
            let answered = carry_out(&wish).map(|(decided, held)| {
                made.push(decided);
                let held = Arc::new(held);
                self.held.send_replace(held.clone());
                held
            });
            // The caller may have gone this very moment.
            let _ = answer.send(answered);
        }
        made
    }

    /// Publishes what is in force, where `is_new` of what is known; whether that is so.
    pub(super) fn tell(&self, is_new: impl FnOnce(&H) -> bool, held: impl FnOnce() -> H) -> bool {
        self.held.send_if_modified(|known| {
            let is_new = is_new(known);
            if is_new {
                *known = Arc::new(held());
            }
            is_new
        })
    }
}
