//! Plain GeoJSON polygons (RFC 7946), which have a name and no restrictions.

use ::geojson::GeoJson;
use serde_json::Value;

use super::member::{Member, is_blank};
use super::schedule::Schedule;
use super::shape::Shape;
use super::zone::{Format, Reading, Volume, Zone};

/// Members with which publishers limit an area in height, in lower case and without separators.
const LIMITS: [&str; 23] = [
    "ceiling",
    "ceilingft",
    "ceilingm",
    "floor",
    "floorft",
    "floorm",
    "lower",
    "lowerval",
    "lowervalue",
    "lowermeters",
    "lowerlimit",
    "loweraltitude",
    "minalt",
    "minaltitude",
    "maxalt",
    "maxaltitude",
    "maxheight",
    "upper",
    "upperval",
    "uppervalue",
    "uppermeters",
    "upperlimit",
    "upperaltitude",
];

/// Refuses text that is not GeoJSON.
pub(super) fn check(text: &str) -> Result<(), String> {
    text.parse::<GeoJson>().map(|_| ()).map_err(|cause| format!("is no GeoJSON: {cause}"))
}

/// The polygons of a feature or geometry, each as an area; a feature without a geometry has none.
pub(super) fn zones(object: &Value, reading: &Reading<'_>) -> Result<Vec<Zone>, String> {
    let object = Member::top(object);
    let is_feature = object.value().get("type").is_some_and(|kind| kind == "Feature");
    let (geometry, properties) =
        if is_feature { (object.get("geometry"), object.get("properties")) } else { (Some(object), None) };
    let Some(geometry) = geometry else { return Ok(Vec::new()) };
    let mut shapes = Vec::new();
    add_shapes(&geometry, &mut shapes)?;
    // Heights from the configuration override those of the file.
    if !reading.band.is_limited() {
        let limit = properties.iter().flat_map(Member::members).find(is_limit);
        if let Some(limit) = limit {
            return Err(limit.refused(
                "plain GeoJSON has no heights; write floor_m or ceiling_m in this [[areas]], or remove the member from a \
                 copy of the file",
            ));
        }
    }
    let name = properties.as_ref().and_then(|properties| properties.value().get("name"));
    let name = name.and_then(Value::as_str).map(str::trim).filter(|name| !name.is_empty());
    let zone = |shape| Zone {
        name: name.unwrap_or(&reading.stem).to_owned(),
        identifier: None,
        kind: None,
        conditions: None,
        schedule: Schedule::default(),
        format: Format::GeoJson,
        volumes: vec![Volume { shape, band: reading.band }],
    };
    Ok(shapes.into_iter().map(zone).collect())
}

/// Whether a member limits an area in height.
fn is_limit(member: &Member<'_>) -> bool {
    let name: String = member.name().chars().filter(char::is_ascii_alphanumeric).collect();
    LIMITS.contains(&name.to_ascii_lowercase().as_str())
}

/// Adds the polygons of a geometry; each polygon of a collection counts on its own.
fn add_shapes(geometry: &Member<'_>, shapes: &mut Vec<Shape>) -> Result<(), String> {
    let kind = geometry.need("type", "a geometry has a type")?;
    match kind.text()? {
        "Polygon" | "MultiPolygon" => {
            let is_empty = geometry.value().get("coordinates").is_none_or(is_blank);
            let shape =
                if is_empty { Err("holds an empty polygon".to_owned()) } else { Shape::of(geometry.value()) };
            shapes.push(shape?);
            Ok(())
        }
        "GeometryCollection" => match geometry.get("geometries") {
            Some(parts) => parts.entries().iter().try_for_each(|part| add_shapes(part, shapes)),
            None => Ok(()),
        },
        _ => {
            Err(kind.refused("it is no polygon: understood are Polygon, MultiPolygon and GeometryCollection"))
        }
    }
}
