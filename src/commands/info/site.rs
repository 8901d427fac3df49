//! Configuration from a capture, to be completed by someone who knows the site.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::fmt::Write as _;
use std::fs::OpenOptions;
use std::io::{self, Write as _};
use std::path::Path;

use super::text::{can_locate, classification, edition, inputs};
use crate::commands::Usage;
use input::survey::SensorHint;
use site::config::FILL_IN;

/// A radar's place, if it is known.
#[derive(Clone, Debug)]
pub(in crate::commands) struct RadarPlace {
    /// Keys with their values, one per line.
    pub(in crate::commands) keys: String,
}

/// Places of radars, by SAC and SIC.
pub(in crate::commands) type RadarPlaces = BTreeMap<(u8, u8), RadarPlace>;

/// Refuses an existing file, because it may have been filled in. `option` names the file on the command line.
pub(in crate::commands) fn check(file: &Path, option: &str) -> Result<(), Usage> {
    if file.as_os_str() == "-" {
        return Err(Usage(format!("{option} takes a file: standard output holds the report")));
    }
    if file.exists() {
        let file = file.display();
        return Err(Usage(format!(
            "{option} {file}: the file exists and is not overwritten; name another one"
        )));
    }
    Ok(())
}

/// Writes a configuration of these sensors from these inputs. A sensor that appears in several captures is written once.
///
/// # Errors
/// There is no sensor, or the file cannot be written.
pub(in crate::commands) fn write(
    file: &Path,
    option: &str,
    inputs: &[String],
    sensors: Vec<SensorHint>,
    places: &RadarPlaces,
) -> Result<(), Box<dyn Error + Send + Sync>> {
    let sensors = merged(sensors);
    if sensors.is_empty() {
        let file = file.display();
        return Err(format!(
            "{option} {file}: not written: the input has no sensor that a site can have: no radar (CAT048) and no receiver of transponders \
             (CAT129), ADS-B (CAT021, Beast) or Remote ID"
        )
        .into());
    }
    let text = site(file, inputs, &sensors, places);
    let written = OpenOptions::new().write(true).create_new(true).open(file);
    written.and_then(|mut file| file.write_all(text.as_bytes())).map_err(|error| {
        let file = file.display();
        io::Error::new(error.kind(), format!("{option} {file}: cannot be written: {error}")).into()
    })
}

/// Each sensor once, radars first, as in its first capture, with the inputs of all captures.
fn merged(sensors: Vec<SensorHint>) -> Vec<SensorHint> {
    let mut by_name: BTreeMap<(&str, u8, u8), SensorHint> = BTreeMap::new();
    for sensor in sensors {
        match by_name.get_mut(&(sensor.kind, sensor.sac, sensor.sic)) {
            Some(known) => {
                let inputs: BTreeSet<_> = known.inputs.iter().chain(&sensor.inputs).copied().collect();
                known.inputs = inputs.into_iter().collect();
            }
            None => _ = by_name.insert((sensor.kind, sensor.sac, sensor.sic), sensor),
        }
    }
    by_name.into_values().collect()
}

/// Text of the file. Unknown values are [`FILL_IN`], which the configuration refuses with their lines.
fn site(file: &Path, seen_in: &[String], sensors: &[SensorHint], places: &RadarPlaces) -> String {
    let name = file.file_stem().map_or_else(|| "site".to_owned(), |stem| stem.to_string_lossy().into_owned());
    // A SIC of the same system area that no sensor uses.
    let sac = sensors[0].sac;
    let sic = (1..=u8::MAX).find(|&sic| !sensors.iter().any(|sensor| (sensor.sac, sensor.sic) == (sac, sic)));
    let is_known = |sensor: &SensorHint| places.contains_key(&(sensor.sac, sensor.sic));
    let radars = || sensors.iter().filter(|sensor| sensor.kind == "radar");
    let command = if places.is_empty() { "info" } else { "locate" };
    let advice = if radars().count() > 0 && radars().all(is_known) {
        "# The radars were located from the transponders in it; ± is a standard deviation. Check the result:\n".to_owned()
    } else if places.is_empty() && can_locate(sensors) {
        format!(
            "# Where a radar stands is not in its data. This command finds it from the transponders:\n\
             #   utm-fusion locate {} -o located.toml\n\
             # Or replace each \"{FILL_IN}\", then\n",
            seen_in.join(" ").escape_debug()
        )
    } else {
        format!("# Where a radar stands is not in its data: replace each \"{FILL_IN}\", then\n")
    };
    let mut text = format!(
        "# Made by `utm-fusion {command}` of what is in {}.\n\
         {advice}\
         #   utm-fusion check {}\n\
         # Left off, with their defaults in force: [fusion], [output] (nothing is sent), [state], [alerts], [integrity],\n\
         # [[areas]], and sensors that are neither radars (CAT048) nor transponder receivers (CAT129).\n\
         # config/example.toml explains all keys.\n\n\
         [site]\n\
         name = {}\n\
         sac = {sac}                  # SAC and SIC of what this service sends; change them to those that it has been given\n\
         sic = {}\n",
        seen_in.join(", ").escape_debug(),
        file.display().to_string().escape_debug(),
        toml::Value::from(name),
        sic.unwrap_or(u8::MAX),
    );
    if !sensors.iter().any(|sensor| sensor.kind == "radar") {
        text += &format!(
            "\n# The input has no radar (CAT048), and a configuration needs one: it is the origin of the frame.\n\
             [[sensors]]\nid = \"radar\"\nkind = \"radar\"\nsac = \"{FILL_IN}\"\nsic = \"{FILL_IN}\"\n"
        );
        text += &place();
    }
    for sensor in sensors {
        _ = write!(
            text,
            "\n[[sensors]]\nid = \"{kind}-{sac}-{sic}\"\nkind = \"{kind}\"\nsac = {sac}\nsic = {sic}\n",
            kind = sensor.kind,
            sac = sensor.sac,
            sic = sensor.sic,
        );
        let known = places.get(&(sensor.sac, sensor.sic)).filter(|_| sensor.kind == "radar");
        if let Some(known) = known {
            text += &known.keys;
        } else if sensor.kind == "radar" {
            text += &place();
        }
        if let Some(period_s) = sensor.period_s {
            _ = writeln!(text, "period_s = {period_s:?}");
        }
        let keys = classification(sensor).into_iter().chain(edition(sensor)).chain(inputs(sensor));
        keys.for_each(|key| _ = writeln!(text, "{key}"));
        text += match sensor.kind {
            "radar" if known.is_some() => "",
            "radar" => {
                "# Standard deviations, from the data sheet; usual ones are taken where they are not given:\n\
                 # accuracy = { range_m = …, azimuth_deg = …, height_m = … }\n"
            }
            // These sensors state the accuracy of each report.
            "adsb" | "remote-id" => "",
            _ => {
                "# Standard deviations, from the data sheet; usual ones are taken where they are not given:\n\
                 # accuracy = { horizontal_m = …, vertical_m = … }\n"
            }
        };
    }
    text += "\n# Map and API, for this machine only.\n[http]\nlisten = \"127.0.0.1:8080\"\n";
    text
}

/// Keys of a radar's position.
fn place() -> String {
    format!(
        "latitude_deg = \"{FILL_IN}\"      # WGS-84, north positive\n\
         longitude_deg = \"{FILL_IN}\"     # east positive\n\
         height_amsl_m = \"{FILL_IN}\"     # of the antenna, above mean sea level\n"
    )
}
