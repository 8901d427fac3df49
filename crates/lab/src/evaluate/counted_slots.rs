//! Slots that count for each drone.

use super::truth::{TrueTrack, Truth};
use fusion::slots::{Slot, SlotGrid};
use fusion::time::{SECOND, Time};

/// The first 10 s of a drone's truth do not count, because the window is still filling.
const SKIPPED_FIRST_NS: i64 = 10 * SECOND;
/// The last 7.5 s do not count, because their slots are published after the flight.
const SKIPPED_LAST_NS: i64 = 15 * SECOND / 2;

/// Slots that count: the centre lies within the drone's truth, but not near its ends or inside its holes.
#[derive(Clone, Debug)]
pub(crate) struct CountedSlots {
    /// Per drone: first and last slot of each interval, in order.
    pieces: Vec<Vec<(Slot, Slot)>>,
    run: Option<(Slot, Slot)>,
    slot_s: f64,
}

impl CountedSlots {
    pub(crate) fn new(truth: &Truth, grid: SlotGrid) -> Self {
        let pieces: Vec<_> = truth.tracks().iter().map(|track| pieces(track, grid)).collect();
        let first = pieces.iter().filter_map(|pieces| pieces.first()).map(|piece| piece.0).min();
        let last = pieces.iter().filter_map(|pieces| pieces.last()).map(|piece| piece.1).max();
        Self { pieces, run: first.zip(last), slot_s: grid.slot_s() }
    }

    /// Whether `slot` counts for `drone`.
    pub(crate) fn contains(&self, drone: usize, slot: Slot) -> bool {
        let pieces = &self.pieces[drone];
        let next = pieces.partition_point(|piece| piece.1 < slot);
        pieces.get(next).is_some_and(|piece| piece.0 <= slot)
    }

    /// First and last slot of each interval that counts for `drone`, in order.
    pub(crate) fn intervals(&self, drone: usize) -> &[(Slot, Slot)] {
        &self.pieces[drone]
    }

    /// Number of slots that count for `drone`.
    pub(crate) fn slots(&self, drone: usize) -> u64 {
        self.pieces[drone].iter().map(|(first, last)| (last.0 - first.0 + 1) as u64).sum()
    }

    /// Minutes that count for `drone`.
    pub(crate) fn minutes(&self, drone: usize) -> f64 {
        self.slots(drone) as f64 * self.slot_s / 60.0
    }

    /// First and last slot that count for any drone; `None` if there is none.
    pub(crate) fn run(&self) -> Option<(Slot, Slot)> {
        self.run
    }

    /// Whether the run contains `slot`.
    pub(crate) fn run_contains(&self, slot: Slot) -> bool {
        self.run.is_some_and(|(first, last)| (first..=last).contains(&slot))
    }

    /// Length of the run, minutes.
    pub(crate) fn run_minutes(&self) -> Option<f64> {
        self.run.map(|(first, last)| (last.0 - first.0 + 1) as f64 * self.slot_s / 60.0)
    }
}

fn pieces(track: &TrueTrack, grid: SlotGrid) -> Vec<(Slot, Slot)> {
    let (start, end) = track.span();
    let mut pieces = Vec::new();
    let mut from = Time::from_nanos(start.nanos().saturating_add(SKIPPED_FIRST_NS));
    let end = Time::from_nanos(end.nanos().saturating_sub(SKIPPED_LAST_NS));
    let mut add = |from: Time, until: Time| {
        let (first, last) = (first_centre_from(from, grid), last_centre_until(until, grid));
        if first <= last {
            pieces.push((first, last));
        }
    };
    for (hole, after) in track.holes() {
        add(from, hole.min(end));
        from = from.max(after);
    }
    add(from, end);
    pieces
}

/// First slot whose centre is at `time` or later.
fn first_centre_from(time: Time, grid: SlotGrid) -> Slot {
    let slot = grid.of(time);
    if grid.centre(slot) < time { slot.plus(1) } else { slot }
}

/// Last slot whose centre is at `time` or earlier.
fn last_centre_until(time: Time, grid: SlotGrid) -> Slot {
    let slot = grid.of(time);
    if grid.centre(slot) > time { slot.plus(-1) } else { slot }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::GeodeticPlace;

    fn counted(seconds: &[f64]) -> CountedSlots {
        let place = GeodeticPlace { latitude_deg: 0.0, longitude_deg: 0.0, altitude_amsl_m: None };
        let samples =
            seconds.iter().map(|&second| (Time::from_nanos((second * 1e9) as i64), place)).collect();
        CountedSlots::new(&Truth::new([("A".to_owned(), samples)]), SlotGrid::default())
    }

    fn every_five(from: i32, until: i32) -> Vec<f64> {
        (from..=until).step_by(5).map(f64::from).collect()
    }

    #[test]
    fn counted_slots_exclude_start_and_end_of_the_truth() {
        // 10 <= k/4 + 1/8 <= 22.5: slots 40 to 89.
        let counted = counted(&every_five(0, 30));
        assert_eq!([39, 40, 89, 90].map(|slot| counted.contains(0, Slot(slot))), [false, true, true, false]);
        assert_eq!((counted.slots(0), counted.run()), (50, Some((Slot(40), Slot(89)))));
        assert!((counted.run_minutes().unwrap() - 12.5 / 60.0).abs() < 1e-12);
        assert!((counted.minutes(0) - 12.5 / 60.0).abs() < 1e-12);
    }

    #[test]
    fn slot_centre_decides_at_both_ends() {
        let inside = counted(&[0.125, 5.0, 10.0, 15.0, 17.625 + 2.5]);
        assert_eq!(inside.run(), Some((Slot(40), Slot(50))), "10.125 and 12.625 are centres of slots");
        let outside = counted(&[0.126, 5.0, 10.0, 15.0, 17.624 + 2.5]);
        assert_eq!(outside.run(), Some((Slot(41), Slot(49))));
    }

    #[test]
    fn holes_are_cut_out() {
        // Hole from 15 to 25.1: centres 15.125 to 24.875 are inside it, and 25.125 is outside.
        let counted = counted(&[0.0, 5.0, 10.0, 15.0, 25.1, 30.0, 35.0]);
        let counts = [59, 60, 99, 100].map(|slot| counted.contains(0, Slot(slot)));
        assert_eq!(counts, [true, false, false, true]);
        // 40 to 59, and 100 to 109 (27.375 <= 27.5).
        assert_eq!((counted.slots(0), counted.run()), (30, Some((Slot(40), Slot(109)))));
        assert!(counted.run_contains(Slot(80)) && !counted.contains(0, Slot(80)));
    }

    #[test]
    fn short_flight_has_no_counted_slots() {
        let short = counted(&every_five(0, 15));
        assert_eq!((short.slots(0), short.run(), short.run_minutes()), (0, None, None));
        let cut = counted(&[0.0, 11.0]);
        assert_eq!((cut.slots(0), cut.run()), (0, None), "all of it is a hole");
    }
}
