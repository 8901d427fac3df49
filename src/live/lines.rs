//! The lines being read: each in a task of its own, opened again when it fails or falls silent.

use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{self, Receiver, SyncSender, TrySendError};
use std::time::Duration;

use tracing::{error, info};

use super::clock::Clock;
use crate::config::Config;
use crate::ingest::udp::{self, Arrival, Line, LineCounters};

/// Datagrams that may wait for the engine: some seconds of the busiest site.
const QUEUE: usize = 8192;
/// A line that failed is opened again after this time.
const REOPEN: Duration = Duration::from_secs(2);
/// A line on which nothing comes for this long is joined anew: its interface may have gone and come back.
const REJOIN: Duration = Duration::from_secs(10);
/// How often it is looked whether anything came.
const LISTEN: Duration = Duration::from_secs(1);

/// The lines of a configuration, being read.
pub(crate) struct Listening {
    /// What comes on them; closed when the tasks end.
    pub(crate) arrivals: Receiver<Arrival>,
    /// Each line with what it counts.
    pub(crate) lines: Vec<(Arc<Line>, Arc<LineCounters>)>,
    /// A task a line; each goes on until it is aborted.
    pub(crate) tasks: Vec<tokio::task::JoinHandle<()>>,
}

/// Begins to read the lines.
pub(crate) fn listen(config: &Config, clock: &Clock, runtime: &tokio::runtime::Handle) -> Listening {
    let (sender, arrivals) = mpsc::sync_channel(QUEUE);
    let lines: Vec<(Arc<Line>, Arc<LineCounters>)> =
        udp::lines(config).into_iter().map(|line| (Arc::new(line), Arc::default())).collect();
    let tasks = lines
        .iter()
        .enumerate()
        .map(|(index, (line, counters))| {
            let reader =
                Reader { index, line: line.clone(), counters: counters.clone(), clock: clock.clone() };
            runtime.spawn(reader.keep_reading(sender.clone()))
        })
        .collect();
    Listening { arrivals, lines, tasks }
}

/// The reader of a line.
struct Reader {
    index: usize,
    line: Arc<Line>,
    counters: Arc<LineCounters>,
    clock: Clock,
}

impl Reader {
    /// Opens the line and reads it; opens it again whenever it fails, or falls silent.
    async fn keep_reading(self, sender: SyncSender<Arrival>) {
        let Self { line, counters, .. } = &self;
        let hand_on = |arrival| match sender.try_send(arrival) {
            Ok(()) => true,
            Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => false,
        };
        // A line that is joined anew and works needs no word.
        let (mut joined_anew, mut failing) = (false, false);
        loop {
            let opened = line.open().and_then(|(socket, buffer)| {
                counters.opened(&socket);
                Ok((tokio::net::UdpSocket::from_std(socket)?, buffer))
            });
            counters.joined.store(opened.is_ok(), Ordering::Relaxed);
            match opened {
                Ok((socket, buffer)) => {
                    if std::mem::take(&mut failing) || !joined_anew {
                        info!("listening to {}, receive buffer {} KiB", line.name(), buffer / 1024);
                    }
                    let Some(error) = self.read_until_silent(&socket, hand_on).await else {
                        joined_anew = true;
                        continue;
                    };
                    counters.joined.store(false, Ordering::Relaxed);
                    joined_anew = false;
                    error!("{}: {error}; it is opened again", line.name());
                }
                Err(error) if !std::mem::replace(&mut failing, true) => {
                    let every_s = REOPEN.as_secs();
                    error!("{} cannot be opened: {error}; it is tried again every {every_s} s", line.name());
                }
                Err(_) => {}
            }
            tokio::time::sleep(REOPEN).await;
        }
    }

    /// Why reading ended; `None`: the line fell silent.
    async fn read_until_silent(
        &self,
        socket: &tokio::net::UdpSocket,
        hand_on: impl Fn(Arrival) -> bool,
    ) -> Option<io::Error> {
        let Self { index, line, counters, clock } = self;
        let reading = udp::read(socket, *index, line, counters, || clock.now(), hand_on);
        tokio::pin!(reading);
        let (mut before, mut silent) = (counters.last_received.load(Ordering::Relaxed), Duration::ZERO);
        while silent < REJOIN {
            tokio::select! {
                ended = &mut reading => return ended.err(),
                () = tokio::time::sleep(LISTEN) => {
                    let last = counters.last_received.load(Ordering::Relaxed);
                    silent = if last == before { silent + LISTEN } else { Duration::ZERO };
                    before = last;
                }
            }
        }
        None
    }
}
