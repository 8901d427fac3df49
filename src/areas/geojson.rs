//! Polygons of GeoJSON, RFC 7946, of which nothing is known but a name.

use ::geojson::{Feature, GeoJson};
use geo::{Geometry, MultiPolygon};

use super::schedule::Schedule;
use super::shape::Shape;
use super::zone::{Format, Reading, Volume, Zone};

/// The polygons of a file, each as an area.
pub(super) fn zones(text: &str, reading: &Reading<'_>) -> Result<Vec<Zone>, String> {
    let json: GeoJson = text.parse().map_err(|cause| format!("is no GeoJSON: {cause}"))?;
    let features = match json {
        GeoJson::FeatureCollection(collection) => collection.features,
        GeoJson::Feature(feature) => vec![feature],
        GeoJson::Geometry(geometry) => vec![geometry.into()],
    };
    let mut zones = Vec::new();
    for feature in features {
        let name = feature.property("name").and_then(|name| name.as_str()).map(str::trim);
        let name = name.filter(|name| !name.is_empty()).unwrap_or(&reading.stem).to_owned();
        for polygon in polygons_of(feature)? {
            zones.push(Zone {
                name: name.clone(),
                identifier: None,
                kind: None,
                conditions: None,
                schedule: Schedule::default(),
                format: Format::GeoJson,
                volumes: vec![Volume { shape: Shape::new(polygon)?, band: reading.band }],
            });
        }
    }
    Ok(zones)
}

/// Those of a feature; a collection of polygons is several, a feature without a geometry none.
fn polygons_of(feature: Feature) -> Result<Vec<MultiPolygon>, String> {
    let Some(geometry) = feature.geometry else { return Ok(Vec::new()) };
    let geometry = Geometry::try_from(geometry).map_err(|cause| format!("is no GeoJSON: {cause}"))?;
    let one = |geometry| match geometry {
        Geometry::Polygon(polygon) => Ok(polygon.into()),
        Geometry::MultiPolygon(polygons) => Ok(polygons),
        _ => Err("holds something that is no polygon".to_owned()),
    };
    match geometry {
        Geometry::GeometryCollection(collection) => collection.into_iter().map(one).collect(),
        geometry => Ok(vec![one(geometry)?]),
    }
}
