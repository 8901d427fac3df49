//! The recorder: what the engine handled and what was sent, as pcap files that `replay` reads.
//!
//! It runs on a thread of its own behind a bounded queue. A disk that is slow, full or gone costs recordings, never a slot.
//!
//! | file | what |
//! |---|---|
//! | `input-<start>.pcap` | every datagram at the time at which the engine handled it, with its sender and its line's group and port |
//! | `output-<start>.pcap` | what was sent, at its due time: what `replay -o output.pcap` writes |
//! | `input-<start>.site.toml` | the configuration in force; its head says from which slot on the replay equals the output |
//! | `input-<start>.numbers.json` | the numbers of the transponders that have points in the file, to begin the replay with; appended, one per line |
//! | `input-<start>.registration.json` | how the radars were registered, to begin the replay with; that is at most 10 s old |
//! | `input-<start>.engine` | the state of the engine before the first datagram, where checkpoints are made |
//! | `input-<start>.decisions.jsonl` | what operators decided, with the slots from which it counts; only where they did |
//!
//! Files being written end in `.part`. Datagrams reach them whole, at least once a second.

mod leftovers;
mod names;
mod queue;
mod recorded;
mod retention;
mod segment;
mod writer;

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc;
use std::thread::JoinHandle;

use tracing::{error, error_span};

use crate::config::{Config, Record};
use fusion::numbering::Given;
use queue::Counters;
use writer::Writer;

pub use queue::{RecorderCounts, RecorderMeter, RecorderQueue};
pub use recorded::Recorded;

/// Datagrams that may wait for the disk: some seconds of the busiest site.
const QUEUE: usize = 16_384;

/// The running recorder; it ends when its queue is gone.
pub struct Recorder {
    thread: JoinHandle<()>,
    counters: Arc<Counters>,
}

impl Recorder {
    /// Starts the thread; `numbers` are those given before the start. `with_output` records both series.
    ///
    /// # Errors
    /// No thread could be started. A directory that cannot be written is no error: it is logged, and tried again.
    pub fn start(
        config: &Config,
        record: &Record,
        numbers: Vec<Given>,
        with_output: bool,
    ) -> io::Result<(RecorderQueue, Self)> {
        let (sender, queue) = mpsc::sync_channel(QUEUE);
        let counters = Arc::<Counters>::default();
        let mut writer = Writer::new(config, record, numbers, with_output, counters.clone());
        let span = error_span!("recorder", directory = %record.dir.display());
        let thread = std::thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || span.in_scope(|| writer.run(&queue)))?;
        Ok((RecorderQueue::new(sender, QUEUE, counters.clone()), Self { thread, counters }))
    }

    /// The counts so far.
    pub fn counts(&self) -> RecorderCounts {
        self.counters.now()
    }

    /// Waits until everything is written; the queue must be gone.
    pub fn join(self) -> RecorderCounts {
        let Self { thread, counters } = self;
        if thread.join().is_err() {
            error!("the recorder's thread panicked: this is a bug");
        }
        counters.now()
    }
}

/// A directory as [`Record`] has it by default: recordings of 256 MiB, 16 full ones.
pub fn record_into(dir: &Path) -> Record {
    Record { dir: dir.to_owned(), rotate_mib: 256, keep: 16, keep_mib: 0, keep_hours: 0 }
}
