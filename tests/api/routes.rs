//! Answers of the other routes.

use axum::http::StatusCode;
use serde_json::Value;
use utm_fusion::api::Options;
use utm_fusion::config::{AlertArea, Area, AreaKind, SensorKind, Tiles};

use crate::common::{Site, flown};

/// RFC 7946: closed rings, outer ones counterclockwise, holes clockwise, positions on the map.
fn check_polygon(rings: &Value) {
    for (index, ring) in rings.as_array().unwrap().iter().enumerate() {
        let ring: Vec<(f64, f64)> = ring
            .as_array()
            .unwrap()
            .iter()
            .map(|place| (place[0].as_f64().unwrap(), place[1].as_f64().unwrap()))
            .collect();
        assert!(ring.len() >= 4 && ring.first() == ring.last());
        assert!(ring.iter().all(|(lng, lat)| lng.abs() <= 180.0 && lat.abs() <= 90.0));
        let area: f64 = ring.windows(2).map(|pair| pair[0].0 * pair[1].1 - pair[1].0 * pair[0].1).sum();
        assert_eq!(area > 0.0, index == 0);
    }
}

#[tokio::test]
async fn sensors_stand_where_they_are_configured() {
    let site = Site::plain();
    site.publish_status(flown().status.clone()).await;
    let json = site.get("/api/v1/sensors").await.json();
    let features = json["features"].as_array().unwrap();
    assert_eq!(features.len(), flown().config.sensors.len());
    for (feature, sensor) in features.iter().zip(&flown().config.sensors) {
        let properties = &feature["properties"];
        assert_eq!(properties["id"], sensor.id.as_str());
        match &sensor.kind {
            SensorKind::Radar(radar) => {
                assert_eq!(feature["geometry"]["coordinates"][0], radar.longitude_deg);
                assert_eq!(feature["geometry"]["coordinates"][1], radar.latitude_deg);
            }
            _ => assert!(feature["geometry"].is_null()),
        }
        for key in [
            "kind",
            "state",
            "reasons",
            "rate_hz",
            "clock_offset_s",
            "accepted",
            "refused",
            "lines",
            "last_seen",
        ] {
            assert!(properties.get(key).is_some(), "{key}: {properties}");
        }
    }
    assert!(json["unknown"].is_array());
}

#[tokio::test]
async fn coverage_and_areas_are_valid_polygons() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("config/areas");
    let site = Site::with(Options::default(), |config| {
        for sensor in &mut config.sensors {
            if let SensorKind::Radar(radar) = &mut sensor.kind {
                radar.max_range_m = Some(5_000.0);
            }
        }
        for (kind, name) in
            [(AreaKind::Mask, "motorway"), (AreaKind::Alert(AlertArea::default()), "airfield")]
        {
            config.areas.push(Area { kind, file: folder.join(format!("{name}.geojson")) });
        }
    });
    let coverage = site.get("/api/v1/coverage").await.json();
    for feature in coverage["features"].as_array().unwrap() {
        check_polygon(&feature["geometry"]["coordinates"]);
        assert_eq!(feature["geometry"]["coordinates"][0].as_array().unwrap().len(), 73);
    }
    let areas = site.get("/api/v1/areas").await.json();
    let features = areas["features"].as_array().unwrap();
    let kinds: Vec<_> = features.iter().map(|f| f["properties"]["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["mask", "alert"]);
    for feature in features {
        for polygon in feature["geometry"]["coordinates"].as_array().unwrap() {
            check_polygon(polygon);
        }
    }
}

#[tokio::test]
async fn coverage_area_replaces_the_range_circle() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("config/areas");
    let file = folder.join("coverage.geojson");
    let outline = [[-0.64, 52.48], [-0.54, 52.48], [-0.54, 52.53], [-0.64, 52.53], [-0.64, 52.48]];
    let sensors = &flown().config.sensors;
    for covered in sensors {
        let site = Site::with(Options::default(), |config| {
            let kind = AreaKind::Coverage { sensor: covered.id.clone() };
            config.areas.push(Area { kind, file: file.clone() });
        });
        let coverage = site.get("/api/v1/coverage").await.json();
        let mut seen = Vec::new();
        for feature in coverage["features"].as_array().unwrap() {
            let properties = &feature["properties"];
            seen.push(properties["sensor"].as_str().unwrap().to_owned());
            let range_m = sensors.iter().find(|s| s.id == seen[seen.len() - 1]).and_then(|s| match &s.kind {
                SensorKind::Radar(radar) => radar.max_range_m,
                _ => None,
            });
            assert_eq!(properties["max_range_m"].as_f64(), range_m);
            if properties["sensor"] == covered.id.as_str() {
                assert_eq!(properties["shape"], "area");
                assert_eq!(feature["geometry"]["coordinates"], serde_json::json!([[outline]]));
            } else {
                assert_eq!(properties["shape"], "circle");
                check_polygon(&feature["geometry"]["coordinates"]);
            }
        }
        // Once each: radars, which have a range, and the sensor with a coverage area.
        let wanted: Vec<_> = sensors
            .iter()
            .filter(|sensor| matches!(sensor.kind, SensorKind::Radar(_)) || sensor.id == covered.id)
            .map(|sensor| sensor.id.clone())
            .collect();
        assert_eq!(seen, wanted);
        let areas = site.get("/api/v1/areas").await.json();
        let properties = &areas["features"][0]["properties"];
        // Name in the feature; otherwise the file name "coverage" would be used.
        let name = "made up: the receiver's view";
        assert_eq!((&properties["kind"], &properties["name"]), (&"coverage".into(), &name.into()));
        assert_eq!(properties["sensor"], covered.id.as_str());
    }
}

/// Names, heights and hours of zones. Each part of a zone is a feature.
#[tokio::test]
async fn zones_are_shown_with_their_limits_as_they_are_now() {
    let ring = "[[[-0.6,52.5],[-0.5,52.5],[-0.5,52.6],[-0.6,52.5]]]";
    let part = |layer: &str| format!(r#"{{"type": "Polygon", "coordinates": {ring}, "layer": {{{layer}}}}}"#);
    let parts = [
        part(r#""lower": 0, "lowerReference": "AGL", "upper": 120, "upperReference": "AGL""#),
        part(r#""lower": 1000, "lowerReference": "AMSL", "uom": "ft""#),
    ];
    let zone = format!(
        r#"{{"type": "Feature", "properties": {{"identifier": "EGD1", "name": [{{"text": "Feld", "lang": "de"}}, {{"text":
        "Field", "lang": "en-GB"}}], "type": "REQ_AUTHORIZATION", "restrictionConditions": "ask", "limitedApplicability":
        [{{"startDateTime": "2001-01-01T00:00:00Z"}}]}},
        "geometry": {{"type": "GeometryCollection", "geometries": [{}]}}}}"#,
        parts.join(",")
    );
    let file = std::env::temp_dir().join(format!("utm-fusion-zone-{}.json", std::process::id()));
    std::fs::write(&file, zone).unwrap();
    let site = Site::with(Options::default(), |config| {
        let settings = AlertArea { ground_m: Some(90.0), ..AlertArea::default() };
        config.areas.push(Area { kind: AreaKind::Alert(settings), file: file.clone() });
    });
    std::fs::remove_file(&file).unwrap();
    let areas = site.get("/api/v1/areas").await.json();
    let features = areas["features"].as_array().unwrap();
    let shown: Vec<Value> = features.iter().map(|feature| feature["properties"].clone()).collect();
    let zone = |limit: &str, metres: f64| {
        serde_json::json!({ "kind": "alert", "name": "Field", "identifier": "EGD1", "type": "authorisation", "conditions": "ask",
            limit: metres, "active": true, "hours": "from 2001-01-01 00:00 UTC", "severity": "critical", "format": "ed-318" })
    };
    assert_eq!(shown, [zone("ceiling_m", 210.0), zone("floor_m", 304.8)]);
}

#[tokio::test]
async fn readiness_says_what_is_missing() {
    let mut site = Site::plain();
    assert_eq!(site.get("/healthz").await.status, StatusCode::OK);
    let not_yet = site.get("/readyz").await;
    assert_eq!(not_yet.status, StatusCode::SERVICE_UNAVAILABLE);
    assert_eq!(not_yet.json()["reasons"].as_array().unwrap().len(), 2);
    site.publish(1).await;
    let mut status = flown().status.clone();
    status.sensors[0].lines[0].joined = false;
    site.publish_status(status).await;
    assert_eq!(site.get("/readyz").await.json()["reasons"], serde_json::json!(["line a line is not open"]));
    site.publish_status(flown().status.clone()).await;
    assert_eq!(site.get("/readyz").await.status, StatusCode::OK);
}

#[tokio::test]
async fn status_and_info_are_complete() {
    let mut site = Site::plain();
    site.publish(1).await;
    site.publish_status(flown().status.clone()).await;
    let status = site.get("/api/v1/status").await.json();
    assert_eq!(status["latency_s"]["p50"], 6.251);
    assert_eq!(status["tally"]["received"], flown().status.tally.received);
    let info = site.get("/api/v1/info").await.json();
    assert_eq!((&info["profile"], &info["latency_s"]), (&"reference".into(), &6.25.into()));
}

#[tokio::test]
async fn readsb_and_display_data() {
    let mut site = Site::plain();
    site.publish(1).await;
    let tracks = site.get("/api/v1/tracks").await.json();
    let tracks = tracks["features"].as_array().unwrap();
    let json = site.get("/data/aircraft.json?_=123").await.json();
    let aircraft = json["aircraft"].as_array().unwrap();
    assert_eq!(aircraft.len(), tracks.len());
    let mut hexes = std::collections::BTreeSet::new();
    for (craft, track) in aircraft.iter().zip(tracks) {
        let hex = craft["hex"].as_str().unwrap();
        assert!(hex.len() == 7 && hex.starts_with('~') && hexes.insert(hex), "{hex}");
        if let Some(alt) = track["properties"]["alt"].as_f64() {
            assert!((craft["alt_geom"].as_f64().unwrap() * 0.3048 - alt).abs() < 0.16);
        }
        assert!(craft.get("alt_baro").is_none());
    }
    assert!(site.get("/data/receiver.json").await.json()["refresh"].is_u64());

    let known = tracks.iter().find(|t| t["properties"].get("uas_id").is_some()).unwrap();
    let (id, lat, lng) =
        (known["id"].as_str().unwrap(), &known["properties"]["lat"], &known["properties"]["lng"]);
    let (lat, lng) = (lat.as_f64().unwrap(), lng.as_f64().unwrap());
    let view = format!("/uss/flights?view={},{},{},{}", lat + 0.01, lng - 0.01, lat - 0.01, lng + 0.01);
    let flights = site.get(&view).await.json();
    assert!(flights["flights"].as_array().unwrap().iter().any(|flight| flight["id"] == id), "{flights}");
    let flight = flights["flights"].as_array().unwrap().iter().find(|flight| flight["id"] == id).unwrap();
    assert!(flight.get("recent_positions").is_none(), "nobody asked");
    site.publish(12).await;
    let recent = site.get(&format!("{view}&recent_positions_duration=2")).await.json();
    let recent = recent["flights"].as_array().unwrap().iter().find(|flight| flight["id"] == id).unwrap();
    let positions = recent["recent_positions"].as_array().unwrap();
    assert_eq!(positions.len(), 2, "one a second: {positions:?}");
    assert!(positions[0]["time"]["value"].as_str() < positions[1]["time"]["value"].as_str());
    // The track has left the area, but was in it within the last minute.
    let (was, is) = (&positions[0]["position"], &recent["current_state"]["position"]);
    let at = |place: &Value, axis: &str| place[axis].as_f64().unwrap();
    assert!(at(was, "lat") != at(is, "lat") && at(was, "lng") != at(is, "lng"));
    let edge = |axis: &str| (at(was, axis) + at(is, axis)) / 2.0;
    let beyond = |axis: &str| at(was, axis) + (at(was, axis) - at(is, axis)) * 5.0;
    let left =
        format!("/uss/flights?view={},{},{},{}", edge("lat"), edge("lng"), beyond("lat"), beyond("lng"));
    let left = site.get(&left).await.json();
    assert!(left["flights"].as_array().unwrap().iter().any(|flight| flight["id"] == id), "{left}");
    let details = site.get(&format!("/uss/flights/{id}/details")).await.json();
    assert_eq!(details["details"]["uas_id"]["serial_number"], known["properties"]["uas_id"]["serial_number"]);
}

#[tokio::test]
async fn the_page_is_served_under_its_policy() {
    let site = Site::plain();
    let page = site.get("/?zoom=3").await;
    assert_eq!((page.status, page.header("content-type")), (StatusCode::OK, "text/html; charset=utf-8"));
    assert!(page.header("content-security-policy").contains("default-src 'self'"));
    assert_eq!(page.header("x-content-type-options"), "nosniff");
    assert!(!page.header("content-security-policy").contains("img-src"));
    assert!(site.get("/api/v1/info").await.json().get("tiles").is_none());
}

#[tokio::test]
async fn the_server_of_the_tiles_is_the_only_other_one() {
    let url = "https://tiles.example:8443/map/{z}/{x}/{y}.png".to_owned();
    let tiles = Tiles { url, attribution: "© somebody".to_owned() };
    let site = Site::with(Options::default(), |config| config.http.tiles = Some(tiles.clone()));
    let policy = site.get("/").await.header("content-security-policy").to_owned();
    assert!(policy.contains("img-src 'self' https://tiles.example:8443; "), "{policy}");
    assert!(
        policy.starts_with("default-src 'self'; ") && policy.matches("https://").count() == 1,
        "{policy}"
    );
    let info = site.get("/api/v1/info").await.json();
    assert_eq!(info["tiles"], serde_json::json!({ "url": tiles.url, "attribution": tiles.attribution }));
}

/// A single machine has no cluster. A cluster reports owners and standbys.
#[tokio::test]
async fn cluster_members_are_listed() {
    use utm_fusion::live::{
        CellState, ClockDifference, ClockStanding, ClusterMembers, GatewayState, NodeState,
    };
    let site = Site::plain();
    assert_eq!(site.get("/api/v1/cluster").await.status, StatusCode::NOT_FOUND);
    assert_eq!(site.get("/api/v1/info").await.json()["cluster"], false);
    assert!(!site.get("/metrics").await.text.contains("cluster_"));

    site.writer.publish_members(ClusterMembers {
        region: "north".to_owned(),
        cells: vec![CellState {
            cell: "all".to_owned(),
            owner: Some("node-1".to_owned()),
            lease: 7,
            step: 5,
            left_out: "plots",
            ..CellState::default()
        }],
        nodes: vec![NodeState {
            node: "node-1".to_owned(),
            part: "owner",
            takeovers: 2,
            owns: vec!["all".to_owned()],
            ..NodeState::default()
        }],
        gateways: vec![
            GatewayState { node: "gateway-1".to_owned(), waiting: 3, ..GatewayState::default() },
            GatewayState {
                node: "gateway-2".to_owned(),
                clock: ClockStanding::Good,
                clock_bound_s: Some(0.0025),
                ..GatewayState::default()
            },
        ],
        clocks: vec![ClockDifference {
            gateway: "gateway-1".to_owned(),
            other: "gateway-2".to_owned(),
            difference_s: -0.05,
            datagrams: 60,
            apart: true,
        }],
        shown: 40,
        missing: 1,
        twice: 2,
        ..ClusterMembers::default()
    });
    let json = site.get("/api/v1/cluster").await.json();
    assert_eq!((&json["cells"][0]["owner"], json["cells"][0].get("standby")), (&Value::from("node-1"), None));
    // An unknown clock has no number, and is not good.
    let clock = |gateway: usize| {
        (&json["gateways"][gateway]["clock"], json["gateways"][gateway].get("clock_bound_s"))
    };
    assert_eq!(clock(0), (&Value::from("unknown"), None));
    assert_eq!(clock(1), (&Value::from("good"), Some(&Value::from(0.0025))));
    assert_eq!(json["clocks"][0]["difference_s"], -0.05);
    let metrics = site.get("/metrics").await.text;
    assert!(!metrics.contains("clock_bound_seconds{gateway=\"gateway-1\"}"), "{metrics}");
    for line in [
        "utm_fusion_cluster_clock_bound_seconds{gateway=\"gateway-2\"} 0.0025",
        "utm_fusion_cluster_clock_difference_seconds{gateway=\"gateway-1\",other=\"gateway-2\"} -0.05",
        "utm_fusion_cluster_owner{cell=\"all\"} 1",
        "utm_fusion_cluster_standby{cell=\"all\"} 0",
        "utm_fusion_cluster_epoch{cell=\"all\"} 7",
        "utm_fusion_cluster_takeovers_total{node=\"node-1\"} 2",
        "utm_fusion_cluster_waiting{gateway=\"gateway-1\"} 3",
        "utm_fusion_cluster_missing_slots_total 1",
        "utm_fusion_cluster_twice_total 2",
        "utm_fusion_cluster_shed_step{cell=\"all\"} 5",
        "utm_fusion_cluster_cell_missing{cell=\"all\"} 0",
        "utm_fusion_cluster_cells_owned{node=\"node-1\"} 1",
    ] {
        assert!(metrics.lines().any(|found| found == line), "{line}\n{metrics}");
    }
}
