//! The recorder: writes received and sent datagrams to pcap files that `replay` reads.
//!
//! It runs on its own thread behind a bounded queue. A slow, full or missing disk costs recordings, never a slot.
//!
//! | file | what |
//! |---|---|
//! | `input-<start>.pcap` | every datagram at the time of its handling, with its sender and its line's group and port |
//! | `output-<start>.pcap` | the datagrams sent, at their due times: what `replay -o output.pcap` writes |
//! | `input-<start>.site.toml` | the configuration in force; its head states from which slot on the replay equals the output |
//! | `input-<start>.numbers.json` | the numbers of transponders with points in the file, one per line, for the start of a replay |
//! | `input-<start>.registration.json` | the registration of the radars, at most 10 s old, for the start of a replay |
//! | `input-<start>.engine` | the state of the engine before the first datagram, if checkpoints are configured |
//! | `input-<start>.decisions.jsonl` | the operators' decisions, with the slots from which they apply; only if there are any |
//!
//! Files being written end in `.part`. They always end with a whole datagram, and are written at least once a second.

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

use fusion::numbering::Given;
use queue::RecorderCounters;
use site::config::{Config, Record};
use writer::RecordingWriter;

pub use queue::{RecorderCounts, RecorderMeter, RecorderQueue};
pub use recorded::RecordingItem;

/// Maximum number of datagrams waiting for the disk: some seconds at the busiest site.
const QUEUE: usize = 16_384;

/// Contents of a recording, beside the datagrams received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordedContents {
    /// All files of a service.
    Service,
    /// The files that a replay of the input needs.
    Input,
    /// Only datagrams: no configuration belongs to them.
    Datagrams,
}

/// The running recorder; it ends when its queue is dropped.
pub struct Recorder {
    thread: JoinHandle<()>,
    counters: Arc<RecorderCounters>,
}

impl Recorder {
    /// Starts the thread. `numbers` are the transponder numbers assigned before the start.
    ///
    /// # Errors
    /// No thread could be started. A directory that cannot be written is not an error: it is logged, and tried again.
    pub fn start(
        config: &Config,
        record: &Record,
        numbers: Vec<Given>,
        contents: RecordedContents,
    ) -> io::Result<(RecorderQueue, Self)> {
        let (sender, queue) = mpsc::sync_channel(QUEUE);
        let counters = Arc::<RecorderCounters>::default();
        let mut writer = RecordingWriter::new(config, record, numbers, contents, counters.clone());
        let span = error_span!("recorder", directory = %record.dir.display());
        let thread = std::thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || span.in_scope(|| writer.run(&queue)))?;
        Ok((RecorderQueue::new(sender, QUEUE, counters.clone()), Self { thread, counters }))
    }

    /// Counts so far.
    pub fn counts(&self) -> RecorderCounts {
        self.counters.now()
    }

    /// Waits until everything is written; the queue must have been dropped.
    pub fn join(self) -> RecorderCounts {
        let Self { thread, counters } = self;
        if thread.join().is_err() {
            error!("the recorder's thread panicked: this is a bug");
        }
        counters.now()
    }
}

/// Recording into a directory with the defaults of [`Record`]: recordings of 256 MiB, 16 full ones.
pub fn record_into(dir: &Path) -> Record {
    Record { dir: dir.to_owned(), rotate_mib: 256, keep: 16, keep_mib: 0, keep_hours: 0 }
}
