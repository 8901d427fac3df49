//! Keeps a file of the state up to date, on a thread of its own: the engine never waits for a disk.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tracing::{error, info, warn};

use super::write_atomically;

/// The running keeper; it ends when the sender is gone.
pub(super) struct TextKeeper {
    thread: JoinHandle<()>,
    what: &'static str,
}

impl TextKeeper {
    /// Starts the thread, which writes the latest text that is sent to it into that file of `directory`, once in `pause`
    /// at most, and at the end; what could not be written is tried again after that time, too. One text may wait. `what`
    /// the file holds stands in the log.
    ///
    /// # Errors
    /// No thread could be started.
    pub(super) fn start(
        directory: PathBuf,
        file: &'static str,
        what: &'static str,
        pause: Duration,
    ) -> io::Result<(SyncSender<Arc<str>>, Self)> {
        let (sender, texts) = mpsc::sync_channel(1);
        let thread = std::thread::Builder::new()
            .name(what.to_owned())
            .spawn(move || keep(&directory, file, what, pause, &texts))?;
        Ok((sender, Self { thread, what }))
    }

    /// Waits until the last text is written; the sender must be gone.
    pub(super) fn join(self) {
        if self.thread.join().is_err() {
            error!("the thread that keeps the {} panicked; this is a bug", self.what);
        }
    }
}

#[expect(clippy::disallowed_methods, reason = "a pause between two writes")]
fn keep(directory: &Path, file: &str, what: &str, pause: Duration, texts: &Receiver<Arc<str>>) {
    let mut unwritten: Option<Arc<str>> = None;
    let mut next = Instant::now() + pause;
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
        next = Instant::now() + pause;
        match unwritten.as_deref().map(|text| write(directory, file, text)) {
            Some(Ok(())) => {
                unwritten = None;
                if std::mem::take(&mut failed) {
                    info!("{}: {what} is kept again", directory.display());
                }
            }
            Some(Err(error)) if !failed => {
                failed = true;
                let seconds = pause.as_secs();
                warn!(
                    "{}: {what} cannot be kept: {error}; tried again every {seconds} s",
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

fn write(directory: &Path, file: &str, text: &str) -> io::Result<()> {
    std::fs::create_dir_all(directory)?;
    write_atomically(&directory.join(file), text)
}
