//! `registration.json`: the misalignment of each radar as its tracks have shown it, with the radar's configuration at the
//! time, and what was learnt of its errors; and what was learnt of each type of transponders.
//!
//! ```json
//! {"version":1,"radars":{
//! "north":{"latitude_deg":60.1,"longitude_deg":10.5,"height_amsl_m":210.0,"bearing_correction_deg":0.0,"state":{},"learning":{}}
//! },"transponders":{"sensors":["north","drone-it"],"types":[
//! {"version":1,"receiver":1}
//! ]}}
//! ```
//!
//! The file of a recording (`<name>.registration.json`) is the same.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use tracing::warn;

use super::read;
use crate::config::{Config, Radar, Registration as Mode, SensorKind};
use fusion::Engine;
use fusion::SensorIndex;
use fusion::learning::{LearningState, TypeState};
use fusion::registration::{Registration, RegistrationState};
use fusion::time::{SECOND, Time};

/// The file's name in the directory of `[state]`.
pub const REGISTRATION: &str = "registration.json";
/// The only version so far.
const VERSION: u32 = 1;
/// Positions and corrections that differ by less are the same, degrees and metres: text is not exact to the last bit.
const SAME: f64 = 1e-9;
/// Largest number that is written; what follows from larger ones may be no number.
const LARGEST: f64 = 1e30;
/// Most tracks that are written one by one.
const TRACKS: usize = 32;
/// Most that the clock may have been ahead, nanoseconds.
const AHEAD_NS: i64 = 60 * SECOND;

/// The registration of each radar, by the sensor's id, and what is known of transponders.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Registrations {
    radars: BTreeMap<String, Entry>,
    transponders: Transponders,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Contents {
    version: u32,
    radars: BTreeMap<String, Entry>,
    /// Files of before it was learnt have none.
    #[serde(default)]
    transponders: Transponders,
}

/// What was learnt of each type of transponders.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Transponders {
    /// The sensors' ids, by the numbers that the states have for them.
    sensors: Vec<String>,
    /// Checked when they are restored, one by one.
    types: Vec<Value>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Entry {
    #[serde(flatten)]
    setup: Setup,
    /// Checked when it is restored: one radar's may be wrong and another's right.
    state: Value,
    /// The same; files of before it was learnt have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    learning: Option<Value>,
}

/// What the configuration says of a radar, and what the registration is relative to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Setup {
    latitude_deg: f64,
    longitude_deg: f64,
    height_amsl_m: f64,
    bearing_correction_deg: f64,
}

impl Setup {
    fn of(radar: &Radar) -> Self {
        let &Radar { latitude_deg, longitude_deg, height_amsl_m, bearing_correction_deg, .. } = radar;
        Self { latitude_deg, longitude_deg, height_amsl_m, bearing_correction_deg }
    }

    /// What differs, for people.
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

impl Registrations {
    /// What the engine knows of the configured radars.
    pub fn of(config: &Config, engine: &Engine) -> Self {
        let entry = |(index, registered): (SensorIndex, &fusion::operational::Registered)| {
            let sensor = config.sensors.get(usize::from(index.0))?;
            let SensorKind::Radar(radar) = &sensor.kind else { return None };
            let state = serde_json::to_value(registered.to_state()).expect("numbers and text are JSON");
            let learning =
                serde_json::to_value(registered.learning_state()).expect("numbers and text are JSON");
            let learning = radar.learn_accuracy.then_some(learning);
            Some((sensor.id.clone(), Entry { setup: Setup::of(radar), state, learning }))
        };
        let json = |state| serde_json::to_value(state).expect("numbers and text are JSON");
        let transponders = Transponders {
            sensors: config.sensors.iter().map(|sensor| sensor.id.clone()).collect(),
            types: engine.type_states().iter().map(json).collect(),
        };
        Self { radars: engine.registered().filter_map(entry).collect(), transponders }
    }

    /// The number of radars of which something is known.
    pub fn len(&self) -> usize {
        self.radars.len()
    }

    /// Whether nothing is known of any radar.
    pub fn is_empty(&self) -> bool {
        self.radars.is_empty()
    }

    /// Gives the engine what fits its radars. Each radar whose registration does not is logged and returned, with the
    /// reason. What is later than `now`, where that is given, was written while the clock was wrong: nothing that comes
    /// would count beside it.
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
            // One that is not configured to learn is not worth a word.
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

impl Transponders {
    /// One type; without what radars have shown of its delay whose registration is not `kept`, since that is relative to it, and
    /// not at all where its receiver is no more.
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

/// Whether that was written before `now`, as far as clocks agree.
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

impl Entry {
    /// What was learnt of a radar that is registered.
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
        if let Some(changed) = self.setup.changed(&Setup::of(radar)) {
            return Err(changed);
        }
        let state = RegistrationState::deserialize(&self.state).map_err(|error| error.to_string())?;
        plausible(&self.state, now)?;
        // Also what only looks like a state must not reach the engine.
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
        // The reference profile has no use for it, which is not worth a word.
        engine.restore(index, &state).map(drop).map_err(|error| error.to_string())
    }
}

/// Whether times and numbers are such as are written.
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

/// Whether that is so of any text in it.
fn is_any(value: &Value, so: &dyn Fn(&str) -> bool) -> bool {
    match value {
        Value::String(text) => so(text),
        Value::Array(values) => values.iter().any(|value| is_any(value, so)),
        Value::Object(fields) => fields.values().any(|value| is_any(value, so)),
        _ => false,
    }
}

/// The text of a file with these, one radar or type of transponders per line.
pub fn registration_text(registrations: &Registrations) -> String {
    let line = |(id, entry): (&String, &Entry)| {
        let entry = serde_json::to_string(entry).expect("numbers and text are JSON");
        format!("{}:{entry}", Value::from(id.as_str()))
    };
    let radars: Vec<String> = registrations.radars.iter().map(line).collect();
    let Transponders { sensors, types } = &registrations.transponders;
    let types: Vec<String> = types.iter().map(Value::to_string).collect();
    format!(
        "{{\"version\":{VERSION},\"radars\":{{\n{}\n}},\"transponders\":{{\"sensors\":{},\"types\":[\n{}\n]}}}}\n",
        radars.join(",\n"),
        Value::from(sensors.as_slice()),
        types.join(",\n")
    )
}

/// What a file's text holds.
///
/// # Errors
/// What is wrong with it, for people: it is not JSON, or of another version.
pub fn parse_registration(text: &str) -> Result<Registrations, String> {
    let value: Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
    // Before all else: another version may look otherwise.
    if let Some(version) = value["version"].as_u64().filter(|&version| version != u64::from(VERSION)) {
        return Err(format!("its version is {version}, and only {VERSION} is known"));
    }
    let contents = Contents::deserialize(value).map_err(|error| error.to_string())?;
    Ok(Registrations { radars: contents.radars, transponders: contents.transponders })
}

/// Reads such a file.
///
/// # Errors
/// It cannot be read (also where it does not exist), or not be understood; the error names it.
pub fn read_registration(path: &Path) -> io::Result<Registrations> {
    read(path, parse_registration)
}
