//! The writer of the history: a thread behind a bounded queue, so that a slow disk costs history and nothing else.

use std::io;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{self, Receiver, SyncSender, TrySendError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tracing::{error, info};

use super::{SavedTrack, Snapshot, Store};
use crate::live::{Archive, Severity, Trouble};
use crate::picture::{MAX_ACCURACY_M, Picture, PictureMaker};
use fusion::time::SECOND;

/// Pictures that may wait: a minute of them.
const QUEUE: usize = 60;
/// Pictures per transaction: a power failure costs this many seconds.
const BATCH: usize = 5;

/// Pause before a file that failed is tried again, which reads all of it.
const RETRY: Duration = Duration::from_secs(10);

/// Keeps a picture a second.
#[derive(Debug)]
pub struct Historian {
    store: Store,
    writer: Option<Writer>,
    /// The second that was kept last.
    second: i64,
}

/// The writer's thread, and its queue.
#[derive(Debug)]
struct Writer {
    queue: SyncSender<Snapshot>,
    thread: JoinHandle<()>,
}

impl Writer {
    fn start(store: Store) -> io::Result<Self> {
        let (queue, pictures) = mpsc::sync_channel(QUEUE);
        let keeper = Keeper { store, retry: None };
        let thread =
            std::thread::Builder::new().name("history".to_owned()).spawn(move || keeper.run(&pictures))?;
        Ok(Self { queue, thread })
    }
}

impl Historian {
    /// Starts the writer, which opens the store where that is not open.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn start(store: Store) -> io::Result<Self> {
        let writer = Writer::start(store.clone())?;
        Ok(Self { store, writer: Some(writer), second: i64::MIN })
    }

    /// Hands a picture to the writer. A writer that has ended is a bug; another one is started.
    fn offer(&mut self, snapshot: Snapshot) -> Result<(), TrySendError<Snapshot>> {
        let Some(writer) = &self.writer else { return Err(TrySendError::Disconnected(snapshot)) };
        let offered = writer.queue.try_send(snapshot);
        if let Err(TrySendError::Disconnected(_)) = offered {
            error!("the thread of the history has ended: this is a bug; another one is started");
            self.store.0.counters.failing.store(true, Ordering::Relaxed);
            self.store.0.counters.damaged.store(true, Ordering::Relaxed);
            self.writer = Writer::start(self.store.clone()).ok();
        }
        offered
    }
}

impl Archive for Historian {
    /// Keeps the picture, if it is the first of its second.
    fn note(&mut self, picture: &Picture, maker: &PictureMaker) {
        let second = picture.time.nanos().div_euclid(SECOND);
        if std::mem::replace(&mut self.second, second) == second {
            return;
        }
        let tracks = picture.within(MAX_ACCURACY_M).map(|track| SavedTrack::of(track, maker)).collect();
        let snapshot = Snapshot { time: picture.time, tracks };
        if self.offer(snapshot).is_err() {
            self.store.0.counters.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn trouble(&self) -> Option<Trouble> {
        self.store.is_failing().then(|| Trouble {
            about: "history".into(),
            severity: Severity::Warning,
            text: "no history is kept: the disk cannot be written".to_owned(),
        })
    }
}

/// What waits is written before it is gone.
impl Drop for Historian {
    fn drop(&mut self) {
        if let Some(Writer { queue, thread }) = self.writer.take() {
            drop(queue);
            let _ = thread.join();
        }
    }
}

/// The writer's thread.
struct Keeper {
    store: Store,
    /// When a file that failed is tried again.
    retry: Option<Instant>,
}

impl Keeper {
    fn run(mut self, pictures: &Receiver<Snapshot>) {
        if !self.store.is_open() {
            let opened = self.store.open_or_replace();
            self.note(&opened);
        }
        let mut batch = Vec::with_capacity(BATCH);
        loop {
            let next = pictures.recv();
            let ended = next.is_err();
            batch.extend(next);
            if batch.len() == BATCH || ended {
                if !self.keep(&batch) {
                    self.store.0.counters.lost.fetch_add(batch.len() as u64, Ordering::Relaxed);
                }
                batch.clear();
            }
            if ended {
                return;
            }
        }
    }

    /// Whether they were kept; not while a failed file is let alone.
    #[expect(clippy::disallowed_methods, reason = "a failed file is tried again by the clock of the machine")]
    fn keep(&mut self, batch: &[Snapshot]) -> bool {
        if batch.is_empty() || self.retry.is_some_and(|retry| Instant::now() < retry) {
            return batch.is_empty();
        }
        let is_opened_first = self.retry.is_some() || self.store.is_damaged();
        let opened = if is_opened_first { self.store.open_or_replace() } else { Ok(()) };
        let mut kept = opened.and_then(|()| self.store.keep(batch));
        if self.store.is_damaged() {
            kept = self.store.open_or_replace().and_then(|()| self.store.keep(batch));
        }
        self.note(&kept)
    }

    /// Notes whether the file can be written; whether it can.
    #[expect(clippy::disallowed_methods, reason = "a failed file is tried again by the clock of the machine")]
    fn note(&mut self, written: &Result<(), redb::Error>) -> bool {
        let failing = &self.store.0.counters.failing;
        match written {
            Ok(()) => {
                self.retry = None;
                if failing.swap(false, Ordering::Relaxed) {
                    info!(missing = self.store.lost(), "the history is written again");
                }
            }
            Err(error) => {
                if !failing.swap(true, Ordering::Relaxed) {
                    let (file, retry_s) = (self.store.0.path.display(), RETRY.as_secs());
                    error!(%file, %error, retry_s, "the history cannot be written: tried again, the service goes on");
                }
                // For its readers.
                if !self.store.is_damaged() {
                    let _ = self.store.reopen();
                }
                self.retry = Some(Instant::now() + RETRY);
            }
        }
        written.is_ok()
    }
}
