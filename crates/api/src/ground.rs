//! Areas and coverage as GeoJSON.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::Serialize;

use super::geometry::{Feature, FeatureCollection, GeoJsonGeometry, GeoPosition, UnnamedFeature};
use fusion::time::Time;
use input::json::rounded;
use input::names::configured;
use picture::Rfc3339;
use service::state::OperatorZone;
use site::areas::{Areas, Format, Part, ZoneKind, on_map, severity};
use site::config::{Area, AreaKind, AreaSeverity, Sensor, SensorKind};

/// Number of corners of a circle.
const CORNERS: usize = 72;
/// Mean radius of the Earth, in metres; used only to draw circles.
const EARTH_M: f64 = 6_371_008.8;

/// Name of the kind of a sensor.
pub fn kind(sensor: &Sensor) -> &'static str {
    sensor.kind.name()
}

/// Coverage of the sensors.
pub type Coverage = FeatureCollection<Feature<'static, Option<GeoJsonGeometry>, CoverageProperties>>;

/// Origin of a coverage polygon.
#[derive(Clone, Copy)]
enum CoverageShape {
    Area,
    Circle,
}

fusion::interface_names!(CoverageShape { Area = "area", Circle = "circle" });

#[derive(Serialize, JsonSchema)]
pub struct CoverageProperties {
    /// Configured id of the sensor.
    sensor: String,
    #[schemars(extend("enum" = configured::<SensorKind>()))]
    kind: &'static str,
    /// `area`: configured polygon. `circle`: range of the radar.
    #[schemars(extend("enum" = CoverageShape::NAMES))]
    shape: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    max_range_m: Option<f64>,
}

/// Coverage of each sensor: its areas of kind `coverage`, else the circle of a radar's range.
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
            (CoverageShape::Circle, circle(radar.longitude_deg, radar.latitude_deg, range_m))
        } else {
            (CoverageShape::Area, Some((&polygons).into()))
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

/// The configured areas, and the zones of operators.
pub type AreaCollection = FeatureCollection<UnnamedFeature<GeoJsonGeometry, AreaProperties>>;

#[derive(Serialize, JsonSchema)]
pub struct AreaProperties {
    #[schemars(extend("enum" = configured::<AreaKind>()))]
    kind: &'static str,
    name: String,
    /// Id of the sensor whose coverage this is.
    #[serde(skip_serializing_if = "Option::is_none")]
    sensor: Option<String>,
    /// Identifier given by the authority.
    #[serde(skip_serializing_if = "Option::is_none")]
    identifier: Option<String>,
    /// Type of a UAS zone.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = ZoneKind::NAMES))]
    r#type: Option<&'static str>,
    /// Conditions of a UAS zone, in the words of its authority.
    #[serde(skip_serializing_if = "Option::is_none")]
    conditions: Option<String>,
    /// Lower limit, in metres above mean sea level; left out if it is the ground.
    #[serde(skip_serializing_if = "Option::is_none")]
    floor_m: Option<f64>,
    /// Upper limit, in metres above mean sea level; left out if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    ceiling_m: Option<f64>,
    /// Whether the area is in force now.
    active: bool,
    /// Time of the next change of `active`; left out if it does not change.
    #[serde(skip_serializing_if = "Option::is_none")]
    changes_at: Option<Rfc3339>,
    /// Short text of the times when the area is in force.
    hours: String,
    /// Severity of an alert for a track inside; left out if the area raises no alert.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = configured::<AreaSeverity>()))]
    severity: Option<&'static str>,
    /// Name of the operator who activated the area; left out if the configuration names it.
    #[serde(skip_serializing_if = "Option::is_none")]
    activated_by: Option<String>,
    /// Format of the area's file.
    #[schemars(extend("enum" = Format::NAMES))]
    format: &'static str,
}

/// The areas, and the zones of operators, as GeoJSON at the time `now`, with the height `undulation_m` of the geoid above the
/// ellipsoid. A zone of several parts becomes several features.
pub fn area_collection(
    areas: &Areas,
    zones: &[OperatorZone],
    now: Time,
    undulation_m: f64,
) -> AreaCollection {
    let feature = |(Part { area, zone, polygon, band }, activated_by): (Part<'_>, Option<&String>)| {
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
            activated_by: activated_by.cloned(),
            format: zone.format.name(),
        };
        UnnamedFeature::new((&polygon).into(), properties)
    };
    let configured = areas.parts().map(|part| (part, None));
    let activated =
        zones.iter().flat_map(|zone| zone.areas.parts().map(move |part| (part, Some(&zone.activated_by))));
    configured.chain(activated).map(feature).collect()
}

/// A circle on the sphere, counterclockwise, cut at the antimeridian; `None` around a pole.
fn circle(longitude_deg: f64, latitude_deg: f64, radius_m: f64) -> Option<GeoJsonGeometry> {
    let (latitude, angle) = (latitude_deg.to_radians(), radius_m / EARTH_M);
    if latitude.abs() + angle >= TAU / 4.0 {
        return None;
    }
    let corner = |number: usize| {
        // Counterclockwise from north, by west.
        let bearing = -TAU * number as f64 / CORNERS as f64;
        let north = latitude.sin() * angle.cos() + latitude.cos() * angle.sin() * bearing.cos();
        let east = (bearing.sin() * angle.sin() * latitude.cos())
            .atan2(angle.cos() - latitude.sin() * north.clamp(-1.0, 1.0));
        [longitude_deg + east.to_degrees(), north.clamp(-1.0, 1.0).asin().to_degrees()]
    };
    let ring: Vec<[f64; 2]> = (0..CORNERS).map(corner).collect();
    let part = |part: Vec<[f64; 2]>| {
        let mut moved: Vec<GeoPosition> =
            part.iter().map(|&[lng, lat]| GeoPosition::new(rounded(lng, 7), rounded(lat, 7), None)).collect();
        moved.dedup();
        let first = moved.first()?.clone();
        moved.push(first);
        (moved.len() > 3).then_some(vec![moved])
    };
    let mut polygons: Vec<Vec<Vec<GeoPosition>>> = on_map(&ring).into_iter().filter_map(part).collect();
    Some(match polygons.len() {
        1 => GeoJsonGeometry::Polygon(polygons.remove(0)),
        _ => GeoJsonGeometry::MultiPolygon(polygons),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(ring: &[GeoPosition]) -> f64 {
        assert_eq!(ring.first(), ring.last());
        let at = |index: usize, axis: usize| ring[index].0[axis];
        (1..ring.len()).map(|i| at(i - 1, 0) * at(i, 1) - at(i, 0) * at(i - 1, 1)).sum::<f64>() / 2.0
    }

    #[test]
    fn circles_are_right_handed_and_cut_at_the_antimeridian() {
        let Some(GeoJsonGeometry::Polygon(plain)) = circle(-0.588, 52.5, 5_000.0) else { panic!() };
        assert_eq!(plain[0].len(), CORNERS + 1);
        assert!(area(&plain[0]) > 0.0);
        for longitude_deg in [179.99, -179.99] {
            let Some(GeoJsonGeometry::MultiPolygon(polygons)) = circle(longitude_deg, -17.0, 5_000.0) else {
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
