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
pub(super) struct TrackOwners(BTreeMap<u32, Vec<(Time, Option<usize>)>>);

impl TrackOwners {
    pub(super) fn of(truth: &Truth, labels: &Labels, output: &[OutputPoint], grid: SlotGrid) -> Self {
        let mut owners = point_owner::PointOwners::new(truth, Some(labels), grid, PointKind::Output);
        let mut by_number: BTreeMap<u32, Vec<(Time, Option<usize>)>> = BTreeMap::new();
        for point in output {
            let drone = match owners.find(point).owner {
                PointOwner::Drone(drone) => Some(drone),
                PointOwner::NoDrone | PointOwner::UnknownPosition => None,
            };
            by_number.entry(point.number).or_default().push((point.time, drone));
        }
        by_number.values_mut().for_each(|points| points.sort_by_key(|point| point.0));
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
        let next = points.partition_point(|point| point.0 < at);
        let around = points[next.saturating_sub(1)..].iter().take(2);
        let away = |point: &(Time, Option<usize>)| point.0.nanos().abs_diff(at.nanos());
        around.min_by_key(|point| away(point)).filter(|point| away(point) <= NEAR_NS)?.1
    }

    /// The drones of the points from one time until another, and of those at most 7 s away.
    pub(super) fn drones(&self, number: u32, from: Time, until: Time) -> BTreeSet<usize> {
        let near = from.nanos() - NEAR_NS as i64..=until.nanos() + NEAR_NS as i64;
        let points = self.0.get(&number).into_iter().flatten();
        points.filter(|(time, _)| near.contains(&time.nanos())).filter_map(|(_, drone)| *drone).collect()
    }

    /// Whether the output shows a drone from 5 s before `begin` on, and until `end`.
    pub(super) fn is_shown(&self, drone: usize, begin: Time, end: Time) -> bool {
        let from = Time::from_nanos(begin.nanos() - 5 * SECOND);
        let shown = self
            .0
            .values()
            .flatten()
            .filter(|(time, owner)| *owner == Some(drone) && (from..=end).contains(time));
        let times = shown.map(|(time, _)| *time);
        times.clone().min().is_some_and(|first| first <= begin)
            && times.max().is_some_and(|last| last >= begin)
    }
}
