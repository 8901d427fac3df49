//! Files that are almost valid: other reference systems, degenerate polygons, national members.

use serde_json::{Value, json};

use super::*;

#[expect(clippy::needless_pass_by_value, reason = "values are written where they are used")]
fn feature(coordinates: Value, properties: Value) -> Value {
    let geometry = json!({ "type": "Polygon", "coordinates": coordinates });
    json!({ "type": "Feature", "geometry": geometry, "properties": properties })
}

fn file(features: &[Value]) -> Value {
    json!({ "type": "FeatureCollection", "features": features })
}

fn square(west: f64, south: f64, east: f64, north: f64) -> Value {
    json!([[[west, south], [east, south], [east, north], [west, north], [west, south]]])
}

fn plain() -> Value {
    feature(square(10.0, 50.0, 11.0, 51.0), json!({ "title": "Aerodrome" }))
}

#[test]
fn crs_other_than_wgs84_is_refused_by_name() {
    let named = |name: &str| json!({ "type": "name", "properties": { "name": name } });
    for name in [
        "urn:ogc:def:crs:OGC:1.3:CRS84",
        "urn:ogc:def:crs:EPSG::4326",
        "EPSG:4326",
        "http://www.opengis.net/def/crs/EPSG/0/4258",
    ] {
        let mut text = file(&[plain()]);
        text["crs"] = named(name);
        assert_eq!(areas(&text.to_string(), &alert(|_| {})).zones().count(), 1, "{name}");
    }
    let mut unsaid = file(&[plain()]);
    unsaid["crs"] = Value::Null;
    assert_eq!(areas(&unsaid.to_string(), &alert(|_| {})).zones().count(), 1);
    let link = json!({ "type": "link", "properties": { "href": "proj4" } });
    for crs in [named("urn:ogc:def:crs:EPSG::3857"), named("4326 of ours"), link] {
        // A `crs` of the file, of a feature, and of a geometry.
        let mut texts = [file(&[plain()]), file(&[plain()]), file(&[plain()])];
        texts[0]["crs"] = crs.clone();
        texts[1]["features"][0]["crs"] = crs.clone();
        texts[2]["features"][0]["geometry"]["crs"] = crs.clone();
        for text in texts {
            let problem = refusal(&text.to_string(), &alert(|_| {}));
            assert!(problem.contains("crs = ") && problem.contains("EPSG:4326"), "{problem}");
        }
    }
}

#[test]
fn polygon_over_the_antimeridian_is_refused() {
    let uncut = file(&[feature(square(179.9, -17.1, -179.9, -16.9), json!({}))]);
    let problem = refusal(&uncut.to_string(), &alert(|_| {}));
    assert!(problem.contains("zone 1: has an edge from longitude 179.9 to -179.9"), "{problem}");
    assert!(problem.contains("RFC 7946"), "{problem}");
    let halves = [square(179.9, -17.1, 180.0, -16.9), square(-180.0, -17.1, -179.9, -16.9)];
    let cut = file(&halves.map(|half| feature(half, json!({}))));
    let alerts = areas(&cut.to_string(), &alert(|_| {})).alerts();
    let is_inside = |longitude_deg| !alerts.around(visitor(longitude_deg, -17.0, None), 0.0).is_empty();
    assert_eq!([179.95, -179.95, 0.0].map(is_inside), [true, true, false]);
    // An edge of 180 degrees is allowed.
    let half = file(&[feature(square(-90.0, 50.0, 90.0, 51.0), json!({}))]);
    assert_eq!(areas(&half.to_string(), &alert(|_| {})).zones().count(), 1);
}

#[test]
fn polygon_with_swapped_coordinates_is_refused() {
    let swapped = file(&[feature(square(-17.1, 179.9, -16.9, 179.99), json!({}))]);
    let problem = refusal(&swapped.to_string(), &alert(|_| {}));
    assert!(problem.contains("latitude and longitude seem to be swapped"), "{problem}");
    let beyond = file(&[feature(square(179.9, 10.0, 180.1, 11.0), json!({}))]);
    let problem = refusal(&beyond.to_string(), &alert(|_| {}));
    assert!(problem.contains("beyond") && !problem.contains("swapped"), "{problem}");
}

#[test]
fn polygon_without_area_is_refused() {
    let point = json!([[[10.1, 50], [10.1, 50], [10.1, 50], [10.1, 50]]]);
    let line = json!([[[10.1, 50.1], [10.2, 50.2], [10.3, 50.3], [10.1, 50.1]]]);
    for ring in [point, line] {
        let problem = refusal(&file(&[feature(ring, json!({}))]).to_string(), &alert(|_| {}));
        assert!(problem.contains("zone 1: has no area"), "{problem}");
    }
    // A square of 1 m is large enough.
    let small = file(&[feature(square(10.0, 50.0, 10.000_014, 50.000_009), json!({}))]);
    assert_eq!(areas(&small.to_string(), &alert(|_| {})).zones().count(), 1);
}

#[test]
fn plain_geojson_is_refused_with_feature_and_member() {
    let point = json!({ "type": "Feature", "properties": { "title": "Airfield" },
        "geometry": { "type": "Point", "coordinates": [10, 50] } });
    let problem = refusal(&file(&[plain(), point]).to_string(), &alert(|_| {}));
    assert!(problem.contains("zone 2 (\"Airfield\"): geometry.type = \"Point\""), "{problem}");
    assert!(problem.contains("no polygon") && problem.contains("RFC 7946"), "{problem}");
}

#[test]
fn height_limit_in_plain_geojson_is_refused() {
    for member in ["CEILING", "ceiling_ft", "UPPER_VAL", "Max Altitude", "floor"] {
        let text =
            file(&[plain(), feature(square(10.0, 50.0, 11.0, 51.0), json!({ member: 200 }))]).to_string();
        for area in [alert(|_| {}), Area { kind: AreaKind::Mask, file: PathBuf::from("mask.geojson") }] {
            let problem = refusal(&text, &area);
            assert!(problem.contains(&format!("zone 2: properties.{member} = 200")), "{problem}");
        }
        // Heights from the configuration override those of the file.
        let limited = areas(&text, &alert(|settings| settings.ceiling_m = Some(100.0)));
        let ceilings = limited.parts().map(|part| part.band.above_sea(47.0).ceiling_m).collect::<Vec<_>>();
        assert_eq!(ceilings, [Some(100.0); 2]);
    }
    let described = json!({ "CEILING": null, "Elevation_meter": 5.2, "height": 120, "upper_limits_of": "x" });
    let text = file(&[feature(square(10.0, 50.0, 11.0, 51.0), described)]).to_string();
    assert_eq!(areas(&text, &alert(|_| {})).zones().count(), 1);
}

/// A zone as published by Estonia: ED-269 within the properties of a feature.
fn estonian(coordinates: Value, applicability: Value) -> Value {
    let mut zone = feature(
        coordinates,
        json!({
            "identifier": "EE902", "country": "EST", "name": "Sanctuary", "type": "COMMON",
            "restriction": "PROHIBITED", "reason": "Nature", "extendedProperties": {},
            "geometry": {
                "uomDimensions": "FT", "lowerLimit": 0, "lowerVerticalReference": "AGL",
                "upperLimit": 1000, "upperVerticalReference": "AGL"
            },
            "lower": "SFC", "lowerMeters": 0, "upper": "1000 FT AGL", "upperMeters": 305, "hidden": false
        }),
    );
    zone["properties"]["applicability"] = applicability;
    zone
}

#[test]
fn ed269_zone_in_geojson_properties_has_its_limits() {
    let always = json!([{ "permanent": "YES", "schedule": [] }]);
    let zone = estonian(square(25.0, 58.8, 25.1, 58.9), always.clone());
    // The whole Earth except the country: its outer ring runs along the poles.
    let earth = square(-180.0, -90.0, 180.0, 90.0)[0].clone();
    let country = square(22.0, 57.5, 28.0, 59.7)[0].clone();
    let abroad = estonian(json!([earth, country]), always);
    let ground = |area: &mut AlertArea| area.ground_m = Some(50.0);
    let alerts = areas(&file(&[zone, abroad]).to_string(), &alert(ground)).alerts();
    let count = |longitude_deg, latitude_deg, height_m| {
        alerts.around(visitor(longitude_deg, latitude_deg, Some(height_m)), 0.0).len()
    };
    assert_eq!(
        [count(25.05, 58.85, 300.0), count(25.05, 58.85, 500.0)],
        [1, 0],
        "up to 1000 ft above ground"
    );
    assert_eq!([count(25.5, 58.85, 300.0), count(10.0, 50.0, 300.0)], [0, 1]);
    // Limits that are not understood are refused by the name of their member.
    for (change, part) in [
        (json!({ "permanent": "MAYBE" }), "permanent"),
        (json!({ "permanent": "NO", "schedule": [] }), "no time is given"),
    ] {
        let zone = estonian(square(25.0, 58.8, 25.1, 58.9), json!([change]));
        let problem = refusal(&file(&[zone]).to_string(), &alert(ground));
        assert!(problem.contains("zone 1 (\"EE902\")") && problem.contains(part), "{problem}");
    }
    let mut layered = estonian(square(25.0, 58.8, 25.1, 58.9), json!([{ "permanent": "YES" }]));
    layered["properties"]["geometry"]["floor"] = json!(3);
    let problem = refusal(&file(&[layered]).to_string(), &alert(ground));
    assert!(problem.contains("floor"), "{problem}");
}
