//! Relocations of radars over the API, applied by an engine at the end of a flight.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{Request, StatusCode};
use serde_json::{Value, json};
use tower::ServiceExt;
use utm_fusion::api::{ApiState, Options, router};
use utm_fusion::config::{Config, Profile, SensorKind};
use utm_fusion::live::Hub;

use crate::common::Flown;
use crate::schema::check;

const SCENARIO: &str = "name = \"misplaced\"\nduration_s = 150\n[drones]\nmultirotors = 12\nequipped = 12\n";

/// A service whose engine stands still and moves radars.
struct OperatorService {
    app: Router,
    stop: Arc<AtomicBool>,
    engine: Option<JoinHandle<()>>,
}

impl OperatorService {
    /// The radar's configured position is `off_m` too far north.
    fn open(profile: Profile, off_m: f64) -> Self {
        let (flown, mut driver) = Flown::in_scenario(SCENARIO, |config: &mut Config| {
            config.fusion.profile = profile;
            if let SensorKind::Radar(radar) = &mut config.sensors[0].kind {
                radar.latitude_deg += off_m / 111_200.0;
            }
        });
        let (writer, hub) =
            Hub::new(Arc::new(flown.config), Arc::new(flown.maker.clone()), flown.frames[0].due);
        writer.publish(flown.frames.last().unwrap().clone());
        writer.publish_status(flown.status.clone());
        let state = ApiState::start(hub, Options::default()).unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let engine = std::thread::spawn(move || {
            while !stopped.load(Ordering::Relaxed) {
                if !writer.relocation_requests.carry_out_all(&mut driver).is_empty() {
                    let sensors = driver.sensors(flown.status.at, |_| Vec::new());
                    writer.publish_status(utm_fusion::live::Status { sensors, ..flown.status.clone() });
                }
                std::thread::sleep(Duration::from_millis(2));
            }
        });
        Self { app: router(state), stop, engine: Some(engine) }
    }

    async fn ask(&self, request: Request<Body>) -> (StatusCode, Value) {
        let response = self.app.clone().oneshot(request).await.unwrap();
        let status = response.status();
        let octets = to_bytes(response.into_body(), 1 << 26).await.unwrap();
        (status, serde_json::from_slice(&octets).unwrap())
    }

    async fn get(&self, path: &str) -> Value {
        self.ask(Request::get(path).body(Body::empty()).unwrap()).await.1
    }

    async fn post(&self, path: &str) -> (StatusCode, Value) {
        self.ask(Request::post(format!("/api/v1/relocations/{path}")).body(Body::empty()).unwrap()).await
    }

    async fn refused(&self, path: &str, status: u16, why: &str) {
        let (answered, problem) = self.post(path).await;
        assert_eq!(answered.as_u16(), status, "{path}: {problem}");
        assert!(problem["detail"].as_str().unwrap().contains(why), "{path}: {problem}");
    }

    async fn radar(&self) -> Value {
        self.get("/api/v1/sensors").await["features"][0].clone()
    }
}

impl Drop for OperatorService {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        self.engine.take().into_iter().for_each(|engine| engine.join().unwrap());
    }
}

#[tokio::test]
async fn misplaced_radar_is_degraded_until_it_is_moved() {
    const OFF_M: f64 = 45.0;
    let service = OperatorService::open(Profile::Operational, OFF_M);
    let document = service.get("/openapi.json").await;
    let schema = |path: &str, method: &str| {
        let operation = &document["paths"][path][method];
        operation["responses"]["200"]["content"]["application/json"]["schema"].clone()
    };
    let list = schema("/api/v1/relocations", "get");
    assert_eq!(list, schema("/api/v1/relocations/{sensor}", "post"));
    assert_eq!(service.get("/api/v1/relocations").await, json!({ "relocations": [] }));
    let before = service.radar().await;
    let told = &before["properties"];
    assert_eq!(told["state"], "degraded", "{told}");
    let reasons = told["reasons"].as_array().unwrap();
    assert!(reasons.iter().any(|reason| reason == "its tracks contradict its position"), "{told}");
    let registration = &told["registration"];
    assert!(registration["alarm"].as_str().unwrap().contains("contradict its position"), "{told}");
    let place = &registration["place"];
    assert_eq!(place["contradicts"], true, "{place}");
    assert!((place["north_m"].as_f64().unwrap() + OFF_M).abs() < 20.0, "{place}");
    service.refused("gamekeeper/revoke", 409, "nothing to undo").await;

    let (status, answer) = service.post("gamekeeper").await;
    assert_eq!(status, StatusCode::OK, "{answer}");
    check(&document, &list, &answer, "applied");
    assert_eq!(answer["relocations"][0]["sensor"], "gamekeeper");
    assert_eq!(answer["relocations"][0]["north_m"], place["north_m"]);
    assert_eq!(service.get("/api/v1/relocations").await, answer);
    let moved = loop {
        let radar = service.radar().await;
        if radar["properties"]["registration"].get("relocated").is_some() {
            break radar;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    };
    // The map shows it at its new place, and its registration restarts.
    assert_eq!(moved["properties"]["registration"]["relocated"]["north_m"], place["north_m"]);
    assert!(moved["properties"]["registration"].get("place").is_none(), "{moved}");
    for (axis, key) in [(0, "longitude_deg"), (1, "latitude_deg")] {
        let at = moved["geometry"]["coordinates"][axis].as_f64().unwrap();
        assert!((at - place[key].as_f64().unwrap()).abs() < 1e-6, "{moved}");
    }
    assert_ne!(moved["geometry"], before["geometry"]);
    service.refused("gamekeeper", 409, "nothing to apply").await;
    let (status, answer) = service.post("gamekeeper/revoke").await;
    assert_eq!((status, answer), (StatusCode::OK, json!({ "relocations": [] })));
}

#[tokio::test]
async fn impossible_relocation_is_a_problem_with_reason() {
    let service = OperatorService::open(Profile::Operational, 0.0);
    service.refused("gamekeeper", 409, "do not contradict its position").await;
    service.refused("nobody", 404, "there is no radar").await;
    service.refused("drone-it", 404, "there is no radar").await;
    let service = OperatorService::open(Profile::Reference, 0.0);
    service.refused("gamekeeper", 409, "reference").await;
}
