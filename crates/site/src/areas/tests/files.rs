//! Zone files that are read, and zone files that are refused.

use serde_json::{Value, json};

use super::*;
use crate::config::AreaSeverity;

const RING: &str = "[[[10, 50], [11, 50], [11, 51], [10, 51], [10, 50]], [[10.4, 50.4], [10.6, 50.4], [10.6, 50.6], [10.4, 50.4]]]";

fn ring() -> Value {
    json!([[[10, 50], [11, 50], [11, 51], [10, 50]]])
}

/// An ED-318 zone with these members in its properties and its geometry.
fn zone(properties: Value, geometry: Value) -> String {
    let mut feature = json!({
        "type": "Feature",
        "properties": { "identifier": "EDR1", "country": "DEU", "type": "PROHIBITED", "variant": "COMMON",
            "zoneAuthority": [{ "purpose": "AUTHORIZATION" }] },
        "geometry": { "type": "Polygon", "coordinates": ring() },
    });
    for (into, from) in [("properties", properties), ("geometry", geometry)] {
        for (name, value) in from.as_object().unwrap() {
            feature[into][name] = value.clone();
        }
    }
    json!({ "type": "FeatureCollection", "features": [feature] }).to_string()
}

/// An ED-269 zone with these members and one volume.
fn zone_269(members: &Value, volume: &Value) -> String {
    let mut zone = json!({
        "identifier": "EDR1", "country": "DEU", "restriction": "PROHIBITED",
        "geometry": [{ "uomDimensions": "M", "horizontalProjection": { "type": "Polygon", "coordinates": ring() } }],
    });
    zone.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
    zone["geometry"][0].as_object_mut().unwrap().extend(volume.as_object().unwrap().clone());
    json!({ "UASZoneList": [zone] }).to_string()
}

/// The band of the only part.
fn band(text: &str, area: &Area) -> BandAmsl {
    let areas = areas(text, area);
    let bands: Vec<Band> = areas.parts().map(|part| part.band).collect();
    assert_eq!(bands.len(), 1);
    bands[0].above_sea(47.0)
}

#[test]
fn mask_has_edges_and_holes() {
    let mask = Area { kind: AreaKind::Mask, file: PathBuf::from("mask.geojson") };
    let masks = areas(&format!(r#"{{"type": "Polygon", "coordinates": {RING}}}"#), &mask).masks();
    for (longitude_deg, latitude_deg, inside) in [
        (10.1, 50.1, true),
        (10.0, 50.5, true),
        (10.55, 50.45, false),
        (9.9, 50.5, false),
        (50.5, 10.5, false),
    ] {
        assert_eq!(masks.contain(longitude_deg, latitude_deg), inside, "{longitude_deg} {latitude_deg}");
    }
    assert!(!Masks::default().contain(10.1, 50.1));
}

#[test]
fn area_is_named_by_its_feature_or_file() {
    let feature = |properties: &str, west: u8| {
        let east = west + 1;
        let ring = format!("[[{west}, 50], [{east}, 50], [{east}, 51], [{west}, 50]]");
        format!(
            r#"{{"type": "Feature", "properties": {properties},
                "geometry": {{"type": "Polygon", "coordinates": [{ring}]}}}}"#
        )
    };
    let named = [
        feature(r#"{"name": "Runway 27"}"#, 10),
        feature(r#"{"name": "Runway 27"}"#, 20),
        feature(r#"{"name": " "}"#, 30),
        feature("null", 40),
    ];
    let text = format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, named.join(","));
    let areas = areas(&text, &alert(|_| {}));
    let names: Vec<&str> = areas.zones().map(|(_, zone)| &*zone.name).collect();
    assert_eq!(names, ["Runway 27", "Runway 27", "field", "field"]);
    let alerts = areas.alerts();
    let around = |longitude_deg| {
        let visitor = visitor(longitude_deg, 50.1, None);
        alerts.around(visitor, 0.0).into_iter().map(|presence| presence.label.to_owned()).collect::<Vec<_>>()
    };
    assert_eq!([10.5, 20.5, 30.5, 40.5].map(around), [["Runway 27"], ["Runway 27"], ["field"], ["field"]]);
}

#[test]
fn invalid_area_is_refused_with_the_reason() {
    for (text, part) in [
        ("", "no GeoJSON"),
        ("{}", "no GeoJSON"),
        (r#"{"type": "Point", "coordinates": [10, 50]}"#, "no polygon"),
        (r#"{"type": "FeatureCollection", "features": []}"#, "no polygon"),
        (r#"{"type": "Polygon", "coordinates": [[[10, 95], [11, 95], [11, 96], [10, 95]]]}"#, "beyond"),
    ] {
        let problem = refusal(text, &alert(|_| {}));
        assert!(problem.contains(part), "{text}: {problem}");
    }
}

/// Members that only resemble those of a zone.
#[test]
fn plain_geojson_is_no_zone() {
    let properties = [
        json!({ "name": "a road", "type": "motorway", "layer": 1, "validFrom": "2019-01-01" }),
        json!({ "layer": "masks", "extent": [10, 50, 11, 51], "reason": "birds", "message": "" }),
        Value::Null,
    ];
    let geometry = json!({ "type": "Polygon", "coordinates": ring() });
    let features = properties
        .map(|properties| json!({ "type": "Feature", "geometry": geometry, "properties": properties }));
    let text = json!({ "type": "FeatureCollection", "name": "all", "features": features }).to_string();
    let mut settings = alert(|settings| settings.floor_m = Some(100.0));
    let areas = areas(&text, &settings);
    assert!(areas.zones().all(|(_, zone)| zone.format == Format::GeoJson && zone.kind.is_none()));
    assert!(areas.parts().all(|part| part.band == Band::amsl(Some(100.0), None)), "as it is configured");
    settings.kind = AreaKind::Mask;
    assert_eq!(contents(&text, &settings).unwrap().zones.len(), 3);
}

#[test]
fn heights_are_converted_to_mean_sea_level() {
    let on = |ground_m| alert(move |settings| settings.ground_m = ground_m);
    let layer = |layer: Value| zone(json!({}), json!({ "layer": layer }));
    let limits = |floor_m, ceiling_m| BandAmsl { floor_m, ceiling_m };
    for (text, ground_m, floor_m, ceiling_m) in [
        (
            layer(
                json!({ "lower": 50, "lowerReference": "AMSL", "upper": "120.5", "upperReference": "AMSL" }),
            ),
            None,
            Some(50.0),
            Some(120.5),
        ),
        (
            layer(
                json!({ "lower": 0, "lowerReference": "AGL", "upper": 400, "upperReference": "AGL", "uom": "ft" }),
            ),
            Some(200.0),
            None,
            Some(321.92),
        ),
        (
            layer(
                json!({ "lower": 100, "lowerReference": "WGS84", "upper": 99999, "upperReference": "AGL", "uom": "m" }),
            ),
            None,
            Some(53.0),
            None,
        ),
        (
            layer(
                json!({ "lower": 0, "lowerReference": "AMSL", "upper": null, "upperReference": "AGL", "uom": "M" }),
            ),
            None,
            Some(0.0),
            None,
        ),
        (
            zone(
                json!({ "verticalLayer": { "UOM": "M", "upper": 900, "upperReference": "AGL", "lower": 45, "lowerReference": "AGL" } }),
                json!({}),
            ),
            Some(100.0),
            Some(145.0),
            Some(1000.0),
        ),
        (
            zone_269(
                &json!({}),
                &json!({ "uomDimensions": "FT", "lowerLimit": 1000, "lowerVerticalReference": "AMSL", "upperLimit": "2000", "upperVerticalReference": "AMSL" }),
            ),
            None,
            Some(304.8),
            Some(609.6),
        ),
        (zone(json!({}), json!({})), None, None, None),
    ] {
        assert_eq!(band(&text, &on(ground_m)), limits(floor_m, ceiling_m), "{text}");
    }
    // A zone without a layer takes the heights of the configuration; a layer has its own.
    let configured = alert(|settings| settings.ceiling_m = Some(300.0));
    assert_eq!(band(&zone(json!({}), json!({})), &configured), limits(None, Some(300.0)));
    let own = layer(json!({ "lower": 10, "lowerReference": "AMSL" }));
    assert_eq!(band(&own, &configured), limits(Some(10.0), None));
}

#[test]
fn every_unknown_member_is_named() {
    let plain = alert(|_| {});
    let layer = |layer: Value| zone(json!({}), json!({ "layer": layer }));
    let period = |period: Value| zone(json!({ "limitedApplicability": [period] }), json!({}));
    let daily = |daily: Value| period(json!({ "schedule": [daily] }));
    for (text, path, more) in [
        (
            layer(json!({ "upper": 120, "upperReference": "AGL" })),
            "geometry.layer.upper = 120",
            "add ground_m",
        ),
        (
            layer(json!({ "upper": 95, "upperReference": "STD", "uom": "FL" })),
            "geometry.layer.uom = \"FL\"",
            "m and ft",
        ),
        (
            layer(json!({ "upper": 950, "upperReference": "STD" })),
            "geometry.layer.upperReference = \"STD\"",
            "AMSL, AGL and WGS84",
        ),
        (layer(json!({ "upper": 950 })), "geometry.layer.upperReference is missing", "AMSL"),
        (
            layer(json!({ "upper": "high", "upperReference": "AMSL" })),
            "geometry.layer.upper = \"high\"",
            "a number",
        ),
        (
            layer(json!({ "lower": 9, "lowerReference": "AMSL", "upper": 9, "upperReference": "AMSL" })),
            "geometry.layer = {",
            "above the lower",
        ),
        (layer(json!({ "floor": 9 })), "geometry.layer.floor = 9", "lowerReference"),
        (zone(json!({ "type": "NO_FLY" }), json!({})), "properties.type = \"NO_FLY\"", "PROHIBITED"),
        (zone(json!({ "type": null }), json!({})), "properties.type is missing", ""),
        (zone(json!({ "lowerLimit": 50 }), json!({})), "properties.lowerLimit = 50", "not looked for"),
        (
            zone(json!({}), json!({ "type": "LineString", "coordinates": [[1, 2], [3, 4]] })),
            "geometry.type = \"LineString\"",
            "Polygon",
        ),
        (
            zone(json!({}), json!({ "type": "Point", "coordinates": [10, 50] })),
            "geometry.extent is missing",
            "circle",
        ),
        (
            zone(
                json!({}),
                json!({ "type": "Point", "coordinates": [10, 50], "extent": { "subType": "Ellipse", "radius": 5 } }),
            ),
            "geometry.extent.subType = \"Ellipse\"",
            "Circle",
        ),
        (
            zone(
                json!({}),
                json!({ "type": "Point", "coordinates": [10, 89.99], "extent": { "subType": "Circle", "radius": 5000 } }),
            ),
            "around a pole",
            "",
        ),
        (
            zone(json!({}), json!({ "coordinates": [[[190, 50], [191, 50], [191, 51], [190, 50]]] })),
            "beyond",
            "",
        ),
        (
            period(json!({ "startDateTime": "soon" })),
            "limitedApplicability[0].startDateTime = \"soon\"",
            "2026-06-15",
        ),
        (
            period(json!({ "startDateTime": "2026-06-15T09:00:00" })),
            "startDateTime = \"2026-06-15T09:00:00\"",
            "add time_zone",
        ),
        (
            period(json!({ "startDateTime": "2026-06-15T09:00:00Z", "endDateTime": "2026-06-15T09:00:00Z" })),
            "limitedApplicability[0] = {",
            "behind startDateTime",
        ),
        (period(json!({ "until": "2026" })), "limitedApplicability[0].until = \"2026\"", "endDateTime"),
        (
            daily(json!({ "day": ["ANY"], "startEvent": "SR", "endEvent": "SS" })),
            "schedule[0].startEvent = \"SR\"",
            "daylight",
        ),
        (
            daily(json!({ "day": ["HOL"], "startTime": "16:00Z", "endTime": "17:00Z" })),
            "schedule[0].day[0] = \"HOL\"",
            "MON",
        ),
        (daily(json!({ "day": "SAT", "startTime": "16:00Z" })), "schedule[0] = {", "both"),
        (daily(json!({ "day": "SAT" })), "schedule[0] = {", "add time_zone"),
        (
            daily(json!({ "startTime": "16:00", "endTime": "17:00" })),
            "startTime = \"16:00\"",
            "add time_zone",
        ),
        (daily(json!({ "startTime": "4 pm", "endTime": "17:00" })), "startTime = \"4 pm\"", ""),
        (
            daily(json!({ "startTime": "16:00Z", "endTime": "17:00+01:00" })),
            "endTime = \"17:00+01:00\"",
            "startTime",
        ),
        (zone_269(&json!({ "restriction": "CLOSED" }), &json!({})), "restriction = \"CLOSED\"", "PROHIBITED"),
        (
            zone_269(&json!({ "applicability": [{ "permanent": "NO" }] }), &json!({})),
            "applicability[0] = {",
            "no time",
        ),
        (
            zone_269(&json!({ "applicability": [{ "permanent": "MAYBE" }] }), &json!({})),
            "applicability[0].permanent = \"MAYBE\"",
            "YES",
        ),
        (
            zone_269(
                &json!({}),
                &json!({ "uomDimensions": "FT", "horizontalProjection": { "type": "Circle", "center": [10, 50], "radius": 100 } }),
            ),
            "geometry[0].uomDimensions = \"FT\"",
            "circles",
        ),
        (
            zone_269(
                &json!({}),
                &json!({ "horizontalProjection": { "type": "Circle", "center": [10, 50], "radius": -1 } }),
            ),
            "radius is not",
            "",
        ),
        (
            zone_269(&json!({}), &json!({ "horizontalProjection": null })),
            "geometry[0].horizontalProjection is missing",
            "",
        ),
        (zone_269(&json!({}), &json!({ "ceiling": 5 })), "geometry[0].ceiling = 5", "upperLimit"),
    ] {
        let problem = refusal(&text, &plain);
        assert!(problem.starts_with("zone 1 (\"EDR1\"): "), "{problem}");
        assert!(problem.contains(path) && problem.contains(more), "{problem}\nhas not: {path} … {more}");
    }
}

#[test]
fn first_faults_are_named_and_the_rest_counted() {
    let mut file: Value = serde_json::from_str(&zone(json!({ "type": "NO_FLY" }), json!({}))).unwrap();
    let feature = file["features"][0].clone();
    file["features"].as_array_mut().unwrap().extend(vec![feature; 4]);
    let problem = refusal(&file.to_string(), &alert(|_| {}));
    assert_eq!(problem.matches("NO_FLY").count(), 3, "{problem}");
    assert!(problem.contains("zone 3 (") && problem.ends_with("2 more zones"), "{problem}");
}

#[test]
fn limits_without_alert_are_refused() {
    let mask = Area { kind: AreaKind::Mask, file: PathBuf::from("mask.json") };
    let low = zone(json!({}), json!({ "layer": { "upper": 120, "upperReference": "AGL" } }));
    let short =
        zone(json!({ "limitedApplicability": [{ "endDateTime": "2027-01-01T00:00:00Z" }] }), json!({}));
    for text in [low, short] {
        let problem = refusal(&text, &mask);
        assert!(
            problem.contains("EDR1 holds at some heights or times only") && problem.contains("\"mask\""),
            "{problem}"
        );
    }
    let always =
        zone(json!({ "type": "CONDITIONAL" }), json!({ "layer": { "lower": 0, "lowerReference": "AGL" } }));
    assert_eq!(contents(&always, &mask).unwrap().zones.len(), 1);
}

#[test]
fn zone_names_are_in_the_chosen_language() {
    let texts = json!([{ "text": "Naturobjekt", "lang": "de-CH" }, { "text": "Objet naturel", "lang": "fr-CH" },
        { "text": "Nature", "lang": "en-GB" }, { "text": "Nature US", "lang": "en-US" }]);
    let named = |name: &Value, language: &str| {
        let area = alert(|settings| settings.language = language.to_owned());
        let areas = areas(&zone(json!({ "name": name }), json!({})), &area);
        areas.zones().map(|(_, zone)| zone.label()).collect::<Vec<_>>().join("")
    };
    for (language, name) in [
        ("en", "Nature"),
        ("en-US", "Nature US"),
        ("FR", "Objet naturel"),
        ("de-AT", "Naturobjekt"),
        ("rm", "Naturobjekt"),
    ] {
        assert_eq!(named(&texts, language), format!("{name} (EDR1)"));
    }
    assert_eq!(named(&json!("Field"), "en"), "Field (EDR1)");
    assert_eq!(named(&json!([{ "lang": "en" }, { "text": "Feld", "lang": "de" }]), "en"), "Feld (EDR1)");
    assert_eq!(named(&json!([]), "en"), "EDR1");
    assert_eq!(named(&json!("EDR1"), "en"), "EDR1");
}

#[test]
fn file_has_validity_times() {
    let dated = |metadata: Value| {
        let mut file: Value = serde_json::from_str(&zone(json!({}), json!({}))).unwrap();
        file["metadata"] = metadata;
        file.to_string()
    };
    let problem = refusal(&dated(json!({ "validFrom": { "purposely": "invalid" } })), &alert(|_| {}));
    assert!(problem.contains("metadata.validFrom = {"), "{problem}");
    let areas = areas(
        &dated(json!({ "validFrom": "2026-01-01T00:00:00Z", "validTo": "2026-12-31T00:00:00+01:00" })),
        &alert(|_| {}),
    );
    assert_eq!(areas.warnings(at("2026-12-30T22:59:59Z")), [""; 0]);
    let [warning] = &areas.warnings(at("2026-12-30T23:00:00Z"))[..] else { panic!("it is replaced") };
    assert!(warning.contains("2026-12-30T23:00:00"), "{warning}");
}

#[test]
fn zone_type_gives_the_severity() {
    let severity_of = |kind: &str, set: Option<AreaSeverity>| {
        let area = alert(|settings| settings.severity = set);
        let alerts = areas(&zone(json!({ "type": kind }), json!({})), &area).alerts();
        let found =
            alerts.around(visitor(10.9, 50.5, None), 0.0).into_iter().map(|presence| presence.severity);
        found.collect::<Vec<_>>()
    };
    for (kind, severity) in [
        ("PROHIBITED", Some(AreaSeverity::Critical)),
        ("REQ_AUTHORIZATION", Some(AreaSeverity::Critical)),
        ("REQ_AUTHORISATION", Some(AreaSeverity::Critical)),
        ("CONDITIONAL", Some(AreaSeverity::Warning)),
        ("USPACE", Some(AreaSeverity::Warning)),
        ("NO_RESTRICTION", None),
    ] {
        assert_eq!(severity_of(kind, None), Vec::from_iter(severity), "{kind}");
        let set = severity.map(|_| AreaSeverity::Warning);
        assert_eq!(severity_of(kind, Some(AreaSeverity::Warning)), Vec::from_iter(set), "{kind}");
    }
}

#[test]
fn allowed_aircraft_and_those_above_raise_no_alert() {
    let area = alert(|settings| settings.allow = vec!["ALPHA".to_owned()]);
    let layer = json!({ "layer": { "lower": 100, "lowerReference": "AMSL", "upper": 200, "upperReference": "AMSL" } });
    let alerts = areas(&zone(json!({}), layer), &area).alerts();
    let count = |visitor: Visitor<'_>| alerts.around(visitor, 0.0).len();
    let inside = |altitude_m| visitor(10.9, 50.5, altitude_m);
    assert_eq!([Some(99.9), Some(100.0), Some(200.0), Some(200.1)].map(|m| count(inside(m))), [0, 1, 1, 0]);
    assert_eq!(count(Visitor { serial: Some("ALPHA"), ..inside(Some(150.0)) }), 0);
    assert_eq!(count(Visitor { serial: Some("BRAVO"), ..inside(Some(150.0)) }), 1);
    // An aircraft of unknown altitude may be inside, and is reported so.
    let nobody = inside(None);
    let unknown: Vec<bool> =
        alerts.around(nobody, 0.0).into_iter().map(|presence| presence.is_height_unknown).collect();
    assert_eq!(unknown, [true]);
    let of_all_heights = areas(&zone(json!({}), json!({})), &area).alerts();
    let unknown: Vec<bool> =
        of_all_heights.around(nobody, 0.0).into_iter().map(|presence| presence.is_height_unknown).collect();
    assert_eq!(unknown, [false], "it is inside whatever its height");
}

/// If several zones have the same label, the one with the highest severity is reported.
#[test]
fn zones_with_one_name_are_one_area() {
    let mut file: Value = serde_json::from_str(&zone(json!({ "type": "CONDITIONAL" }), json!({}))).unwrap();
    for kind in ["PROHIBITED", "NO_RESTRICTION"] {
        let mut feature = file["features"][0].clone();
        feature["properties"]["type"] = kind.into();
        file["features"].as_array_mut().unwrap().push(feature);
    }
    let areas = areas(&file.to_string(), &alert(|_| {}));
    assert_eq!(areas.zones().count(), 3);
    let alerts = areas.alerts();
    let found: Vec<_> = alerts
        .around(visitor(10.9, 50.5, None), 0.0)
        .into_iter()
        .map(|presence| presence.zone.kind)
        .collect();
    assert_eq!(found, [Some(ZoneKind::Prohibited)]);
}
