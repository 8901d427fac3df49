//! Replayed recordings: differences from the live service.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{Request, StatusCode};
use serde_json::Value;
use tower::ServiceExt;
use utm_fusion::api::{ApiState, Options, router, serve};
use utm_fusion::areas::Masks;
use utm_fusion::capture::Capture;
use utm_fusion::config::{Config, Profile};
use utm_fusion::live::{Hub, OpenCaptures, Player, now};
use utm_fusion::picture::PictureMaker;
use utm_fusion::pipeline::Pipeline;
use utm_fusion::state::CorrelationPlan;

use crate::common::Reader;

/// First and last reception of the bundled capture.
const SPAN: [&str; 2] = ["2026-06-20T23:59:30.279Z", "2026-06-21T00:00:45.052Z"];

/// A service that replays the bundled capture.
struct Show {
    state: ApiState,
    app: Router,
}

impl Show {
    fn start(speed: f64) -> Self {
        Self::of(speed, Profile::Reference)
    }

    fn of(speed: f64, profile: Profile) -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo");
        let mut config = Config::load(folder.join("site.toml")).unwrap();
        config.fusion.profile = profile;
        let config = Arc::new(config);
        let maker = PictureMaker::new(&config, Pipeline::new(&config, Masks::default()).normaliser());
        let (writer, hub) = Hub::new(config.clone(), Arc::new(maker), now());
        let open: OpenCaptures = Arc::new(move || Ok(vec![Capture::open(&folder.join("capture.pcap"))?]));
        let date = jiff::civil::Date::default();
        let (player, _) = Player::start(
            open,
            date,
            config,
            Default::default(),
            writer,
            (speed, false),
            CorrelationPlan::default(),
        )
        .unwrap();
        let state = ApiState::start(hub, Options { player: Some(player), ..Options::default() }).unwrap();
        Self { app: router(state.clone()), state }
    }

    async fn ask(&self, request: axum::http::request::Builder) -> (StatusCode, Value) {
        let response = self.app.clone().oneshot(request.body(Body::empty()).unwrap()).await.unwrap();
        let status = response.status();
        let octets = to_bytes(response.into_body(), 1 << 26).await.unwrap();
        (status, serde_json::from_slice(&octets).unwrap())
    }

    async fn get(&self, path: &str) -> Value {
        self.ask(Request::get(path)).await.1
    }

    async fn order(&self, what: &str) {
        assert_eq!(self.ask(Request::post(format!("/api/v1/replay/{what}"))).await.0, StatusCode::OK);
    }

    /// Waits for an answer that satisfies `is_so`.
    async fn until(&self, path: &str, is_so: impl Fn(&Value) -> bool) -> Value {
        for _ in 0..500 {
            let json = self.get(path).await;
            if is_so(&json) {
                return json;
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        panic!("{path} is {}", self.get(path).await);
    }
}

fn is_at(picture: &Value, time: &str) -> bool {
    let stamp = |text: &str| text.parse::<jiff::Timestamp>().unwrap();
    let apart = picture["time"].as_str().map(|shown| stamp(shown).duration_since(stamp(time)));
    apart.is_some_and(|apart| apart.abs() <= jiff::SignedDuration::from_millis(250))
}

#[tokio::test]
async fn start_and_end_are_known_from_the_start() {
    let show = Show::start(1.0);
    let replay = show.until("/api/v1/info", |info| info["replay"]["end"].is_string()).await["replay"].take();
    assert_eq!([&replay["start"], &replay["end"]], SPAN);
    assert_eq!(replay["ended"], false);
}

#[tokio::test]
async fn paused_replay_is_ready_and_sends_heartbeats() {
    let show = Show::start(1.0);
    show.until("/api/v1/tracks", |picture| picture["seq"].as_u64() > Some(0)).await;
    show.order("pause").await;
    show.until("/api/v1/info", |info| info["replay"]["playing"] == false).await;
    let listener = tokio::net::TcpListener::bind(("127.0.0.1", 0)).await.unwrap();
    let address = listener.local_addr().unwrap();
    tokio::spawn(serve(listener, show.state.clone()));
    let mut reader = Reader::open(address, "/api/v1/stream", "").await;
    assert_eq!(reader.any().await.unwrap().name, "snapshot");
    // Longer than the live service may be without a slot.
    let begun = tokio::time::Instant::now();
    let mut beats = 0;
    while begun.elapsed() < Duration::from_secs(7) {
        let event = reader.any().await.unwrap();
        beats += usize::from(event.name == "heartbeat");
        assert_ne!(event.name, "tracks", "it stands still");
    }
    assert!((6..=8).contains(&beats), "{beats} heartbeats");
    let (status, json) = show.ask(Request::get("/readyz")).await;
    assert_eq!(status, StatusCode::OK, "{json}");
    let health = show.get("/api/v1/status").await;
    assert!(!health["reasons"].to_string().contains("no slot"), "{health}");
}

#[tokio::test]
async fn readers_follow_a_seek_with_recorded_times() {
    let show = Show::start(1.0);
    show.order("pause").await;
    let times =
        ["2026-06-21T00:00:20Z", "2026-06-20T23:59:50Z", "2026-06-21T00:00:00Z", "2026-06-20T23:59:40Z"];
    for time in times {
        show.order(&format!("seek?time={time}")).await;
        let picture = show.until("/api/v1/tracks", |picture| is_at(picture, time)).await;
        assert_eq!(picture["latency_s"], 6.25);
    }
    // A seek beyond the end shows the last slot.
    show.order("seek?time=2026-06-21T01:00:00Z").await;
    show.until("/api/v1/info", |info| info["replay"]["ended"] == true).await;
    show.until("/api/v1/tracks", |picture| is_at(picture, "2026-06-21T00:00:44.875Z")).await;
    let sensors = show.get("/api/v1/sensors").await;
    let rate_hz = sensors["features"][0]["properties"]["rate_hz"].as_f64().unwrap();
    assert!((10.0..25.0).contains(&rate_hz), "the radar's rate is {rate_hz}, not 16 a second");
}

#[tokio::test]
async fn decision_during_a_replay_is_applied() {
    let show = Show::of(4.0, Profile::Operational);
    let fused = |picture: &Value| {
        let track =
            picture["features"].as_array()?.iter().find(|track| track["properties"]["source"] == "fused")?;
        let properties = &track["properties"];
        let radar = properties["contributors"].as_array()?.iter().find(|part| part["kind"] == "radar")?;
        let (sensor, number) = (radar["sensor"].as_str()?, &radar["track_number"]);
        let serial = properties["uas_id"]["serial_number"].as_str()?;
        Some(format!("/api/v1/correlations?sensor={sensor}&track={number}&uas={serial}&verdict=decorrelated"))
    };
    let picture = show.until("/api/v1/tracks", |picture| fused(picture).is_some()).await;
    let path = fused(&picture).unwrap();
    let (status, held) = show.ask(Request::post(&path)).await;
    assert_eq!(status, StatusCode::OK, "{held}");
    let since = held["correlations"][0]["since"].as_str().unwrap();
    let is_in_force = |answer: &Value| *answer == held;
    show.until("/api/v1/correlations", is_in_force).await;
    let is_apart = |picture: &Value| fused(picture).is_none_or(|other| other != path);
    show.until("/api/v1/tracks", is_apart).await;
    show.order("pause").await;
    show.until("/api/v1/info", |info| info["replay"]["playing"] == false).await;
    let (status, problem) = show.ask(Request::post(&path)).await;
    assert_eq!(status, StatusCode::CONFLICT, "{problem}");
    // After a seek back, the slots are published again.
    show.order("seek?time=2026-06-20T23:59:30Z").await;
    show.until("/api/v1/correlations", |answer| answer["correlations"] == serde_json::json!([])).await;
    show.order(&format!("seek?time={since}")).await;
    show.until("/api/v1/correlations", is_in_force).await;
}

#[tokio::test]
async fn raw_inputs_are_kept_from_the_first_request() {
    let show = Show::start(20.0);
    show.until("/api/v1/tracks", |picture| picture["seq"].as_u64() > Some(20)).await;
    let first = show.get("/api/v1/raw").await;
    assert_eq!((&first["last"], &first["features"]), (&0.into(), &serde_json::json!([])));
    let raw = show.until("/api/v1/raw", |raw| raw["features"].as_array().unwrap().len() > 200).await;
    let last = raw["last"].as_u64().unwrap();
    for feature in raw["features"].as_array().unwrap() {
        let (properties, place) = (&feature["properties"], &feature["geometry"]["coordinates"]);
        assert!(place[0].is_f64() && place[1].is_f64() && properties["time"].is_string(), "{feature}");
        match properties["kind"].as_str().unwrap() {
            "radar" => assert!(properties["track_number"].is_u64()),
            _ => assert!(properties["serial_number"].is_string()),
        }
    }
    for kind in ["radar", "transponder"] {
        assert!(
            raw["features"].as_array().unwrap().iter().any(|f| f["properties"]["kind"] == kind),
            "{kind}"
        );
    }
    let path = format!("/api/v1/raw?after={last}");
    let next = show.until(&path, |raw| !raw["features"].as_array().unwrap().is_empty()).await;
    let new = next["features"].as_array().unwrap().len() as u64;
    assert_eq!(next["last"].as_u64().unwrap(), last + new, "what was given is not given again");
}
