//! `record`: what arrives, into files, without an engine.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use jiff::SignedDuration;
use tokio::signal::unix::{Signal, SignalKind, signal};
use tracing::info;

use super::moment::duration;
use super::{CommandResult, Outcome, load_live};
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
    let mut record = config.output.record.clone().unwrap_or_else(|| record_into(&args.dir));
    record.dir.clone_from(&args.dir);
    let (queue, recorder) = Recorder::start(&config, &record, Vec::new(), false)?;

    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build()?;
    let stop = Arc::new(AtomicBool::new(false));
    let signals = {
        let _inside = runtime.enter();
        (signal(SignalKind::interrupt())?, signal(SignalKind::terminate())?)
    };
    runtime.spawn(stop_at(signals, stop.clone()));
    let listening = listen(&config, &Clock::default(), runtime.handle());
    info!("recording into {}; Ctrl-C ends it", args.dir.display());
    hand_on(&listening, queue, &stop, args.duration);

    // The queue is gone: the recorder writes what waits, and ends.
    let recorder = recorder.join();
    let unrecorded = recorder.unwritten + recorder.lost;
    info!("stopped: {} datagrams recorded, {unrecorded} lost", recorder.written);
    Ok(if unrecorded > 0 { Outcome::Incomplete } else { Outcome::Done })
}

/// Until SIGINT or SIGTERM.
async fn stop_at((mut interrupt, mut terminate): (Signal, Signal), stop: Arc<AtomicBool>) {
    tokio::select! {
        _ = interrupt.recv() => {}
        _ = terminate.recv() => {}
    }
    stop.store(true, Ordering::Relaxed);
}

fn hand_on(
    listening: &Listening,
    mut queue: RecorderQueue,
    stop: &AtomicBool,
    duration: Option<SignedDuration>,
) {
    let began = now();
    let mut told = began;
    let is_over = |at: Time| duration.is_some_and(|duration| at - began >= duration);
    while !stop.load(Ordering::Relaxed) && !is_over(now()) {
        match listening.arrivals.recv_timeout(LOOK_UP) {
            Ok(arrival) => queue.offer(recorded(arrival)),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        let at = now();
        if at - told >= STATISTICS {
            told = at;
            tell(listening, queue.counts());
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

/// `239.192.48.1:8048 on 127.0.0.1: 1,234 received; …; 2,345 recorded, 0 lost`
fn tell(listening: &Listening, counts: RecorderCounts) {
    let lines: Vec<String> = listening
        .lines
        .iter()
        .map(|(line, counters)| {
            let state = if counters.joined.load(Ordering::Relaxed) { "" } else { " (not open)" };
            format!("{}{state}: {} received", line.name(), counters.received.load(Ordering::Relaxed))
        })
        .collect();
    info!("{}; {} recorded, {} lost", lines.join("; "), counts.written, counts.unwritten + counts.lost);
}
