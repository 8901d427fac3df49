//! Zones that operators have activated. `zones/` in the directory of `[state]` has one GeoJSON file for each:
//!
//! ```json
//! {"type":"FeatureCollection","features":[{"type":"Feature","properties":{"name":"School","ceiling_m":120.0,
//! "activated_by":"tower","activated_at":"2026-11-28T12:00:00.000Z"},"geometry":{"type":"Polygon","coordinates":[…]}}]}
//! ```
//!
//! `floor_m` and `ceiling_m` are in metres above mean sea level, and optional. The file's name is the name of the zone, with
//! octets other than ASCII letters, digits, `-` and `_` as in a URL (`%20`).

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use tracing::error;

use super::atomic::write_atomically;
use super::health::StateHealth;
use fusion::time::Time;
use site::areas::{Areas, Format};
use site::config::{AlertArea, Area, AreaKind};

/// Directory of the files in that of `[state]`.
pub const ZONES: &str = "zones";
/// Maximum number of zones.
pub const MAX_ZONES: usize = 100;
/// Maximum length of a name, in octets. The name of its file, with `.part` or `.damaged-…`, then fits into 255 octets.
pub const MAX_ZONE_NAME: usize = 64;
/// Maximum length of the GeoJSON of a zone, in octets.
const MAX_GEOJSON: usize = 64 * 1024;
/// Maximum length of a file, in octets: the geometry, and the properties that are added.
const MAX_FILE: u64 = MAX_GEOJSON as u64 + 4096;
/// Limits of heights, in metres above mean sea level, as in `[[areas]]`.
const HEIGHTS_M: std::ops::RangeInclusive<f64> = -500.0..=50_000.0;
const EXTENSION: &str = ".geojson";
/// Contents of the files for the log.
const CONTENTS: &str = "zone of an operator";

/// A zone that an operator has activated.
#[derive(Clone, Debug, PartialEq)]
pub struct OperatorZone {
    /// Name of the zone, unique among the zones of operators.
    pub name: String,
    /// Lower limit, in metres above mean sea level; `None`: from the ground up.
    pub floor_m: Option<f64>,
    /// Upper limit, in metres above mean sea level; `None`: no limit.
    pub ceiling_m: Option<f64>,
    /// Name of the operator.
    pub activated_by: String,
    /// Time of the activation.
    pub activated_at: Time,
    /// The zone as an area of kind `alert`.
    pub areas: Areas,
}

/// A request about a zone is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ZoneRefusal {
    /// The name cannot be used.
    #[error(
        "a zone has a name of 1 to {MAX_ZONE_NAME} octets without control characters or spaces around it"
    )]
    Name,
    /// The text is not a zone.
    #[error("{0}")]
    Invalid(String),
    /// No operator has activated a zone of this name.
    #[error("no operator has activated a zone of this name")]
    Unknown,
    /// The maximum number of zones is active.
    #[error("{MAX_ZONES} zones are active, which is the maximum; revoke one first")]
    Full,
    /// The disk is full.
    #[error("the zone is not active, because the disk of the state directory is full")]
    DiskFull,
    /// The file cannot be written or removed.
    #[error("nothing has changed, because the file of the zone cannot be written or removed: {0}")]
    Unwritten(ErrorKind),
}

/// The zones of operators, and their files.
#[derive(Debug)]
pub struct ZoneStore {
    directory: PathBuf,
    health: StateHealth,
    zones: BTreeMap<String, OperatorZone>,
}

impl ZoneStore {
    /// Reads the zones below the directory `state`. A damaged file is set aside and reported; the other zones are not affected.
    pub fn load(state: &Path, health: &StateHealth, now: Time) -> Self {
        let directory = state.join(ZONES);
        let mut store = Self { directory, health: health.clone(), zones: BTreeMap::new() };
        match store.files() {
            Ok(files) => {
                store.zones = files.iter().filter_map(|file| store.read(file, now)).collect();
            }
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) if error.kind() == ErrorKind::NotADirectory => {
                health.set_aside(state, ZONES, "zones of operators", &error, now);
            }
            Err(error) => {
                error!(directory = %store.directory.display(), %error, "zones of operators cannot be read");
                health.note_failure(ZONES, &error);
            }
        }
        store
    }

    /// The zones, by name.
    pub fn zones(&self) -> impl Iterator<Item = &OperatorZone> {
        self.zones.values()
    }

    /// Activates the zone of a GeoJSON text, or replaces the zone of that name. It is on the disk when this returns.
    ///
    /// # Errors
    /// The name or the text cannot be used, there are too many zones, or the file cannot be written; then nothing changes.
    pub fn activate(
        &mut self,
        name: &str,
        geojson: &[u8],
        by: &str,
        now: Time,
    ) -> Result<OperatorZone, ZoneRefusal> {
        if name.is_empty()
            || name.len() > MAX_ZONE_NAME
            || name.trim() != name
            // Browsers take these for parts of a path.
            || matches!(name, "." | "..")
            || name.chars().any(char::is_control)
        {
            return Err(ZoneRefusal::Name);
        }
        let text = file_text(name, geojson, by, now).map_err(ZoneRefusal::Invalid)?;
        // Read from the text that is written, so that a restart restores the same zone.
        let zone = parse(&text).map_err(ZoneRefusal::Invalid)?;
        if self.zones.len() >= MAX_ZONES && !self.zones.contains_key(name) {
            return Err(ZoneRefusal::Full);
        }
        let file = file_name(name);
        self.health.clear_obstacles(&self.directory, &file, CONTENTS, now);
        let path = self.directory.join(&file);
        let written = fs::create_dir_all(&self.directory)
            .and_then(|()| write_atomically(&path, &text))
            .and_then(|()| self.flush());
        written.map_err(|error| {
            error!(file = %path.display(), %error, "zone cannot be written");
            match error.kind() {
                ErrorKind::StorageFull | ErrorKind::QuotaExceeded => ZoneRefusal::DiskFull,
                kind => ZoneRefusal::Unwritten(kind),
            }
        })?;
        self.zones.insert(name.to_owned(), zone.clone());
        Ok(zone)
    }

    /// Revokes a zone and removes its file. Returns the zone.
    ///
    /// # Errors
    /// There is no such zone, or its file cannot be removed; then it stays active.
    pub fn revoke(&mut self, name: &str) -> Result<OperatorZone, ZoneRefusal> {
        if !self.zones.contains_key(name) {
            return Err(ZoneRefusal::Unknown);
        }
        let path = self.directory.join(file_name(name));
        let removed = match fs::remove_file(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
            removed => removed.and_then(|()| self.flush()),
        };
        removed.map_err(|error| {
            error!(file = %path.display(), %error, "zone cannot be removed");
            ZoneRefusal::Unwritten(error.kind())
        })?;
        self.zones.remove(name).ok_or(ZoneRefusal::Unknown)
    }

    /// Names of the files of zones, in order.
    fn files(&self) -> io::Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in fs::read_dir(&self.directory)? {
            names.extend(entry?.file_name().into_string().ok().filter(|name| name.ends_with(EXTENSION)));
        }
        names.sort_unstable();
        Ok(names)
    }

    /// Zone of a file, with its name. A damaged file is set aside.
    fn read(&self, file: &str, now: Time) -> Option<(String, OperatorZone)> {
        self.health.clear_obstacles(&self.directory, file, CONTENTS, now);
        let text = match text_of(&self.directory.join(file)) {
            Err(error) if error.kind() == ErrorKind::NotFound => return None,
            text => text,
        };
        let zone = text.map_err(|error| error.to_string()).and_then(|text| parse(&text));
        match zone.and_then(|zone| expect_name(zone, file)) {
            Ok(zone) => Some((zone.name.clone(), zone)),
            Err(error) => {
                self.health.set_aside(&self.directory, file, CONTENTS, &error, now);
                None
            }
        }
    }

    /// Writes the directory to the disk: a zone that was activated or revoked stays so after a loss of power.
    fn flush(&self) -> io::Result<()> {
        open(&self.directory)?.sync_all()
    }
}

/// A copy of another zone would be an area that no request can revoke.
fn expect_name(zone: OperatorZone, file: &str) -> Result<OperatorZone, String> {
    let expected = file_name(&zone.name);
    if expected == file {
        return Ok(zone);
    }
    Err(format!("the file of the zone {:?} is called {expected}", zone.name))
}

#[expect(clippy::disallowed_methods, reason = "the state is a file")]
fn open(path: &Path) -> io::Result<File> {
    File::open(path)
}

fn text_of(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    open(path)?.take(MAX_FILE + 1).read_to_string(&mut text)?;
    if text.len() as u64 > MAX_FILE {
        return Err(io::Error::new(ErrorKind::InvalidData, format!("larger than {MAX_FILE} octets")));
    }
    Ok(text)
}

fn file_name(name: &str) -> String {
    let mut file = String::new();
    for octet in name.bytes() {
        match octet {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' => file.push(octet.into()),
            // Writing to a text does not fail.
            _ => _ = write!(file, "%{octet:02X}"),
        }
    }
    file + EXTENSION
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ZoneFile {
    r#type: ZoneFileType,
    features: [ZoneFeature; 1],
}

#[derive(Serialize, Deserialize)]
enum ZoneFileType {
    FeatureCollection,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ZoneFeature {
    r#type: ZoneFeatureType,
    properties: ZoneProperties,
    geometry: Value,
}

#[derive(Serialize, Deserialize)]
enum ZoneFeatureType {
    Feature,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ZoneProperties {
    name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    floor_m: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ceiling_m: Option<f64>,
    activated_by: String,
    activated_at: jiff::Timestamp,
}

/// Zone in the text of a file.
fn parse(text: &str) -> Result<OperatorZone, String> {
    let file: ZoneFile = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let [ZoneFeature { properties, .. }] = file.features;
    let ZoneProperties { name, floor_m, ceiling_m, activated_by, activated_at } = properties;
    check_heights(floor_m, ceiling_m)?;
    let areas = areas(text, &name, floor_m, ceiling_m)?;
    let activated_at = Time::from_nanos(i64::try_from(activated_at.as_nanosecond()).unwrap_or(i64::MAX));
    Ok(OperatorZone { name, floor_m, ceiling_m, activated_by, activated_at, areas })
}

/// Text of the file for a zone in GeoJSON.
fn file_text(name: &str, geojson: &[u8], by: &str, now: Time) -> Result<String, String> {
    if geojson.len() > MAX_GEOJSON {
        return Err(format!("a zone has at most {MAX_GEOJSON} octets"));
    }
    let mut posted: Value =
        serde_json::from_slice(geojson).map_err(|error| format!("is no GeoJSON: {error}"))?;
    let feature = feature_of(&mut posted)?;
    let geometry = feature.get("geometry").cloned().unwrap_or_default();
    let mut nothing = Map::new();
    let properties = feature.get_mut("properties").and_then(Value::as_object_mut).unwrap_or(&mut nothing);
    let [floor_m, ceiling_m] = [take_height(properties, "floor_m")?, take_height(properties, "ceiling_m")?];
    check_heights(floor_m, ceiling_m)?;
    // The whole text is read, so that nothing that limits the zone, such as hours or other heights, is ignored.
    areas(&posted.to_string(), name, None, None)?;
    let activated_at =
        jiff::Timestamp::from_nanosecond(now.nanos().into()).map_err(|error| error.to_string())?;
    let activated_at = activated_at.round(jiff::Unit::Millisecond).map_err(|error| error.to_string())?;
    let (name, activated_by) = (name.to_owned(), by.to_owned());
    let properties = ZoneProperties { name, floor_m, ceiling_m, activated_by, activated_at };
    let feature = ZoneFeature { r#type: ZoneFeatureType::Feature, properties, geometry };
    let file = ZoneFile { r#type: ZoneFileType::FeatureCollection, features: [feature] };
    serde_json::to_string(&file).map(|text| text + "\n").map_err(|error| error.to_string())
}

/// The only feature of a GeoJSON text.
fn feature_of(posted: &mut Value) -> Result<&mut Value, String> {
    match posted.get("type").and_then(Value::as_str) {
        Some("Feature") => Ok(posted),
        Some("FeatureCollection") => match posted.get_mut("features").and_then(Value::as_array_mut) {
            Some(features) if features.len() == 1 => Ok(&mut features[0]),
            _ => Err("a zone is one feature; activate several polygons as a MultiPolygon, or one by one"
                .to_owned()),
        },
        _ => Err("a zone is a GeoJSON Feature, or a FeatureCollection of one".to_owned()),
    }
}

/// Removes a height from the properties, in metres above mean sea level.
fn take_height(properties: &mut Map<String, Value>, key: &str) -> Result<Option<f64>, String> {
    match properties.remove(key) {
        None | Some(Value::Null) => Ok(None),
        Some(value) => match value.as_f64() {
            Some(metres) => Ok(Some(metres)),
            None => Err(format!(
                "properties.{key} = {value}: a height is a number of metres, or null for no limit"
            )),
        },
    }
}

fn check_heights(floor_m: Option<f64>, ceiling_m: Option<f64>) -> Result<(), String> {
    for (key, metres) in [("floor_m", floor_m), ("ceiling_m", ceiling_m)] {
        if metres.is_some_and(|metres| !HEIGHTS_M.contains(&metres)) {
            return Err(format!(
                "properties.{key}: a height is between -500 and 50000 metres above mean sea level"
            ));
        }
    }
    match floor_m.zip(ceiling_m) {
        Some((floor_m, ceiling_m)) if floor_m >= ceiling_m => {
            Err("properties.ceiling_m: the ceiling is not above the floor".to_owned())
        }
        _ => Ok(()),
    }
}

/// The polygons of a GeoJSON text as areas of kind `alert`.
fn areas(text: &str, name: &str, floor_m: Option<f64>, ceiling_m: Option<f64>) -> Result<Areas, String> {
    let kind = AreaKind::Alert(AlertArea { floor_m, ceiling_m, ..AlertArea::default() });
    let areas = Areas::parse(text, Area { kind, file: name.into() }).map_err(|error| error.problem)?;
    if areas.zones().any(|(_, zone)| zone.format != Format::GeoJson) {
        return Err(
            "UAS zones of an authority are configured in [[areas]]; an operator activates plain GeoJSON"
                .to_owned(),
        );
    }
    Ok(areas)
}

#[cfg(test)]
mod tests;
