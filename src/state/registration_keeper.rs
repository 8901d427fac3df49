//! Keeps `registration.json` up to date, on a thread of its own: the engine never waits for a disk.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::time::Duration;

use tracing::error;

use super::text_keeper::TextKeeper;
use super::{REGISTRATION, Registrations, read_registration, set_aside};
use fusion::time::Time;

/// The file is written at most this often; also one that could not be written is tried again after this time.
const PAUSE: Duration = Duration::from_secs(300);

/// The running keeper; it ends when the sender is gone.
pub struct RegistrationKeeper {
    keeper: TextKeeper,
}

impl RegistrationKeeper {
    /// What `directory` holds. A file that cannot be used is reported and set aside: the service starts with none, rather than
    /// not at all.
    pub fn load(directory: &Path, now: Time) -> Registrations {
        match read_registration(&directory.join(REGISTRATION)) {
            Ok(registrations) => registrations,
            Err(error) if error.kind() == io::ErrorKind::NotFound => Registrations::default(),
            Err(error) => {
                match set_aside(directory, REGISTRATION, now) {
                    Ok(aside) => {
                        error!("{error}; it is now {}, and registration begins anew", aside.display());
                    }
                    Err(rename) => {
                        error!("{error}; it cannot be set aside ({rename}); registration begins anew");
                    }
                }
                Registrations::default()
            }
        }
    }

    /// Starts the thread, which writes the latest text that is sent to it into `directory`, now and then and at the end. One
    /// text may wait.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn start(directory: PathBuf) -> io::Result<(SyncSender<Arc<str>>, Self)> {
        let (sender, keeper) = TextKeeper::start(directory, REGISTRATION, "registration", PAUSE)?;
        Ok((sender, Self { keeper }))
    }

    /// Waits until the last text is written; the sender must be gone.
    pub fn join(self) {
        self.keeper.join();
    }
}
