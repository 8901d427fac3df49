//! Clocks that are wrong, one at a time, and messages that no member would write.

use std::collections::BTreeSet;

use asterix::DataSource;
use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use jiff::SignedDuration;

use super::toy::{self, Toy};
use super::world::{BEGINS_MS, ClockOwner, Clocks, Faults, World};
use super::{MANY, checked, owned, schedules};
use crate::cell::{AppendResult, Cell, InputRecord, LogRequest};
use crate::message::{CellOutput, GatewayInput, InputHeader, InputOrigin, LoggedMessage, ReceivedDatagram};
use crate::reference_clock::{ClockReading, InputRefusal};

/// Longest delay of a node by a fault, in milliseconds. To a node that reads a message late, the sender's clock appears less
/// ahead by that delay.
const LATE_MS: i64 = 20_000;

/// Numbers of inputs used and refused, from gateways with right and with wrong clocks.
#[derive(Debug, Default)]
struct InputVerdicts {
    right: usize,
    right_refused: usize,
    wrong: usize,
    wrong_used: usize,
}

/// Judges every input that an output covers. A clock is wrong if it is ahead, or has been behind for 2.5 s in which its gateway
/// sent without a gap.
fn input_verdicts(world: &World<Toy>, what: &str) -> InputVerdicts {
    let outputs = world.outputs();
    let refused: BTreeSet<u64> = outputs.iter().flat_map(|output| output.refused.iter().copied()).collect();
    let (first, last) = (outputs[0].after_input, outputs[outputs.len() - 1].after_input);
    let mut verdicts = InputVerdicts::default();
    // Time of each gateway's last input, and since when it sent without a gap.
    let mut heard = [(0, 0); 2];
    for (sequence, sent) in world.sent() {
        let Some(sent) = sent.filter(|_| (first..=last).contains(&sequence)) else { continue };
        let is_refused = refused.contains(&sequence);
        let (last_at, since) = &mut heard[sent.gateway];
        if sent.at - std::mem::replace(last_at, sent.at) > 1_500 {
            *since = sent.at;
        }
        let lasts_ms = sent.lasts_ms.min(sent.at - *since);
        if sent.is_set {
            // The slot and the sending time are of different clocks.
            continue;
        }
        if sent.error_ms == 0 {
            verdicts.right += 1;
            verdicts.right_refused += usize::from(is_refused);
        } else if sent.error_ms > LATE_MS {
            assert!(is_refused, "{what}: {sequence} of a clock ahead is used: {sent:?}");
            verdicts.wrong += 1;
        } else if sent.error_ms > 0 || lasts_ms > 2_500 {
            // A node that has just started has not yet observed long enough that the clock is behind.
            verdicts.wrong_used += usize::from(!is_refused);
            verdicts.wrong += 1;
        }
    }
    verdicts
}

fn flown(seed: u64, faults: Faults, clocks: Clocks) -> World<Toy> {
    let mut world = World::new(seed, faults, toy::feed()).with(clocks);
    world.run();
    world
}

#[test]
fn wrong_clock_of_one_member_shifts_no_slot() {
    for (seed, who) in (0..).zip([
        ClockOwner::Gateway(0),
        ClockOwner::Gateway(1),
        ClockOwner::Log,
        ClockOwner::Node(0),
        ClockOwner::Node(1),
        ClockOwner::Node(2),
    ]) {
        for error_ms in [3_000, -3_000, 10_000, -10_000, 30_000, -30_000, 600_000, -600_000] {
            // The error is present from the beginning, or starts once there are slots.
            let from = if (error_ms / 1_000) % 4 == 2 { 0 } else { 20_000 };
            let world = flown(seed, Faults::none(), Clocks(vec![(who, from, 40_000, error_ms)]));
            let what = format!("{who:?} {error_ms} ms from {from} ms");
            checked(&world, &what);
            let verdicts = input_verdicts(&world, &what);
            assert_eq!((verdicts.right_refused, verdicts.wrong_used), (0, 0), "{what}: {verdicts:?}");
            assert_eq!(world.takeovers(), 1, "{what}");
            assert!(world.silence_s() < 1.0, "{what}: silent for {} s", world.silence_s());
            assert!(world.early_ms() < 250, "{what}: {} ms early", world.early_ms());
        }
    }
}

/// Runs with all other faults and odd messages. Hardly any input of a right clock is refused: only the first one after a silence
/// of all gateways, from a log whose clock was set meanwhile, read by a node that has just started.
#[test]
fn wrong_clocks_with_other_faults_shift_no_slot() {
    let (mut all, mut takeovers) = (InputVerdicts::default(), 0);
    for seed in schedules() {
        let clocks = Clocks::any(seed);
        let faults = Faults::any(seed).without_gateways(&clocks);
        let mut world = World::new(seed, faults, toy::feed()).with(clocks).odd();
        world.run();
        let what = format!("seed {seed}");
        checked(&world, &what);
        super::delivered(&world, &what);
        assert!(world.early_ms() < 250, "{what}: {} ms early", world.early_ms());
        let found = input_verdicts(&world, &what);
        all.right += found.right;
        all.right_refused += found.right_refused;
        all.wrong += found.wrong;
        all.wrong_used += found.wrong_used;
        takeovers += world.takeovers();
    }
    println!("{all:?}; {takeovers} take-overs");
    if schedules().count() < MANY as usize {
        return;
    }
    assert!(all.right > 1_000 && all.wrong > 100 && takeovers > 2, "{all:?} {takeovers}");
    assert!(all.right_refused * 2_000 <= all.right && all.wrong_used * 10 < all.wrong, "{all:?}");
}

/// Milliseconds after the beginning, by all clocks.
fn at(ms: i64) -> ClockReading {
    let wall = Time::from_nanos((BEGINS_MS + ms) * 1_000_000);
    ClockReading { steady: SignedDuration::from_millis(ms), wall }
}

/// A message sent by a gateway with that configuration at the end of a slot, and read without delay.
fn message(gateway: &str, config: u64, slot: Slot, ms: i64) -> InputRecord {
    let address = "127.0.0.1:5000".parse().unwrap();
    let received = SlotGrid::default().centre(slot);
    let payload = format!("{gateway} {}", slot.0).into_bytes();
    let origin = Some(InputOrigin { gateway: gateway.to_owned(), sent: at(ms).wall, config });
    let datagrams = vec![ReceivedDatagram { received, from: address, to: address, payload }];
    let sensor = DataSource { sac: 25, sic: 1 };
    let input = GatewayInput { origin, sensor, slot, part: 0, is_last: true, datagrams };
    let header: Option<InputHeader> = InputHeader::of(&input.body()).unwrap();
    InputRecord {
        stamp: at(ms).wall,
        at: at(ms),
        header,
        logged: Some(LoggedMessage::Input(input)),
        has_more: false,
    }
}

/// Publishes the slots that are due.
fn published(cell: &mut Cell<Toy>, ms: i64, outputs: &mut Vec<CellOutput>) {
    cell.pump(at(ms)).unwrap();
    while let Some(LogRequest::Append { output, .. }) = cell.next_request() {
        outputs.push(output);
        cell.handle_append(AppendResult::Stored(outputs.len() as u64));
        cell.pump(at(ms)).unwrap();
    }
}

#[test]
fn input_of_another_configuration_is_refused_and_counted() {
    let (mut cell, mut outputs, mut sequence) = (owned().configured(7), Vec::new(), 0);
    for slot in 0..40 {
        let ms = 250 * (slot + 1);
        let slot = SlotGrid::default().of(at(ms).wall).plus(-1);
        for (gateway, config) in [("g0", 7), ("g1", 8), ("g2", 0)] {
            sequence += 1;
            cell.read_input(sequence, message(gateway, config, slot, ms));
        }
        published(&mut cell, ms + 20, &mut outputs);
    }
    let refused: Vec<u64> = outputs.iter().flat_map(|output| output.refused.iter().copied()).collect();
    let last = outputs.last().unwrap().after_input;
    assert!(outputs.len() > 30);
    assert_eq!(refused, (1..=last).filter(|sequence| sequence % 3 == 2).collect::<Vec<_>>());
    let refusals = cell.refusals();
    let of: Vec<_> = refusals.iter().map(|((gateway, why), (count, _))| (&**gateway, *why, *count)).collect();
    assert_eq!(of, [("g1", InputRefusal::Configuration, 40)]);
}

/// The list of refused inputs has to fit into a message of the log.
#[test]
fn flood_of_refused_inputs_is_spread_over_outputs() {
    let (mut cell, mut outputs, mut sequence) = (owned(), Vec::new(), 0);
    for slot in 0..40 {
        let ms = 250 * (slot + 1);
        let slot_then = SlotGrid::default().of(at(ms).wall).plus(-1);
        let flood = if slot == 20 { 25_000 } else { 0 };
        for _ in 0..flood {
            sequence += 1;
            cell.read_input(sequence, message("x", 0, slot_then.plus(14_400), ms));
        }
        sequence += 1;
        cell.read_input(sequence, message("g0", 0, slot_then, ms));
        published(&mut cell, ms + 20, &mut outputs);
    }
    let most = outputs.iter().map(|output| output.refused.len()).max().unwrap();
    let all: usize = outputs.iter().map(|output| output.refused.len()).sum();
    assert_eq!((most, all), (10_000, 25_000));
    for pair in outputs.windows(2) {
        assert_eq!(pair[1].slot.0, pair[0].slot.0 + 1);
    }
    assert!(outputs.len() >= 38, "{}", outputs.len());
}
