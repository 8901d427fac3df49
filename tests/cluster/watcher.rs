//! Reads along what a cell publishes, and makes it once more at the end.

use std::fmt;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use fusion::slots::SlotGrid;
use fusion::time::Time;
use jiff::SignedDuration;
use tokio::task::JoinSet;
use utm_fusion::areas::Masks;
use utm_fusion::cluster::{Cell, Cells, Checkpoint, Log, Logged, Moment, Output, pictures};
use utm_fusion::config::{Cluster, Config};
use utm_fusion::live::now;
use utm_fusion::territory::CellName;

use crate::site::until;

/// A message, where it is in its stream, and when it came.
struct Read<T> {
    sequence: u64,
    message: T,
    at: Instant,
    clock: Time,
}

#[derive(Default)]
struct Seen {
    inputs: Vec<Read<Logged>>,
    outputs: Vec<Read<Output>>,
}

/// Reads from a checkpoint on.
pub struct Watcher {
    cell: CellName,
    from: Checkpoint,
    /// What was published before it began to read.
    before: u64,
    config: Arc<Config>,
    wait: SignedDuration,
    seen: Arc<Mutex<Seen>>,
    tasks: JoinSet<()>,
}

/// An aircraft's id, and its serial number.
pub type Called = (String, Option<String>);

/// Who was published in each slot; not to be printed.
#[derive(Default)]
pub struct Slots(pub Vec<(i64, Vec<Called>)>);

impl fmt::Debug for Slots {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "of {} slots", self.0.len())
    }
}

/// What was published while it read.
#[derive(Debug)]
pub struct Summary {
    pub slots: usize,
    /// The numbers of the leases, in order.
    pub epochs: Vec<u64>,
    /// What was left out, step by step.
    pub steps: Vec<u8>,
    /// The longest time in which nothing came, and the latest slot after it was due, seconds.
    pub silence_s: f64,
    pub latest_s: f64,
    /// How much earlier than it was due a slot came at most, seconds.
    pub early_s: f64,
    /// Aircraft of the last picture, by transponder number.
    pub numbers: Vec<u32>,
    /// Of each slot, which aircraft are published: their ids, and serial numbers where they have one.
    pub aircraft: Slots,
}

impl Watcher {
    pub async fn start(log: &Log, cluster: &Cluster, config: &Arc<Config>, cell: &CellName) -> Self {
        let name = cell.as_str();
        let from = until("a checkpoint of these streams", async || {
            let kept = log.checkpoint(name).await.ok().flatten()?;
            let mark = log.mark(kept.handled, kept.published).await.ok().flatten();
            (mark == Some(kept.mark)).then_some(kept)
        })
        .await;
        let before =
            until("an output", async || log.last(name).await.ok().flatten().map(|last| last.0)).await;
        let seen = Arc::<Mutex<Seen>>::default();
        let (own, audience) = (cell.clone(), Cells::of(config).unwrap().audience(config, cell));
        let mut tasks = JoinSet::new();
        let (mut inputs, into) = (log.inputs(from.handled + 1), seen.clone());
        tasks.spawn(async move {
            while let Some((sequence, octets)) = inputs.next().await {
                let Some(message) = Logged::parse(&octets, &own, &audience).unwrap() else { continue };
                let read = Read { sequence, message, at: Instant::now(), clock: now() };
                into.lock().unwrap().inputs.push(read);
            }
        });
        let (mut outputs, into) = (log.outputs(name, from.published + 1), seen.clone());
        tasks.spawn(async move {
            while let Some((sequence, octets)) = outputs.next().await {
                let message = Output::parse(&octets).unwrap();
                let read = Read { sequence, message, at: Instant::now(), clock: now() };
                into.lock().unwrap().outputs.push(read);
            }
        });
        let wait = SignedDuration::from_nanos((cluster.wait_s * 1e9) as i64);
        Self { cell: cell.clone(), from, before, config: config.clone(), wait, seen, tasks }
    }

    /// Slots so far.
    pub fn slots(&self) -> usize {
        self.seen.lock().unwrap().outputs.len()
    }

    /// Waits until so many more slots have come.
    pub async fn more(&self, slots: usize) {
        let before = self.slots();
        until("more slots", async || (self.slots() >= before + slots).then_some(())).await;
    }

    /// Waits until slots come when they are due.
    pub async fn in_time(&self) {
        let (grid, due_after) = (SlotGrid::new(self.config.fusion.slot), self.due_after());
        until("slots in time", async || {
            let seen = self.seen.lock().unwrap();
            let last = seen.outputs.last()?;
            let due = grid.centre(last.message.slot) + due_after;
            (last.sequence > self.before && (last.clock - due).as_secs_f64() < 0.5).then_some(())
        })
        .await;
    }

    /// From the centre of a slot until it is due.
    fn due_after(&self) -> SignedDuration {
        self.config.fusion.latency() - self.config.fusion.slot / 2
    }

    /// The longest silence from the slot of that place on, seconds.
    pub fn silence_s(&self, from: usize) -> f64 {
        let seen = self.seen.lock().unwrap();
        let gaps = seen.outputs[from.saturating_sub(1)..].windows(2);
        gaps.map(|pair| (pair[1].at - pair[0].at).as_secs_f64()).fold(0.0, f64::max)
    }

    /// Every slot came once, in order, of owners of which none published after it was replaced, and is what an engine makes that
    /// was there all the time.
    pub async fn checked(mut self) -> Summary {
        let behind = self.seen.lock().unwrap().outputs.last().expect("a slot came").message.behind;
        until("the inputs of the last slot", async || {
            let seen = self.seen.lock().unwrap();
            seen.inputs.last().is_some_and(|input| input.sequence >= behind).then_some(())
        })
        .await;
        self.tasks.shutdown().await;
        let seen = std::mem::take(&mut *self.seen.lock().unwrap());
        let outputs = &seen.outputs;
        for pair in outputs.windows(2) {
            let [before, after] = [&pair[0].message, &pair[1].message];
            let place = |read: &Read<Output>| {
                let Output { slot, epoch, behind, .. } = read.message;
                format!("{}: slot {} of {epoch} behind {behind}", read.sequence, slot.0)
            };
            let what = format!("{}, then {}", place(&pair[0]), place(&pair[1]));
            assert_eq!(after.slot.0, before.slot.0 + 1, "a slot is doubled or missing: {what}");
            assert!(after.epoch >= before.epoch, "who was replaced has published: {what}");
            assert!(after.behind >= before.behind, "{what}");
        }
        let cells = Cells::of(&self.config).unwrap();
        let engine = cells.engine(&self.config, Masks::default(), now(), &self.cell);
        let engine = engine.restored(Masks::default(), &self.from.engine).unwrap();
        let grid = SlotGrid::new(self.config.fusion.slot);
        let mut alone = Cell::new(engine, grid, self.wait, self.from.handled, self.from.published);
        seen.inputs.iter().for_each(|input| alone.input(input.sequence, input.message.clone()));
        for output in outputs.iter().filter(|output| output.message.behind <= behind) {
            alone.output(output.sequence, output.message.clone()).unwrap();
            assert_eq!(
                alone.pump(Moment::default()),
                Ok(()),
                "slot {} is another one",
                output.message.slot.0
            );
            assert_eq!(alone.behind(), 0, "slot {} cannot be made", output.message.slot.0);
        }
        let is_heard = |logged: &Logged| matches!(logged, Logged::Input(input) if !input.heard.is_empty());
        assert!(seen.inputs.iter().any(|input| is_heard(&input.message)), "no sensor was heard");
        let mut epochs: Vec<u64> = outputs.iter().map(|output| output.message.epoch).collect();
        epochs.dedup();
        let mut steps: Vec<u8> = outputs.iter().map(|output| output.message.step.0).collect();
        steps.dedup();
        // The last one of before counts, too: silence begins with it.
        let live: Vec<_> = outputs.iter().filter(|output| output.sequence >= self.before).collect();
        let silence = live.windows(2).map(|pair| pair[1].at - pair[0].at).max().unwrap_or(Duration::ZERO);
        let due_after = self.due_after();
        let late = |output: &&Read<Output>| output.clock - (grid.centre(output.message.slot) + due_after);
        let latest = live.iter().map(late).max().unwrap_or_default();
        let earliest = live.iter().map(late).min().unwrap_or_default();
        let (picture, _) = pictures(&outputs.last().unwrap().message.picture).unwrap();
        let mut numbers: Vec<u32> = picture.tracks.iter().map(|track| track.point.number).collect();
        numbers.sort_unstable();
        let aircraft = |output: &Read<Output>| {
            let (picture, _) = pictures(&output.message.picture).unwrap();
            let called = picture.tracks.iter().map(|track| {
                let serial = track
                    .point
                    .source
                    .transponder()
                    .map(|part| String::from_utf8_lossy(part.identity.name()).into_owned());
                (track.id.clone().unwrap_or_default(), serial)
            });
            (output.message.slot.0, called.collect())
        };
        let aircraft = Slots(outputs.iter().map(aircraft).collect());
        Summary {
            slots: outputs.len(),
            epochs,
            steps,
            silence_s: silence.as_secs_f64(),
            latest_s: latest.as_secs_f64(),
            early_s: (-earliest).as_secs_f64(),
            numbers,
            aircraft,
        }
    }
}
