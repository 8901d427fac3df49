//! Operator correlations over the API, applied by an engine at the end of a flight.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{Request, StatusCode};
use fusion::Source;
use serde_json::{Value, json};
use tower::ServiceExt;
use utm_fusion::api::{ApiState, Options, router};
use utm_fusion::config::{Auth, Config, Profile};
use utm_fusion::live::Hub;

use crate::common::{Flown, Site};
use crate::schema::check;

/// SHA-256 of "reader".
const READER: &str = "3d0941964aa3ebdcb00ccef58b1bb399f9f898465e9886d5aec7f31090a0fb30";
/// SHA-256 of "desk".
const OPERATOR: &str = "49be417ad74080a0031b636b44cfc26fdd0065492d6cd3b033960c4414955cf7";

/// A service whose engine stands still and processes operator decisions.
struct OperatorService {
    app: Router,
    /// Radar, track number and transponder serial of each fused pair.
    pairs: Vec<(String, u16, String)>,
    stop: Arc<AtomicBool>,
    engine: Option<JoinHandle<()>>,
}

impl OperatorService {
    fn open(profile: Profile, change: impl FnOnce(&mut Config)) -> Self {
        let (mut flown, mut driver) = Flown::with_driver(profile);
        change(&mut flown.config);
        let (writer, hub) =
            Hub::new(Arc::new(flown.config), Arc::new(flown.maker.clone()), flown.frames[0].due);
        let last = flown.frames.last().unwrap().clone();
        let pair = |source: &Source| match source {
            Source::Fused(radar, transponder, _) => {
                let serial = transponder.identity.name().escape_ascii().to_string();
                Some((flown.maker.sensor(radar.track.sensor).to_owned(), radar.track.number, serial))
            }
            _ => None,
        };
        let pairs = last.picture.tracks.iter().filter_map(|track| pair(&track.point.source)).collect();
        writer.publish(last);
        let state = ApiState::start(hub, Options::default()).unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let engine = std::thread::spawn(move || {
            while !stopped.load(Ordering::Relaxed) {
                writer.correlation_requests.carry_out_all(&mut driver);
                std::thread::sleep(Duration::from_millis(2));
            }
        });
        Self { app: router(state), pairs, stop, engine: Some(engine) }
    }

    fn close(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        self.engine.take().into_iter().for_each(|engine| engine.join().unwrap());
    }

    async fn ask(&self, request: axum::http::request::Builder) -> (StatusCode, String) {
        let response = self.app.clone().oneshot(request.body(Body::empty()).unwrap()).await.unwrap();
        let status = response.status();
        let octets = to_bytes(response.into_body(), 1 << 26).await.unwrap();
        (status, String::from_utf8(octets.to_vec()).unwrap())
    }

    async fn get(&self, path: &str) -> Value {
        serde_json::from_str(&self.ask(Request::get(path)).await.1).unwrap()
    }

    async fn post(&self, query: &str) -> (StatusCode, Value) {
        let (status, text) = self.ask(Request::post(format!("/api/v1/correlations?{query}"))).await;
        (status, serde_json::from_str(&text).unwrap())
    }
}

impl Drop for OperatorService {
    fn drop(&mut self) {
        self.close();
    }
}

fn query((sensor, track, serial): &(String, u16, String), verdict: &str) -> String {
    format!("sensor={sensor}&track={track}&uas={serial}&verdict={verdict}")
}

#[tokio::test]
async fn a_decision_is_in_force_until_it_is_withdrawn() {
    let service = OperatorService::open(Profile::Operational, |_| {});
    let document = service.get("/openapi.json").await;
    let schema = |method: &str| {
        let responses = &document["paths"]["/api/v1/correlations"][method]["responses"];
        responses["200"]["content"]["application/json"]["schema"].clone()
    };
    assert!(schema("get").get("$ref").is_some() && schema("get") == schema("post"));
    assert_eq!(service.get("/api/v1/correlations").await, json!({ "correlations": [] }));
    let [first, second] = &service.pairs[..2] else { panic!("{:?}", service.pairs) };

    let (status, answer) = service.post(&query(first, "decorrelated")).await;
    assert_eq!(status, StatusCode::OK, "{answer}");
    check(&document, &schema("post"), &answer, "decided");
    let held = &answer["correlations"][0];
    assert_eq!((&held["sensor"], &held["track_number"]), (&first.0.as_str().into(), &first.1.into()));
    assert_eq!(
        (&held["uas_id"]["serial_number"], &held["verdict"]),
        (&first.2.as_str().into(), &"decorrelated".into())
    );
    assert_eq!(service.get("/api/v1/correlations").await, answer);
    // The decision applies from the next slot on.
    let time = |text: &Value| text.as_str().unwrap().parse::<jiff::Timestamp>().unwrap();
    let picture = service.get("/api/v1/tracks").await;
    let after = time(&held["since"]).duration_since(time(&picture["time"]));
    assert_eq!(after, jiff::SignedDuration::from_millis(250));

    let crossed = (second.0.clone(), second.1, first.2.clone());
    let (status, answer) = service.post(&query(&crossed, "correlated")).await;
    assert_eq!((status, answer["correlations"].as_array().unwrap().len()), (StatusCode::OK, 2), "{answer}");
    let metrics = service.ask(Request::get("/metrics")).await.1;
    for verdict in ["correlated", "decorrelated"] {
        assert!(metrics.contains(&format!("utm_fusion_decisions{{verdict=\"{verdict}\"}} 1\n")), "{metrics}");
    }
    for pair in [first, &crossed] {
        assert_eq!(service.post(&query(pair, "automatic")).await.0, StatusCode::OK);
    }
    assert_eq!(service.get("/api/v1/correlations").await, json!({ "correlations": [] }));
}

#[tokio::test]
async fn impossible_decision_is_a_problem_with_reason() {
    let mut service = OperatorService::open(Profile::Operational, |_| {});
    let (sensor, track, serial) = service.pairs[0].clone();
    let whole = query(&service.pairs[0], "correlated");
    for (query, status, why) in [
        (whole.replace("sensor=", "x="), 400, "there is no such parameter"),
        (format!("track={track}&uas={serial}&verdict=correlated"), 400, "id of a radar"),
        (format!("sensor={sensor}&uas={serial}&verdict=correlated"), 400, "0 to 4095"),
        (format!("sensor={sensor}&track=4096&uas={serial}&verdict=correlated"), 400, "0 to 4095"),
        (format!("sensor={sensor}&track={track}&verdict=correlated"), 400, "serial number"),
        (
            whole.replace("verdict=correlated", "verdict=perhaps"),
            400,
            "correlated, decorrelated or automatic",
        ),
        (whole.replace(&format!("sensor={sensor}"), "sensor=nowhere"), 404, "no radar"),
        (whole.replace(&format!("track={track}"), "track=4095"), 404, "no such track now"),
        (whole.replace(&serial, "NOBODY"), 404, "no such transponder"),
        (format!("{whole}&country=XX"), 404, "no such transponder"),
    ] {
        let (answered, problem) = service.post(&query).await;
        assert_eq!(answered.as_u16(), status, "{query}: {problem}");
        assert!(problem["detail"].as_str().unwrap().contains(why), "{query}: {problem}");
    }
    // The engine has ended.
    service.close();
    let (status, problem) = service.post(&whole).await;
    assert_eq!(status, StatusCode::SERVICE_UNAVAILABLE, "{problem}");

    let service = OperatorService::open(Profile::Reference, |_| {});
    let (status, problem) = service.post(&query(&service.pairs[0], "correlated")).await;
    assert_eq!(status, StatusCode::CONFLICT);
    assert!(problem["detail"].as_str().unwrap().contains("reference profile decides by itself"), "{problem}");
}

#[tokio::test]
async fn hanging_engine_is_waited_for_at_most_two_seconds() {
    let site = Site::operational();
    let begun = tokio::time::Instant::now();
    let path = "/api/v1/correlations?sensor=gamekeeper&track=1&uas=X&verdict=correlated";
    let sensors = site.get("/api/v1/sensors").await.json();
    let radar = sensors["features"][0]["id"].as_str().unwrap();
    let answer = site.ask(Request::post(path.replace("gamekeeper", radar))).await;
    assert_eq!((answer.status, answer.header("retry-after")), (StatusCode::SERVICE_UNAVAILABLE, "1"));
    assert!((2..8).contains(&begun.elapsed().as_secs()), "{:?}", begun.elapsed());
}

#[tokio::test]
async fn deciding_takes_the_scope_control() {
    let file = std::env::temp_dir().join(format!("utm-fusion-control-{}.toml", std::process::id()));
    let text = format!(
        "reader = {{ sha256 = \"{READER}\", scopes = [\"read\"] }}\n\
         desk = {{ sha256 = \"{OPERATOR}\", scopes = [\"read\", \"control\"] }}\n"
    );
    std::fs::write(&file, text).unwrap();
    let service = OperatorService::open(Profile::Operational, |config| {
        config.http.auth = Auth::Tokens { tokens_file: file }
    });
    let path = format!("/api/v1/correlations?{}", query(&service.pairs[0], "decorrelated"));
    let by = |token: &str, request: axum::http::request::Builder| {
        request.header("authorization", format!("Bearer {token}"))
    };
    assert_eq!(service.ask(Request::post(&path)).await.0, StatusCode::UNAUTHORIZED);
    for (token, status, control) in [("reader", StatusCode::FORBIDDEN, false), ("desk", StatusCode::OK, true)]
    {
        assert_eq!(service.ask(by(token, Request::post(&path))).await.0, status, "{token}");
        let info: Value =
            serde_json::from_str(&service.ask(by(token, Request::get("/api/v1/info"))).await.1).unwrap();
        assert_eq!(info["control"], control, "{token}");
    }
    let listed = service.ask(by("reader", Request::get("/api/v1/correlations"))).await;
    assert!(listed.0 == StatusCode::OK && listed.1.contains("decorrelated"), "{}", listed.1);
}
