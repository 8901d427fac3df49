//! Keeps `numbers.json` up to date, on a thread of its own: the engine never waits for a disk.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tracing::{error, info, warn};

use super::{NUMBERS, numbers_text, read_numbers, set_aside, write_atomically};
use fusion::numbering::{Given, NumberChange};
use fusion::time::Time;

/// The file is written at most this often.
const PAUSE: Duration = Duration::from_secs(1);
/// A file that could not be written is tried again after this time.
const RETRY: Duration = Duration::from_secs(5);
/// So many changes may wait for the disk; the engine keeps what does not fit.
const QUEUE: usize = 4096;

/// The running keeper; it ends when every sender of its numbers is gone.
pub struct Keeper {
    thread: JoinHandle<()>,
}

impl Keeper {
    /// The numbers that `directory` holds; those of a file without times count as heard now. A file that cannot be used is
    /// told and set aside: the service starts with none, rather than not at all.
    pub fn load(directory: &Path, now: Time) -> Vec<Given> {
        match read_numbers(directory) {
            Ok(mut numbers) => {
                numbers.iter_mut().for_each(|given| _ = given.heard.get_or_insert(now));
                info!("{} transponder numbers of before, from {}", numbers.len(), directory.display());
                numbers
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
            Err(error) => {
                match set_aside(directory, NUMBERS, now) {
                    Ok(aside) => error!("{error}; it is now {}, and numbers begin anew", aside.display()),
                    Err(rename) => error!("{error}; it cannot be set aside ({rename}); numbers begin anew"),
                }
                Vec::new()
            }
        }
    }

    /// Starts the thread, which keeps `numbers`, with what becomes of them, in `directory`.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn start(directory: PathBuf, numbers: Vec<Given>) -> io::Result<(SyncSender<NumberChange>, Self)> {
        let (sender, changes) = mpsc::sync_channel(QUEUE);
        let numbers = numbers.into_iter().map(|given| (given.number, given)).collect();
        let thread = std::thread::Builder::new()
            .name("numbers".to_owned())
            .spawn(move || keep(&directory, numbers, &changes))?;
        Ok((sender, Self { thread }))
    }

    /// Waits until the last numbers are written; every sender must be gone.
    pub fn join(self) {
        if self.thread.join().is_err() {
            error!("the thread that keeps the transponder numbers panicked; this is a bug");
        }
    }
}

#[expect(clippy::disallowed_methods, reason = "a pause between two writes")]
fn keep(directory: &Path, mut numbers: BTreeMap<u32, Given>, changes: &Receiver<NumberChange>) {
    let mut failed = false;
    // Waits for the first of them, then a second for more.
    while let Ok(first) = changes.recv() {
        apply(first, &mut numbers);
        let mut until = Instant::now() + PAUSE;
        let mut ended = false;
        loop {
            match changes.recv_timeout(until.saturating_duration_since(Instant::now())) {
                Ok(more) => {
                    apply(more, &mut numbers);
                    continue;
                }
                Err(RecvTimeoutError::Disconnected) => ended = true,
                Err(RecvTimeoutError::Timeout) => {}
            }
            match write(directory, &numbers) {
                Ok(()) => {
                    if std::mem::take(&mut failed) {
                        info!("{}: transponder numbers are kept again", directory.display());
                    }
                    break;
                }
                Err(error) if !failed => {
                    failed = true;
                    let seconds = RETRY.as_secs();
                    warn!(
                        "{}: transponder numbers cannot be kept: {error}; tried again every {seconds} s",
                        directory.display()
                    );
                }
                Err(_) => {}
            }
            if ended {
                return;
            }
            until = Instant::now() + RETRY;
        }
    }
}

fn apply(change: NumberChange, numbers: &mut BTreeMap<u32, Given>) {
    match change {
        NumberChange::Heard(given) => numbers.insert(given.number, given),
        NumberChange::Returned(given) => numbers.remove(&given.number),
    };
}

fn write(directory: &Path, numbers: &BTreeMap<u32, Given>) -> io::Result<()> {
    std::fs::create_dir_all(directory)?;
    let numbers: Vec<Given> = numbers.values().copied().collect();
    write_atomically(&directory.join(NUMBERS), &numbers_text(&numbers))
}
