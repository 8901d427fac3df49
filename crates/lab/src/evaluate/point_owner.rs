//! Finds the drone of a point: by the labels of its contributors, else by the nearest true position.

use std::ops::Range;

use super::labels::{Attribution, Labels};
use super::nearby::Nearby;
use super::truth::Truth;
use super::types::OutputPoint;
use fusion::slots::{Slot, SlotGrid};
use fusion::time::{SECOND, Time};

/// Maximum distance to the nearest drone for points without labels, metres.
const REACH_M: f64 = 150.0;

/// Half of the time resolution of plots and labels (1/128 s), within which a label matches a plot, nanoseconds.
const HALF_COUNT_NS: i64 = 7_812_500 / 2;
/// Time after a plot for which its label applies to its track's points, nanoseconds. A point names the last
/// contributing track until another contributes or the target is dropped.
const AFTER_NS: i64 = 25 * SECOND;
/// Time before a plot from which its label applies, nanoseconds; longer than any backward extrapolation.
const BEFORE_NS: i64 = 3 * SECOND;
/// Time after a plot for which the state of its track determines published points, nanoseconds.
const SPEAKS_NS: i64 = 3 * SECOND;

/// The owner of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PointOwner {
    /// A drone of the truth, by index.
    Drone(usize),
    /// Not a drone: a bird, clutter, a ghost.
    NoDrone,
    /// A drone whose position is unknown: it is missing in the truth, or in a hole.
    UnknownPosition,
}

/// Attribution of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PointAttribution {
    pub(super) owner: PointOwner,
    /// Whether its radar track and transponder belong to one drone; `None` if they do not both contribute, labels do
    /// not determine it, or the radar track is seduced.
    pub(super) paired: Option<bool>,
    /// Whether its radar track was seduced at that time.
    pub(super) seduced: bool,
    /// Whether the latest plot of its radar track, at that time or up to 3 s before, was of a seduced track. Points
    /// between and after plots depend on that plot.
    pub(super) walked_off: bool,
}

/// Kind of points in a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PointKind {
    /// Points of slots, to which the latest plot of a radar track contributes.
    Output,
    /// Plots, each with its own label.
    Plots,
}

/// Finds the owners of points, slot by slot.
pub(super) struct PointOwners<'a> {
    truth: &'a Truth,
    labels: Option<&'a Labels>,
    grid: SlotGrid,
    kind: PointKind,
    /// Drones near the slot of the last lookup.
    nearby: Option<(Slot, Nearby)>,
}

impl<'a> PointOwners<'a> {
    pub(super) fn new(truth: &'a Truth, labels: Option<&'a Labels>, grid: SlotGrid, kind: PointKind) -> Self {
        Self { truth, labels, grid, kind, nearby: None }
    }

    /// Attributes a point; fast if points come slot by slot.
    pub(super) fn find(&mut self, point: &OutputPoint) -> PointAttribution {
        let nearest = |this: &mut Self| PointAttribution {
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
        // A radar-only point between two plots, or before or after them.
        let at = |later_ns| Time::from_nanos(point.time.nanos() + later_ns);
        let around = at(-AFTER_NS)..=at(BEFORE_NS);
        let beside = |number| labels.radar_track_near(number, point.sensor.as_deref(), point.time, &around);
        let track = match (transponder, radar) {
            (None, Some(None)) => point.radar_track.map(beside),
            _ => radar,
        };
        let owner = self.by_labels([transponder, track]).unwrap_or_else(|| self.nearest(point));
        PointAttribution { owner, paired, seduced, walked_off }
    }

    /// The first contributor that is a drone. [`PointOwner::NoDrone`] if labels say that no contributor is one; `None` if the
    /// labels do not determine it.
    fn by_labels(&self, contributors: [Option<Option<Attribution<'_>>>; 2]) -> Option<PointOwner> {
        let mut contributors = contributors.into_iter().flatten().peekable();
        contributors.peek()?;
        let mut all_labelled = true;
        for contributor in contributors {
            match contributor {
                Some(Attribution { id: Some(id), .. }) => {
                    return Some(
                        self.truth.index_of(id).map_or(PointOwner::UnknownPosition, PointOwner::Drone),
                    );
                }
                Some(Attribution { id: None, .. }) => {}
                None => all_labelled = false,
            }
        }
        all_labelled.then_some(PointOwner::NoDrone)
    }

    fn span(&self, point: &OutputPoint) -> Range<Time> {
        let slot = self.grid.of(point.time);
        let open = self.grid.open(slot);
        match self.kind {
            PointKind::Output => open..self.grid.open(slot.plus(1)),
            PointKind::Plots => open..Time::from_nanos(point.time.nanos() + HALF_COUNT_NS),
        }
    }

    /// The drone nearest to the point at its time. Interpolation across a hole counts only if no other drone is near.
    fn nearest(&mut self, point: &OutputPoint) -> PointOwner {
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
            // At equal distances, take the lower index, whatever the order of the search.
            if is_known && best.is_none_or(|best| (distance_m, drone) < best) {
                best = Some((distance_m, drone));
            }
        }
        self.nearby = Some((slot, nearby));
        match best {
            Some((_, drone)) => PointOwner::Drone(drone),
            None if in_a_hole => PointOwner::UnknownPosition,
            None => PointOwner::NoDrone,
        }
    }
}
