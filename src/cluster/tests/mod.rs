//! Seeded schedules of faults in virtual time, over a model of the log's four operations.

mod cells;
mod clocks;
mod office;
mod site;
mod toy;
mod world;

use std::collections::BTreeSet;

use fusion::slots::{Slot, SlotGrid};

use super::cell::{Appended, Cell, Tail, Wish};
use super::engine::{SiteEngine, pictures};
use super::message::{Logged, Output};
use super::reference_clock::Moment;
use toy::Toy;
use world::{Engine, Fault, Faults, WAIT, World};

/// What an engine that was there all the time, and handled the log in order, would have published.
fn checked<E: Engine>(world: &World<E>, what: &str) {
    let outputs = world.outputs();
    assert!(outputs.len() > 100, "{what}: {} slots", outputs.len());
    for pair in outputs.windows(2) {
        assert_eq!(pair[1].slot.0, pair[0].slot.0 + 1, "{what}: a slot is doubled or missing");
        assert!(pair[1].epoch >= pair[0].epoch, "{what}: who was replaced has published");
    }
    let mut alone = Cell::new(E::new(), SlotGrid::default(), WAIT, 0, 0);
    for (index, input) in world.inputs().iter().enumerate() {
        alone.input(index as u64 + 1, input.clone());
    }
    for (index, output) in outputs.iter().enumerate() {
        alone.output(index as u64 + 1, output.clone()).unwrap();
    }
    assert_eq!(alone.pump(Moment::default()), Ok(()), "{what}: another picture");
    assert_eq!(alone.rests_at().map(|(_, published)| published), Some(outputs.len() as u64), "{what}");
}

/// Every letter of what was published is in the log, whoever had to send it.
fn delivered(world: &World<Toy>, what: &str) {
    let letters = world.inputs().iter().filter_map(|logged| match logged {
        Logged::Letter(letter) => Some(letter.slot),
        Logged::Input(_) => None,
    });
    let letters: BTreeSet<Slot> = letters.collect();
    let outputs = world.outputs();
    // The last seconds' may be on their way.
    for output in &outputs[..outputs.len().saturating_sub(12)] {
        assert!(letters.contains(&output.slot), "{what}: the letter of slot {} is lost", output.slot.0);
    }
}

/// Number of schedules from which on each kind of fault is among them.
const MANY: u64 = 40;

/// The seeds of the schedules that are run: `UTM_FUSION_SCHEDULES` is their number, or the first and the number behind the last
/// (`2000..4000`).
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
fn without_a_fault_every_slot_is_published_once_and_soon() {
    let world = flown(1, Faults::none());
    checked(&world, "no fault");
    assert_eq!(world.takeovers(), 1, "the first owner is the only one");
    assert!(world.silence_s() < 0.7, "{}", world.silence_s());
}

#[test]
fn a_killed_owner_is_followed_within_the_lease_and_a_second() {
    for seed in 0..20 {
        let world = flown(seed, Faults::only(seed, Fault::Kill));
        checked(&world, &format!("seed {seed}"));
        assert!(world.silence_s() < 4.0, "seed {seed}: silent for {} s", world.silence_s());
    }
}

#[test]
fn an_owner_that_stood_still_publishes_nothing_when_it_goes_on() {
    for seed in 0..20 {
        let world = flown(seed, Faults::only(seed, Fault::Pause));
        checked(&world, &format!("seed {seed}"));
    }
}

#[test]
fn while_the_log_has_no_leader_it_is_late_and_never_doubled() {
    for seed in 0..20 {
        checked(&flown(seed, Faults::only(seed, Fault::Leaderless)), &format!("seed {seed}"));
    }
}

#[test]
fn a_node_without_the_log_is_replaced() {
    for seed in 0..20 {
        checked(&flown(seed, Faults::only(seed, Fault::Partition)), &format!("seed {seed}"));
    }
}

#[test]
fn whatever_happens_nothing_is_doubled_and_nothing_is_missing() {
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
    // The schedules would say nothing if nothing happened in them.
    let is_some = takeovers > 2 * count as usize && refused > 0 && lost > 0;
    assert!(is_some || count < MANY, "{takeovers} {refused} {lost}");
}

/// A cell that is owned by nobody else, and the first output of which is the log's first.
fn owned() -> Cell<Toy> {
    let mut cell = Cell::new(Toy::new(), SlotGrid::default(), WAIT, 0, 0);
    cell.lease(false);
    assert_eq!(cell.wish(), Some(Wish::Lease));
    cell.leased(Some(1));
    assert_eq!(cell.wish(), Some(Wish::Last(0)));
    cell.last(Ok(Tail { outputs: Vec::new(), last: 0, is_whole: true, is_mine: true })).unwrap();
    cell
}

/// An owner that was held up publishes what it would have in time, and does so before it has made all of it.
#[test]
fn who_is_late_leaves_nothing_out_and_publishes_as_it_goes() {
    let world = flown(0, Faults::none());
    let (inputs, expected) = (world.inputs(), world.outputs());
    let late = SlotGrid::default().open(expected.last().unwrap().slot.plus(40));
    let late = Moment { wall: late, ..Moment::default() };
    let mut cell = owned();
    let (read, rest) = inputs.split_at(inputs.len() / 2);
    for (sequence, input) in (1..).zip(read) {
        cell.input(sequence, input.clone());
        cell.more(true);
    }
    let (mut published, mut pumps) = (Vec::new(), 0);
    let mut go_on = |cell: &mut Cell<Toy>| {
        loop {
            cell.pump(late).unwrap();
            pumps += 1;
            while let Some(Wish::Append { output, .. }) = cell.wish() {
                published.push(output);
                cell.appended(Appended::Stored(published.len() as u64));
            }
            if !cell.is_pressed() {
                return (published.len(), pumps);
            }
        }
    };
    let (slots, looks) = go_on(&mut cell);
    assert!(slots > expected.len() / 3 && slots < expected.len() * 2 / 3, "{slots} of {}", expected.len());
    assert!(looks > slots / 5, "{slots} slots in {looks} looks");
    for (sequence, input) in (read.len() as u64 + 1..).zip(rest) {
        cell.input(sequence, input.clone());
    }
    cell.more(false);
    go_on(&mut cell);
    let pictures = |outputs: &[Output]| -> Vec<_> {
        outputs.iter().take(expected.len()).map(|output| (output.slot, output.picture.clone())).collect()
    };
    assert_eq!(pictures(&published), pictures(expected));
}

/// What an owner leaves out, who stands by leaves out, too, whoever owns the cell next.
#[test]
fn what_an_owner_leaves_out_because_it_cannot_keep_up_is_left_out_by_all() {
    for seed in 100..103 {
        let mut world: World<SiteEngine> = World::new(seed, Faults::any(seed), site::feed()).relieving();
        world.run();
        checked(&world, &format!("seed {seed}"));
        let steps: BTreeSet<u8> = world.outputs().iter().map(|output| output.step.0).collect();
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

/// The whole engine, and not a cheap one in its place: filters, registration, integrity, pictures.
#[test]
fn so_it_is_with_the_engine_of_a_site() {
    for seed in 0..6 {
        let mut world: World<SiteEngine> = World::new(seed, Faults::any(seed), site::feed());
        world.run();
        checked(&world, &format!("seed {seed}"));
        let (picture, now) = pictures(&world.outputs().last().unwrap().picture).unwrap();
        assert!(picture.tracks.len() > 4 && now.is_some(), "{} aircraft", picture.tracks.len());
    }
}

/// An output of another lease, or of none, in an owner's way.
fn forged(like: &Output, epoch: u64) -> Output {
    Output { epoch, picture: b"forged".to_vec(), ..like.clone() }
}

/// An owner that has published its first slot, and the next one that it wants to append.
fn publishing() -> (Cell<Toy>, Output) {
    let world = flown(0, Faults::none());
    let mut cell = owned();
    for (sequence, input) in (1..).zip(world.inputs()) {
        cell.input(sequence, input.clone());
    }
    let slot = world.outputs()[10].slot;
    let wall = SlotGrid::default().open(slot.plus(25));
    cell.pump(Moment { wall, ..Moment::default() }).unwrap();
    assert!(matches!(cell.wish(), Some(Wish::Append { expected: 0, .. })));
    cell.appended(Appended::Stored(1));
    let Some(Wish::Append { expected: 1, output }) = cell.wish() else { panic!("the next one") };
    (cell, output)
}

fn tail(outputs: Vec<(u64, Output)>, last: u64, is_mine: bool) -> Result<Tail, ()> {
    Ok(Tail { outputs, last, is_whole: true, is_mine })
}

#[test]
fn owner_goes_on_behind_messages_that_no_owner_wrote() {
    for (epoch, is_mine) in [(1, false), (0, false), (9, true)] {
        let (mut cell, output) = publishing();
        cell.appended(Appended::Refused);
        assert_eq!(cell.wish(), Some(Wish::Last(1)));
        // One that cannot be read, a forged one, and one more.
        cell.last(tail(vec![(3, forged(&output, epoch))], 4, is_mine)).unwrap();
        assert_eq!(cell.wish(), Some(Wish::Append { expected: 4, output }), "epoch {epoch}");
        assert!(cell.foreign() > 0);
    }
}

#[test]
fn owner_is_fenced_by_a_greater_lease_that_is_not_its_own() {
    let (mut cell, output) = publishing();
    cell.appended(Appended::Refused);
    cell.wish();
    let refused = cell.last(tail(vec![(2, forged(&output, 9))], 2, false));
    assert_eq!(refused, Err(super::cell::Lost::Fenced));
    // Its lease ran out, another one had the cell, and now it has a lease again: that one was real.
    let (mut cell, output) = publishing();
    cell.output(2, forged(&output, 9)).unwrap();
    cell.appended(Appended::Refused);
    cell.wish();
    cell.leased_again(12);
    assert_eq!(cell.last(tail(Vec::new(), 2, true)), Err(super::cell::Lost::Fenced));
}

/// An answer is of before the other node had the lease where that one's output is read after the question.
#[test]
fn greater_lease_read_after_the_question_is_asked_for_again() {
    let (mut cell, output) = publishing();
    cell.appended(Appended::Unknown);
    assert_eq!(cell.wish(), Some(Wish::Last(1)));
    cell.output(2, forged(&output, 9)).unwrap();
    cell.last(tail(Vec::new(), 1, true)).unwrap();
    assert_eq!(cell.wish(), Some(Wish::Last(2)));
    assert_eq!(cell.last(tail(Vec::new(), 2, false)), Err(super::cell::Lost::Fenced));
}

/// The lease is given late: another node has it, and has published since.
#[test]
fn lease_that_comes_late_is_none_where_a_greater_one_has_published() {
    let mut cell = Cell::new(Toy::new(), SlotGrid::default(), WAIT, 0, 0);
    cell.lease(false);
    assert_eq!(cell.wish(), Some(Wish::Lease));
    let (_, output) = publishing();
    cell.output(1, forged(&output, 9)).unwrap();
    cell.leased(Some(1));
    assert_eq!(cell.wish(), Some(Wish::Last(1)));
    assert_eq!(cell.last(tail(Vec::new(), 1, false)), Err(super::cell::Lost::Fenced));
}

#[test]
fn standby_leaves_out_what_differs_where_the_owners_follows() {
    let world = flown(0, Faults::none());
    let outputs = world.outputs();
    let mut follower = Cell::new(Toy::new(), SlotGrid::default(), WAIT, 0, 0);
    for (sequence, input) in (1..).zip(world.inputs()) {
        follower.input(sequence, input.clone());
    }
    follower.output(1, outputs[0].clone()).unwrap();
    let mut sequence = 1;
    for (index, output) in outputs.iter().enumerate().skip(1) {
        let old = &outputs[index - 1];
        for message in [forged(output, output.epoch), old.clone(), forged(old, 3), output.clone()] {
            sequence += 1;
            follower.output(sequence, message).unwrap();
        }
        assert_eq!(follower.pump(Moment::default()), Ok(()), "slot {index}");
        assert_eq!(follower.published(), sequence, "slot {index}");
    }
    assert_eq!(follower.foreign(), 3 * (outputs.len() as u64 - 1));
}
