//! `registration.json`: the misalignment of each radar as estimated from its tracks, with the radar's configuration at the
//! time; its learned errors; and the learned errors of each type of transponders.
//!
//! ```json
//! {"version":1,"radars":{
//! "north":{"latitude_deg":60.1,"longitude_deg":10.5,"height_amsl_m":210.0,"bearing_correction_deg":0.0,"state":{},"learning":{}}
//! },"transponders":{"sensors":["north","drone-it"],"types":[
//! {"version":1,"receiver":1}
//! ]}}
//! ```
//!
//! A recording's file (`<name>.registration.json`) has the same format.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use tracing::warn;

use super::read;
use fusion::Engine;
use fusion::SensorIndex;
use fusion::learning::{LearningState, TypeState};
use fusion::registration::{Registration, RegistrationState};
use fusion::time::{SECOND, Time};
use site::config::{Config, Radar, Registration as Mode, SensorKind};

/// Name of the file in the directory of `[state]`.
pub const REGISTRATION: &str = "registration.json";
/// The only version so far.
const VERSION: u32 = 1;
/// Maximum difference of equal positions and corrections, in degrees and metres: decimal text is not exact to the last bit.
const SAME: f64 = 1e-9;
/// Largest number that is written; calculations with larger ones might overflow.
const LARGEST: f64 = 1e30;
/// Maximum number of tracks that are written individually.
const TRACKS: usize = 32;
/// Maximum time by which the clock may have been ahead, in nanoseconds.
const AHEAD_NS: i64 = 60 * SECOND;

/// Registration of each radar, by the sensor's id, and learned errors of transponders.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SavedRegistrations {
    radars: BTreeMap<String, SavedRadar>,
    transponders: LearnedTransponders,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RegistrationJson {
    version: u32,
    radars: BTreeMap<String, SavedRadar>,
    /// Absent in files of versions without this learning.
    #[serde(default)]
    transponders: LearnedTransponders,
}

/// Learned errors of each type of transponders.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LearnedTransponders {
    /// Ids of the sensors, in the order of the indices in the states.
    sensors: Vec<String>,
    /// Checked on restoration, one by one.
    types: Vec<Value>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct SavedRadar {
    #[serde(flatten)]
    setup: RadarSetup,
    /// Checked on restoration, so that an invalid one does not affect other radars.
    state: Value,
    /// Checked on restoration; absent in files of versions without this learning.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    learning: Option<Value>,
}

/// Configuration of a radar that its registration is relative to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct RadarSetup {
    latitude_deg: f64,
    longitude_deg: f64,
    height_amsl_m: f64,
    bearing_correction_deg: f64,
}

impl RadarSetup {
    fn of(radar: &Radar) -> Self {
        let &Radar { latitude_deg, longitude_deg, height_amsl_m, bearing_correction_deg, .. } = radar;
        Self { latitude_deg, longitude_deg, height_amsl_m, bearing_correction_deg }
    }

    /// Text of the differences.
    fn changed(&self, now: &Self) -> Option<String> {
        let named = |setup: &Self| {
            [
                ("latitude_deg", setup.latitude_deg),
                ("longitude_deg", setup.longitude_deg),
                ("height_amsl_m", setup.height_amsl_m),
                ("bearing_correction_deg", setup.bearing_correction_deg),
            ]
        };
        let differs = |((key, before), (_, now)): ((&str, f64), (&str, f64))| {
            ((before - now).abs() > SAME).then(|| format!("{key} was {before} and is {now}"))
        };
        let all: Vec<String> = named(self).into_iter().zip(named(now)).filter_map(differs).collect();
        (!all.is_empty()).then(|| all.join(", "))
    }
}

impl SavedRegistrations {
    /// Registration and learned errors in the engine.
    pub fn of(config: &Config, engine: &Engine) -> Self {
        let entry = |(index, registered): (SensorIndex, &fusion::operational::Registered)| {
            let sensor = config.sensors.get(usize::from(index.0))?;
            let SensorKind::Radar(radar) = &sensor.kind else { return None };
            let state = serde_json::to_value(registered.to_state()).expect("numbers and text are JSON");
            let learning =
                serde_json::to_value(registered.learning_state()).expect("numbers and text are JSON");
            let learning = radar.learn_accuracy.then_some(learning);
            Some((sensor.id.clone(), SavedRadar { setup: RadarSetup::of(radar), state, learning }))
        };
        let json = |state| serde_json::to_value(state).expect("numbers and text are JSON");
        let transponders = LearnedTransponders {
            sensors: config.sensors.iter().map(|sensor| sensor.id.clone()).collect(),
            types: engine.type_states().iter().map(json).collect(),
        };
        Self { radars: engine.registered().filter_map(entry).collect(), transponders }
    }

    /// Number of radars with a registration.
    pub fn len(&self) -> usize {
        self.radars.len()
    }

    /// Whether there is no registration of any radar.
    pub fn is_empty(&self) -> bool {
        self.radars.is_empty()
    }

    /// Restores the registrations into the engine, where they fit its radars. Each one that does not is logged and
    /// returned, with the reason. A state later than `now`, if given, is rejected: it was written while the clock was
    /// wrong, and would prevail over all new data.
    pub fn restore(&self, config: &Config, now: Option<Time>, engine: &mut Engine) -> Vec<String> {
        let mut unused = Vec::new();
        let mut kept: Vec<&str> = Vec::new();
        for (id, entry) in &self.radars {
            let restored = radar(config, id).and_then(|(index, radar)| {
                entry.restore(index, radar, now, engine)?;
                Ok((index, radar))
            });
            let (index, radar) = match restored {
                Ok(restored) => restored,
                Err(reason) => {
                    warn!(radar = %id, reason, "registration of a radar begins anew");
                    unused.push(reason);
                    continue;
                }
            };
            kept.push(id);
            // Not logged for a radar that is not configured to learn.
            if radar.learn_accuracy
                && let Err(reason) = entry.restore_learning(index, now, engine)
            {
                warn!(radar = %id, reason, "errors of a radar are learnt anew");
                unused.push(reason);
            }
        }
        for state in &self.transponders.types {
            if let Err(reason) = self.transponders.restore(state, &kept, config, now, engine) {
                warn!(reason, "a type of transponders is learnt anew");
                unused.push(reason);
            }
        }
        unused
    }
}

impl LearnedTransponders {
    /// Restores one type. Its delay is relative to the registrations of radars, so contributions of radars whose
    /// registration was not `kept` are left out. A type whose receiver no longer exists is skipped.
    fn restore(
        &self,
        state: &Value,
        kept: &[&str],
        config: &Config,
        now: Option<Time>,
        engine: &mut Engine,
    ) -> Result<(), String> {
        let state = TypeState::deserialize(state).map_err(|error| error.to_string())?;
        is_past(state.time(), now)?;
        let number = |before: SensorIndex| {
            let id = self.sensors.get(usize::from(before.0))?;
            let index = config.sensors.iter().position(|sensor| sensor.id == *id)?;
            let is_radar = matches!(config.sensors[index].kind, SensorKind::Radar(_));
            (!is_radar || kept.contains(&id.as_str())).then_some(SensorIndex(index as u16))
        };
        let Some(state) = state.renumbered(number) else { return Ok(()) };
        engine.restore_type(&state).map(drop).map_err(|error| error.to_string())
    }
}

/// Checks that a state was written before `now`, within the accuracy of clocks.
fn is_past(written: Time, now: Option<Time>) -> Result<(), String> {
    match now.is_some_and(|now| written.nanos() > now.nanos().saturating_add(AHEAD_NS)) {
        true => Err(format!("it is of {written}, which is still to come")),
        false => Ok(()),
    }
}

/// The radar with this id.
fn radar<'a>(config: &'a Config, id: &str) -> Result<(SensorIndex, &'a Radar), String> {
    let found = config.sensors.iter().enumerate().find(|(_, sensor)| sensor.id == id);
    let (index, sensor) = found.ok_or("there is no such sensor any more")?;
    let SensorKind::Radar(radar) = &sensor.kind else { return Err("it is no radar any more".to_owned()) };
    Ok((SensorIndex(index as u16), radar))
}

impl SavedRadar {
    /// Restores the learned errors of a registered radar.
    fn restore_learning(
        &self,
        radar: SensorIndex,
        now: Option<Time>,
        engine: &mut Engine,
    ) -> Result<(), String> {
        let Some(learning) = &self.learning else { return Ok(()) };
        let state = LearningState::deserialize(learning).map_err(|error| error.to_string())?;
        state.time().map_or(Ok(()), |written| is_past(written, now))?;
        engine.restore_learning(radar, &state).map(drop).map_err(|error| error.to_string())
    }

    fn restore(
        &self,
        index: SensorIndex,
        radar: &Radar,
        now: Option<Time>,
        engine: &mut Engine,
    ) -> Result<(), String> {
        if radar.registration == Mode::Off {
            return Err("it is off".to_owned());
        }
        if let Some(changed) = self.setup.changed(&RadarSetup::of(radar)) {
            return Err(changed);
        }
        let state = RegistrationState::deserialize(&self.state).map_err(|error| error.to_string())?;
        plausible(&self.state, now)?;
        // An invalid state must not reach the engine, even if it has the right format.
        let registration = Registration::from_state(&state);
        let estimate = registration.map_err(|error| error.to_string())?.estimate();
        let values = [estimate.bearing, estimate.tilt_east, estimate.tilt_north].into_iter().chain([
            estimate.range_m,
            estimate.height_m,
            estimate.time_s,
        ]);
        let mut numbers = values.flat_map(|value| [value.value, value.deviation]);
        let is_one = numbers.all(f64::is_finite) && (0.0..=LARGEST).contains(&estimate.samples);
        if !is_one {
            return Err("nothing follows from its numbers".to_owned());
        }
        // The reference profile does not use it; that is not logged.
        engine.restore(index, &state).map(drop).map_err(|error| error.to_string())
    }
}

/// Checks that times and numbers are within the range that is written.
fn plausible(state: &Value, now: Option<Time>) -> Result<(), String> {
    let latest = state["latest"].as_array().map_or(&[][..], Vec::as_slice);
    if latest.len() > TRACKS {
        return Err(format!("it has {} tracks, and {TRACKS} is the most", latest.len()));
    }
    let time = |value: &Value| value.as_i64().unwrap_or(i64::MIN);
    let written = time(&state["now"]);
    is_past(Time::from_nanos(written), now)?;
    if latest.iter().any(|track| time(&track["time"]) > written || time(&track["begun"]) > written) {
        return Err("it has tracks that are later than itself".to_owned());
    }
    if is_any(state, &|text| text.split_whitespace().any(is_too_large)) {
        return Err(format!("it has numbers beyond {LARGEST:e}"));
    }
    Ok(())
}

fn is_too_large(number: &str) -> bool {
    number.parse::<f64>().is_ok_and(|number| !(-LARGEST..=LARGEST).contains(&number))
}

/// Whether `so` returns `true` for any text in the value.
fn is_any(value: &Value, so: &dyn Fn(&str) -> bool) -> bool {
    match value {
        Value::String(text) => so(text),
        Value::Array(values) => values.iter().any(|value| is_any(value, so)),
        Value::Object(fields) => fields.values().any(|value| is_any(value, so)),
        _ => false,
    }
}

/// Text of a file with these registrations, one radar or type of transponders per line.
pub fn registration_text(registrations: &SavedRegistrations) -> String {
    let line = |(id, entry): (&String, &SavedRadar)| {
        let entry = serde_json::to_string(entry).expect("numbers and text are JSON");
        format!("{}:{entry}", Value::from(id.as_str()))
    };
    let radars: Vec<String> = registrations.radars.iter().map(line).collect();
    let LearnedTransponders { sensors, types } = &registrations.transponders;
    let types: Vec<String> = types.iter().map(Value::to_string).collect();
    format!(
        "{{\"version\":{VERSION},\"radars\":{{\n{}\n}},\"transponders\":{{\"sensors\":{},\"types\":[\n{}\n]}}}}\n",
        radars.join(",\n"),
        Value::from(sensors.as_slice()),
        types.join(",\n")
    )
}

/// Registrations in a file's text.
///
/// # Errors
/// What is wrong with the text: it is not JSON, or of another version.
pub fn parse_registration(text: &str) -> Result<SavedRegistrations, String> {
    let value: Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
    // Checked first, because another version may have another format.
    if let Some(version) = value["version"].as_u64().filter(|&version| version != u64::from(VERSION)) {
        return Err(format!("its version is {version}, and only {VERSION} is known"));
    }
    let contents = RegistrationJson::deserialize(value).map_err(|error| error.to_string())?;
    Ok(SavedRegistrations { radars: contents.radars, transponders: contents.transponders })
}

/// Reads such a file.
///
/// # Errors
/// The file cannot be read (or does not exist), or is invalid; the error names it.
pub fn read_registration(path: &Path) -> io::Result<SavedRegistrations> {
    read(path, parse_registration)
}
