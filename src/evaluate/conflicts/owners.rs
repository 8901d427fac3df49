//! Which drones the tracks of a pair are.

use std::collections::BTreeMap;

use crate::evaluate::labels::Labels;
use crate::evaluate::owner::{self, Owner, PointKind};
use crate::evaluate::truth::Truth;
use crate::evaluate::types::OutputPoint;
use fusion::slots::SlotGrid;
use fusion::time::{SECOND, Time};

/// A point so near in time says whose track it is, nanoseconds: the picture that waits has no point ahead of its slot, and
/// one of now is ahead of the last of them.
const NEAR_NS: u64 = 7 * SECOND as u64;

/// The drones of each number, by time.
pub(super) struct Owners(BTreeMap<u32, Vec<(Time, Option<usize>)>>);

impl Owners {
    pub(super) fn of(truth: &Truth, labels: &Labels, output: &[OutputPoint], grid: SlotGrid) -> Self {
        let mut owners = owner::Owners::new(truth, Some(labels), grid, PointKind::Output);
        let mut by_number: BTreeMap<u32, Vec<(Time, Option<usize>)>> = BTreeMap::new();
        for point in output {
            let drone = match owners.find(point).owner {
                Owner::Drone(drone) => Some(drone),
                Owner::Nobody | Owner::Untold => None,
            };
            by_number.entry(point.number).or_default().push((point.time, drone));
        }
        by_number.values_mut().for_each(|points| points.sort_by_key(|point| point.0));
        Self(by_number)
    }

    /// The drones of two tracks, the lower index first; `None`: one of them is none, or both are the same.
    pub(super) fn pair(&self, numbers: [u32; 2], at: Time) -> Option<[usize; 2]> {
        let [a, b] = numbers.map(|number| self.drone(number, at));
        let (a, b) = (a?, b?);
        (a != b).then(|| [a.min(b), a.max(b)])
    }

    /// Whose the point is that is nearest in time.
    fn drone(&self, number: u32, at: Time) -> Option<usize> {
        let points = self.0.get(&number)?;
        let next = points.partition_point(|point| point.0 < at);
        let around = points[next.saturating_sub(1)..].iter().take(2);
        let away = |point: &(Time, Option<usize>)| point.0.nanos().abs_diff(at.nanos());
        around.min_by_key(|point| away(point)).filter(|point| away(point) <= NEAR_NS)?.1
    }
}
