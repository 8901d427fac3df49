//! The reference of an assessment, and the blocks of its intervals.

use std::collections::{BTreeMap, BTreeSet};

use super::bootstrap::{BlockKey, BlockSums, add};
use super::types::ReferenceKind;
use crate::evaluate::{CountedSlots, GeodeticPlace, Truth};
use fusion::slots::SlotGrid;
use fusion::time::{SECOND, Time};

/// Number of aircraft from which each is one block.
const AIRCRAFT_MIN: usize = 8;
/// Length of a block, if there are fewer aircraft, seconds: longer than radar errors last.
const BLOCK_S: i64 = 60;
/// Speed below which an aircraft hovers, m/s.
const HOVERS_M_S: f64 = 2.0;

/// The reference, and common settings.
pub(super) struct AssessmentScene<'a> {
    pub(super) truth: &'a Truth,
    pub(super) kind: ReferenceKind,
    pub(super) counted: CountedSlots,
    pub(super) grid: SlotGrid,
    /// Origin of ranges of the picture and of receivers.
    pub(super) origin: GeodeticPlace,
    /// Class of each aircraft, if stated.
    pub(super) classes: &'a BTreeMap<String, String>,
    /// Per aircraft: whether reports of a transponder belong to it.
    pub(super) equipped: Vec<bool>,
    /// Seed of the draws.
    pub(super) seed: u64,
    /// Number of aircraft with slots that count.
    pub(super) aircraft: usize,
    /// Opening of the first slot that counts, and end of the last.
    run: Option<(Time, Time)>,
}

/// Motion of an aircraft.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum MotionClass {
    Hovering,
    Straight,
    Turning,
}

impl<'a> AssessmentScene<'a> {
    pub(super) fn new(
        (truth, kind): (&'a Truth, ReferenceKind),
        classes: &'a BTreeMap<String, String>,
        grid: SlotGrid,
        origin: GeodeticPlace,
        seed: u64,
    ) -> Self {
        let counted = CountedSlots::new(truth, grid);
        let aircraft = (0..truth.tracks().len()).filter(|&drone| counted.slots(drone) > 0).count();
        let run = counted.run().map(|(first, last)| (grid.open(first), grid.open(last.plus(1))));
        let equipped = vec![false; truth.tracks().len()];
        Self { truth, kind, counted, grid, origin, classes, equipped, seed, aircraft, run }
    }

    pub(super) fn is_truth(&self) -> bool {
        self.kind == ReferenceKind::Truth
    }

    /// Length of a block, seconds; `None` if a block is all of an aircraft's flight.
    pub(super) fn block_s(&self) -> Option<f64> {
        (self.aircraft < AIRCRAFT_MIN).then_some(BLOCK_S as f64)
    }

    /// Block of an aircraft at a time.
    pub(super) fn block(&self, drone: usize, time: Time) -> BlockKey {
        (Some(drone), if self.aircraft < AIRCRAFT_MIN { self.piece(time) } else { 0 })
    }

    /// Block of a time, for figures of no aircraft.
    pub(super) fn block_of_run(&self, time: Time) -> BlockKey {
        (None, self.piece(time))
    }

    fn piece(&self, time: Time) -> i64 {
        let start = self.run.map_or(0, |run| run.0.nanos());
        (time.nanos() - start).div_euclid(BLOCK_S * SECOND)
    }

    /// Indices of the aircraft.
    pub(super) fn drones(&self) -> std::ops::Range<usize> {
        0..self.truth.tracks().len()
    }

    /// Times that count for an aircraft: from and until.
    pub(super) fn spans(&self, drone: usize) -> impl Iterator<Item = (Time, Time)> + '_ {
        let span = |&(first, last): &(fusion::slots::Slot, fusion::slots::Slot)| {
            (self.grid.open(first), self.grid.open(last.plus(1)))
        };
        self.counted.intervals(drone).iter().map(span)
    }

    /// Time flown that counts by aircraft for which `is_wanted` holds, in units of `unit_s` seconds, by block.
    pub(super) fn flown(&self, unit_s: f64, is_wanted: impl Fn(usize) -> bool) -> BlockSums {
        let mut sums = BlockSums::new();
        for drone in self.drones().filter(|&drone| is_wanted(drone)) {
            for &(first, last) in self.counted.intervals(drone) {
                for slot in first.0..=last.0 {
                    let time = self.grid.centre(fusion::slots::Slot(slot));
                    add(&mut sums, self.block(drone, time), 0.0, self.grid.slot_s() / unit_s);
                }
            }
        }
        sums
    }

    /// Length of the run, in units of `unit_s` seconds, by block.
    pub(super) fn run_time(&self, unit_s: f64) -> BlockSums {
        let mut sums = BlockSums::new();
        if let Some((first, last)) = self.counted.run() {
            for slot in first.0..=last.0 {
                let time = self.grid.centre(fusion::slots::Slot(slot));
                add(&mut sums, self.block_of_run(time), 0.0, self.grid.slot_s() / unit_s);
            }
        }
        sums
    }

    /// Place of an aircraft.
    pub(super) fn place(&self, drone: usize, time: Time) -> Option<GeodeticPlace> {
        self.truth.tracks()[drone].at(time)
    }

    /// Motion of an aircraft; `None` within a second of an end or a hole of the reference.
    pub(super) fn motion(&self, drone: usize, time: Time) -> Option<MotionClass> {
        let track = &self.truth.tracks()[drone];
        let turns = track.turns(time)?;
        Some(match turns {
            _ if track.speed_m_s(time)? < HOVERS_M_S => MotionClass::Hovering,
            true => MotionClass::Turning,
            false => MotionClass::Straight,
        })
    }

    /// Velocity over ground, east and north, m/s: the mean of the second around the time.
    pub(super) fn velocity(&self, drone: usize, time: Time) -> Option<[f64; 2]> {
        let at = |later_ns: i64| self.place(drone, Time::from_nanos(time.nanos() + later_ns));
        let moved = at(SECOND / 2)?.offset_from(&at(-SECOND / 2)?);
        Some([moved.east_m, moved.north_m])
    }

    /// Names of the classes of the aircraft.
    pub(super) fn class_names(&self) -> BTreeSet<&str> {
        let tracks = self.truth.tracks().iter();
        tracks.filter_map(|track| self.classes.get(track.id())).map(String::as_str).collect()
    }

    /// Class of an aircraft.
    pub(super) fn class(&self, drone: usize) -> Option<&str> {
        self.classes.get(self.truth.tracks()[drone].id()).map(String::as_str)
    }
}
