//! Whose is a point: by its contributors' labels, else by the nearest truth.

use std::ops::Range;

use super::labels::{Attribution, Labels};
use super::nearby::Nearby;
use super::truth::Truth;
use super::types::OutputPoint;
use fusion::slots::{Slot, SlotGrid};
use fusion::time::{SECOND, Time};

/// Without labels a point belongs to the nearest drone at most this far away, metres.
const REACH_M: f64 = 150.0;

/// Plots and labels have times in 1/128 s; half of that decides which plot a label means, nanoseconds.
const HALF_COUNT_NS: i64 = 7_812_500 / 2;
/// A radar track's plot tells of points so long after it, nanoseconds: the track that took part last is named until another
/// one does, or its target is forgotten;
const AFTER_NS: i64 = 25 * SECOND;
/// and so long before it: further than any is extrapolated backward.
const BEFORE_NS: i64 = 3 * SECOND;

/// Whose a point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Owner {
    /// Of this drone of the truth.
    Drone(usize),
    /// Of none: a bird, clutter, a ghost.
    Nobody,
    /// Of a drone the truth does not tell the place of: one that is not in it, or in a hole of it.
    Untold,
}

/// What is known about a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Finding {
    pub(super) owner: Owner,
    /// Whether its radar track and transponder are one drone; `None`: not both took part, or not told, or the radar's
    /// track is seduced.
    pub(super) paired: Option<bool>,
    /// Whether its radar track was seduced there.
    pub(super) seduced: bool,
}

/// Which points are asked about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PointKind {
    /// Points of a slot: in one, the latest plot of a radar track takes part.
    Output,
    /// Plots, each with a label of its own.
    Plots,
}

/// Tells whose points are, slot by slot.
pub(super) struct Owners<'a> {
    truth: &'a Truth,
    labels: Option<&'a Labels>,
    grid: SlotGrid,
    kind: PointKind,
    /// The drones of the slot last asked about.
    nearby: Option<(Slot, Nearby)>,
}

impl<'a> Owners<'a> {
    pub(super) fn new(truth: &'a Truth, labels: Option<&'a Labels>, grid: SlotGrid, kind: PointKind) -> Self {
        Self { truth, labels, grid, kind, nearby: None }
    }

    /// What is known about a point; fast where points come slot by slot.
    pub(super) fn find(&mut self, point: &OutputPoint) -> Finding {
        let nearest = |this: &mut Self| Finding { owner: this.nearest(point), paired: None, seduced: false };
        let Some(labels) = self.labels else { return nearest(self) };
        let transponder = point.transponder.map(|number| labels.transponder(number));
        let span = self.span(point);
        let radar = point.radar_track.map(|track| labels.radar_track(track, point.sensor.as_deref(), &span));
        let paired = transponder.flatten().zip(radar.flatten()).and_then(|(transponder, radar)| {
            (!radar.seduced).then_some(transponder.id.is_some() && transponder.id == radar.id)
        });
        let seduced = radar.flatten().is_some_and(|radar| radar.seduced);
        // Of a point between two plots, or beyond them, which no transponder tells of.
        let at = |later_ns| Time::from_nanos(point.time.nanos() + later_ns);
        let around = at(-AFTER_NS)..=at(BEFORE_NS);
        let beside = |number| labels.radar_track_near(number, point.sensor.as_deref(), point.time, &around);
        let track = match (transponder, radar) {
            (None, Some(None)) => point.radar_track.map(beside),
            _ => radar,
        };
        let owner = self.told([transponder, track]).unwrap_or_else(|| self.nearest(point));
        Finding { owner, paired, seduced }
    }

    /// The first contributor that is a drone; nobody where all are told to be none; `None` where labels do not tell.
    fn told(&self, contributors: [Option<Option<Attribution<'_>>>; 2]) -> Option<Owner> {
        let mut contributors = contributors.into_iter().flatten().peekable();
        contributors.peek()?;
        let mut all_told = true;
        for contributor in contributors {
            match contributor {
                Some(Attribution { id: Some(id), .. }) => {
                    return Some(self.truth.index_of(id).map_or(Owner::Untold, Owner::Drone));
                }
                Some(Attribution { id: None, .. }) => {}
                None => all_told = false,
            }
        }
        all_told.then_some(Owner::Nobody)
    }

    fn span(&self, point: &OutputPoint) -> Range<Time> {
        let slot = self.grid.of(point.time);
        let open = self.grid.open(slot);
        match self.kind {
            PointKind::Output => open..self.grid.open(slot.plus(1)),
            PointKind::Plots => open..Time::from_nanos(point.time.nanos() + HALF_COUNT_NS),
        }
    }

    /// The drone nearest to the point at its time; a hole of the truth is crossed only where no other is near.
    fn nearest(&mut self, point: &OutputPoint) -> Owner {
        let (truth, slot) = (self.truth, self.grid.of(point.time));
        let around = || Nearby::of_truth(truth, self.grid.open(slot), self.grid.open(slot.plus(1)));
        let nearby = match self.nearby.take() {
            Some((of, nearby)) if of == slot => nearby,
            _ => around(),
        };
        let mut best: Option<(f64, usize)> = None;
        let mut in_a_hole = false;
        for drone in nearby.within(point.place, REACH_M) {
            let track = &truth.tracks()[drone];
            let (place, is_known) = match track.at(point.time) {
                Some(place) => (Some(place), true),
                None => (track.at_or_across_hole(point.time), false),
            };
            let distance_m = place.map(|place| point.place.offset_from(&place).distance_m());
            let Some(distance_m) = distance_m.filter(|&distance_m| distance_m <= REACH_M) else { continue };
            in_a_hole |= !is_known;
            // Of two at one distance the first by id, whatever the order they are found in.
            if is_known && best.is_none_or(|best| (distance_m, drone) < best) {
                best = Some((distance_m, drone));
            }
        }
        self.nearby = Some((slot, nearby));
        match best {
            Some((_, drone)) => Owner::Drone(drone),
            None if in_a_hole => Owner::Untold,
            None => Owner::Nobody,
        }
    }
}
