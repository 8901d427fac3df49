//! Lines of `decisions.jsonl` about radars that operators moved to where their tracks show them.
//!
//! ```json
//! {"relocated":"north","slot":7180675221,"time":"2026-11-20T10:05:05.125Z","from":{"latitude_deg":60.1,"longitude_deg":10.5,"bearing_correction_deg":0.0},"to":{"east_m":-20.4,"north_m":23.0,"bearing_deg":0.3}}
//! ```
//!
//! Without `to` the configured position holds again. `from` is the configured position: once it was changed, the line is ignored.

use serde::{Deserialize, Serialize};
use tracing::warn;

use fusion::SensorIndex;
use fusion::operational::{ActiveRelocation, RadarRelocation, Relocation};
use fusion::slots::{Slot, SlotGrid};
use site::config::{Config, Radar};

/// Maximum difference of equal configured values, degrees.
const SAME_DEG: f64 = 1e-9;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RelocationLine {
    relocated: String,
    pub(super) slot: i64,
    #[serde(default)]
    time: String,
    from: ConfiguredPlace,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    to: Option<RelocationJson>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ConfiguredPlace {
    latitude_deg: f64,
    longitude_deg: f64,
    bearing_correction_deg: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RelocationJson {
    east_m: f64,
    north_m: f64,
    bearing_deg: f64,
}

impl ConfiguredPlace {
    fn of(radar: &Radar) -> Self {
        let &Radar { latitude_deg, longitude_deg, bearing_correction_deg, .. } = radar;
        Self { latitude_deg, longitude_deg, bearing_correction_deg }
    }

    fn is(&self, other: &Self) -> bool {
        let values = |place: &Self| [place.latitude_deg, place.longitude_deg, place.bearing_correction_deg];
        values(self).iter().zip(values(other)).all(|(one, other)| (one - other).abs() <= SAME_DEG)
    }
}

/// Line of a relocation from this slot on, with its line feed; empty if the sensor is no radar of the configuration.
pub fn relocation_line(slot: Slot, decided: &RadarRelocation, config: &Config) -> String {
    let sensor = config.sensors.get(usize::from(decided.radar.0));
    let Some((sensor, radar)) = sensor.and_then(|sensor| Some((sensor, sensor.kind.radar()?))) else {
        return String::new();
    };
    let line = RelocationLine {
        relocated: sensor.id.clone(),
        slot: slot.0,
        time: SlotGrid::new(config.fusion.slot).centre(slot).to_string(),
        from: ConfiguredPlace::of(radar),
        to: decided.to.map(|Relocation { east_m, north_m, bearing }| RelocationJson {
            east_m,
            north_m,
            bearing_deg: bearing.to_degrees(),
        }),
    };
    serde_json::to_string(&line).expect("numbers and text are JSON") + "\n"
}

/// Lines of the relocations in force.
pub fn relocation_lines(active: &[ActiveRelocation], config: &Config) -> String {
    let line = |&ActiveRelocation { radar, to, since }: &ActiveRelocation| {
        relocation_line(since, &RadarRelocation { radar, to: Some(to) }, config)
    };
    active.iter().map(line).collect()
}

/// The relocation in a line; `None` if the line is about something else.
pub(super) fn parse_relocation(line: &str) -> Result<Option<RelocationLine>, String> {
    let value: serde_json::Value = serde_json::from_str(line).map_err(|error| error.to_string())?;
    if value.get("relocated").is_none() {
        return Ok(None);
    }
    let line: RelocationLine = serde_json::from_value(value).map_err(|error| error.to_string())?;
    match line.to.map(RelocationJson::relocation) {
        Some(to) if !to.is_plausible() => {
            Err("a radar is moved by at most 10 km and turned by at most 180°".to_owned())
        }
        _ => Ok(Some(line)),
    }
}

impl RelocationJson {
    fn relocation(self) -> Relocation {
        let Self { east_m, north_m, bearing_deg } = self;
        Relocation { east_m, north_m, bearing: bearing_deg.to_radians() }
    }
}

impl RelocationLine {
    /// The decision for an engine of this configuration; `None`, and a line in the log, if it does not apply to it.
    pub(super) fn decided(&self, config: &Config) -> Option<(Slot, RadarRelocation)> {
        let (time, radar) = (&self.time, &self.relocated);
        let named = config.sensors.iter().enumerate().find(|(_, sensor)| sensor.id == *radar);
        let Some((index, configured)) = named.and_then(|(index, sensor)| Some((index, sensor.kind.radar()?)))
        else {
            warn!(decided = time, radar, "relocation is not used: there is no such radar");
            return None;
        };
        if !self.from.is(&ConfiguredPlace::of(configured)) {
            warn!(
                decided = time,
                radar, "relocation is not used: the radar's configured position was changed since"
            );
            return None;
        }
        let to = self.to.map(RelocationJson::relocation);
        Some((Slot(self.slot), RadarRelocation { radar: SensorIndex(index as u16), to }))
    }
}
