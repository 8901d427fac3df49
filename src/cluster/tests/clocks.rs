//! Clocks that are wrong, one at a time, and messages that no member would write.

use std::collections::BTreeSet;

use asterix::DataSource;
use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use jiff::SignedDuration;

use super::toy::{self, Toy};
use super::world::{BEGINS_MS, Clocks, Faults, Who, World};
use super::{MANY, checked, owned, schedules};
use crate::cluster::cell::{Appended, Cell, Read, Wish};
use crate::cluster::message::{Header, Heard, Input, Logged, Origin, Output};
use crate::cluster::reference_clock::{Moment, Refusal};

/// A node that reads a message late finds it less ahead by that delay. No fault delays a node for longer than this, milliseconds.
const LATE_MS: i64 = 20_000;

/// How many inputs of gateways were used and refused, whose clocks are right and wrong.
#[derive(Debug, Default)]
struct Judged {
    right: usize,
    right_refused: usize,
    wrong: usize,
    wrong_used: usize,
}

/// Judges every input of a gateway that an output covers: wrong is one whose clock is ahead, or has been behind for 2.5 s in which it
/// was heard without a gap.
fn judged(world: &World<Toy>, what: &str) -> Judged {
    let outputs = world.outputs();
    let refused: BTreeSet<u64> = outputs.iter().flat_map(|output| output.refused.iter().copied()).collect();
    let (first, last) = (outputs[0].behind, outputs[outputs.len() - 1].behind);
    let mut judged = Judged::default();
    // When each gateway was heard last, and since when without a gap.
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
            // Its slot is by one clock, and its sending by another.
            continue;
        }
        if sent.error_ms == 0 {
            judged.right += 1;
            judged.right_refused += usize::from(is_refused);
        } else if sent.error_ms > LATE_MS {
            assert!(is_refused, "{what}: {sequence} of a clock ahead is used: {sent:?}");
            judged.wrong += 1;
        } else if sent.error_ms > 0 || lasts_ms > 2_500 {
            // A node that has just begun to read has not seen for long enough that it is behind.
            judged.wrong_used += usize::from(!is_refused);
            judged.wrong += 1;
        }
    }
    judged
}

fn flown(seed: u64, faults: Faults, clocks: Clocks) -> World<Toy> {
    let mut world = World::new(seed, faults, toy::feed()).with(clocks);
    world.run();
    world
}

#[test]
fn wrong_clock_of_any_member_delays_and_advances_nothing() {
    for (seed, who) in
        (0..).zip([Who::Gateway(0), Who::Gateway(1), Who::Log, Who::Node(0), Who::Node(1), Who::Node(2)])
    {
        for error_ms in [3_000, -3_000, 10_000, -10_000, 30_000, -30_000, 600_000, -600_000] {
            // From the beginning, or once there were slots.
            let from = if (error_ms / 1_000) % 4 == 2 { 0 } else { 20_000 };
            let world = flown(seed, Faults::none(), Clocks(vec![(who, from, 40_000, error_ms)]));
            let what = format!("{who:?} {error_ms} ms from {from} ms");
            checked(&world, &what);
            let judged = judged(&world, &what);
            assert_eq!((judged.right_refused, judged.wrong_used), (0, 0), "{what}: {judged:?}");
            assert_eq!(world.takeovers(), 1, "{what}");
            assert!(world.silence_s() < 1.0, "{what}: silent for {} s", world.silence_s());
            assert!(world.early_ms() < 250, "{what}: {} ms early", world.early_ms());
        }
    }
}

/// With all other faults, and odd messages. Of right clocks hardly an input is refused: one that is the first after a silence of
/// all, of a log whose clock was set meanwhile, as read by a node that has just begun.
#[test]
fn no_clock_decides_whatever_else_happens() {
    let (mut all, mut takeovers) = (Judged::default(), 0);
    for seed in schedules() {
        let clocks = Clocks::any(seed);
        let faults = Faults::any(seed).without_gateways(&clocks);
        let mut world = World::new(seed, faults, toy::feed()).with(clocks).odd();
        world.run();
        let what = format!("seed {seed}");
        checked(&world, &what);
        super::delivered(&world, &what);
        assert!(world.early_ms() < 250, "{what}: {} ms early", world.early_ms());
        let found = judged(&world, &what);
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
fn at(ms: i64) -> Moment {
    let wall = Time::from_nanos((BEGINS_MS + ms) * 1_000_000);
    Moment { steady: SignedDuration::from_millis(ms), wall }
}

/// A message that a gateway of that configuration sends when a slot is over, as it is read at once.
fn message(gateway: &str, config: u64, slot: Slot, ms: i64) -> Read {
    let address = "127.0.0.1:5000".parse().unwrap();
    let received = SlotGrid::default().centre(slot);
    let payload = format!("{gateway} {}", slot.0).into_bytes();
    let origin = Some(Origin { gateway: gateway.to_owned(), sent: at(ms).wall, config });
    let heard = vec![Heard { received, from: address, to: address, payload }];
    let sensor = DataSource { sac: 25, sic: 1 };
    let input = Input { origin, sensor, slot, part: 0, is_last: true, heard };
    let header: Option<Header> = Header::of(&input.body()).unwrap();
    Read { stamp: at(ms).wall, at: at(ms), header, logged: Some(Logged::Input(input)), has_more: false }
}

/// Publishes the slots that are due.
fn published(cell: &mut Cell<Toy>, ms: i64, outputs: &mut Vec<Output>) {
    cell.pump(at(ms)).unwrap();
    while let Some(Wish::Append { output, .. }) = cell.wish() {
        outputs.push(output);
        cell.appended(Appended::Stored(outputs.len() as u64));
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
            cell.read(sequence, message(gateway, config, slot, ms));
        }
        published(&mut cell, ms + 20, &mut outputs);
    }
    let refused: Vec<u64> = outputs.iter().flat_map(|output| output.refused.iter().copied()).collect();
    let last = outputs.last().unwrap().behind;
    assert!(outputs.len() > 30);
    assert_eq!(refused, (1..=last).filter(|sequence| sequence % 3 == 2).collect::<Vec<_>>());
    let refusals = cell.refusals();
    let of: Vec<_> = refusals.iter().map(|((gateway, why), (count, _))| (&**gateway, *why, *count)).collect();
    assert_eq!(of, [("g1", Refusal::Configuration, 40)]);
}

/// The list of what is refused is to fit a message of the log.
#[test]
fn flood_of_refused_inputs_is_spread_over_outputs() {
    let (mut cell, mut outputs, mut sequence) = (owned(), Vec::new(), 0);
    for slot in 0..40 {
        let ms = 250 * (slot + 1);
        let slot_then = SlotGrid::default().of(at(ms).wall).plus(-1);
        let flood = if slot == 20 { 25_000 } else { 0 };
        for _ in 0..flood {
            sequence += 1;
            cell.read(sequence, message("x", 0, slot_then.plus(14_400), ms));
        }
        sequence += 1;
        cell.read(sequence, message("g0", 0, slot_then, ms));
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
