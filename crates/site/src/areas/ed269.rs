//! UAS zones of EUROCAE ED-269, a JSON format in which a zone is a list of volumes. Estonia publishes such zones as GeoJSON
//! features: their properties are the zone, the properties' `geometry` has the heights, the feature's geometry the shape.

use serde_json::Value;

use super::band::{self, Names};
use super::hours::period;
use super::member::{Member, is_blank};
use super::schedule::Schedule;
use super::shape::Shape;
use super::zone::{Format, Reading, Volume, Zone, ZoneKind};

/// Names of the heights of a volume.
const VOLUME: Names = Names {
    lower: "lowerLimit",
    lower_reference: "lowerVerticalReference",
    upper: "upperLimit",
    upper_reference: "upperVerticalReference",
    unit: "uomDimensions",
};

/// The zones of a file; `None`: the file has another format.
pub(super) fn zones(file: &Value) -> Option<&[Value]> {
    let list = |name: &str| file.get(name).and_then(Value::as_array).map(Vec::as_slice);
    let has_volumes = |zone: &Value| zone.get("geometry").is_some_and(Value::is_array);
    match list("UASZoneList") {
        Some(zones) => Some(zones),
        None if has_volumes(file) => Some(std::slice::from_ref(file)),
        None => list("features").filter(|zones| zones.iter().any(has_volumes)),
    }
}

/// Whether a GeoJSON feature is an ED-269 zone.
pub(super) fn is_feature(feature: &Value) -> bool {
    let properties = &feature["properties"];
    let heights = &properties["geometry"];
    properties["applicability"].is_array()
        && [VOLUME.lower, VOLUME.upper].iter().any(|name| heights.get(name).is_some())
}

/// Reads a zone.
pub(super) fn zone(zone: &Value, reading: &Reading<'_>) -> Result<Zone, String> {
    let zone = Member::top(zone);
    let geometry = zone.need("geometry", "a zone is somewhere")?;
    let volumes = || geometry.entries().iter().map(|part| volume(part, reading)).collect();
    zone_of(&zone, reading, volumes)
}

/// Reads a zone that is a GeoJSON feature.
pub(super) fn feature_zone(feature: &Value, reading: &Reading<'_>) -> Result<Zone, String> {
    let feature = Member::top(feature);
    let zone = feature.need("properties", "a zone has properties that say what holds in it")?;
    let geometry = feature.need("geometry", "a zone is somewhere")?;
    let heights = zone.need("geometry", "a zone has heights")?;
    let volumes = || {
        let kind = geometry.need("type", "a geometry has a type")?;
        if !matches!(kind.text()?, "Polygon" | "MultiPolygon") {
            return Err(kind.refused("understood are Polygon and MultiPolygon"));
        }
        if let Some(stray) = ["extent", "layer"].iter().find_map(|name| geometry.get(name)) {
            return Err(stray.refused("what limits a zone is not looked for here"));
        }
        let Names { lower, lower_reference, upper, upper_reference, unit } = VOLUME;
        heights.knows_only(&[lower, lower_reference, upper, upper_reference, unit])?;
        let band = band::read(&heights, &VOLUME, reading.ground_m)?;
        Ok(vec![Volume { shape: Shape::of(geometry.value())?, band }])
    };
    zone_of(&zone, reading, volumes)
}

/// Reads all of a zone but its volumes.
fn zone_of(
    zone: &Member<'_>,
    reading: &Reading<'_>,
    volumes: impl FnOnce() -> Result<Vec<Volume>, String>,
) -> Result<Zone, String> {
    let (name, identifier) = reading.names(zone)?;
    for name in ["schedule", "startDateTime", "endDateTime", "limitedApplicability", "layer"] {
        if let Some(stray) = zone.get(name) {
            return Err(stray.refused("what limits a zone is not looked for here"));
        }
    }
    let kind = zone.need("restriction", "a zone says what holds in it")?;
    let applicability = zone.get("applicability").map_or_else(Vec::new, |periods| periods.entries());
    let mut periods = Vec::new();
    for entry in applicability.iter().filter(|entry| !is_blank(entry.value())) {
        let permanent =
            entry.get("permanent").map(|permanent| match permanent.text()?.to_ascii_uppercase().as_str() {
                "YES" => Ok(true),
                "NO" => Ok(false),
                _ => Err(permanent.refused("understood are YES and NO")),
            });
        let permanent = permanent.transpose()?;
        let period = period(entry, reading.zone.as_ref())?;
        if permanent == Some(false) && period == Default::default() {
            return Err(entry.refused("it is not permanent, and no time is given"));
        }
        // The times of a permanent zone have no meaning.
        periods.push(if permanent == Some(true) { Default::default() } else { period });
    }
    Ok(Zone {
        name,
        identifier,
        kind: Some(ZoneKind::read(&kind)?),
        conditions: reading.text(zone, "restrictionConditions")?,
        schedule: Schedule::of(periods),
        format: Format::Ed269,
        volumes: volumes()?,
    })
}

fn volume(volume: &Member<'_>, reading: &Reading<'_>) -> Result<Volume, String> {
    let Names { lower, lower_reference, upper, upper_reference, unit } = VOLUME;
    volume.knows_only(&[lower, lower_reference, upper, upper_reference, unit, "horizontalProjection"])?;
    let projection = volume.need("horizontalProjection", "a volume has a shape")?;
    let kind = projection.need("type", "understood are Polygon and Circle")?;
    let shape = match kind.text()? {
        "Circle" => {
            projection.knows_only(&["type", "center", "radius"])?;
            // Publishers disagree whether the unit of heights applies to the radius, or the radius is always in metres.
            if let Some(unit) =
                volume.get(unit).filter(|unit| !unit.text().is_ok_and(|text| text.eq_ignore_ascii_case("M")))
            {
                return Err(unit.refused("volumes that are circles are understood in M"));
            }
            Shape::circle_of(&projection.need("center", "a circle has a centre")?, &projection)?
        }
        "Polygon" | "MultiPolygon" => Shape::of(projection.value())?,
        _ => return Err(kind.refused("understood are Polygon and Circle")),
    };
    Ok(Volume { shape, band: band::read(volume, &VOLUME, reading.ground_m)? })
}
