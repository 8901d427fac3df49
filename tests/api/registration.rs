//! Registration of radars in `/api/v1/sensors`, `/metrics` and the alerts.

use fusion::learning::{LearntValue, VelocityErrors, VelocityVerdict};
use fusion::operational::Step;
use jiff::SignedDuration;
use serde_json::Value;
use utm_fusion::config::Registration;
use utm_fusion::live::{RegistrationStatus, Status};

use crate::common::Site;

/// Registration of the radar in the status of the service.
fn radars(status: &mut Status) -> &mut RegistrationStatus {
    status.sensors.iter_mut().find_map(|sensor| sensor.registration.as_mut()).unwrap()
}

async fn told(site: &Site) -> (Value, Value) {
    let sensors = site.get("/api/v1/sensors").await.json();
    let radar = sensors["features"].as_array().unwrap().iter().find(|f| f["properties"]["kind"] == "radar");
    let radar = radar.unwrap()["properties"].clone();
    (radar["registration"].clone(), radar["id"].clone())
}

#[tokio::test]
async fn registration_of_a_radar_is_reported() {
    let site = Site::operational();
    let mut status = site.status();
    let estimate = radars(&mut status).estimate.unwrap();
    site.publish_status(status.clone()).await;
    let (registration, id) = told(&site).await;
    assert_eq!(registration["mode"], "apply");
    assert_eq!(registration["tracks"].as_f64().unwrap(), (estimate.samples * 10.0).round() / 10.0);
    let near = |name: &str, key: &str, value: f64| {
        let told = registration[name][key].as_f64().unwrap();
        assert!((told - value).abs() < 1e-4, "{name} {key}: {told}, {value}");
    };
    near("bearing_deg", "value", estimate.bearing.value.to_degrees());
    near("bearing_deg", "deviation", estimate.bearing.deviation.to_degrees());
    near("tilt_north_deg", "deviation", estimate.tilt_north.deviation.to_degrees());
    near("height_m", "value", estimate.height_m.value);
    near("time_s", "deviation", estimate.time_s.deviation);
    assert_eq!(registration["range_m"]["observable"], estimate.range_m.observable);
    assert!(registration.get("step").is_none() && registration.get("alarm").is_none());
    let metrics = site.get("/metrics").await.text;
    let id = id.as_str().unwrap();
    for (name, value) in [
        ("bearing_degrees", estimate.bearing.value.to_degrees()),
        ("bearing_deviation_degrees", estimate.bearing.deviation.to_degrees()),
        ("range_metres", estimate.range_m.value),
        ("time_deviation_seconds", estimate.time_s.deviation),
        ("tracks", estimate.samples),
        ("steps_total", 0.0),
    ] {
        let line = format!("utm_fusion_registration_{name}{{sensor=\"{id}\"}} {value}\n");
        assert!(metrics.contains(&line), "{line}\n{metrics}");
    }

    // Without the profile there is no registration.
    let site = Site::plain();
    site.publish_status(site.status()).await;
    assert_eq!(told(&site).await.0, Value::Null);
    assert!(!site.get("/metrics").await.text.contains("utm_fusion_registration"));
}

#[tokio::test]
async fn proposed_registration_is_not_applied() {
    let site = Site::operational();
    let mut status = site.status();
    let registration = radars(&mut status);
    registration.estimate.as_mut().unwrap().bearing.observable = true;
    let mut applied = Vec::new();
    for mode in [Registration::Apply, Registration::Propose] {
        radars(&mut status).mode = mode;
        site.publish_status(status.clone()).await;
        applied.push(told(&site).await.0["applied"].clone());
    }
    assert_eq!(applied, [true, false]);
    let off = RegistrationStatus {
        mode: Registration::Off,
        estimate: None,
        shared_minutes: None,
        learnt: None,
        place: None,
        relocated: None,
        step: None,
        steps: 0,
        alarm: None,
    };
    *radars(&mut status) = off;
    site.publish_status(status).await;
    assert_eq!(told(&site).await.0, serde_json::json!({ "mode": "off", "applied": false }));
}

#[tokio::test]
async fn a_doubtful_registration_is_a_hint_and_no_alarm() {
    let site = Site::operational();
    let mut status = site.status();
    radars(&mut status).estimate.as_mut().unwrap().residual = Some(3.9);
    site.publish_status(status.clone()).await;
    assert!(told(&site).await.0.get("hint").is_none());
    radars(&mut status).estimate.as_mut().unwrap().residual = Some(4.1);
    site.publish_status(status).await;
    let hint = told(&site).await.0["hint"].as_str().unwrap().to_owned();
    assert!(hint.contains("doubtful") && hint.contains("4.1"), "{hint}");
    assert!(!site.get("/api/v1/alerts").await.text.contains("\"registration\""));
}

#[tokio::test]
async fn registration_step_is_an_alert_for_an_hour() {
    let site = Site::operational();
    let mut status = site.status();
    let at = status.at;
    let before = radars(&mut status).estimate.unwrap();
    let mut after = before;
    after.bearing.value = before.bearing.value + 3.0_f64.to_radians();
    let step = Step { time: at, before, after };
    let registration = radars(&mut status);
    registration.step = Some(step);
    let alerts = |told: &Value, list: &str| {
        let all = told[list].as_array().unwrap().clone();
        all.into_iter().filter(|alert| alert["kind"] == "registration").collect::<Vec<_>>()
    };
    for (after_s, lasting) in [(0, 1), (3600, 1), (3601, 0)] {
        status.at = at + SignedDuration::from_secs(after_s);
        let now = status.at;
        radars(&mut status).alarm = RegistrationStatus::alarm(&step, now);
        site.publish_status(status.clone()).await;
        let (registration, id) = told(&site).await;
        assert_eq!(registration.get("alarm").is_some(), lasting == 1);
        assert_eq!(registration["step"]["time"], at.to_string());
        let turned = |when: &str| registration["step"][when]["bearing_deg"]["value"].as_f64().unwrap();
        assert!((turned("after") - turned("before") - 3.0).abs() < 1e-3, "{registration}");
        let told = site.get("/api/v1/alerts").await.json();
        assert_eq!(alerts(&told, "alerts").len(), lasting, "{after_s}: {told}");
        if let [alert] = &alerts(&told, "alerts")[..] {
            let text = alert["text"].as_str().unwrap();
            assert!(alert["sensor"] == id && alert["severity"] == "warning", "{alert}");
            assert!(text.contains("moved, knocked") && text.contains("\"propose\""), "{text}");
        } else {
            assert_eq!(alerts(&told, "ended").len(), 1);
        }
    }
}

#[tokio::test]
async fn learnt_errors_of_a_radar_are_reported() {
    let site = Site::operational();
    let mut status = site.status();
    let radar = radars(&mut status).learnt.as_mut().unwrap();
    let errors = VelocityErrors { sigma_m_s: 9.126, deviation_m_s: 0.5 };
    radar.velocity = VelocityVerdict::Ignored(errors);
    radar.azimuth.of_data_sheet.value = 0.42;
    let radar = *radar;
    site.publish_status(status).await;
    let sensors = site.get("/api/v1/sensors").await.json();
    let features = sensors["features"].as_array().unwrap().clone();
    let told = |kind: &str| {
        let feature = features.iter().find(|feature| feature["properties"]["kind"] == kind).unwrap();
        feature["properties"].clone()
    };
    assert_eq!(told("transponder").get("learnt"), None);
    let (id, learnt) = (told("radar")["id"].clone(), told("radar")["learnt"].clone());
    let near = |axis: &str, name: &str, value: f64| {
        let told = learnt[axis][name]["value"].as_f64().unwrap();
        assert!((told - value).abs() < 1e-4, "{axis} {name}: {told}, {value}");
    };
    near("azimuth_deg", "bias", radar.azimuth.bias.value.to_degrees());
    near("azimuth_deg", "of_data_sheet", 0.42);
    near("range_m", "noise", radar.range_m.noise.value);
    near("height_m", "correlation_s", radar.height_m.correlation_s.value);
    assert_eq!(learnt["velocity"]["verdict"], "ignored");
    assert_eq!(learnt["velocity"]["error_m_s"]["value"], 9.13);
    let summary = learnt["summary"].as_str().unwrap();
    assert!(
        summary.contains("azimuth 0.42") && summary.contains("velocities ignored: 9.1 m/s off"),
        "{summary}"
    );
    let metrics = site.get("/metrics").await.text;
    let id = id.as_str().unwrap();
    for line in [
        format!("utm_fusion_learnt_of_data_sheet{{sensor=\"{id}\",axis=\"azimuth\"}} 0.42\n"),
        format!("utm_fusion_learnt_velocity_used{{sensor=\"{id}\"}} 0\n"),
    ] {
        assert!(metrics.contains(&line), "{line}\n{metrics}");
    }
}

#[tokio::test]
async fn learnt_transponder_types_are_with_their_receiver() {
    let site = Site::operational();
    let mut status = site.status();
    let receiver = status.sensors.iter_mut().find(|sensor| !sensor.types.is_empty()).unwrap();
    let [(_, learnt)] = &mut receiver.types[..] else { panic!("{:?}", receiver.types) };
    learnt.horizontal_m = LearntValue { value: 0.0214, deviation: 0.0041 };
    learnt.delay_s = LearntValue { value: -0.031, deviation: 0.052 };
    learnt.applied_s = 0.0;
    let (id, reports) = (receiver.id.clone(), learnt.reports);
    assert!(reports > 10);
    site.publish_status(status).await;
    let sensors = site.get("/api/v1/sensors").await.json();
    let of_sensor = |sensor: &&Value| sensor["properties"]["id"] == id.as_str();
    let types = &sensors["features"].as_array().unwrap().iter().find(of_sensor).unwrap()["properties"];
    let of_type = &types["transponder_types"][0];
    assert_eq!((&of_type["manufacturer"], &of_type["model"]), (&"SIM".into(), &"UAS".into()));
    assert_eq!(of_type["horizontal_m"], serde_json::json!({ "value": 0.021, "deviation": 0.004 }));
    assert_eq!(of_type["delay_s"]["value"], -0.031);
    assert_eq!(of_type["reports"], reports);
    assert!(of_type["summary"].as_str().unwrap().contains("delay -0.03 ± 0.05 s, 0.00 s applied"));
    let metrics = site.get("/metrics").await.text;
    let line = format!(
        "utm_fusion_learnt_transponder_delay_seconds{{sensor=\"{id}\",type=\"SIM UAS\",part=\"value\"}} -0.031\n"
    );
    assert!(metrics.contains(&line), "{line}\n{metrics}");
}
