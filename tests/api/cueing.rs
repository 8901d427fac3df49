//! Directions in which cameras should look.

use serde_json::Value;

use crate::common::Site;

const CAMERA: [f64; 2] = [52.5, -0.6];

/// Azimuth of a place from the camera on a plane, degrees clockwise from north.
fn azimuth_deg(track: &Value) -> f64 {
    let degrees = |name: &str| track["properties"][name].as_f64().unwrap();
    let north = degrees("lat") - CAMERA[0];
    let east = (degrees("lng") - CAMERA[1]) * CAMERA[0].to_radians().cos();
    east.atan2(north).to_degrees().rem_euclid(360.0)
}

#[tokio::test]
async fn camera_is_sent_to_aircraft_in_conflict_and_unidentified_ones() {
    let mut site = Site::with_camera(CAMERA);
    let mut reasons = std::collections::BTreeSet::new();
    for _ in 0..10 {
        site.publish(4).await;
        let answer = site.get("/api/v1/cueing?limit=100").await.json();
        let camera = &answer["cameras"][0];
        assert_eq!((&camera["sensor"], &camera["oriented"]), (&"mast".into(), &false.into()));
        let targets = camera["targets"].as_array().unwrap();
        let now = site.get("/api/v1/tracks?at=now").await.json();
        let tracks = now["features"].as_array().unwrap();
        let conflicts = site.get("/api/v1/conflicts?level=warning").await.json();
        let in_conflict = |id: &Value| {
            conflicts["conflicts"].as_array().unwrap().iter().any(|pair| pair["a"] == *id || pair["b"] == *id)
        };
        assert_eq!(answer["time"], now["time"]);
        for track in tracks {
            let cue = targets.iter().find(|cue| cue["track"] == track["id"]);
            let is_unidentified = track["properties"]["source"] == "radar";
            assert_eq!(cue.is_some(), is_unidentified || in_conflict(&track["id"]), "{track}");
            let Some(cue) = cue else { continue };
            let off = cue["azimuth_deg"].as_f64().unwrap() - azimuth_deg(track);
            assert!((off + 180.0).rem_euclid(360.0) - 180.0 < 0.3, "{cue} {track}");
            assert_eq!(cue["stated_azimuth_deg"], cue["azimuth_deg"], "the orientation is as configured");
            assert!(cue["azimuth_deviation_deg"].as_f64().unwrap() > 0.0, "{cue}");
            reasons.insert(cue["reason"].as_str().unwrap().to_owned());
        }
        let order = ["violation", "warning", "uncooperative", "untrusted", "unidentified"];
        let rank = |cue: &Value| order.iter().position(|reason| cue["reason"] == *reason).unwrap();
        assert!(targets.iter().map(rank).is_sorted(), "{targets:?}");
        let few = site.get("/api/v1/cueing?sensor=mast&limit=1").await.json();
        assert!(few["cameras"][0]["targets"].as_array().unwrap().len() <= 1);
    }
    assert!(reasons.contains("unidentified") && reasons.len() > 1, "{reasons:?}");
}

#[tokio::test]
async fn cueing_of_a_sensor_that_is_no_camera_is_refused() {
    let site = Site::with_camera(CAMERA);
    assert_eq!(site.get("/api/v1/cueing?sensor=gamekeeper").await.status, 400);
    assert_eq!(site.get("/api/v1/cueing?limit=0").await.status, 400);
}
