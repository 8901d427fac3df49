//! What stands on the ground: sensors, how far they see, areas; and what is wrong with them.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use super::ask::{Answer, Ask, GEO_JSON, JSON, json, live};
use super::keeper::alert_json;
use crate::areas::{Areas, NamedPolygon};
use crate::config::{Area, AreaKind, Sensor, SensorKind};
use crate::json::rounded;
use crate::live::{Alert, Contested, LineStatus, RegistrationStatus, SensorStatus, values};
use fusion::registration::Misalignment;

/// Corners of a circle.
const CORNERS: usize = 72;
/// Mean radius of the Earth, metres: to draw circles, not to measure.
const EARTH_M: f64 = 6_371_008.8;

/// `/api/v1/sensors`.
pub fn sensors(ask: &Ask) -> Answer {
    let hub = ask.state.hub();
    let status = hub.status();
    let feature = |(index, sensor): (usize, &Sensor)| {
        let geometry = match &sensor.kind {
            SensorKind::Radar(radar) => {
                let undulation_m = hub.maker.geoid_undulation_m();
                let place =
                    [radar.longitude_deg, radar.latitude_deg, rounded(radar.height_amsl_m + undulation_m, 3)];
                json!({ "type": "Point", "coordinates": place })
            }
            SensorKind::Transponder(_) => Value::Null,
        };
        let state = status.as_ref().and_then(|status| status.sensors.get(index));
        let properties = match state {
            Some(state) => sensor_properties(sensor, state),
            None => json!({ "id": sensor.id, "kind": kind(sensor) }),
        };
        json!({ "type": "Feature", "id": sensor.id, "geometry": geometry, "properties": properties })
    };
    let features: Vec<Value> = hub.config.sensors.iter().enumerate().map(feature).collect();
    let unknown = status.iter().flat_map(|status| &status.unknown).map(|unknown| {
        json!({
            "category": unknown.category,
            "sac": unknown.source.sac,
            "sic": unknown.source.sic,
            "own": unknown.own,
            "records": unknown.records,
            "last_seen": unknown.last_seen.to_string(),
        })
    });
    let unknown: Vec<Value> = unknown.collect();
    let mut collection = json!({ "type": "FeatureCollection", "unknown": unknown, "features": features });
    if let Some(status) = &status {
        collection["time"] = json!(status.at.to_string());
    }
    json(GEO_JSON, &collection)
}

fn kind(sensor: &Sensor) -> &'static str {
    match sensor.kind {
        SensorKind::Radar(_) => "radar",
        SensorKind::Transponder(_) => "transponder",
    }
}

/// A sensor as it is; what is unknown is left out.
pub(super) fn sensor_properties(sensor: &Sensor, status: &SensorStatus) -> Value {
    let line = |line: &LineStatus| {
        let mut json = json!({
            "name": line.name,
            "joined": line.joined,
            "received": line.received,
            "duplicates": line.duplicates,
            "foreign": line.foreign,
            "queue_full": line.queue_full,
            "kernel_dropped": line.kernel_dropped,
        });
        if let Some(last) = line.last_received {
            json["last_received"] = json!(last.to_string());
        }
        json
    };
    let lines: Vec<Value> = status.lines.iter().map(line).collect();
    let mut properties = json!({
        "id": status.id,
        "kind": kind(sensor),
        "sac": sensor.sac,
        "sic": sensor.sic,
        "state": status.state.name(),
        "reasons": status.reasons,
        "rate_hz": rounded(status.rate_hz, 3),
        "accepted": status.accepted,
        "refused": status.refused,
        "lines": lines,
    });
    if let Some(last) = status.last_seen {
        properties["last_seen"] = json!(last.to_string());
    }
    if let Some(offset_s) = status.clock_offset_s {
        properties["clock_offset_s"] = json!(rounded(offset_s, 3));
    }
    if !status.contested.is_empty() {
        properties["contested"] = status.contested.iter().map(contested_json).collect();
    }
    if let Some(registration) = &status.registration {
        properties["registration"] = registration_json(registration);
    }
    properties
}

/// A sender that is refused because another one speaks for the sensor.
fn contested_json(contested: &Contested) -> Value {
    let Contested { counts, refused, transponders } = contested;
    let serials: Vec<String> =
        transponders.iter().map(|identity| identity.serial().escape_ascii().to_string()).collect();
    json!({ "counts": counts.to_string(), "refused": refused.to_string(), "transponders": serials })
}

/// How a radar is registered.
fn registration_json(registration: &RegistrationStatus) -> Value {
    let mut json = json!({ "mode": registration.mode.name(), "applied": registration.is_applied() });
    if let Some(estimate) = &registration.estimate {
        json["tracks"] = json!(rounded(estimate.samples, 1));
        if let Some(residual) = estimate.residual {
            json["residual"] = json!(rounded(residual, 2));
        }
        add_values(&mut json, estimate);
    }
    if let Some(hint) = registration.hint() {
        json["hint"] = json!(hint);
    }
    if let Some(alarm) = &registration.alarm {
        json["alarm"] = json!(alarm);
    }
    if let Some(step) = &registration.step {
        let values = |estimate: &Misalignment| {
            let mut json = json!({});
            add_values(&mut json, estimate);
            json
        };
        json["step"] = json!({
            "time": step.time.to_string(),
            "before": values(&step.before),
            "after": values(&step.after),
        });
    }
    json
}

/// What is estimated of a radar, as properties.
pub(super) const REGISTERED: [&str; 6] =
    ["bearing_deg", "tilt_east_deg", "tilt_north_deg", "range_m", "height_m", "time_s"];

fn add_values(json: &mut Value, estimate: &Misalignment) {
    for (name, (.., value)) in REGISTERED.into_iter().zip(values(estimate)) {
        json[name] = json!({
            "value": rounded(value.value, 4),
            "deviation": rounded(value.deviation, 4),
            "observable": value.observable,
        });
    }
}

/// `/api/v1/coverage`.
pub fn coverage(ask: &Ask) -> Answer {
    Ok(live(GEO_JSON, ask.state.terms().coverage.clone()))
}

/// Where each sensor sees: its areas of kind `coverage`, or else, of a radar, the circle of its range.
pub(super) fn coverage_json(sensors: &[Sensor], areas: &Areas) -> Vec<u8> {
    let feature = |sensor: &Sensor| {
        let radar = match &sensor.kind {
            SensorKind::Radar(radar) => Some(radar),
            SensorKind::Transponder(_) => None,
        };
        let range_m = radar.and_then(|radar| radar.max_range_m);
        let is_its =
            |area: &Area| matches!(&area.kind, AreaKind::Coverage { sensor: id } if *id == sensor.id);
        let its = areas.polygons().filter(|of| is_its(of.area)).flat_map(|of| of.polygon);
        let polygons: Vec<geo::Polygon> = its.collect();
        let (shape, geometry) = if polygons.is_empty() {
            (
                "circle",
                radar
                    .zip(range_m)
                    .map(|(radar, m)| circle_geometry(radar.longitude_deg, radar.latitude_deg, m))?,
            )
        } else {
            ("area", json!(geojson::Geometry::new((&geo::MultiPolygon(polygons)).into())))
        };
        let mut properties = json!({ "sensor": sensor.id, "kind": kind(sensor), "shape": shape });
        if let Some(range_m) = range_m {
            properties["max_range_m"] = json!(range_m);
        }
        Some(json!({ "type": "Feature", "id": sensor.id, "geometry": geometry, "properties": properties }))
    };
    let features: Vec<Value> = sensors.iter().filter_map(feature).collect();
    json!({ "type": "FeatureCollection", "features": features }).to_string().into_bytes()
}

/// A circle on the sphere, counterclockwise, cut at the antimeridian; one around a pole is not drawn.
fn circle_geometry(longitude_deg: f64, latitude_deg: f64, radius_m: f64) -> Value {
    let (latitude, angle) = (latitude_deg.to_radians(), radius_m / EARTH_M);
    if latitude.abs() + angle >= TAU / 4.0 {
        return Value::Null;
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
    // West of -180, inside, and east of 180: each moved into the map.
    let parts = [(-540.0, -180.0, 360.0), (-180.0, 180.0, 0.0), (180.0, 540.0, -360.0)];
    let part = |(west, east, shift): (f64, f64, f64)| {
        let cut = cut(&cut(&ring, west, 1.0), east, -1.0);
        let mut moved: Vec<[f64; 2]> =
            cut.iter().map(|&[lng, lat]| [rounded(lng + shift, 7), rounded(lat, 7)]).collect();
        moved.dedup();
        let first = *moved.first()?;
        moved.push(first);
        (moved.len() > 3).then_some(moved)
    };
    let mut rings: Vec<Vec<[f64; 2]>> = parts.into_iter().filter_map(part).collect();
    if rings.len() == 1 {
        return json!({ "type": "Polygon", "coordinates": [rings.remove(0)] });
    }
    let polygons: Vec<_> = rings.into_iter().map(|ring| [ring]).collect();
    json!({ "type": "MultiPolygon", "coordinates": polygons })
}

/// The part of a convex ring that is east (`side` 1) or west (-1) of a meridian.
fn cut(ring: &[[f64; 2]], meridian: f64, side: f64) -> Vec<[f64; 2]> {
    let mut kept = Vec::new();
    for (index, &here) in ring.iter().enumerate() {
        let before = ring[(index + ring.len() - 1) % ring.len()];
        let inside = |place: [f64; 2]| (place[0] - meridian) * side >= 0.0;
        if inside(here) != inside(before) {
            let share = (meridian - before[0]) / (here[0] - before[0]);
            kept.push([meridian, before[1] + share * (here[1] - before[1])]);
        }
        if inside(here) {
            kept.push(here);
        }
    }
    kept
}

/// `/api/v1/areas`.
pub fn areas(ask: &Ask) -> Answer {
    Ok(live(GEO_JSON, ask.state.terms().areas.clone()))
}

/// The areas as GeoJSON.
pub(super) fn areas_json(areas: &Areas) -> Vec<u8> {
    let feature = |NamedPolygon { area, name, polygon }: NamedPolygon<'_>| {
        let (kind, sensor) = match &area.kind {
            AreaKind::Mask => ("mask", None),
            AreaKind::Coverage { sensor } => ("coverage", Some(sensor)),
            AreaKind::Alert => ("alert", None),
        };
        let mut properties = json!({ "kind": kind, "name": name });
        if let Some(sensor) = sensor {
            properties["sensor"] = json!(sensor);
        }
        let geometry = geojson::Geometry::new((&polygon).into());
        json!({ "type": "Feature", "geometry": geometry, "properties": properties })
    };
    let features: Vec<Value> = areas.polygons().map(feature).collect();
    json!({ "type": "FeatureCollection", "features": features }).to_string().into_bytes()
}

/// `/api/v1/alerts`: those that last, the worst first, and those that ended lately.
pub fn alerts(ask: &Ask) -> Answer {
    let all = ask.state.hub().alerts();
    let (ended, lasting): (Vec<_>, Vec<_>) = all.iter().partition(|alert| alert.until.is_some());
    let told = |alerts: Vec<&Alert>| alerts.into_iter().map(alert_json).collect::<Vec<_>>();
    json(JSON, &json!({ "time": ask.state.now().to_string(), "alerts": told(lasting), "ended": told(ended) }))
}

/// `/api/v1/conflicts`: an empty list would look like a clear sky, so the answer says that nothing looks for them.
pub fn conflicts(ask: &Ask) -> Answer {
    let reason = "conflicts are not computed in any profile of this version: the empty list does not mean that there are none";
    let time = ask.state.now().to_string();
    json(JSON, &json!({ "time": time, "computed": false, "reason": reason, "conflicts": [] }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(ring: &Value) -> f64 {
        let ring = ring.as_array().unwrap();
        assert_eq!(ring.first(), ring.last());
        let at = |index: usize, axis: usize| ring[index][axis].as_f64().unwrap();
        (1..ring.len()).map(|i| at(i - 1, 0) * at(i, 1) - at(i, 0) * at(i - 1, 1)).sum::<f64>() / 2.0
    }

    #[test]
    fn circles_are_right_handed_and_cut_at_the_antimeridian() {
        let plain = circle_geometry(-0.588, 52.5, 5_000.0);
        assert_eq!(plain["coordinates"][0].as_array().unwrap().len(), CORNERS + 1);
        assert!(area(&plain["coordinates"][0]) > 0.0);
        for longitude_deg in [179.99, -179.99] {
            let cut = circle_geometry(longitude_deg, -17.0, 5_000.0);
            let polygons = cut["coordinates"].as_array().unwrap();
            assert_eq!(polygons.len(), 2);
            for polygon in polygons {
                assert!(area(&polygon[0]) > 0.0);
                for place in polygon[0].as_array().unwrap() {
                    assert!(place[0].as_f64().unwrap().abs() <= 180.0);
                }
            }
        }
        assert_eq!(circle_geometry(0.0, 90.0, 5_000.0), Value::Null);
    }
}
