//! Whose each point is, its error, and whether it counts.

use super::counted::Counted;
use super::labels::Labels;
use super::owner::{Owner, Owners, PointKind};
use super::place::{Offset, Place};
use super::truth::Truth;
use super::types::{OutputPoint, PolarPlace, Sample, Scoring};
use fusion::slots::{Slot, SlotGrid};

/// A point that counts.
#[derive(Clone, Debug)]
pub(super) struct Judged<'a> {
    pub(super) point: &'a OutputPoint,
    pub(super) slot: Slot,
    /// The drone it belongs to; `None`: none.
    pub(super) drone: Option<usize>,
    /// The drone's true position at that time.
    pub(super) truth: Option<Place>,
    /// From there to the point.
    pub(super) error: Option<Offset>,
    /// Whether its radar track and transponder are one drone; `None` where that is not scored.
    pub(super) paired: Option<bool>,
    /// Whether its radar track was seduced there.
    pub(super) seduced: bool,
    /// In what state its drone is followed; `None` of a point without drone, or where the truth does not tell.
    pub(super) state: Option<State>,
}

/// The states in which a drone may be followed: its radar's errors differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    /// It flies straight on or stands.
    Straight,
    /// It turns.
    Turning,
    /// The radar's track has walked off.
    WalkedOff,
}

/// What points are scored against.
#[derive(Clone, Copy)]
pub(super) struct Reference<'a> {
    pub(super) truth: &'a Truth,
    pub(super) labels: Option<&'a Labels>,
    pub(super) counted: &'a Counted,
    pub(super) grid: SlotGrid,
}

/// The points that count, in the order given.
pub(super) fn judge<'a>(
    points: &'a [OutputPoint],
    kind: PointKind,
    reference: Reference<'_>,
) -> Vec<Judged<'a>> {
    let Reference { truth, labels, grid, .. } = reference;
    let mut owners = Owners::new(truth, labels, grid, kind);
    // Owners are found fastest slot by slot; the order given is restored afterwards.
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by_key(|&place| grid.of(points[place].time));
    let mut judged: Vec<(usize, Judged<'a>)> = order
        .into_iter()
        .filter_map(|place| Some((place, judge_one(&points[place], &mut owners, reference)?)))
        .collect();
    judged.sort_by_key(|(place, _)| *place);
    judged.into_iter().map(|(_, judged)| judged).collect()
}

/// `None` for a point that does not count: outside the drone's counted slots, or where its true position is unknown.
fn judge_one<'a>(
    point: &'a OutputPoint,
    owners: &mut Owners<'_>,
    reference: Reference<'_>,
) -> Option<Judged<'a>> {
    let Reference { truth, counted, grid, .. } = reference;
    let slot = grid.of(point.time);
    if !counted.run_contains(slot) {
        return None;
    }
    let finding = owners.find(point);
    let state = |drone: usize| match truth.tracks()[drone].turns(point.time) {
        _ if finding.walked_off => Some(State::WalkedOff),
        turns => turns.map(|turns| if turns { State::Turning } else { State::Straight }),
    };
    let (drone, at) = match finding.owner {
        Owner::Drone(drone) if counted.contains(drone, slot) => {
            (Some(drone), Some(truth.tracks()[drone].at(point.time)?))
        }
        Owner::Nobody => (None, None),
        Owner::Drone(_) | Owner::Untold => return None,
    };
    Some(Judged {
        point,
        slot,
        drone,
        truth: at,
        error: at.map(|at| point.place.offset_from(&at)),
        paired: finding.paired,
        seduced: finding.seduced,
        // It is asked for where there is a covariance to be judged by it.
        state: drone.filter(|_| point.covariance.is_some()).and_then(state),
    })
}

impl Judged<'_> {
    /// The published form.
    pub(super) fn sample(&self, settings: &Scoring) -> Sample {
        Sample {
            time: self.point.time,
            place: self.point.place,
            source: self.point.source,
            number: self.point.number,
            drone: self.drone,
            error: self.error,
            seen: settings
                .site
                .zip(self.truth)
                .map(|(site, truth)| PolarPlace::from(&truth.offset_from(&site))),
        }
    }
}

impl From<&Offset> for PolarPlace {
    fn from(offset: &Offset) -> Self {
        let azimuth_deg = offset.east_m.atan2(offset.north_m).to_degrees().rem_euclid(360.0);
        Self { range_m: offset.horizontal_m(), azimuth_deg }
    }
}
