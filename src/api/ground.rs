//! Areas and coverage as GeoJSON.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::Serialize;

use super::geometry::{Collection, Feature, Geometry, Position, Unnamed};
use crate::areas::{Areas, Format, Part, ZoneKind, on_map, severity};
use crate::config::{Area, AreaKind, AreaSeverity, Sensor, SensorKind};
use crate::json::rounded;
use crate::names::configured;
use crate::picture::Rfc3339;
use fusion::time::Time;

/// Corners of a circle.
const CORNERS: usize = 72;
/// Mean radius of the Earth, metres: to draw circles, not to measure.
const EARTH_M: f64 = 6_371_008.8;

/// What kind of sensor it is.
pub fn kind(sensor: &Sensor) -> &'static str {
    sensor.kind.name()
}

/// Where the sensors see.
pub type Coverage = Collection<Feature<'static, Option<Geometry>, CoverageProperties>>;

/// Where a sensor's polygon comes from.
#[derive(Clone, Copy)]
enum Shape {
    Area,
    Circle,
}

fusion::interface_names!(Shape { Area = "area", Circle = "circle" });

#[derive(Serialize, JsonSchema)]
pub struct CoverageProperties {
    /// Its configured id.
    sensor: String,
    #[schemars(extend("enum" = configured::<SensorKind>()))]
    kind: &'static str,
    /// Area: as configured; circle: of the radar's range.
    #[schemars(extend("enum" = Shape::NAMES))]
    shape: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    max_range_m: Option<f64>,
}

/// Where each sensor sees: its areas of kind `coverage`, or else, of a radar, the circle of its range.
pub fn coverage(sensors: &[Sensor], areas: &Areas) -> Coverage {
    let feature = |sensor: &Sensor| {
        let radar = sensor.kind.radar();
        let max_range_m = radar.and_then(|radar| radar.max_range_m);
        let is_its =
            |area: &Area| matches!(&area.kind, AreaKind::Coverage { sensor: id } if *id == sensor.id);
        let its = areas.parts().filter(|of| is_its(of.area)).flat_map(|of| of.polygon);
        let polygons: geo::MultiPolygon = its.collect();
        let (shape, geometry) = if polygons.0.is_empty() {
            let (radar, range_m) = radar.zip(max_range_m)?;
            (Shape::Circle, circle(radar.longitude_deg, radar.latitude_deg, range_m))
        } else {
            (Shape::Area, Some((&polygons).into()))
        };
        let sensor_id = sensor.id.clone();
        let properties = CoverageProperties {
            sensor: sensor_id.clone(),
            kind: kind(sensor),
            shape: shape.name(),
            max_range_m,
        };
        Some(Feature::new(sensor_id, geometry, properties))
    };
    sensors.iter().filter_map(feature).collect()
}

/// The configured areas.
pub type AreaCollection = Collection<Unnamed<Geometry, AreaProperties>>;

#[derive(Serialize, JsonSchema)]
pub struct AreaProperties {
    #[schemars(extend("enum" = configured::<AreaKind>()))]
    kind: &'static str,
    name: String,
    /// Whose coverage it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    sensor: Option<String>,
    /// What its authority calls it.
    #[serde(skip_serializing_if = "Option::is_none")]
    identifier: Option<String>,
    /// What holds in a UAS zone.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = ZoneKind::NAMES))]
    r#type: Option<&'static str>,
    /// What of a UAS zone is in force under which conditions, in its authority's words.
    #[serde(skip_serializing_if = "Option::is_none")]
    conditions: Option<String>,
    /// Lowest height, metres above mean sea level; left out from the ground up.
    #[serde(skip_serializing_if = "Option::is_none")]
    floor_m: Option<f64>,
    /// Highest height, metres above mean sea level; left out without a limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    ceiling_m: Option<f64>,
    /// Whether it is in force now.
    active: bool,
    /// When that changes; left out where it does not.
    #[serde(skip_serializing_if = "Option::is_none")]
    changes_at: Option<Rfc3339>,
    /// When it is in force, in short.
    hours: String,
    /// How bad it is to be inside; left out where it raises no alert.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = configured::<AreaSeverity>()))]
    severity: Option<&'static str>,
    /// What its file is.
    #[schemars(extend("enum" = Format::NAMES))]
    format: &'static str,
}

/// The areas as GeoJSON, as they are at a time, where the geoid is that far above the ellipsoid; a zone of several parts is as
/// many features.
pub fn area_collection(areas: &Areas, now: Time, undulation_m: f64) -> AreaCollection {
    let feature = |Part { area, zone, polygon, band }: Part<'_>| {
        let sensor = match &area.kind {
            AreaKind::Coverage { sensor } => Some(sensor.clone()),
            AreaKind::Mask | AreaKind::Alert(_) => None,
        };
        let band = band.above_sea(undulation_m);
        let properties = AreaProperties {
            kind: area.kind.name(),
            name: zone.name.clone(),
            sensor,
            identifier: zone.identifier.clone(),
            r#type: zone.kind.map(ZoneKind::name),
            conditions: zone.conditions.clone(),
            floor_m: band.floor_m.map(|metres| rounded(metres, 1)),
            ceiling_m: band.ceiling_m.map(|metres| rounded(metres, 1)),
            active: zone.schedule.is_active(now),
            changes_at: zone.schedule.changes_after(now).map(Rfc3339),
            hours: zone.schedule.to_string(),
            severity: area.alert().and_then(|set| severity(set, zone.kind)).map(|severity| severity.name()),
            format: zone.format.name(),
        };
        Unnamed::new((&polygon).into(), properties)
    };
    areas.parts().map(feature).collect()
}

/// A circle on the sphere, counterclockwise, cut at the antimeridian; one around a pole is not drawn.
fn circle(longitude_deg: f64, latitude_deg: f64, radius_m: f64) -> Option<Geometry> {
    let (latitude, angle) = (latitude_deg.to_radians(), radius_m / EARTH_M);
    if latitude.abs() + angle >= TAU / 4.0 {
        return None;
    }
    let corner = |number: usize| {
        // Against the clock, from north by west.
        let bearing = -TAU * number as f64 / CORNERS as f64;
        let north = latitude.sin() * angle.cos() + latitude.cos() * angle.sin() * bearing.cos();
        let east = (bearing.sin() * angle.sin() * latitude.cos())
            .atan2(angle.cos() - latitude.sin() * north.clamp(-1.0, 1.0));
        [longitude_deg + east.to_degrees(), north.clamp(-1.0, 1.0).asin().to_degrees()]
    };
    let ring: Vec<[f64; 2]> = (0..CORNERS).map(corner).collect();
    let part = |part: Vec<[f64; 2]>| {
        let mut moved: Vec<Position> =
            part.iter().map(|&[lng, lat]| Position::new(rounded(lng, 7), rounded(lat, 7), None)).collect();
        moved.dedup();
        let first = moved.first()?.clone();
        moved.push(first);
        (moved.len() > 3).then_some(vec![moved])
    };
    let mut polygons: Vec<Vec<Vec<Position>>> = on_map(&ring).into_iter().filter_map(part).collect();
    Some(match polygons.len() {
        1 => Geometry::Polygon(polygons.remove(0)),
        _ => Geometry::MultiPolygon(polygons),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(ring: &[Position]) -> f64 {
        assert_eq!(ring.first(), ring.last());
        let at = |index: usize, axis: usize| ring[index].0[axis];
        (1..ring.len()).map(|i| at(i - 1, 0) * at(i, 1) - at(i, 0) * at(i - 1, 1)).sum::<f64>() / 2.0
    }

    #[test]
    fn circles_are_right_handed_and_cut_at_the_antimeridian() {
        let Some(Geometry::Polygon(plain)) = circle(-0.588, 52.5, 5_000.0) else { panic!() };
        assert_eq!(plain[0].len(), CORNERS + 1);
        assert!(area(&plain[0]) > 0.0);
        for longitude_deg in [179.99, -179.99] {
            let Some(Geometry::MultiPolygon(polygons)) = circle(longitude_deg, -17.0, 5_000.0) else {
                panic!()
            };
            assert_eq!(polygons.len(), 2);
            for polygon in polygons {
                assert!(area(&polygon[0]) > 0.0);
                assert!(polygon[0].iter().all(|position| position.0[0].abs() <= 180.0));
            }
        }
        assert_eq!(circle(0.0, 90.0, 5_000.0), None);
    }
}
