//! What is learnt of a sensor is learnt in one cell, its home, and used in all: two that correct a radar's plots otherwise would
//! not see the same aircraft. Every cell tells the home of a radar which tracks of the radar in the cell are drones and which are
//! not, so that the home knows of as many as one engine over all cells would.

use std::collections::BTreeMap;

use super::Region;
use super::letter::Word;
use crate::cluster::cells::reach_m;
use crate::config::{Config, SensorKind};
use crate::territory::CellName;
use fusion::frames::{Geodetic, TangentPlane};
use fusion::operational::LabelledTrack;
use fusion::slots::Slot;
use fusion::{Engine, SensorIndex};

/// Slots between two letters about a sensor: 10 s, in which a radar track contributes once.
const EVERY: i64 = 40;
/// What was learnt is used so many slots later, everywhere.
const LATER: i64 = 16;

/// Tells other cells about sensors.
#[derive(Clone, Debug, Default)]
pub(crate) struct Teaching {
    region: Option<Region>,
    /// The home of each radar.
    homes: BTreeMap<SensorIndex, CellName>,
    /// The sensors of which this cell is the home.
    subjects: Vec<Subject>,
}

#[derive(Clone, Debug, PartialEq)]
struct Subject {
    /// `None`: the transponders.
    radar: Option<SensorIndex>,
    others: Vec<CellName>,
}

impl Teaching {
    /// Of the radars whose home it is; the cell that is home to the first of them, else the first one, of the transponders as
    /// well.
    pub(crate) fn new(config: &Config, region: &Region) -> Self {
        let radars = config.sensors.iter().enumerate().filter_map(|(index, sensor)| match &sensor.kind {
            SensorKind::Radar(radar) => {
                let place = Geodetic::from_degrees(radar.latitude_deg, radar.longitude_deg, 0.0);
                Some((SensorIndex(index as u16), (place, reach_m(radar))))
            }
            _ => None,
        });
        let home = |place| region.territory.home(place, &region.cells);
        let others = |is_near: &dyn Fn(&CellName) -> bool| {
            let others = region.cells.iter().filter(|cell| **cell != region.cell && is_near(cell));
            others.cloned().collect()
        };
        let radars: Vec<(SensorIndex, (Geodetic, f64))> = radars.collect();
        let first =
            radars.first().map_or_else(|| region.cells.first().cloned(), |(_, (place, _))| home(*place));
        let homes: BTreeMap<SensorIndex, CellName> =
            radars.iter().filter_map(|&(sensor, (place, _))| Some((sensor, home(place)?))).collect();
        let own = radars.iter().filter(|(sensor, _)| homes.get(sensor) == Some(&region.cell));
        let mut subjects: Vec<Subject> = own
            .map(|&(sensor, (place, reach_m))| {
                let within_m = reach_m + region.halo_m;
                let is_near = |cell: &CellName| {
                    region.territory.outline(cell).is_some_and(|cell| cell.is_within(place, within_m))
                };
                Subject { radar: Some(sensor), others: others(&is_near) }
            })
            .collect();
        if first.as_ref() == Some(&region.cell) {
            subjects.push(Subject { radar: None, others: others(&|_| true) });
        }
        Self { region: Some(region.clone()), homes, subjects }
    }

    /// The tracks of radars that were labelled in this cell: what is for the homes in other cells.
    fn labelled(&self, region: &Region, frame: &TangentPlane, engine: &mut Engine) -> Vec<(CellName, Word)> {
        let mut by_home = BTreeMap::<&CellName, Vec<LabelledTrack>>::new();
        for track in engine.take_labelled() {
            // The cell that contains a track of the halo sends it.
            let is_here = region.contains(frame.to_geodetic(track.position));
            match self.homes.get(&track.radar).filter(|_| is_here) {
                Some(home) if *home == region.cell => engine.count_labelled(&track),
                Some(home) => by_home.entry(home).or_default().push(track),
                None => {}
            }
        }
        by_home.into_iter().map(|(home, tracks)| (home.clone(), Word::Labelled(tracks))).collect()
    }

    /// The letters of a slot; the engine itself uses their values from the same slot on.
    pub(crate) fn turn(
        &self,
        slot: Slot,
        frame: &TangentPlane,
        engine: &mut Engine,
    ) -> Vec<(CellName, Word)> {
        let Some(region) = self.region.as_ref().filter(|_| slot.0.rem_euclid(EVERY) == 0) else {
            return Vec::new();
        };
        let mut words = self.labelled(region, frame, engine);
        let from = slot.plus(LATER);
        for Subject { radar, others } in &self.subjects {
            let Some(values) = engine.learnt_values(*radar) else { continue };
            let values = Box::new(values);
            words.extend(others.iter().map(|to| (to.clone(), Word::Values { from, values: values.clone() })));
            engine.use_values(from, *values);
        }
        words
    }
}
