//! Drones that belong to the tracks of a pair.

use std::collections::{BTreeMap, BTreeSet};

use super::labels::Labels;
use super::point_owner::{self, PointKind, PointOwner};
use super::truth::Truth;
use super::types::OutputPoint;
use fusion::slots::SlotGrid;
use fusion::time::{SECOND, Time};

/// Maximum time between a prediction and the point that identifies its track, nanoseconds. The delayed picture has no
/// point after its slot, and the picture of the current time is ahead of the last point.
const NEAR_NS: u64 = 7 * SECOND as u64;

/// Drones of each track number, by time.
pub(super) struct TrackOwners(BTreeMap<u32, Vec<OwnedPoint>>);

/// A point of the output.
#[derive(Clone, Copy, Debug)]
struct OwnedPoint {
    time: Time,
    /// `None`: the point is not a drone's.
    drone: Option<usize>,
    has_height: bool,
}

impl TrackOwners {
    pub(super) fn of(truth: &Truth, labels: &Labels, output: &[OutputPoint], grid: SlotGrid) -> Self {
        let mut owners = point_owner::PointOwners::new(truth, Some(labels), grid, PointKind::Output);
        let mut by_number: BTreeMap<u32, Vec<OwnedPoint>> = BTreeMap::new();
        for point in output {
            let drone = match owners.find(point).owner {
                PointOwner::Drone(drone) => Some(drone),
                PointOwner::NoDrone | PointOwner::UnknownPosition => None,
            };
            let has_height = point.place.altitude_amsl_m.is_some();
            let owned = OwnedPoint { time: point.time, drone, has_height };
            by_number.entry(point.number).or_default().push(owned);
        }
        by_number.values_mut().for_each(|points| points.sort_by_key(|point| point.time));
        Self(by_number)
    }

    /// The drones of two tracks, the lower index first; `None`: a track is not a drone, or both are the same drone.
    pub(super) fn pair(&self, numbers: [u32; 2], at: Time) -> Option<[usize; 2]> {
        let [a, b] = numbers.map(|number| self.drone(number, at));
        let (a, b) = (a?, b?);
        (a != b).then(|| [a.min(b), a.max(b)])
    }

    /// The drone of the point nearest in time.
    pub(super) fn drone(&self, number: u32, at: Time) -> Option<usize> {
        let points = self.0.get(&number)?;
        let next = points.partition_point(|point| point.time < at);
        let around = points[next.saturating_sub(1)..].iter().take(2);
        let away = |point: &OwnedPoint| point.time.nanos().abs_diff(at.nanos());
        around.min_by_key(|point| away(point)).filter(|point| away(point) <= NEAR_NS)?.drone
    }

    /// The drones of the points from one time until another, and of those at most 7 s away.
    pub(super) fn drones(&self, number: u32, from: Time, until: Time) -> BTreeSet<usize> {
        let near = from.nanos() - NEAR_NS as i64..=until.nanos() + NEAR_NS as i64;
        let points = self.0.get(&number).into_iter().flatten();
        points.filter(|point| near.contains(&point.time.nanos())).filter_map(|point| point.drone).collect()
    }

    /// Whether the output shows a drone from 5 s before `begin` on, and until `end`.
    pub(super) fn is_shown(&self, drone: usize, begin: Time, end: Time) -> bool {
        let times = self.points(drone, begin, end).map(|point| point.time);
        times.clone().min().is_some_and(|first| first <= begin)
            && times.max().is_some_and(|last| last >= begin)
    }

    /// Whether the output knows the height of a drone at some time from 5 s before `begin` until `end`.
    pub(super) fn has_height(&self, drone: usize, begin: Time, end: Time) -> bool {
        self.points(drone, begin, end).any(|point| point.has_height)
    }

    /// Points of a drone from 5 s before `begin` until `end`.
    fn points(&self, drone: usize, begin: Time, end: Time) -> impl Iterator<Item = &OwnedPoint> + Clone {
        let from = Time::from_nanos(begin.nanos() - 5 * SECOND);
        let owned =
            move |point: &&OwnedPoint| point.drone == Some(drone) && (from..=end).contains(&point.time);
        self.0.values().flatten().filter(owned)
    }
}
