//! Points of one stream by drone, and the slots in which each input has the drone.

use std::collections::{BTreeMap, BTreeSet};

use crate::evaluate::counted_slots::CountedSlots;
use crate::evaluate::scored_point::ScoredPoint;
use fusion::slots::Slot;

/// The counted points of one stream.
pub(in crate::evaluate) struct StreamScene<'a> {
    /// Points per drone, by time and then in order of emission.
    pub(in crate::evaluate) drones: Vec<Vec<&'a ScoredPoint<'a>>>,
    /// Points of no drone.
    pub(in crate::evaluate) without_drone: Vec<&'a ScoredPoint<'a>>,
    pub(in crate::evaluate) counted: &'a CountedSlots,
    /// Presence of the inputs; `None` without a capture.
    pub(in crate::evaluate) inputs: Option<&'a InputSlots>,
}

/// Slots in which each input has each drone.
pub(in crate::evaluate) struct InputSlots {
    /// Per drone: slots in which its transponder interpolates.
    pub(in crate::evaluate) covered: Vec<BTreeSet<Slot>>,
    /// Per drone: slots with a plot of it whose track is not seduced.
    pub(in crate::evaluate) detected: Vec<BTreeSet<Slot>>,
    /// Per drone and slot: number of radars with a plot of it whose track is not seduced; slots without any are
    /// missing.
    pub(in crate::evaluate) radars: Vec<BTreeMap<Slot, usize>>,
    /// Per drone: whether it carries a transponder.
    pub(in crate::evaluate) equipped: Vec<bool>,
}

impl<'a> StreamScene<'a> {
    pub(in crate::evaluate) fn new(
        scored_point: &'a [ScoredPoint<'a>],
        drones: usize,
        counted: &'a CountedSlots,
        inputs: Option<&'a InputSlots>,
    ) -> Self {
        let mut scene = Self { drones: vec![Vec::new(); drones], without_drone: Vec::new(), counted, inputs };
        for scored_point in scored_point {
            match scored_point.drone {
                Some(drone) => scene.drones[drone].push(scored_point),
                None => scene.without_drone.push(scored_point),
            }
        }
        for points in &mut scene.drones {
            points.sort_by_key(|scored_point| scored_point.point.time); // stable: order of emission
        }
        scene
    }

    /// Points of these drones.
    pub(in crate::evaluate) fn points<'s>(
        &'s self,
        group: &'s [usize],
    ) -> impl Iterator<Item = &'a ScoredPoint<'a>> + 's {
        group.iter().flat_map(|&drone| self.drones[drone].iter().copied())
    }
}

impl InputSlots {
    /// Per drone: slots of the points that pass `passes`.
    pub(in crate::evaluate) fn slots(
        scored_point: &[ScoredPoint<'_>],
        drones: usize,
        passes: impl Fn(&ScoredPoint<'_>) -> bool,
    ) -> Vec<BTreeSet<Slot>> {
        let mut slots = vec![BTreeSet::new(); drones];
        for scored_point in scored_point.iter().filter(|scored_point| passes(scored_point)) {
            if let Some(drone) = scored_point.drone {
                slots[drone].insert(scored_point.slot);
            }
        }
        slots
    }

    /// Per drone and slot: number of radars with a plot of it whose track is not seduced.
    pub(in crate::evaluate) fn radars(
        plots: &[ScoredPoint<'_>],
        drones: usize,
    ) -> Vec<BTreeMap<Slot, usize>> {
        let mut seeing: BTreeSet<(usize, Slot, Option<&str>)> = BTreeSet::new();
        for plot in plots.iter().filter(|plot| !plot.seduced) {
            seeing.extend(plot.drone.map(|drone| (drone, plot.slot, plot.point.sensor.as_deref())));
        }
        let mut radars = vec![BTreeMap::new(); drones];
        for (drone, slot, _) in seeing {
            *radars[drone].entry(slot).or_default() += 1;
        }
        radars
    }

    /// Whether the drone's transponder interpolates in the slot; `None` for a drone without a transponder.
    pub(in crate::evaluate) fn is_covered(&self, drone: usize, slot: Slot) -> Option<bool> {
        self.equipped[drone].then(|| self.covered[drone].contains(&slot))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::{GeodeticPlace, OutputPoint, PointFlags, PointSource};
    use fusion::time::Time;

    #[test]
    fn radar_counts_once_per_slot_while_it_follows_the_drone() {
        let plot = |sensor: &str| OutputPoint {
            time: Time::default(),
            place: GeodeticPlace { latitude_deg: 0.0, longitude_deg: 0.0, altitude_amsl_m: None },
            source: PointSource::Radar,
            number: 1,
            radar_track: Some(1),
            sensor: Some(sensor.to_owned()),
            transponder: None,
            identity: None,
            covariance: None,
            flags: PointFlags::default(),
        };
        let (east, west) = (plot("east"), plot("west"));
        let scored_point = |point, slot, drone, seduced| ScoredPoint {
            point,
            slot: Slot(slot),
            drone,
            truth: None,
            error: None,
            paired: None,
            seduced,
            state: None,
        };
        let plots = [
            scored_point(&east, 0, Some(1), false),
            scored_point(&east, 0, Some(1), false),
            scored_point(&west, 0, Some(1), false),
            scored_point(&east, 1, Some(1), false),
            scored_point(&west, 1, Some(1), true),
            scored_point(&west, 2, Some(1), true),
            scored_point(&west, 0, None, false),
        ];
        let radars = InputSlots::radars(&plots, 2);
        assert_eq!(radars, [BTreeMap::new(), BTreeMap::from([(Slot(0), 2), (Slot(1), 1)])]);
    }
}
