//! Integrity of transponders and operator verdicts over the API, by an engine at the end of a flight.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{Request, StatusCode};
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tower::ServiceExt;
use utm_fusion::api::{ApiState, Options, router, serve};
use utm_fusion::config::{Action, Profile};
use utm_fusion::live::Hub;

use crate::common::{Flown, Reader};
use crate::schema::check;

/// A service whose engine stands still and processes operator verdicts.
struct OperatorService {
    app: Router,
    state: ApiState,
    stop: Arc<AtomicBool>,
    engine: Option<JoinHandle<()>>,
}

impl OperatorService {
    fn open(profile: Profile, action: Action) -> Self {
        let (mut flown, mut driver) = Flown::with_driver(profile);
        flown.config.integrity.action = action;
        let (writer, hub) =
            Hub::new(Arc::new(flown.config), Arc::new(flown.maker.clone()), flown.frames[0].due);
        writer.publish(flown.frames.last().unwrap().clone());
        writer.trust_requests.publish_if_changed(&driver);
        let state = ApiState::start(hub, Options::default()).unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let engine = std::thread::spawn(move || {
            while !stopped.load(Ordering::Relaxed) {
                writer.trust_requests.carry_out_all(&mut driver);
                std::thread::sleep(Duration::from_millis(2));
            }
        });
        Self { app: router(state.clone()), state, stop, engine: Some(engine) }
    }

    fn close(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        self.engine.take().into_iter().for_each(|engine| engine.join().unwrap());
    }

    async fn ask(&self, request: Request<Body>) -> (StatusCode, String) {
        let response = self.app.clone().oneshot(request).await.unwrap();
        let status = response.status();
        let octets = to_bytes(response.into_body(), 1 << 26).await.unwrap();
        (status, String::from_utf8(octets.to_vec()).unwrap())
    }

    async fn get(&self, path: &str) -> Value {
        let answer = self.ask(Request::get(path).body(Body::empty()).unwrap()).await.1;
        serde_json::from_str(&answer).unwrap()
    }

    async fn post(&self, identity: &str, body: &str) -> (StatusCode, Value) {
        let request = Request::post(format!("/api/v1/integrity/{identity}"))
            .header("content-type", "application/json")
            .body(Body::from(body.to_owned()));
        let (status, text) = self.ask(request.unwrap()).await;
        (status, serde_json::from_str(&text).unwrap())
    }

    /// Serial number of a transponder.
    async fn somebody(&self) -> String {
        self.get("/api/v1/integrity").await["identities"][0]["identity"].as_str().unwrap().to_owned()
    }
}

impl Drop for OperatorService {
    fn drop(&mut self) {
        self.close();
    }
}

const DISTRUSTED: &str = r#"{"verdict": "distrusted"}"#;

#[tokio::test]
async fn verdict_applies_until_withdrawn() {
    let service = OperatorService::open(Profile::Operational, Action::Flag);
    let document = service.get("/openapi.json").await;
    let operation = |path: &str, method: &str| document["paths"][path][method].clone();
    let path = "/api/v1/integrity/{identity}";
    let schema =
        |operation: Value| operation["responses"]["200"]["content"]["application/json"]["schema"].clone();
    let (get, post) = (operation("/api/v1/integrity", "get"), operation(path, "post"));
    assert!(post["requestBody"]["content"]["application/json"]["schema"].get("$ref").is_some(), "{post}");
    assert_eq!(post["parameters"][0]["name"], "identity");
    assert_eq!(schema(get.clone()), schema(post));

    let known = service.get("/api/v1/integrity").await;
    check(&document, &schema(get.clone()), &known, "known");
    assert!(known["computed"] == true && known["time"].is_string(), "{known}");
    let picture = service.get("/api/v1/tracks").await;
    let mut shown: Vec<&Value> = picture["features"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|feature| feature["properties"].get("uas_id").is_some())
        .map(|feature| &feature["properties"]["uas_id"]["serial_number"])
        .collect();
    let identities = known["identities"].as_array().unwrap();
    shown.retain(|serial| !identities.iter().any(|one| one["identity"] == **serial));
    assert!(shown.is_empty() && !identities.is_empty(), "{shown:?} {known}");
    let with_track = identities.iter().find(|one| one.get("track_id").is_some()).unwrap();
    let track = service.get(&format!("/api/v1/tracks/{}", with_track["track_id"].as_str().unwrap())).await;
    assert_eq!(track["properties"]["uas_id"]["serial_number"], with_track["identity"]);
    assert!(identities.iter().all(|one| one.get("verdict").is_none()));

    let serial = with_track["identity"].as_str().unwrap();
    let (status, answer) = service.post(serial, DISTRUSTED).await;
    assert_eq!(status, StatusCode::OK, "{answer}");
    check(&document, &schema(get), &answer, "said");
    let said = |answer: &Value| {
        let identities = answer["identities"].as_array().unwrap();
        identities.iter().find(|one| one["identity"] == serial).unwrap().clone()
    };
    assert_eq!(said(&answer)["verdict"], "distrusted");
    // The verdict applies from the next slot on.
    let time = |text: &Value| text.as_str().unwrap().parse::<jiff::Timestamp>().unwrap();
    let after = time(&said(&answer)["verdict_since"]).duration_since(time(&picture["time"]));
    assert_eq!(after, jiff::SignedDuration::from_millis(250));
    assert_eq!(said(&service.get("/api/v1/integrity").await), said(&answer));
    let (status, answer) = service.post(serial, r#"{"verdict": "automatic"}"#).await;
    assert!(status == StatusCode::OK && said(&answer).get("verdict").is_none(), "{answer}");

    let metrics = service.ask(Request::get("/metrics").body(Body::empty()).unwrap()).await.1;
    let states: Vec<&str> =
        metrics.lines().filter(|line| line.starts_with("utm_fusion_integrity{state=")).collect();
    let count: usize =
        states.iter().map(|line| line.rsplit(' ').next().unwrap().parse::<usize>().unwrap()).sum();
    assert_eq!((states.len(), count), (4, identities.len()), "{states:?}");
    for series in ["utm_fusion_integrity_flags_total{reason=\"replay\"} 0\n", "utm_fusion_uncooperative 0\n"]
    {
        assert!(metrics.contains(series), "{series}");
    }
}

#[tokio::test]
async fn impossible_verdict_is_a_problem_with_reason() {
    let mut service = OperatorService::open(Profile::Operational, Action::Flag);
    let serial = service.somebody().await;
    for (identity, body, status, why) in [
        ("NOBODY", DISTRUSTED, 404, "no such transponder"),
        (&*format!("{serial}?country=XX"), DISTRUSTED, 404, "no such transponder"),
        (&serial, r#"{"verdict": "perhaps"}"#, 400, "trusted, distrusted or automatic"),
        (&serial, r#"{"verdict": 1}"#, 400, "the body is JSON such as"),
        (&serial, r#"{"verdict": "trusted", "by": "me"}"#, 400, "unknown field"),
        (&serial, "", 400, "the body is JSON such as"),
        (&*format!("{serial}?verdict=trusted"), DISTRUSTED, 400, "there is no such parameter"),
        (&serial, &format!("{DISTRUSTED}{}", " ".repeat(70_000)), 413, "at most 65536 octets"),
    ] {
        let (answered, problem) = service.post(identity, body).await;
        assert_eq!(answered.as_u16(), status, "{identity} {body}: {problem}");
        assert!(problem["detail"].as_str().unwrap().contains(why), "{body}: {problem}");
    }
    // The engine has ended.
    service.close();
    assert_eq!(service.post(&serial, DISTRUSTED).await.0, StatusCode::SERVICE_UNAVAILABLE);

    for service in [
        OperatorService::open(Profile::Reference, Action::Flag),
        OperatorService::open(Profile::Operational, Action::Off),
    ] {
        assert_eq!(service.get("/api/v1/integrity").await["computed"], false);
        let (status, problem) = service.post("ANY", DISTRUSTED).await;
        assert_eq!(status, StatusCode::CONFLICT);
        assert!(problem["detail"].as_str().unwrap().contains("not judged here"), "{problem}");
    }
}

#[tokio::test]
async fn integrity_changes_are_streamed() {
    let service = OperatorService::open(Profile::Operational, Action::Flag);
    let serial = service.somebody().await;
    let listener = TcpListener::bind(("127.0.0.1", 0)).await.unwrap();
    let address = listener.local_addr().unwrap();
    tokio::spawn(serve(listener, service.state.clone()));
    let mut reader = Reader::open(address, "/api/v1/stream", "").await;
    assert_eq!(reader.next().await.unwrap().name, "snapshot");
    for (verdict, told) in [("trusted", json!("trusted")), ("automatic", Value::Null)] {
        service.post(&serial, &json!({ "verdict": verdict }).to_string()).await;
        let event = loop {
            let event = reader.next().await.unwrap();
            if event.name == "integrity" && event.data["identity"] == *serial {
                break event;
            }
        };
        assert_eq!(event.data["verdict"], told, "{}", event.data);
        assert!(event.data["state"].is_string() && event.data["evidence"].is_array());
    }
}
