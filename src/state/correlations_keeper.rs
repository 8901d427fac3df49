//! Keeps `decisions.jsonl` up to date: what operators have decided outlives a restart.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::time::Duration;

use tracing::error;

use super::text_keeper::TextKeeper;
use super::{CORRELATIONS, Correlations, read_correlations, set_aside};
use fusion::time::Time;

/// The file is written at most this often: while decisions are in force it changes all the time, by when their radar tracks
/// were heard last, and after a crash that counts.
const PAUSE: Duration = Duration::from_secs(1);

/// The running keeper; it ends when the sender is gone.
pub struct DecisionsKeeper {
    keeper: TextKeeper,
}

impl DecisionsKeeper {
    /// What `directory` holds. A file that cannot be used is reported and set aside: the service starts with none, rather than
    /// not at all.
    pub fn load(directory: &Path, now: Time) -> Correlations {
        match read_correlations(&directory.join(CORRELATIONS)) {
            Ok(correlations) => correlations,
            Err(error) if error.kind() == io::ErrorKind::NotFound => Correlations::default(),
            Err(error) => {
                match set_aside(directory, CORRELATIONS, now) {
                    Ok(aside) => {
                        error!("{error}; it is now {}, and no decision of before holds", aside.display());
                    }
                    Err(rename) => {
                        error!("{error}; it cannot be set aside ({rename}); no decision of before holds");
                    }
                }
                Correlations::default()
            }
        }
    }

    /// Starts the thread, which writes the latest text that is sent to it into `directory`. One text may wait.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn start(directory: PathBuf) -> io::Result<(SyncSender<Arc<str>>, Self)> {
        let (sender, keeper) = TextKeeper::start(directory, CORRELATIONS, "decisions", PAUSE)?;
        Ok((sender, Self { keeper }))
    }

    /// Waits until the last text is written; the sender must be gone.
    pub fn join(self) {
        self.keeper.join();
    }
}
