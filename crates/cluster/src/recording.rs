//! A recording of a cell's inputs, in the format of a single service. It replays to the pictures that the owner publishes.

use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4};
use std::path::Path;

use jiff::SignedDuration;
use tracing::{info, warn};

use super::audience::Audience;
use super::cell::{Cell, CellEngine, CellLoss};
use super::cells::WHOLE;
use super::engine::{SiteEngine, pictures};
use super::log::{Log, LogError};
use super::message::{GatewayInput, LoggedMessage, ReceivedDatagram};
use super::overload::SheddingLevel;
use super::reference_clock::ClockReading;
use super::region::{CellMessage, CellMessageContent};
use fusion::numbering::Given;
use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use picture::formats::Encoders;
use service::live::now;
use service::record::{
    RecordedContents, Recorder, RecorderCounts, RecorderQueue, RecordingItem, record_into,
};
use service::state::{correlation_line, word_line};
use site::areas::{Areas, Masks};
use site::config::{Cluster, Config, Feed};
use site::territory::CellName;

/// Reason why a cell cannot be recorded, or a recording ended.
#[derive(Debug, thiserror::Error)]
pub enum NotRecorded {
    /// The log does not answer.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The log has no usable checkpoint to start from.
    #[error(
        "there is no checkpoint of the cell to begin from: nothing was published yet, or it is of another site or version"
    )]
    NoCheckpoint,
    /// The published pictures differ from those made of the inputs.
    #[error("{0}")]
    Lost(#[from] CellLoss),
    /// The recorder's thread cannot be started, or has ended.
    #[error("the recorder has ended: {0}")]
    Recorder(String),
}

/// A site's engine whose inputs and outputs are recorded.
struct RecordedEngine {
    site: Config,
    engine: SiteEngine,
    queue: RecorderQueue,
    encoders: Encoders,
    due_after: SignedDuration,
    max_accuracy_m: f64,
}

/// Converts an address to IPv4, which recordings require.
const fn to_ipv4(from: SocketAddr) -> SocketAddrV4 {
    match from {
        SocketAddr::V4(from) => from,
        SocketAddr::V6(from) => SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, from.port()),
    }
}

impl CellEngine for RecordedEngine {
    fn receive(&mut self, datagram: &ReceivedDatagram, at: Time) {
        let (line, from) = (self.engine.line(datagram.to), to_ipv4(datagram.from));
        self.queue.add(RecordingItem::Input { received: at, line, from, payload: datagram.payload.clone() });
        self.engine.receive(datagram, at);
    }

    fn tick(&mut self, now: Time) {
        self.engine.tick(now);
    }

    fn next_due(&self) -> Option<Time> {
        self.engine.next_due()
    }

    fn set_level(&mut self, level: SheddingLevel) {
        if level > SheddingLevel::default() {
            warn!(
                step = level.0,
                "the owner cannot keep up: what it leaves out is recorded, and a replay leaves it in"
            );
        }
        self.engine.set_level(level);
    }

    fn handle_message(&mut self, message: &CellMessage) {
        // A decision for a slot that is already made takes effect at the next slot.
        let next = |from: Slot| self.engine.next_slot().map_or(from, |next| from.max(next));
        let line = match &message.content {
            CellMessageContent::Correlate { from, correlation } => {
                Some(correlation_line(next(*from), correlation, &self.site))
            }
            CellMessageContent::SetTrust { from, decision } => {
                Some(word_line(next(*from), decision, &self.site))
            }
            _ => None,
        };
        line.into_iter().for_each(|line| _ = self.queue.add(RecordingItem::Decided(line.into())));
        self.engine.handle_message(message);
    }

    fn poll(&mut self) -> Option<(Slot, Vec<u8>)> {
        let (slot, octets) = self.engine.poll()?;
        if let Some((picture, _)) = pictures(&octets) {
            let due = picture.time + self.due_after;
            let shown = picture.within(self.max_accuracy_m);
            for payload in self.encoders.picture(Feed::RECORDED, picture.time, shown) {
                self.queue.add(RecordingItem::Output { due, payload });
            }
        }
        Some((slot, octets))
    }
}

/// Records the sensor data of a region with several cells into rotating files, until `ends`. The recording has no initial state:
/// each cell has its own, and no single engine makes what they publish.
///
/// # Errors
/// The recorder cannot be started.
pub async fn record_region(
    log: &Log,
    config: &Config,
    directory: &Path,
    ends: impl Future<Output = ()>,
) -> Result<RecorderCounts, NotRecorded> {
    let site = Config { cluster: None, ..config.clone() };
    let (queue, recorder) = start_recorder(&site, directory, Vec::new())?;
    let lines = SiteEngine::new(site, Masks::default(), now());
    info!(directory = %directory.display(), "recording what the sensors send; Ctrl-C ends it");
    let mut inputs = log.inputs(0);
    tokio::pin!(ends);
    loop {
        let input = tokio::select! {
            () = &mut ends => break,
            input = inputs.next() => input,
        };
        let Some((_, octets)) = input else { break };
        for ReceivedDatagram { received, from, to, payload } in
            GatewayInput::parse(&octets).into_iter().flat_map(|input| input.datagrams)
        {
            queue.add(RecordingItem::Input { received, line: lines.line(to), from: to_ipv4(from), payload });
        }
    }
    drop(queue);
    stop_recorder(recorder).await
}

fn start_recorder(
    site: &Config,
    directory: &Path,
    numbers: Vec<Given>,
) -> Result<(RecorderQueue, Recorder), NotRecorded> {
    let settings = site.output.record.clone().unwrap_or_else(|| record_into(directory));
    let settings = site::config::Record { dir: directory.to_owned(), ..settings };
    let started = Recorder::start(site, &settings, numbers, RecordedContents::Service);
    started.map_err(|error| NotRecorded::Recorder(error.to_string()))
}

async fn stop_recorder(recorder: Recorder) -> Result<RecorderCounts, NotRecorded> {
    let written = tokio::task::spawn_blocking(move || recorder.join()).await;
    written.map_err(|error| NotRecorded::Recorder(error.to_string()))
}

/// Records a cell that is the whole site into rotating files, until `ends`. The first file starts with the newest checkpoint, so
/// that `replay` of the files produces what the owner published.
///
/// # Errors
/// There is no checkpoint, the log does not answer, or the published pictures differ from those made of the inputs.
pub async fn record(
    log: &Log,
    cluster: &Cluster,
    config: &Config,
    areas: &Areas,
    directory: &Path,
    ends: impl Future<Output = ()>,
) -> Result<RecorderCounts, NotRecorded> {
    // The recording describes a single machine.
    let site = Config { cluster: None, ..config.clone() };
    let (cell, whole) = (WHOLE, CellName::new(WHOLE).expect("it is a name"));
    let kept = log.checkpoint(cell).await?.ok_or(NotRecorded::NoCheckpoint)?;
    if !log.matches_streams(&kept).await? {
        return Err(NotRecorded::NoCheckpoint);
    }
    let engine = SiteEngine::new(site.clone(), areas.masks(), now());
    let engine = engine.restored(areas.masks(), &kept.engine).map_err(|_| NotRecorded::NoCheckpoint)?;
    let (queue, recorder) = start_recorder(&site, directory, engine.numbers())?;
    let state = SiteEngine::driver_in(&kept.engine).ok_or(NotRecorded::NoCheckpoint)?;
    queue.add(RecordingItem::Checkpoint(state));
    let recorded = RecordedEngine {
        site: site.clone(),
        engine,
        queue,
        encoders: Encoders::new(&site),
        due_after: config.fusion.latency() - config.fusion.slot / 2,
        max_accuracy_m: config.output.max_accuracy_m,
    };
    let wait = SignedDuration::from_nanos((cluster.wait_s * 1e9) as i64);
    let mut following =
        Cell::new(recorded, SlotGrid::new(config.fusion.slot), wait, kept.handled, kept.published);
    info!(directory = %directory.display(), cell, "recording; Ctrl-C ends it");
    let (mut inputs, mut outputs) = (log.inputs(kept.handled + 1), log.outputs(cell, kept.published + 1));
    tokio::pin!(ends);
    loop {
        tokio::select! {
            () = &mut ends => break,
            input = inputs.next() => {
                let Some((sequence, octets)) = input else { break };
                let logged = LoggedMessage::parse(&octets, &whole, &Audience::default());
                logged.into_iter().flatten().for_each(|logged| following.add_input(sequence, logged));
            }
            output = outputs.next() => {
                let Some((sequence, octets)) = output else { break };
                match log.validated_when_available(cell, &octets).await {
                    Some(output) => following.handle_output(sequence, output)?,
                    None => following.skip_output(sequence),
                }
            }
        }
        following.pump(ClockReading::default())?;
    }
    drop(following);
    stop_recorder(recorder).await
}
