//! `record`: what arrives, into files, without an engine.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use jiff::SignedDuration;
use tracing::{info, warn};

use super::moment::duration;
use super::{CommandResult, Outcome, load_live};
use crate::app::{Stop, runtime};
use crate::live::{Clock, Listening, listen, now};
use crate::net::listen::Arrival;
use crate::record::Recorded;
use crate::record::{Recorder, RecorderCounts, RecorderQueue, record_into};
use fusion::time::Time;

/// Records what arrives on the inputs of a configuration into rotating pcap files, until Ctrl-C.
///
/// `replay` reads them; beside each stands the site.toml to do so with.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// The site's configuration: where to listen. What it says of recording and output is not used, but for rotate_mib and
    /// keep.
    #[arg(long, value_name = "FILE")]
    pub config: PathBuf,
    /// Where the files go; made where it does not exist.
    #[arg(long, value_name = "DIR")]
    pub dir: PathBuf,
    /// Records what the nodes of a cluster handle, from their log, instead of listening: `replay --state` gives what they published.
    #[cfg(feature = "cluster")]
    #[arg(long)]
    pub cluster: bool,
    /// Ends after this time: 90s, 10m, 8h.
    #[arg(long, value_name = "D", value_parser = duration)]
    pub duration: Option<SignedDuration>,
}

/// How often it is told how it goes.
const STATISTICS: SignedDuration = SignedDuration::from_secs(10);
/// How often it is looked whether to stop.
const LOOK_UP: Duration = Duration::from_millis(200);

/// Lines that are stopped hand on what has arrived within this time.
const DRAINED: Duration = Duration::from_secs(2);

/// Runs the command.
pub fn run(args: &Args) -> CommandResult {
    let config = load_live(&args.config)?;
    // The recorder would try again and again, as it does for the service; here there is nothing else to do.
    std::fs::create_dir_all(&args.dir)
        .map_err(|error| format!("{}: cannot be made: {error}", args.dir.display()))?;
    #[cfg(feature = "cluster")]
    if args.cluster {
        return super::cluster::record(&config, &args.dir, args.duration);
    }
    let mut record = config.output.record.clone().unwrap_or_else(|| record_into(&args.dir));
    record.dir.clone_from(&args.dir);
    let (queue, recorder) = Recorder::start(&config, &record, Vec::new(), false)?;

    let (runtime, stop) = (runtime(1)?, Stop::listen()?);
    let mut listening = listen(&config, &Clock::default(), runtime.handle());
    if listening.posts.take().is_some() {
        warn!("what gateways post over HTTP is not recorded: only a running service is posted to");
    }
    info!(directory = %args.dir.display(), "recording; Ctrl-C ends it");
    hand_on(&listening, queue, &stop, args.duration);

    // The queue is gone: the recorder writes what waits, and ends.
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
        match listening.arrivals.recv_timeout(LOOK_UP) {
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
    // What has arrived by now; the channel is closed behind it.
    listening.readers.stop();
    while let Ok(arrival) = listening.arrivals.recv_timeout(DRAINED) {
        queue.offer(recorded(arrival));
    }
}

fn recorded(arrival: Arrival) -> Recorded {
    let Arrival { received, line, from, payload } = arrival;
    Recorded::Input { received, line, from, payload }
}

/// How each input does, and the recorder.
fn log_counts(listening: &Listening, counts: RecorderCounts) {
    for (line, counters) in &listening.lines {
        let (open, received) = (&counters.joined, &counters.received);
        let (open, received) = (open.load(Ordering::Relaxed), received.load(Ordering::Relaxed));
        info!(input = line.name(), open, received, "input");
    }
    info!(recorded = counts.written, lost = counts.unwritten + counts.lost, "recorder");
}
