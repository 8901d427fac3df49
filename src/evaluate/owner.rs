//! Which drone a point belongs to: by its contributors' labels, else the nearest true position.

use std::ops::Range;

use super::labels::{Attribution, Labels};
use super::nearby::Nearby;
use super::truth::Truth;
use super::types::OutputPoint;
use fusion::slots::{Slot, SlotGrid};
use fusion::time::{SECOND, Time};

/// Without labels a point belongs to the nearest drone within this distance, metres.
const REACH_M: f64 = 150.0;

/// Half of the time resolution of plots and labels (1/128 s), within which a label matches a plot, nanoseconds.
const HALF_COUNT_NS: i64 = 7_812_500 / 2;
/// How long after a plot its label still holds for its track's points, nanoseconds: a point names the last contributing
/// track until another contributes or the target is dropped.
const AFTER_NS: i64 = 25 * SECOND;
/// How long before a plot its label already holds, nanoseconds: longer than any backward extrapolation.
const BEFORE_NS: i64 = 3 * SECOND;
/// How long after a plot its track still speaks for what is published, nanoseconds.
const SPEAKS_NS: i64 = 3 * SECOND;

/// The owner of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Owner {
    /// This drone of the truth.
    Drone(usize),
    /// No drone: a bird, clutter, a ghost.
    Nobody,
    /// A drone whose position the truth does not give: it is missing there, or in a hole.
    Untold,
}

/// What is known about a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Finding {
    pub(super) owner: Owner,
    /// Whether its radar track and transponder are one drone; `None` where not both contribute, labels are silent, or the
    /// radar track is seduced.
    pub(super) paired: Option<bool>,
    /// Whether its radar track was seduced there.
    pub(super) seduced: bool,
    /// Whether its radar track's latest plot, there or shortly before, was of a seduced track: what is published between
    /// plots and behind the last of them follows from it.
    pub(super) walked_off: bool,
}

/// The kind of points in a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PointKind {
    /// Points of slots, to which the latest plot of a radar track contributes.
    Output,
    /// Plots, each with a label of its own.
    Plots,
}

/// Finds the owners of points, slot by slot.
pub(super) struct Owners<'a> {
    truth: &'a Truth,
    labels: Option<&'a Labels>,
    grid: SlotGrid,
    kind: PointKind,
    /// The drones near the slot that was asked for last.
    nearby: Option<(Slot, Nearby)>,
}

impl<'a> Owners<'a> {
    pub(super) fn new(truth: &'a Truth, labels: Option<&'a Labels>, grid: SlotGrid, kind: PointKind) -> Self {
        Self { truth, labels, grid, kind, nearby: None }
    }

    /// What is known about a point; fast where points come slot by slot.
    pub(super) fn find(&mut self, point: &OutputPoint) -> Finding {
        let nearest = |this: &mut Self| Finding {
            owner: this.nearest(point),
            paired: None,
            seduced: false,
            walked_off: false,
        };
        let Some(labels) = self.labels else { return nearest(self) };
        let transponder =
            point.transponder.map(|number| labels.transponder(point.identity.as_deref(), number));
        let span = self.span(point);
        let radar = point.radar_track.map(|track| labels.radar_track(track, point.sensor.as_deref(), &span));
        let paired = transponder.flatten().zip(radar.flatten()).and_then(|(transponder, radar)| {
            (!radar.seduced).then_some(transponder.id.is_some() && transponder.id == radar.id)
        });
        let is_seduced = |radar: Option<Attribution<'_>>| radar.is_some_and(|radar| radar.seduced);
        let seduced = is_seduced(radar.flatten());
        let lately = Time::from_nanos(span.end.nanos() - SPEAKS_NS)..span.end;
        let walked_off = point
            .radar_track
            .is_some_and(|track| is_seduced(labels.radar_track(track, point.sensor.as_deref(), &lately)));
        // A radar-only point between two plots, or beyond them.
        let at = |later_ns| Time::from_nanos(point.time.nanos() + later_ns);
        let around = at(-AFTER_NS)..=at(BEFORE_NS);
        let beside = |number| labels.radar_track_near(number, point.sensor.as_deref(), point.time, &around);
        let track = match (transponder, radar) {
            (None, Some(None)) => point.radar_track.map(beside),
            _ => radar,
        };
        let owner = self.told([transponder, track]).unwrap_or_else(|| self.nearest(point));
        Finding { owner, paired, seduced, walked_off }
    }

    /// The first contributor that is a drone; nobody if labels call all of them none; `None` where labels are silent.
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

    /// The drone nearest to the point at its time. Interpolation across a hole counts only where no other drone is near.
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
