//! The one writer of the history: a thread behind a bounded queue, so that a slow disk costs history and nothing else.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::thread::JoinHandle;

use tracing::{error, info};

use super::{Kept, Snapshot, Store};
use crate::picture::{Picture, PictureMaker};
use crate::time::SECOND;

/// Pictures that may wait: a minute of them.
const QUEUE: usize = 60;
/// Pictures of one transaction: a power failure costs this many seconds.
const BATCH: usize = 5;

/// Keeps a picture a second.
#[derive(Debug)]
pub struct Historian {
    queue: Option<SyncSender<Snapshot>>,
    lost: Arc<AtomicU64>,
    writer: Option<JoinHandle<()>>,
    /// The second that was kept last.
    second: i64,
}

impl Historian {
    /// Starts the writer.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn start(store: Store) -> io::Result<Self> {
        let (queue, pictures) = mpsc::sync_channel(QUEUE);
        let lost = Arc::new(AtomicU64::new(0));
        let counter = lost.clone();
        let writer = std::thread::Builder::new()
            .name("history".to_owned())
            .spawn(move || write(&store, &pictures, &counter))?;
        Ok(Self { queue: Some(queue), lost, writer: Some(writer), second: i64::MIN })
    }

    /// Keeps the picture, if it is the first of its second; never waits.
    pub fn note(&mut self, picture: &Picture, maker: &PictureMaker) {
        let second = picture.time.nanos().div_euclid(SECOND);
        if std::mem::replace(&mut self.second, second) == second {
            return;
        }
        let tracks = picture.tracks.iter().map(|track| Kept::of(track, maker)).collect();
        let snapshot = Snapshot { time: picture.time, tracks };
        if self.queue.as_ref().is_none_or(|queue| queue.try_send(snapshot).is_err()) {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Pictures that were not kept.
    pub fn lost(&self) -> Arc<AtomicU64> {
        self.lost.clone()
    }
}

/// What waits is written before it is gone.
impl Drop for Historian {
    fn drop(&mut self) {
        drop(self.queue.take());
        if let Some(writer) = self.writer.take() {
            let _ = writer.join();
        }
    }
}

fn write(store: &Store, pictures: &Receiver<Snapshot>, lost: &AtomicU64) {
    let mut failing = false;
    let mut batch = Vec::with_capacity(BATCH);
    loop {
        let next = pictures.recv();
        let ended = next.is_err();
        batch.extend(next);
        if batch.len() < BATCH && !ended {
            continue;
        }
        if !batch.is_empty() {
            match store.keep(&batch) {
                Ok(()) if failing => {
                    failing = false;
                    info!("the history is written again");
                }
                Ok(()) => {}
                Err(error) => {
                    lost.fetch_add(batch.len() as u64, Ordering::Relaxed);
                    if !std::mem::replace(&mut failing, true) {
                        error!("the history cannot be written: {error}; it goes on without");
                    }
                }
            }
            batch.clear();
        }
        if ended {
            return;
        }
    }
}
