//! Keepers of the state files, each on its own thread, so that the engine never waits for a disk.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tracing::{error, info, warn};

use super::{CORRELATIONS, NUMBERS, REGISTRATION, SHELVED, StateHealth, numbers_text, write_atomically};
use crate::clock::now;
use fusion::numbering::{Given, NumberChange};
use fusion::time::Time;

/// A file in the directory of `[state]`.
#[derive(Clone, Copy, Debug)]
pub struct StateFile {
    name: &'static str,
    /// Description of its contents for the log.
    contents: &'static str,
    /// Minimum time between two writes.
    pause: Duration,
    /// Pause before a failed write is tried again.
    retry: Duration,
    /// Maximum number of changes waiting for the disk.
    queue: usize,
}

impl StateFile {
    /// Transponder numbers; the engine keeps the changes that do not fit into the queue.
    pub const NUMBERS: Self = Self {
        name: NUMBERS,
        contents: "transponder numbers",
        pause: Duration::from_secs(1),
        retry: Duration::from_secs(5),
        queue: 4096,
    };
    /// Registration of the radars.
    pub const REGISTRATION: Self = Self {
        name: REGISTRATION,
        contents: "registration",
        pause: Duration::from_secs(300),
        retry: Duration::from_secs(300),
        queue: 1,
    };
    /// Operators' decisions. While one is in force the file changes continually, with the last reception of its radar
    /// track.
    pub const DECISIONS: Self = Self {
        name: CORRELATIONS,
        contents: "decisions",
        pause: Duration::from_secs(1),
        retry: Duration::from_secs(1),
        queue: 1,
    };
    /// Shelved alerts.
    pub const SHELVED: Self = Self {
        name: SHELVED,
        contents: "shelved alerts",
        pause: Duration::from_secs(1),
        retry: Duration::from_secs(5),
        queue: 1,
    };

    /// Contents of the file in `directory`; empty if there is none. A damaged file is set aside: the service starts without
    /// it, rather than not at all.
    pub fn load<T: Default>(
        &self,
        directory: &Path,
        now: Time,
        health: &StateHealth,
        read: impl FnOnce(&Path) -> io::Result<T>,
    ) -> T {
        health.clear_obstacles(directory, self.name, self.contents, now);
        match read(&directory.join(self.name)) {
            Ok(contents) => contents,
            Err(error) if error.kind() == io::ErrorKind::NotFound => T::default(),
            Err(error) => {
                health.set_aside(directory, self.name, self.contents, &error, now);
                T::default()
            }
        }
    }

    /// Starts the thread that keeps `contents`, updated by the changes sent to it, in this file of `directory`. Failures to
    /// write are recorded in `health`.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn keep<C: StateContents>(
        self,
        directory: &Path,
        contents: C,
        health: &StateHealth,
    ) -> io::Result<(SyncSender<C::Change>, StateKeeper)> {
        let (sender, changes) = mpsc::sync_channel(self.queue);
        let (directory, health) = (directory.to_owned(), health.clone());
        let thread = std::thread::Builder::new()
            .name(self.contents.to_owned())
            .spawn(move || self.follow(&directory, contents, &health, &changes))?;
        Ok((sender, StateKeeper(thread)))
    }

    #[expect(clippy::disallowed_methods, reason = "a pause between two writes")]
    fn follow<C: StateContents>(
        &self,
        directory: &Path,
        mut kept: C,
        health: &StateHealth,
        changes: &Receiver<C::Change>,
    ) {
        let Self { name, contents, pause, retry, .. } = *self;
        // Waits for the first change, then for more during a pause.
        while let Ok(first) = changes.recv() {
            kept.apply(first);
            let mut until = Instant::now() + pause;
            loop {
                let ended = match changes.recv_timeout(until.saturating_duration_since(Instant::now())) {
                    Ok(more) => {
                        kept.apply(more);
                        continue;
                    }
                    Err(error) => error == RecvTimeoutError::Disconnected,
                };
                let file = directory.join(name);
                let written = std::fs::create_dir_all(directory)
                    .and_then(|()| write_atomically(&file, kept.text().as_bytes()));
                match written {
                    Ok(()) => {
                        if health.note_success(name) {
                            info!(contents, file = %file.display(), "state is written again");
                        }
                        break;
                    }
                    Err(error) => {
                        if health.note_failure(name, &error) {
                            let (file, retry_s) = (file.display(), retry.as_secs());
                            warn!(contents, %file, %error, retry_s, "state cannot be written: tried again");
                        }
                        health.clear_obstacles(directory, name, contents, now());
                    }
                }
                if ended {
                    return;
                }
                until = Instant::now() + retry;
            }
        }
    }
}

/// Contents of a state file.
pub trait StateContents: Send + 'static {
    /// A change of the contents.
    type Change: Send;

    /// Applies a change.
    fn apply(&mut self, change: Self::Change);

    /// Text of the file.
    fn text(&self) -> Arc<str>;
}

/// Assigned transponder numbers, by number.
impl StateContents for BTreeMap<u32, Given> {
    type Change = NumberChange;

    fn apply(&mut self, change: NumberChange) {
        match change {
            NumberChange::Heard(given) => self.insert(given.number, given),
            NumberChange::Returned(given) => self.remove(&given.number),
        };
    }

    fn text(&self) -> Arc<str> {
        numbers_text(&self.values().copied().collect::<Vec<_>>()).into()
    }
}

/// The text itself.
impl StateContents for Arc<str> {
    type Change = Self;

    fn apply(&mut self, text: Self) {
        *self = text;
    }

    fn text(&self) -> Self {
        self.clone()
    }
}

/// A running keeper; it ends when all senders of its changes are dropped.
#[derive(Debug)]
pub struct StateKeeper(JoinHandle<()>);

impl StateKeeper {
    /// Waits until the last change is written.
    pub fn join(self) {
        let thread = self.0.thread().name().unwrap_or_default().to_owned();
        if self.0.join().is_err() {
            error!(thread, "thread panicked: this is a bug");
        }
    }
}
