//! Reads the zones of a file in any of the formats.

use serde_json::Value;

use super::hours::instant;
use super::member::Member;
use super::zone::{Reading, Zone};
use super::{crs, ed269, ed318, geojson};
use fusion::time::Time;

/// Maximum number of zones whose errors are listed.
const NAMED: usize = 3;

/// The zones of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Contents {
    pub(super) zones: Vec<Zone>,
    /// End of the file's validity, as its publisher states it.
    pub(super) valid_to: Option<Time>,
}

/// Reads the zones of a file from its text.
pub(super) fn read(text: &str, reading: &Reading<'_>) -> Result<Contents, String> {
    let hint = |problem: String| {
        format!(
            "{problem}; areas are polygons in GeoJSON (RFC 7946), longitude before latitude, or UAS zones (ED-318, ED-269)"
        )
    };
    let text = text.trim_start_matches('\u{feff}');
    let file: Value = serde_json::from_str(text).map_err(|cause| hint(format!("is no GeoJSON: {cause}")))?;
    crs::check(&file)?;
    let contents = if let Some(zones) = ed269::zones(&file) {
        Contents { zones: each(zones, |zone| ed269::zone(zone, reading))?, valid_to: None }
    } else {
        let features = file
            .get("features")
            .and_then(Value::as_array)
            .map_or_else(|| std::slice::from_ref(&file), |features| features.as_slice());
        if features.iter().any(ed269::is_feature) {
            let zones = each(features, |feature| ed269::feature_zone(feature, reading))?;
            Contents { zones, valid_to: None }
        } else if features.iter().any(ed318::is_zone) {
            let valid_to = valid_to(&file, reading)?;
            Contents { zones: each(features, |feature| ed318::zone(feature, reading))?, valid_to }
        } else {
            geojson::check(text).map_err(hint)?;
            let zones = each(features, |feature| geojson::zones(feature, reading)).map_err(hint)?;
            Contents { zones: zones.into_iter().flatten().collect(), valid_to: None }
        }
    };
    if contents.zones.is_empty() { Err(hint("holds no polygon".to_owned())) } else { Ok(contents) }
}

/// Reads every zone of a list; the error lists the first few zones that cannot be read.
fn each<T>(zones: &[Value], read: impl Fn(&Value) -> Result<T, String>) -> Result<Vec<T>, String> {
    let mut faults = Vec::new();
    let mut found = Vec::new();
    for (index, zone) in zones.iter().enumerate() {
        match read(zone) {
            Ok(zone) => found.push(zone),
            Err(problem) => faults.push(format!("zone {}{}: {problem}", index + 1, identifier(zone))),
        }
    }
    if faults.is_empty() {
        return Ok(found);
    }
    let more = faults.len().saturating_sub(NAMED);
    faults.truncate(NAMED);
    if more > 0 {
        faults.push(format!("and so on: {more} more zones"));
    }
    Err(faults.join("\n  "))
}

/// The identifier or name of a zone, in brackets.
fn identifier(zone: &Value) -> String {
    let places = [
        "/properties/identifier",
        "/properties/UASZone/identifier",
        "/identifier",
        "/properties/name",
        "/properties/title",
        "/name",
    ];
    let text = places.iter().find_map(|place| zone.pointer(place).and_then(Value::as_str));
    text.map_or_else(String::new, |text| format!(" ({text:?})"))
}

/// The end of validity of an ED-318 file. Its beginning is only checked to be a time.
fn valid_to(file: &Value, reading: &Reading<'_>) -> Result<Option<Time>, String> {
    let file = Member::top(file);
    let metadata = file.get("metadata").or_else(|| file.get("datasetMetadata"));
    let time = |name: &str| {
        let time = metadata.as_ref().and_then(|metadata| metadata.get(name));
        time.map(|time| instant(&time, reading.zone.as_ref())).transpose()
    };
    time("validFrom")?;
    time("validTo")
}
