//! Records the outputs of a cell, and makes its slots again at the end.

use std::fmt;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use fusion::slots::SlotGrid;
use fusion::time::Time;
use jiff::SignedDuration;
use tokio::task::JoinSet;
use utm_fusion::areas::Masks;
use utm_fusion::cluster::{Cell, CellOutput, Cells, Checkpoint, ClockReading, Log, LoggedMessage, pictures};
use utm_fusion::config::{Cluster, Config};
use utm_fusion::live::now;
use utm_fusion::territory::CellName;

use crate::site::until;

/// A message, its sequence, and its time of arrival.
struct Received<T> {
    sequence: u64,
    message: T,
    at: Instant,
    clock: Time,
}

#[derive(Default)]
struct ReceivedMessages {
    inputs: Vec<Received<LoggedMessage>>,
    outputs: Vec<Received<CellOutput>>,
}

/// Reads from a checkpoint on.
pub struct Watcher {
    cell: CellName,
    from: Checkpoint,
    /// Sequence of the last output before the start.
    before: u64,
    config: Arc<Config>,
    wait: SignedDuration,
    seen: Arc<Mutex<ReceivedMessages>>,
    tasks: JoinSet<()>,
}

/// Id and serial number of an aircraft.
pub type AircraftName = (String, Option<String>);

/// Aircraft in each slot. Debug output is short.
#[derive(Default)]
pub struct AircraftBySlot(pub Vec<(i64, Vec<AircraftName>)>);

impl fmt::Debug for AircraftBySlot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "of {} slots", self.0.len())
    }
}

/// Outputs of the time watched.
#[derive(Debug)]
pub struct Summary {
    pub slots: usize,
    /// Lease numbers, in order.
    pub epochs: Vec<u64>,
    /// Levels of load shedding, in order.
    pub levels: Vec<u8>,
    /// Longest time without an output, and greatest lateness of a slot, in seconds.
    pub silence_s: f64,
    pub latest_s: f64,
    /// Greatest time by which a slot was published before it was due, in seconds.
    pub early_s: f64,
    /// Track numbers in the last picture.
    pub numbers: Vec<u32>,
    /// Published aircraft of each slot, with id and serial number if known.
    pub aircraft: AircraftBySlot,
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
        let seen = Arc::<Mutex<ReceivedMessages>>::default();
        let (own, audience) = (cell.clone(), Cells::of(config).unwrap().audience(config, cell));
        let mut tasks = JoinSet::new();
        let (mut inputs, into) = (log.inputs(from.handled + 1), seen.clone());
        tasks.spawn(async move {
            while let Some((sequence, octets)) = inputs.next().await {
                let Some(message) = LoggedMessage::parse(&octets, &own, &audience).unwrap() else { continue };
                let read = Received { sequence, message, at: Instant::now(), clock: now() };
                into.lock().unwrap().inputs.push(read);
            }
        });
        let (mut outputs, into) = (log.outputs(name, from.published + 1), seen.clone());
        tasks.spawn(async move {
            while let Some((sequence, octets)) = outputs.next().await {
                let message = CellOutput::parse(&octets).unwrap();
                let read = Received { sequence, message, at: Instant::now(), clock: now() };
                into.lock().unwrap().outputs.push(read);
            }
        });
        let wait = SignedDuration::from_nanos((cluster.wait_s * 1e9) as i64);
        Self { cell: cell.clone(), from, before, config: config.clone(), wait, seen, tasks }
    }

    /// Number of slots so far.
    pub fn slots(&self) -> usize {
        self.seen.lock().unwrap().outputs.len()
    }

    /// Waits for this number of further slots.
    pub async fn more(&self, slots: usize) {
        let before = self.slots();
        until("more slots", async || (self.slots() >= before + slots).then_some(())).await;
    }

    /// Waits until slots are in time.
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

    /// Time from the centre of a slot until it is due.
    fn due_after(&self) -> SignedDuration {
        self.config.fusion.latency() - self.config.fusion.slot / 2
    }

    /// Longest silence from the slot with this index on, in seconds.
    pub fn silence_s(&self, from: usize) -> f64 {
        let seen = self.seen.lock().unwrap();
        let gaps = seen.outputs[from.saturating_sub(1)..].windows(2);
        gaps.map(|pair| (pair[1].at - pair[0].at).as_secs_f64()).fold(0.0, f64::max)
    }

    /// Checks that every slot was published once and in order, that no replaced owner published, and that an uninterrupted engine
    /// makes the same slots.
    pub async fn checked(mut self) -> Summary {
        let after_input = self.seen.lock().unwrap().outputs.last().expect("a slot came").message.after_input;
        until("the inputs of the last slot", async || {
            let seen = self.seen.lock().unwrap();
            seen.inputs.last().is_some_and(|input| input.sequence >= after_input).then_some(())
        })
        .await;
        self.tasks.shutdown().await;
        let seen = std::mem::take(&mut *self.seen.lock().unwrap());
        let outputs = &seen.outputs;
        for pair in outputs.windows(2) {
            let [before, after] = [&pair[0].message, &pair[1].message];
            let place = |read: &Received<CellOutput>| {
                let CellOutput { slot, epoch, after_input, .. } = read.message;
                format!("{}: slot {} of {epoch} behind {after_input}", read.sequence, slot.0)
            };
            let what = format!("{}, then {}", place(&pair[0]), place(&pair[1]));
            assert_eq!(after.slot.0, before.slot.0 + 1, "a slot is doubled or missing: {what}");
            assert!(after.epoch >= before.epoch, "who was replaced has published: {what}");
            assert!(after.after_input >= before.after_input, "{what}");
        }
        let cells = Cells::of(&self.config).unwrap();
        let engine = cells.engine(&self.config, Masks::default(), now(), &self.cell);
        let engine = engine.restored(Masks::default(), &self.from.engine).unwrap();
        let grid = SlotGrid::new(self.config.fusion.slot);
        let mut reproduced = Cell::new(engine, grid, self.wait, self.from.handled, self.from.published);
        seen.inputs.iter().for_each(|input| reproduced.add_input(input.sequence, input.message.clone()));
        for output in outputs.iter().filter(|output| output.message.after_input <= after_input) {
            reproduced.handle_output(output.sequence, output.message.clone()).unwrap();
            assert_eq!(
                reproduced.pump(ClockReading::default()),
                Ok(()),
                "slot {} is another one",
                output.message.slot.0
            );
            assert_eq!(reproduced.outstanding(), 0, "slot {} cannot be made", output.message.slot.0);
        }
        let has_datagrams = |logged: &LoggedMessage| matches!(logged, LoggedMessage::Input(input) if !input.datagrams.is_empty());
        assert!(seen.inputs.iter().any(|input| has_datagrams(&input.message)), "no sensor was heard");
        let mut epochs: Vec<u64> = outputs.iter().map(|output| output.message.epoch).collect();
        epochs.dedup();
        let mut levels: Vec<u8> = outputs.iter().map(|output| output.message.level.0).collect();
        levels.dedup();
        // The last output before the start is included: the silence may begin with it.
        let live: Vec<_> = outputs.iter().filter(|output| output.sequence >= self.before).collect();
        let silence = live.windows(2).map(|pair| pair[1].at - pair[0].at).max().unwrap_or(Duration::ZERO);
        let due_after = self.due_after();
        let late =
            |output: &&Received<CellOutput>| output.clock - (grid.centre(output.message.slot) + due_after);
        let latest = live.iter().map(late).max().unwrap_or_default();
        let earliest = live.iter().map(late).min().unwrap_or_default();
        let (picture, _) = pictures(&outputs.last().unwrap().message.picture).unwrap();
        let mut numbers: Vec<u32> = picture.tracks.iter().map(|track| track.point.number).collect();
        numbers.sort_unstable();
        let aircraft = |output: &Received<CellOutput>| {
            let (picture, _) = pictures(&output.message.picture).unwrap();
            let names = picture.tracks.iter().map(|track| {
                let serial = track
                    .point
                    .source
                    .transponder()
                    .map(|part| String::from_utf8_lossy(part.identity.name()).into_owned());
                (track.id.clone().unwrap_or_default(), serial)
            });
            (output.message.slot.0, names.collect())
        };
        let aircraft = AircraftBySlot(outputs.iter().map(aircraft).collect());
        Summary {
            slots: outputs.len(),
            epochs,
            levels,
            silence_s: silence.as_secs_f64(),
            latest_s: latest.as_secs_f64(),
            early_s: (-earliest).as_secs_f64(),
            numbers,
            aircraft,
        }
    }
}
