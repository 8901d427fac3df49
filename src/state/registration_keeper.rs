//! Keeps `registration.json` up to date, on a thread of its own: the engine never waits for a disk.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tracing::{error, info, warn};

use super::{REGISTRATION, Registrations, read_registration, set_aside, write_atomically};
use crate::time::Time;

/// The file is written at most this often; also one that could not be written is tried again after this time.
const PAUSE: Duration = Duration::from_secs(300);

/// The running keeper; it ends when the sender is gone.
pub struct RegistrationKeeper {
    thread: JoinHandle<()>,
}

impl RegistrationKeeper {
    /// What `directory` holds. A file that cannot be used is told and set aside: the service starts with none, rather than
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
        let (sender, texts) = mpsc::sync_channel(1);
        let thread = std::thread::Builder::new()
            .name("registration".to_owned())
            .spawn(move || keep(&directory, &texts))?;
        Ok((sender, Self { thread }))
    }

    /// Waits until the last text is written; the sender must be gone.
    pub fn join(self) {
        if self.thread.join().is_err() {
            error!("the thread that keeps the registration panicked; this is a bug");
        }
    }
}

#[expect(clippy::disallowed_methods, reason = "a pause between two writes")]
fn keep(directory: &Path, texts: &Receiver<Arc<str>>) {
    let mut unwritten: Option<Arc<str>> = None;
    let mut next = Instant::now() + PAUSE;
    let mut failed = false;
    loop {
        let ended = match texts.recv_timeout(next.saturating_duration_since(Instant::now())) {
            Ok(text) => {
                unwritten = Some(text);
                continue;
            }
            Err(RecvTimeoutError::Timeout) => false,
            Err(RecvTimeoutError::Disconnected) => true,
        };
        next = Instant::now() + PAUSE;
        match unwritten.as_deref().map(|text| write(directory, text)) {
            Some(Ok(())) => {
                unwritten = None;
                if std::mem::take(&mut failed) {
                    info!("{}: registration is kept again", directory.display());
                }
            }
            Some(Err(error)) if !failed => {
                failed = true;
                let minutes = PAUSE.as_secs() / 60;
                warn!(
                    "{}: registration cannot be kept: {error}; tried again every {minutes} min",
                    directory.display()
                );
            }
            Some(Err(_)) | None => {}
        }
        if ended {
            return;
        }
    }
}

fn write(directory: &Path, text: &str) -> io::Result<()> {
    std::fs::create_dir_all(directory)?;
    write_atomically(&directory.join(REGISTRATION), text)
}
