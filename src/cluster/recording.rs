//! A recording of what a cell handles, as a service writes one of itself: it replays to what its owner publishes.

use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4};
use std::path::Path;

use jiff::SignedDuration;
use tracing::{info, warn};

use super::cell::{Cell, Fusing, Lost};
use super::cells::{Audience, WHOLE};
use super::engine::{SiteEngine, pictures};
use super::log::{Log, LogError};
use super::message::{Heard, Input, Logged};
use super::reference_clock::Moment;
use super::region::{Letter, Word};
use super::relief::Step;
use crate::areas::{Areas, Masks};
use crate::config::{Cluster, Config, Feed};
use crate::formats::Encoders;
use crate::live::now;
use crate::record::{Recorded, Recorder, RecorderCounts, RecorderQueue, record_into};
use crate::state::{correlation_line, word_line};
use crate::territory::CellName;
use fusion::numbering::Given;
use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;

/// Why a cell is not recorded, or no longer.
#[derive(Debug, thiserror::Error)]
pub enum NotRecorded {
    /// The log does not answer.
    #[error(transparent)]
    Log(#[from] LogError),
    /// Nobody has written a state to begin from.
    #[error(
        "there is no checkpoint of the cell to begin from: nothing was published yet, or it is of another site or version"
    )]
    NoCheckpoint,
    /// What is published is not what was received makes.
    #[error("{0}")]
    Lost(#[from] Lost),
    /// The recorder's thread cannot be started, or has ended.
    #[error("the recorder has ended: {0}")]
    Recorder(String),
}

/// A site's engine, whose inputs and outputs are recorded.
struct Noted {
    site: Config,
    engine: SiteEngine,
    queue: RecorderQueue,
    encoders: Encoders,
    due_after: SignedDuration,
    max_accuracy_m: f64,
}

/// A recording has addresses of IPv4.
const fn v4(from: SocketAddr) -> SocketAddrV4 {
    match from {
        SocketAddr::V4(from) => from,
        SocketAddr::V6(from) => SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, from.port()),
    }
}

impl Fusing for Noted {
    fn receive(&mut self, heard: &Heard, at: Time) {
        let (line, from) = (self.engine.line(heard.to), v4(heard.from));
        self.queue.wait(Recorded::Input { received: at, line, from, payload: heard.payload.clone() });
        self.engine.receive(heard, at);
    }

    fn tick(&mut self, now: Time) {
        self.engine.tick(now);
    }

    fn next_due(&self) -> Option<Time> {
        self.engine.next_due()
    }

    fn relieve(&mut self, step: Step) {
        if step > Step::default() {
            warn!(
                step = step.0,
                "the owner cannot keep up: what it leaves out is recorded, and a replay leaves it in"
            );
        }
        self.engine.relieve(step);
    }

    fn letter(&mut self, letter: &Letter) {
        // Carried out with the next slot, where it was for one that is made already.
        let next = |from: Slot| self.engine.next_slot().map_or(from, |next| from.max(next));
        let line = match &letter.word {
            Word::Correlate { from, correlation } => {
                Some(correlation_line(next(*from), correlation, &self.site))
            }
            Word::Say { from, word } => Some(word_line(next(*from), word, &self.site)),
            _ => None,
        };
        line.into_iter().for_each(|line| _ = self.queue.wait(Recorded::Decided(line.into())));
        self.engine.letter(letter);
    }

    fn poll(&mut self) -> Option<(Slot, Vec<u8>)> {
        let (slot, octets) = self.engine.poll()?;
        if let Some((picture, _)) = pictures(&octets) {
            let due = picture.time + self.due_after;
            let shown = picture.within(self.max_accuracy_m);
            for payload in self.encoders.picture(Feed::RECORDED, picture.time, shown) {
                self.queue.wait(Recorded::Output { due, payload });
            }
        }
        Some((slot, octets))
    }
}

/// Records what the sensors of a region of several cells send into rotating files, until `ends`. Beside it there is no
/// state to begin from: each cell has its own, and what they publish is of no single engine.
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
    let (queue, recorder) = begun(&site, directory, Vec::new())?;
    let of_lines = SiteEngine::new(site, Masks::default(), now());
    info!(directory = %directory.display(), "recording what the sensors send; Ctrl-C ends it");
    let mut inputs = log.inputs(0);
    tokio::pin!(ends);
    loop {
        let input = tokio::select! {
            () = &mut ends => break,
            input = inputs.next() => input,
        };
        let Some((_, octets)) = input else { break };
        for Heard { received, from, to, payload } in
            Input::parse(&octets).into_iter().flat_map(|input| input.heard)
        {
            queue.wait(Recorded::Input { received, line: of_lines.line(to), from: v4(from), payload });
        }
    }
    drop(queue);
    ended(recorder).await
}

fn begun(
    site: &Config,
    directory: &Path,
    numbers: Vec<Given>,
) -> Result<(RecorderQueue, Recorder), NotRecorded> {
    let settings = site.output.record.clone().unwrap_or_else(|| record_into(directory));
    let settings = crate::config::Record { dir: directory.to_owned(), ..settings };
    let started = Recorder::start(site, &settings, numbers, true);
    started.map_err(|error| NotRecorded::Recorder(error.to_string()))
}

async fn ended(recorder: Recorder) -> Result<RecorderCounts, NotRecorded> {
    let written = tokio::task::spawn_blocking(move || recorder.join()).await;
    written.map_err(|error| NotRecorded::Recorder(error.to_string()))
}

/// Records a cell that is the whole site into rotating files until `ends`; the first begins with the newest checkpoint, so that `replay` of
/// the files gives what the owner published.
///
/// # Errors
/// There is no checkpoint, the log does not answer, or what is published is not what was received makes.
pub async fn record(
    log: &Log,
    cluster: &Cluster,
    config: &Config,
    areas: &Areas,
    directory: &Path,
    ends: impl Future<Output = ()>,
) -> Result<RecorderCounts, NotRecorded> {
    // What stands beside the recording is of one machine.
    let site = Config { cluster: None, ..config.clone() };
    let (cell, whole) = (WHOLE, CellName::new(WHOLE).expect("it is a name"));
    let kept = log.checkpoint(cell).await?.ok_or(NotRecorded::NoCheckpoint)?;
    if !log.knows(&kept).await? {
        return Err(NotRecorded::NoCheckpoint);
    }
    let engine = SiteEngine::new(site.clone(), areas.masks(), now());
    let engine = engine.restored(areas.masks(), &kept.engine).map_err(|_| NotRecorded::NoCheckpoint)?;
    let (queue, recorder) = begun(&site, directory, engine.numbers())?;
    let state = SiteEngine::driver_in(&kept.engine).ok_or(NotRecorded::NoCheckpoint)?;
    queue.wait(Recorded::Checkpoint(state));
    let noted = Noted {
        site: site.clone(),
        engine,
        queue,
        encoders: Encoders::new(&site),
        due_after: config.fusion.latency() - config.fusion.slot / 2,
        max_accuracy_m: config.output.max_accuracy_m,
    };
    let wait = SignedDuration::from_nanos((cluster.wait_s * 1e9) as i64);
    let mut following =
        Cell::new(noted, SlotGrid::new(config.fusion.slot), wait, kept.handled, kept.published);
    info!(directory = %directory.display(), cell, "recording; Ctrl-C ends it");
    let (mut inputs, mut outputs) = (log.inputs(kept.handled + 1), log.outputs(cell, kept.published + 1));
    tokio::pin!(ends);
    loop {
        tokio::select! {
            () = &mut ends => break,
            input = inputs.next() => {
                let Some((sequence, octets)) = input else { break };
                let logged = Logged::parse(&octets, &whole, &Audience::default());
                logged.into_iter().flatten().for_each(|logged| following.input(sequence, logged));
            }
            output = outputs.next() => {
                let Some((sequence, octets)) = output else { break };
                match log.worth(cell, &octets).await {
                    Some(output) => following.output(sequence, output)?,
                    None => following.skip(sequence),
                }
            }
        }
        following.pump(Moment::default())?;
    }
    drop(following);
    ended(recorder).await
}
