//! Seeded schedules of faults in virtual time, over a model of the log's four operations.

mod cells;
mod clocks;
mod number_blocks;
mod number_table;
mod site;
mod takeover;
mod toy;
mod world;

use std::collections::BTreeSet;

use fusion::slots::{Slot, SlotGrid};
use jiff::SignedDuration;

use super::cell::{AppendResult, Cell, CellEngine as _, LogRequest, Tail};
use super::engine::{SiteEngine, pictures};
use super::message::{CellOutput, LoggedMessage};
use super::reference_clock::ClockReading;
use toy::Toy;
use world::{Engine, Fault, Faults, WAIT, World};

/// Compares the outputs with those of an engine that handles the whole log in order without interruption.
fn checked<E: Engine>(world: &World<E>, what: &str) {
    let outputs = world.outputs();
    assert!(outputs.len() > 100, "{what}: {} slots", outputs.len());
    for pair in outputs.windows(2) {
        assert_eq!(pair[1].slot.0, pair[0].slot.0 + 1, "{what}: a slot is doubled or missing");
        assert!(pair[1].epoch >= pair[0].epoch, "{what}: who was replaced has published");
    }
    let mut alone = Cell::new(E::new(), SlotGrid::default(), WAIT, 0, 0);
    for (index, input) in world.inputs().iter().enumerate() {
        alone.add_input(index as u64 + 1, input.clone());
    }
    for (index, output) in outputs.iter().enumerate() {
        alone.handle_output(index as u64 + 1, output.clone()).unwrap();
    }
    assert_eq!(alone.pump(ClockReading::default()), Ok(()), "{what}: another picture");
    assert_eq!(alone.rest_sequences().map(|(_, published)| published), Some(outputs.len() as u64), "{what}");
}

/// Every message written by a published slot is in the log, whichever node had to send it.
fn delivered(world: &World<Toy>, what: &str) {
    let messages = world.inputs().iter().filter_map(|logged| match logged {
        LoggedMessage::Message(message) => Some(message.slot),
        LoggedMessage::Input(_) => None,
    });
    let messages: BTreeSet<Slot> = messages.collect();
    let outputs = world.outputs();
    // Messages of the last seconds may still be on their way.
    for output in &outputs[..outputs.len().saturating_sub(12)] {
        assert!(messages.contains(&output.slot), "{what}: the letter of slot {} is lost", output.slot.0);
    }
}

/// Number of schedules from which on every kind of fault occurs.
const MANY: u64 = 40;

/// Seeds of the schedules. `UTM_FUSION_SCHEDULES` is their number, or a range without its end (`2000..4000`).
fn schedules() -> std::ops::Range<u64> {
    let Ok(text) = std::env::var("UTM_FUSION_SCHEDULES") else { return 0..80 };
    let (first, end) = text.split_once("..").unwrap_or(("0", &text));
    first.parse().unwrap()..end.parse().unwrap()
}

fn flown(seed: u64, faults: Faults) -> World<Toy> {
    let mut world = World::new(seed, faults, toy::feed());
    world.run();
    world
}

#[test]
fn every_slot_is_published_once_without_faults() {
    let world = flown(1, Faults::none());
    checked(&world, "no fault");
    assert_eq!(world.takeovers(), 1, "the first owner is the only one");
    assert!(world.silence_s() < 0.7, "{}", world.silence_s());
}

#[test]
fn killed_owner_is_replaced_within_lease_and_a_second() {
    for seed in 0..20 {
        let world = flown(seed, Faults::only(seed, Fault::Kill));
        checked(&world, &format!("seed {seed}"));
        assert!(world.silence_s() < 4.0, "seed {seed}: silent for {} s", world.silence_s());
    }
}

#[test]
fn resumed_former_owner_publishes_nothing() {
    for seed in 0..20 {
        let world = flown(seed, Faults::only(seed, Fault::Pause));
        checked(&world, &format!("seed {seed}"));
    }
}

#[test]
fn log_without_leader_delays_slots_without_duplicates() {
    for seed in 0..20 {
        checked(&flown(seed, Faults::only(seed, Fault::Leaderless)), &format!("seed {seed}"));
    }
}

#[test]
fn node_without_the_log_is_replaced() {
    for seed in 0..20 {
        checked(&flown(seed, Faults::only(seed, Fault::Partition)), &format!("seed {seed}"));
    }
}

#[test]
fn random_faults_double_and_lose_no_slot() {
    let seeds = schedules();
    let count = seeds.end - seeds.start;
    let (mut takeovers, mut refused, mut lost) = (0, 0, 0);
    for seed in seeds {
        let world = flown(seed, Faults::any(seed));
        checked(&world, &format!("seed {seed}"));
        delivered(&world, &format!("seed {seed}"));
        takeovers += world.takeovers();
        refused += world.refused();
        lost += world.lost();
    }
    // Schedules in which nothing happens would prove nothing.
    let is_some = takeovers > 2 * count as usize && refused > 0 && lost > 0;
    assert!(is_some || count < MANY, "{takeovers} {refused} {lost}");
}

/// A cell owned by this node, whose first output is the first in the log.
fn owned() -> Cell<Toy> {
    let mut cell = Cell::new(Toy::new(), SlotGrid::default(), WAIT, 0, 0);
    cell.set_lease_held(false);
    assert_eq!(cell.next_request(), Some(LogRequest::Lease));
    cell.handle_lease(Some(1));
    assert_eq!(cell.next_request(), Some(LogRequest::Tail(0)));
    cell.handle_tail(Ok(Tail { outputs: Vec::new(), last: 0, is_complete: true, is_mine: true })).unwrap();
    cell
}

/// An owner that was delayed publishes the same pictures as without delay, and starts publishing before it has made all of them.
#[test]
fn late_owner_publishes_every_slot_as_it_catches_up() {
    let world = flown(0, Faults::none());
    let (inputs, expected) = (world.inputs(), world.outputs());
    let late = SlotGrid::default().open(expected.last().unwrap().slot.plus(40));
    let late = ClockReading { wall: late, ..ClockReading::default() };
    let mut cell = owned();
    let (read, rest) = inputs.split_at(inputs.len() / 2);
    for (sequence, input) in (1..).zip(read) {
        cell.add_input(sequence, input.clone());
        cell.set_has_more(true);
    }
    let (mut published, mut pumps) = (Vec::new(), 0);
    let mut go_on = |cell: &mut Cell<Toy>| {
        loop {
            cell.pump(late).unwrap();
            pumps += 1;
            while let Some(LogRequest::Append { output, .. }) = cell.next_request() {
                published.push(output);
                cell.handle_append(AppendResult::Stored(published.len() as u64));
            }
            if !cell.has_due_slots() {
                return (published.len(), pumps);
            }
        }
    };
    let (slots, looks) = go_on(&mut cell);
    assert!(slots > expected.len() / 3 && slots < expected.len() * 2 / 3, "{slots} of {}", expected.len());
    assert!(looks > slots / 5, "{slots} slots in {looks} looks");
    for (sequence, input) in (read.len() as u64 + 1..).zip(rest) {
        cell.add_input(sequence, input.clone());
    }
    cell.set_has_more(false);
    go_on(&mut cell);
    let pictures = |outputs: &[CellOutput]| -> Vec<_> {
        outputs.iter().take(expected.len()).map(|output| (output.slot, output.picture.clone())).collect()
    };
    assert_eq!(pictures(&published), pictures(expected));
}

/// Gateways keep their data while the log is away. It belongs into the slots that are due meanwhile.
#[test]
fn slots_of_an_outage_wait_for_the_data_kept() {
    let world = flown(0, Faults::none());
    let grid = SlotGrid::default();
    let slot_of = |logged: &LoggedMessage| match logged {
        LoggedMessage::Input(input) => input.slot,
        LoggedMessage::Message(message) => message.slot,
    };
    let away = slot_of(&world.inputs()[world.inputs().len() / 3]);
    let read = world.inputs().iter().take_while(|logged| slot_of(logged) <= away).count();
    let at = |seconds: f64| {
        let wall = grid.open(away.plus(1)) + SignedDuration::from_secs_f64(seconds);
        ClockReading { wall, ..ClockReading::default() }
    };
    let mut cell = owned();
    for (sequence, input) in (1..).zip(&world.inputs()[..read]) {
        cell.add_input(sequence, input.clone());
    }
    let (mut published, mut before) = (Vec::new(), None);
    let publish = |cell: &mut Cell<Toy>, published: &mut Vec<CellOutput>, now| {
        loop {
            cell.pump(now).unwrap();
            let Some(LogRequest::Append { output, .. }) = cell.next_request() else { break };
            published.push(output);
            cell.handle_append(AppendResult::Stored(published.len() as u64));
        }
    };
    publish(&mut cell, &mut published, at(0.1));
    // An owner that has just taken over waits a little longer.
    for step in 16..100 {
        let now = at(f64::from(step) * 0.1);
        cell.pump(now).unwrap();
        match cell.next_request() {
            Some(LogRequest::Append { .. }) => cell.handle_append(AppendResult::Unknown),
            Some(LogRequest::Tail(_)) => cell.handle_tail(Err(())).unwrap(),
            _ => {}
        }
        let due = before.get_or_insert(cell.engine().next_due());
        assert_eq!(cell.engine().next_due(), *due, "a slot is made after {step} tenths of a second");
    }
    assert!(!published.is_empty() && matches!(cell.next_request(), Some(LogRequest::Tail(_))));
    let last = published.len() as u64;
    cell.handle_tail(Ok(Tail { outputs: Vec::new(), last, is_complete: true, is_mine: true })).unwrap();
    publish(&mut cell, &mut published, at(10.0));
    let known = published.len();
    for (sequence, input) in (1..).zip(world.inputs()).skip(read) {
        cell.add_input(sequence, input.clone());
    }
    publish(&mut cell, &mut published, at(10.3));
    assert!(published.len() > known + 30, "{} of {known}", published.len());
    for output in &published[known..] {
        let (last, read) = (output.slot.plus(24), &world.inputs()[..output.after_input as usize]);
        let is_read = |sic| {
            let is_it = |logged: &LoggedMessage| match logged {
                LoggedMessage::Input(input) => input.sensor.sic == sic && input.slot == last,
                LoggedMessage::Message(_) => false,
            };
            read.iter().any(is_it)
        };
        assert!(
            is_read(1) && is_read(2),
            "slot {} is made after input {}",
            output.slot.0,
            output.after_input
        );
    }
    // Slots without data wait for a limited time: the sensors end ten seconds before.
    publish(&mut cell, &mut published, at(50.0));
    let end = world.inputs().iter().map(slot_of).max().unwrap();
    assert!(published.last().unwrap().slot.plus(20) > end, "the last slots are not made");
}

/// A standby discards the same data as the owner, also after a takeover.
#[test]
fn shed_data_is_left_out_by_owner_and_standby() {
    for seed in 100..103 {
        let mut world: World<SiteEngine> = World::new(seed, Faults::any(seed), site::feed()).relieving();
        world.run();
        checked(&world, &format!("seed {seed}"));
        let steps: BTreeSet<u8> = world.outputs().iter().map(|output| output.level.0).collect();
        assert!(steps.len() > 4, "{steps:?}");
        let never: World<SiteEngine> = {
            let mut world = World::new(seed, Faults::none(), site::feed());
            world.run();
            world
        };
        let octets =
            |world: &World<SiteEngine>| -> usize { world.outputs().iter().map(|of| of.picture.len()).sum() };
        assert!(octets(&world) < octets(&never), "nothing was left out");
    }
}

/// Uses the whole engine instead of a cheap one: filters, registration, integrity, pictures.
#[test]
fn random_faults_with_site_engine_lose_no_slot() {
    for seed in 0..6 {
        let mut world: World<SiteEngine> = World::new(seed, Faults::any(seed), site::feed());
        world.run();
        checked(&world, &format!("seed {seed}"));
        let (picture, now) = pictures(&world.outputs().last().unwrap().picture).unwrap();
        assert!(picture.tracks.len() > 4 && now.is_some(), "{} aircraft", picture.tracks.len());
    }
}

/// An output with another lease number or none, written before the owner's next one.
fn forged(like: &CellOutput, epoch: u64) -> CellOutput {
    CellOutput { epoch, picture: b"forged".to_vec(), ..like.clone() }
}

/// An owner that has published its first slot, and the next output that it wants to append.
fn publishing() -> (Cell<Toy>, CellOutput) {
    let world = flown(0, Faults::none());
    let mut cell = owned();
    for (sequence, input) in (1..).zip(world.inputs()) {
        cell.add_input(sequence, input.clone());
    }
    let slot = world.outputs()[10].slot;
    let wall = SlotGrid::default().open(slot.plus(25));
    cell.pump(ClockReading { wall, ..ClockReading::default() }).unwrap();
    assert!(matches!(cell.next_request(), Some(LogRequest::Append { expected: 0, .. })));
    cell.handle_append(AppendResult::Stored(1));
    let Some(LogRequest::Append { expected: 1, output }) = cell.next_request() else {
        panic!("the next one")
    };
    (cell, output)
}

fn tail(outputs: Vec<(u64, CellOutput)>, last: u64, is_mine: bool) -> Result<Tail, ()> {
    Ok(Tail { outputs, last, is_complete: true, is_mine })
}

#[test]
fn owner_continues_after_foreign_messages() {
    for (epoch, is_mine) in [(1, false), (0, false), (9, true)] {
        let (mut cell, output) = publishing();
        cell.handle_append(AppendResult::Refused);
        assert_eq!(cell.next_request(), Some(LogRequest::Tail(1)));
        // A message that cannot be read, a forged one, and another one.
        cell.handle_tail(tail(vec![(3, forged(&output, epoch))], 4, is_mine)).unwrap();
        assert_eq!(cell.next_request(), Some(LogRequest::Append { expected: 4, output }), "epoch {epoch}");
        assert!(cell.foreign() > 0);
    }
}

#[test]
fn owner_is_fenced_by_a_greater_lease_of_another_node() {
    let (mut cell, output) = publishing();
    cell.handle_append(AppendResult::Refused);
    cell.next_request();
    let refused = cell.handle_tail(tail(vec![(2, forged(&output, 9))], 2, false));
    assert_eq!(refused, Err(super::cell::CellLoss::Fenced));
    // The lease expired, another node had the cell, and this node has a lease again: the other output was real.
    let (mut cell, output) = publishing();
    cell.handle_output(2, forged(&output, 9)).unwrap();
    cell.handle_append(AppendResult::Refused);
    cell.next_request();
    cell.handle_recreated_lease(12);
    assert_eq!(cell.handle_tail(tail(Vec::new(), 2, true)), Err(super::cell::CellLoss::Fenced));
}

/// An answer is outdated if the other node's output is read after the question.
#[test]
fn greater_lease_read_after_the_request_is_checked_again() {
    let (mut cell, output) = publishing();
    cell.handle_append(AppendResult::Unknown);
    assert_eq!(cell.next_request(), Some(LogRequest::Tail(1)));
    cell.handle_output(2, forged(&output, 9)).unwrap();
    cell.handle_tail(tail(Vec::new(), 1, true)).unwrap();
    assert_eq!(cell.next_request(), Some(LogRequest::Tail(2)));
    assert_eq!(cell.handle_tail(tail(Vec::new(), 2, false)), Err(super::cell::CellLoss::Fenced));
}

/// The lease is granted late: another node has one, and has published since.
#[test]
fn late_lease_is_fenced_after_an_output_of_a_greater_one() {
    let mut cell = Cell::new(Toy::new(), SlotGrid::default(), WAIT, 0, 0);
    cell.set_lease_held(false);
    assert_eq!(cell.next_request(), Some(LogRequest::Lease));
    let (_, output) = publishing();
    cell.handle_output(1, forged(&output, 9)).unwrap();
    cell.handle_lease(Some(1));
    assert_eq!(cell.next_request(), Some(LogRequest::Tail(1)));
    assert_eq!(cell.handle_tail(tail(Vec::new(), 1, false)), Err(super::cell::CellLoss::Fenced));
}

#[test]
fn standby_skips_foreign_outputs_before_the_owners() {
    let world = flown(0, Faults::none());
    let outputs = world.outputs();
    let mut follower = Cell::new(Toy::new(), SlotGrid::default(), WAIT, 0, 0);
    for (sequence, input) in (1..).zip(world.inputs()) {
        follower.add_input(sequence, input.clone());
    }
    follower.handle_output(1, outputs[0].clone()).unwrap();
    let mut sequence = 1;
    for (index, output) in outputs.iter().enumerate().skip(1) {
        let old = &outputs[index - 1];
        for message in [forged(output, output.epoch), old.clone(), forged(old, 3), output.clone()] {
            sequence += 1;
            follower.handle_output(sequence, message).unwrap();
        }
        assert_eq!(follower.pump(ClockReading::default()), Ok(()), "slot {index}");
        assert_eq!(follower.published(), sequence, "slot {index}");
    }
    assert_eq!(follower.foreign(), 3 * (outputs.len() as u64 - 1));
}
