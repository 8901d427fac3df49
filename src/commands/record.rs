//! `record`: records received data without an engine.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use jiff::SignedDuration;
use tracing::{info, warn};

use super::moment::duration;
use super::{CommandResult, Outcome, check_mqtt, load_live, mqtt_inputs};
use crate::app::{Stop, runtime};
use fusion::time::Time;
use service::live::{Listening, WallClock, listen, now};
use service::net::listen::Arrival;
use service::record::RecordingItem;
use service::record::{Recorder, RecorderCounts, RecorderQueue, record_into};

/// Records the data received on the inputs of a configuration into rotating pcap files, until Ctrl-C.
///
/// `replay` reads the files, with the site.toml that is written beside them.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Site configuration, which defines the inputs. Its recording and output settings are ignored, except rotate_mib and keep.
    #[arg(long, value_name = "FILE")]
    pub config: PathBuf,
    /// Directory of the files; created if missing.
    #[arg(long, value_name = "DIR")]
    pub dir: PathBuf,
    /// Records the inputs of a cluster's nodes from the log instead of listening. `replay --state` reproduces what the nodes
    /// published.
    #[cfg(feature = "cluster")]
    #[arg(long)]
    pub cluster: bool,
    /// Duration, such as 90s, 10m or 8h.
    #[arg(long, value_name = "D", value_parser = duration)]
    pub duration: Option<SignedDuration>,
}

/// Interval of the log lines with counters.
const STATISTICS: SignedDuration = SignedDuration::from_secs(10);
/// Interval at which a stop request is checked.
const POLL_INTERVAL: Duration = Duration::from_millis(200);

/// Maximum time for stopped inputs to pass on received data.
const DRAINED: Duration = Duration::from_secs(2);

/// Runs the command.
pub fn run(args: &Args) -> CommandResult {
    let config = load_live(&args.config)?;
    // The recorder would retry, as it does for the service. A recording command has to fail instead.
    std::fs::create_dir_all(&args.dir)
        .map_err(|error| format!("{}: cannot be made: {error}", args.dir.display()))?;
    #[cfg(feature = "cluster")]
    if args.cluster {
        return super::cluster::record(&config, &args.dir, args.duration);
    }
    check_mqtt(&args.config, mqtt_inputs(&config))?;
    let mut record = config.output.record.clone().unwrap_or_else(|| record_into(&args.dir));
    record.dir.clone_from(&args.dir);
    let (queue, recorder) = Recorder::start(&config, &record, Vec::new(), false)?;

    let (runtime, stop) = (runtime(1)?, Stop::listen()?);
    let mut listening = listen(&config, &WallClock::default(), runtime.handle());
    if listening.http_input.take().is_some() {
        warn!("what gateways post over HTTP is not recorded: only a running service is posted to");
    }
    info!(directory = %args.dir.display(), "recording; Ctrl-C ends it");
    hand_on(&listening, queue, &stop, args.duration);

    // The queue is closed, so the recorder writes the rest and ends.
    let recorder = recorder.join();
    let unrecorded = recorder.unwritten + recorder.lost;
    info!(recorded = recorder.written, lost = unrecorded, "stopped");
    Ok(if unrecorded > 0 { Outcome::Incomplete } else { Outcome::Done })
}

fn hand_on(listening: &Listening, mut queue: RecorderQueue, stop: &Stop, duration: Option<SignedDuration>) {
    let began = now();
    let mut told = began;
    let is_over = |at: Time| duration.is_some_and(|duration| at - began >= duration);
    while !stop.comes_within(Duration::ZERO) && !is_over(now()) {
        match listening.arrivals.recv_timeout(POLL_INTERVAL) {
            Ok(arrival) => queue.offer(recorded(arrival)),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        let at = now();
        if at - told >= STATISTICS {
            told = at;
            log_counts(listening, queue.counts());
        }
    }
    // The readers pass on the data received so far; then the channel closes.
    listening.readers.stop();
    while let Ok(arrival) = listening.arrivals.recv_timeout(DRAINED) {
        queue.offer(recorded(arrival));
    }
}

fn recorded(arrival: Arrival) -> RecordingItem {
    let Arrival { received, line, from, payload } = arrival;
    RecordingItem::Input { received, line, from, payload }
}

/// Logs the counters of each input and of the recorder.
fn log_counts(listening: &Listening, counts: RecorderCounts) {
    for (line, counters) in &listening.lines {
        let (open, received) = (&counters.joined, &counters.received);
        let (open, received) = (open.load(Ordering::Relaxed), received.load(Ordering::Relaxed));
        info!(input = line.name(), open, received, "input");
    }
    info!(recorded = counts.written, lost = counts.unwritten + counts.lost, "recorder");
}
