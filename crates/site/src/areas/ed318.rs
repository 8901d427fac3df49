//! UAS zones of EUROCAE ED-318: GeoJSON with layers and circles in its geometries, and the restrictions in its properties.

use serde_json::Value;

use super::band::{self, Names};
use super::hours::period;
use super::member::{Member, is_blank};
use super::schedule::Schedule;
use super::shape::Shape;
use super::zone::{Format, Reading, Volume, Zone, ZoneKind};

/// Names of the heights of a layer.
const LAYER: Names = Names {
    lower: "lower",
    lower_reference: "lowerReference",
    upper: "upper",
    upper_reference: "upperReference",
    unit: "uom",
};
/// Members that would limit a zone, in places where this reader does not expect them.
const STRAY: [&str; 9] = [
    "lowerLimit",
    "upperLimit",
    "horizontalProjection",
    "applicability",
    "startDateTime",
    "endDateTime",
    "schedule",
    "layer",
    "extent",
];
/// Members that only an ED-318 zone has.
const TELLING: [&str; 6] =
    ["UASZone", "variant", "zoneAuthority", "limitedApplicability", "restrictionConditions", "verticalLayer"];

/// Whether a feature is an ED-318 zone. Reading it as plain GeoJSON would ignore its limits.
pub(super) fn is_zone(feature: &Value) -> bool {
    let feature = Member::top(feature);
    let has_object = |member: &Member<'_>, names: &[&str]| {
        names.iter().any(|name| member.get(name).is_some_and(|found| found.is_object()))
    };
    let geometry = feature.get("geometry");
    let parts = geometry.iter().flat_map(|geometry| {
        let parts = geometry.get("geometries").map_or_else(Vec::new, |parts| parts.entries());
        parts.into_iter().chain([geometry.clone()])
    });
    let properties = feature.get("properties");
    let is_said = properties.iter().any(|properties| {
        let kind = properties.get("type").and_then(|kind| ZoneKind::of(kind.text().ok()?));
        let is_stray = |member: Member<'_>| strays(&member).is_some();
        kind.is_some()
            || TELLING.iter().any(|name| properties.get(name).is_some())
            || properties.members().any(is_stray)
    });
    is_said || parts.into_iter().any(|part| has_object(&part, &["layer", "extent"]))
}

/// The refusal of a member that would limit the zone; `None` for any other member. In other GeoJSON `layer` is a number or name.
fn strays(member: &Member<'_>) -> Option<String> {
    let is_it = |name: &&&str| member.name().eq_ignore_ascii_case(name);
    let name = STRAY.iter().find(is_it)?;
    let is_plain = ["layer", "extent", "schedule"].contains(name) && !member.is_object();
    (!is_plain).then(|| member.refused("what limits a zone is not looked for here"))
}

/// Reads a zone.
pub(super) fn zone(feature: &Value, reading: &Reading<'_>) -> Result<Zone, String> {
    let feature = Member::top(feature);
    let properties = feature.need("properties", "a zone has properties that say what holds in it")?;
    // Some publishers put the zone inside its properties, and its limits beside it.
    let said = properties.get("UASZone").unwrap_or_else(|| properties.clone());
    for member in feature.members().chain(properties.members()).chain(said.members()) {
        strays(&member).map_or(Ok(()), Err)?;
    }
    let (name, identifier) = reading.names(&said)?;
    let kind =
        said.get("restriction").map_or_else(|| said.need("type", "a zone says what holds in it"), Ok)?;
    let applicability = [&properties, &said].into_iter().find_map(|from| from.get("limitedApplicability"));
    let periods = applicability.map_or_else(Vec::new, |periods| periods.entries());
    let periods = periods.iter().filter(|entry| !is_blank(entry.value()));
    let periods = periods.map(|entry| period(entry, reading.zone.as_ref())).collect::<Result<_, _>>()?;
    let layer = properties.get("verticalLayer");
    let geometry = feature.need("geometry", "a zone is somewhere")?;
    Ok(Zone {
        name,
        identifier,
        kind: Some(ZoneKind::read(&kind)?),
        conditions: reading.text(&said, "restrictionConditions")?,
        schedule: Schedule::of(periods),
        format: Format::Ed318,
        volumes: volumes(&geometry, layer.as_ref(), reading)?,
    })
}

/// Reads the volumes of a geometry; `layer` has the heights of parts without heights of their own.
fn volumes(
    geometry: &Member<'_>,
    layer: Option<&Member<'_>>,
    reading: &Reading<'_>,
) -> Result<Vec<Volume>, String> {
    let own = geometry.get("layer");
    let layer = own.as_ref().or(layer);
    let kind = geometry.need("type", "a geometry has a type")?;
    let shape = match kind.text()? {
        "GeometryCollection" => {
            let parts = geometry.need("geometries", "a collection has geometries")?;
            let volumes = parts.entries().into_iter().map(|part| volumes(&part, layer, reading));
            return Ok(volumes.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect());
        }
        "Point" => {
            let extent = geometry.need("extent", "a point is the centre of a circle")?;
            extent.knows_only(&["subType", "radius"])?;
            let shape = extent.need("subType", "understood is Circle")?;
            if shape.text()? != "Circle" {
                return Err(shape.refused("understood is Circle"));
            }
            Shape::circle_of(&geometry.need("coordinates", "a circle has a centre")?, &extent)
        }
        "Polygon" | "MultiPolygon" => {
            if let Some(extent) = geometry.get("extent") {
                return Err(extent.refused("only a point has an extent"));
            }
            Shape::of(geometry.value())
        }
        _ => {
            Err(kind
                .refused("understood are Polygon, MultiPolygon, Point with a circle, and GeometryCollection"))
        }
    };
    let band = match layer {
        None => reading.band,
        Some(layer) => {
            let Names { lower, lower_reference, upper, upper_reference, unit } = LAYER;
            layer.knows_only(&[lower, lower_reference, upper, upper_reference, unit])?;
            band::read(layer, &LAYER, reading.ground_m)?
        }
    };
    Ok(vec![Volume { shape: shape?, band }])
}
