//! Writer of the history: a thread behind a bounded queue, so that a slow disk costs only history.

use std::io;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{self, Receiver, SyncSender, TrySendError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tracing::{error, info};

use super::{HistoryPicture, HistoryStore, HistoryTrack};
use crate::live::{Archive, ServiceFault, Severity};
use fusion::time::SECOND;
use picture::{MAX_ACCURACY_M, Picture, PictureMaker};

/// Maximum number of waiting pictures: a minute.
const QUEUE: usize = 60;
/// Number of pictures per transaction; a power failure costs this many seconds.
const BATCH: usize = 5;

/// Pause before a failed file is tried again, which reads all of it.
const RETRY: Duration = Duration::from_secs(10);

/// Keeps one picture per second.
#[derive(Debug)]
pub struct Historian {
    store: HistoryStore,
    writer: Option<HistoryWriter>,
    /// The last second kept.
    second: i64,
}

/// The writer's thread, and its queue.
#[derive(Debug)]
struct HistoryWriter {
    queue: SyncSender<HistoryPicture>,
    thread: JoinHandle<()>,
}

impl HistoryWriter {
    fn start(store: HistoryStore) -> io::Result<Self> {
        let (queue, pictures) = mpsc::sync_channel(QUEUE);
        let keeper = HistoryThread { store, retry: None };
        let thread =
            std::thread::Builder::new().name("history".to_owned()).spawn(move || keeper.run(&pictures))?;
        Ok(Self { queue, thread })
    }
}

impl Historian {
    /// Starts the writer, which opens the store if it is not open.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn start(store: HistoryStore) -> io::Result<Self> {
        let writer = HistoryWriter::start(store.clone())?;
        Ok(Self { store, writer: Some(writer), second: i64::MIN })
    }

    /// Passes a picture to the writer. A writer that has ended is a bug; a new one is started.
    fn offer(&mut self, snapshot: HistoryPicture) -> Result<(), TrySendError<HistoryPicture>> {
        let Some(writer) = &self.writer else { return Err(TrySendError::Disconnected(snapshot)) };
        let offered = writer.queue.try_send(snapshot);
        if let Err(TrySendError::Disconnected(_)) = offered {
            error!("the thread of the history has ended: this is a bug; another one is started");
            self.store.0.counters.failing.store(true, Ordering::Relaxed);
            self.store.0.counters.damaged.store(true, Ordering::Relaxed);
            self.writer = HistoryWriter::start(self.store.clone()).ok();
        }
        offered
    }
}

impl Archive for Historian {
    /// Keeps the picture if it is the first of its second.
    fn note(&mut self, picture: &Picture, maker: &PictureMaker) {
        let second = picture.time.nanos().div_euclid(SECOND);
        if std::mem::replace(&mut self.second, second) == second {
            return;
        }
        let tracks = picture.within(MAX_ACCURACY_M).map(|track| HistoryTrack::of(track, maker)).collect();
        let snapshot = HistoryPicture { time: picture.time, tracks };
        if self.offer(snapshot).is_err() {
            self.store.0.counters.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn trouble(&self) -> Option<ServiceFault> {
        self.store.is_failing().then(|| ServiceFault {
            about: "history".into(),
            severity: Severity::Warning,
            text: "no history is kept: the disk cannot be written".to_owned(),
        })
    }
}

/// Waiting pictures are written first.
impl Drop for Historian {
    fn drop(&mut self) {
        if let Some(HistoryWriter { queue, thread }) = self.writer.take() {
            drop(queue);
            let _ = thread.join();
        }
    }
}

/// State of the writer's thread.
struct HistoryThread {
    store: HistoryStore,
    /// Time at which a failed file is tried again.
    retry: Option<Instant>,
}

impl HistoryThread {
    fn run(mut self, pictures: &Receiver<HistoryPicture>) {
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

    /// Keeps pictures; returns whether they were written. They are not while a failed file is suspended.
    #[expect(clippy::disallowed_methods, reason = "a failed file is tried again by the clock of the machine")]
    fn keep(&mut self, batch: &[HistoryPicture]) -> bool {
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

    /// Records whether the file could be written, and returns it.
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
                // Opens the file again, for its readers.
                if !self.store.is_damaged() {
                    let _ = self.store.reopen();
                }
                self.retry = Some(Instant::now() + RETRY);
            }
        }
        written.is_ok()
    }
}
