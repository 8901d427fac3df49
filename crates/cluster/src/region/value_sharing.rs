//! Sharing of learned sensor values. Each sensor is learned in one cell, its home, and its values are used in all cells: two
//! cells with different corrections of a radar would see different aircraft. Every cell sends its labelled tracks of a radar to
//! the radar's home. The home therefore learns from as many tracks as a single engine for all cells.

use std::collections::BTreeMap;

use super::Region;
use super::cell_message::CellMessageContent;
use fusion::frames::{Geodetic, TangentPlane};
use fusion::operational::LabelledTrack;
use fusion::slots::Slot;
use fusion::{Engine, SensorIndex};
use site::config::{Config, Radar, SensorKind};
use site::territory::CellName;

/// Assumed range of a radar without a configured range, in metres.
pub(crate) const DEFAULT_REACH_M: f64 = 20_000.0;
/// Interval of the messages about a sensor, in slots (10 s). A radar track contributes once in it.
const INTERVAL_SLOTS: i64 = 40;
/// Delay until learned values are used in all cells, in slots.
const DELAY_SLOTS: i64 = 16;

/// Range of a radar, in metres: the configured one, else an assumed one.
pub(crate) fn reach_m(radar: &Radar) -> f64 {
    radar.max_range_m.unwrap_or(DEFAULT_REACH_M)
}

/// Sends learned sensor values to other cells.
#[derive(Clone, Debug, Default)]
pub(crate) struct ValueSharing {
    region: Option<Region>,
    /// Home cell of each radar.
    homes: BTreeMap<SensorIndex, CellName>,
    /// Sensors whose home is this cell.
    sensors: Vec<SharedSensor>,
}

#[derive(Clone, Debug, PartialEq)]
struct SharedSensor {
    /// The radar; `None` for the transponders.
    radar: Option<SensorIndex>,
    others: Vec<CellName>,
}

impl ValueSharing {
    /// Creates the sharing for the radars whose home is this cell. The home of the first radar, else the first cell, is also the
    /// home of the transponders.
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
        let mut sensors: Vec<SharedSensor> = own
            .map(|&(sensor, (place, reach_m))| {
                let within_m = reach_m + region.halo_m;
                let is_near = |cell: &CellName| {
                    region.territory.outline(cell).is_some_and(|cell| cell.is_within(place, within_m))
                };
                SharedSensor { radar: Some(sensor), others: others(&is_near) }
            })
            .collect();
        if first.as_ref() == Some(&region.cell) {
            sensors.push(SharedSensor { radar: None, others: others(&|_| true) });
        }
        Self { region: Some(region.clone()), homes, sensors }
    }

    /// Radar tracks labelled in this cell, as messages to their homes in other cells.
    fn labelled_messages(
        &self,
        region: &Region,
        frame: &TangentPlane,
        engine: &mut Engine,
    ) -> Vec<(CellName, CellMessageContent)> {
        let mut by_home = BTreeMap::<&CellName, Vec<LabelledTrack>>::new();
        for track in engine.take_labelled() {
            // The cell that contains a track sends it; cells that see it in their halo do not.
            let is_here = region.contains(frame.to_geodetic(track.position));
            match self.homes.get(&track.radar).filter(|_| is_here) {
                Some(home) if *home == region.cell => engine.count_labelled(&track),
                Some(home) => by_home.entry(home).or_default().push(track),
                None => {}
            }
        }
        by_home
            .into_iter()
            .map(|(home, tracks)| (home.clone(), CellMessageContent::Labelled(tracks)))
            .collect()
    }

    /// Messages of a slot. The engine uses their values from the same slot on as the recipients.
    pub(crate) fn exchange(
        &self,
        slot: Slot,
        frame: &TangentPlane,
        engine: &mut Engine,
    ) -> Vec<(CellName, CellMessageContent)> {
        let Some(region) = self.region.as_ref().filter(|_| slot.0.rem_euclid(INTERVAL_SLOTS) == 0) else {
            return Vec::new();
        };
        let mut outgoing = self.labelled_messages(region, frame, engine);
        let from = slot.plus(DELAY_SLOTS);
        for SharedSensor { radar, others } in &self.sensors {
            let Some(values) = engine.learnt_values(*radar) else { continue };
            let values = Box::new(values);
            outgoing.extend(
                others
                    .iter()
                    .map(|to| (to.clone(), CellMessageContent::Values { from, values: values.clone() })),
            );
            engine.use_values(from, *values);
        }
        outgoing
    }
}
