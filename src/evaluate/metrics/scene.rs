//! The points of one stream by drone, and the slots in which each input has the drone.

use std::collections::{BTreeMap, BTreeSet};

use crate::evaluate::counted::Counted;
use crate::evaluate::judged::Judged;
use fusion::slots::Slot;

/// The counted points of one stream.
pub(in crate::evaluate) struct Scene<'a> {
    /// Per drone, by time and then in order of emission.
    pub(in crate::evaluate) drones: Vec<Vec<&'a Judged<'a>>>,
    /// Of no drone.
    pub(in crate::evaluate) nobody: Vec<&'a Judged<'a>>,
    pub(in crate::evaluate) counted: &'a Counted,
    /// `None` without a capture.
    pub(in crate::evaluate) inputs: Option<&'a Inputs>,
}

/// The slots in which each input has each drone.
pub(in crate::evaluate) struct Inputs {
    /// Per drone: slots in which its transponder interpolates.
    pub(in crate::evaluate) covered: Vec<BTreeSet<Slot>>,
    /// Per drone: slots with a plot of it whose track is not seduced.
    pub(in crate::evaluate) detected: Vec<BTreeSet<Slot>>,
    /// Per drone: how many radars have a plot of it whose track is not seduced, in the slots where any has.
    pub(in crate::evaluate) radars: Vec<BTreeMap<Slot, usize>>,
    /// Per drone: whether it carries a transponder.
    pub(in crate::evaluate) equipped: Vec<bool>,
}

impl<'a> Scene<'a> {
    pub(in crate::evaluate) fn new(
        judged: &'a [Judged<'a>],
        drones: usize,
        counted: &'a Counted,
        inputs: Option<&'a Inputs>,
    ) -> Self {
        let mut scene = Self { drones: vec![Vec::new(); drones], nobody: Vec::new(), counted, inputs };
        for judged in judged {
            match judged.drone {
                Some(drone) => scene.drones[drone].push(judged),
                None => scene.nobody.push(judged),
            }
        }
        for points in &mut scene.drones {
            points.sort_by_key(|judged| judged.point.time); // stable: order of emission
        }
        scene
    }

    /// The points of these drones.
    pub(in crate::evaluate) fn points<'s>(
        &'s self,
        group: &'s [usize],
    ) -> impl Iterator<Item = &'a Judged<'a>> + 's {
        group.iter().flat_map(|&drone| self.drones[drone].iter().copied())
    }
}

impl Inputs {
    /// Per drone, the slots of the points that pass.
    pub(in crate::evaluate) fn slots(
        judged: &[Judged<'_>],
        drones: usize,
        passes: impl Fn(&Judged<'_>) -> bool,
    ) -> Vec<BTreeSet<Slot>> {
        let mut slots = vec![BTreeSet::new(); drones];
        for judged in judged.iter().filter(|judged| passes(judged)) {
            if let Some(drone) = judged.drone {
                slots[drone].insert(judged.slot);
            }
        }
        slots
    }

    /// Per drone, how many radars have a plot of it in a slot whose track is not seduced.
    pub(in crate::evaluate) fn radars(plots: &[Judged<'_>], drones: usize) -> Vec<BTreeMap<Slot, usize>> {
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

    /// Whether the drone's transponder interpolates in the slot; `None` for a drone that carries none.
    pub(in crate::evaluate) fn is_covered(&self, drone: usize, slot: Slot) -> Option<bool> {
        self.equipped[drone].then(|| self.covered[drone].contains(&slot))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::{Flags, OutputPoint, Place, PointSource};
    use fusion::time::Time;

    #[test]
    fn radars_count_once_a_slot_and_only_while_they_follow_the_drone() {
        let plot = |sensor: &str| OutputPoint {
            time: Time::default(),
            place: Place { latitude_deg: 0.0, longitude_deg: 0.0, altitude_amsl_m: None },
            source: PointSource::Radar,
            number: 1,
            radar_track: Some(1),
            sensor: Some(sensor.to_owned()),
            transponder: None,
            identity: None,
            covariance: None,
            flags: Flags::default(),
        };
        let (east, west) = (plot("east"), plot("west"));
        let judged = |point, slot, drone, seduced| Judged {
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
            judged(&east, 0, Some(1), false),
            judged(&east, 0, Some(1), false),
            judged(&west, 0, Some(1), false),
            judged(&east, 1, Some(1), false),
            judged(&west, 1, Some(1), true),
            judged(&west, 2, Some(1), true),
            judged(&west, 0, None, false),
        ];
        let radars = Inputs::radars(&plots, 2);
        assert_eq!(radars, [BTreeMap::new(), BTreeMap::from([(Slot(0), 2), (Slot(1), 1)])]);
    }
}
