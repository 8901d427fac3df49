//! Remote ID lines posted by gateways: accepted and refused lines, and permissions.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};

use axum::body::{Body, to_bytes};
use axum::http::{Request, StatusCode, request::Builder};
use proptest::prelude::*;
use serde_json::{Value, json};
use utm_fusion::api::Options;
use utm_fusion::config::{Auth, Connection, ConnectionFormat};
use utm_fusion::gateways::remote_id::ReceiverIds;
use utm_fusion::live::{HttpInput, WallClock};
use utm_fusion::net::listen::{Arrival, LineCounters};

use crate::common::Site;

const PATH: &str = "/api/v1/remote-id";
const LINE: &str = r#"{"transmitter":"90:3a:e6:5b:c8:a8","message":"02"}"#;
/// SHA-256 of "reader".
const READER: &str = "3d0941964aa3ebdcb00ccef58b1bb399f9f898465e9886d5aec7f31090a0fb30";
/// SHA-256 of "secret".
const SECRET: &str = "2bb80d537b1da3e38bd30361aa855686bde0eacd7162fef6a25fe97bf527a25b";

/// A site to which gateways may post, with `auth`.
fn configured(auth: Auth) -> Site {
    Site::with(Options::default(), |config| {
        let connection = Connection { format: ConnectionFormat::Http, ..Connection::default() };
        config.sensors[1].connections = vec![connection];
        config.http.auth = auth;
    })
}

/// The site with its line open; at most `most` lines may wait.
fn open(auth: Auth, most: u64) -> (Site, Arc<LineCounters>, Receiver<Arrival>) {
    let site = configured(auth);
    let (sender, arrivals) = sync_channel(100_000);
    let counters = Arc::<LineCounters>::default();
    let receivers = ReceiverIds::new(["roof".to_owned()]);
    site.writer.set_http_input(HttpInput::new(
        2,
        counters.clone(),
        WallClock::default(),
        receivers,
        sender,
        most,
    ));
    (site, counters, arrivals)
}

async fn send(site: &Site, request: Builder, body: impl Into<Body>) -> (StatusCode, Value, String) {
    use tower::ServiceExt;
    let response = site.app.clone().oneshot(request.body(body.into()).unwrap()).await.unwrap();
    let retry = response.headers().get("retry-after").map(|after| after.to_str().unwrap().to_owned());
    let status = response.status();
    let octets = to_bytes(response.into_body(), 1 << 20).await.unwrap();
    (status, serde_json::from_slice(&octets).unwrap(), retry.unwrap_or_default())
}

async fn post(site: &Site, body: impl Into<Body>) -> (StatusCode, Value) {
    let request = Request::post(PATH).header("content-type", "application/x-ndjson");
    let (status, answer, _) = send(site, request, body).await;
    (status, answer)
}

#[tokio::test]
async fn line_of_a_receiver_not_posted_to_is_refused() {
    let (site, counters, arrivals) = open(Auth::None, 1_000);
    let of = |receiver: &str| format!(r#"{{"transmitter":"a","receiver":"{receiver}","message":"02"}}"#);
    let (status, answer) = post(&site, format!("{}\n{}", of("roof"), of("pinned"))).await;
    assert_eq!(status, StatusCode::OK);
    assert_eq!(answer, json!({ "lines": 2, "taken": 1, "refused": { "line_receiver": 1 } }));
    let (status, answer) = post(&site, of("pinned")).await;
    assert_eq!(status, StatusCode::FORBIDDEN, "{answer}");
    let detail = answer["detail"].as_str().unwrap();
    assert!(detail.contains("1 of 1 lines name a receiver that is not posted to"), "{detail}");
    assert!(detail.ends_with("lines may name: roof"), "{detail}");
    let taken: Vec<Arrival> = arrivals.try_iter().collect();
    assert!(taken.len() == 1 && taken[0].payload == of("roof").as_bytes());
    assert!(counters.untranslated().contains(&("line_receiver", 2)));
}

#[tokio::test]
async fn valid_lines_are_accepted_and_others_counted() {
    let (site, _, arrivals) = open(Auth::None, 1_000);
    let long = format!(r#"{{"transmitter":"a","message":"02","more":"{}"}}"#, "x".repeat(2_048));
    let name = r#"{"transmitter":"","message":"02"}"#;
    let digits = r#"{"transmitter":"a","message":"0"}"#;
    let time = r#"{"transmitter":"a","message":"02","time":"noon"}"#;
    let deep = format!("{}{}", "{\"a\":".repeat(9_000), "1");
    let array = r#"[null,"a",null,null,"02"]"#;
    let lines = [LINE, "nonsense", &long, name, "", digits, time, &deep[..2_000], array, "\t", LINE];
    let (status, answer) = post(&site, format!("{}\r\n", lines.join("\r\n"))).await;
    assert_eq!(status, StatusCode::OK);
    let refused = json!({
        "line_not_an_object": 3, "line_too_long": 1, "line_name": 1, "line_not_hexadecimal": 1, "line_time": 1,
    });
    assert_eq!(answer, json!({ "lines": 9, "taken": 2, "refused": refused }));
    let taken: Vec<Arrival> = arrivals.try_iter().collect();
    assert!(
        taken.len() == 2 && taken.iter().all(|taken| taken.line == 2 && taken.payload == LINE.as_bytes())
    );
    let (status, answer) = post(&site, "").await;
    assert_eq!((status, answer), (StatusCode::OK, json!({ "lines": 0, "taken": 0, "refused": {} })));
}

#[tokio::test]
async fn a_body_is_lines_of_json_of_limited_length() {
    let (site, _, arrivals) = open(Auth::None, 1_000);
    for (kind, status) in [
        (Some("application/x-ndjson; charset=utf-8"), 200),
        (Some("application/json"), 200),
        (Some("Application/NDJSON"), 200),
        (None, 200),
        (Some("text/plain"), 415),
        (Some("application/x-www-form-urlencoded"), 415),
        (Some("application/octet-stream"), 415),
        (Some(""), 415),
    ] {
        let request =
            kind.iter().fold(Request::post(PATH), |request, kind| request.header("content-type", *kind));
        let (answered, answer, _) = send(&site, request, LINE).await;
        assert_eq!(answered.as_u16(), status, "{kind:?}: {answer}");
        assert_eq!(arrivals.try_iter().count(), usize::from(status == 200), "{kind:?}");
    }
    let packed = Request::post(PATH).header("content-encoding", "gzip");
    assert_eq!(send(&site, packed, LINE).await.0, StatusCode::UNSUPPORTED_MEDIA_TYPE);
    let page = Request::post(PATH).header("origin", "https://elsewhere.example");
    assert_eq!(send(&site, page, LINE).await.0, StatusCode::FORBIDDEN);
    assert_eq!(send(&site, Request::post(format!("{PATH}?sensor=a")), LINE).await.0, StatusCode::BAD_REQUEST);
    assert_eq!(send(&site, Request::get(PATH), LINE).await.0, StatusCode::METHOD_NOT_ALLOWED);
    assert_eq!(post(&site, "\n".repeat(65_537)).await.0, StatusCode::PAYLOAD_TOO_LARGE);
    assert_eq!(arrivals.try_iter().count(), 0);
    let most = format!("{LINE}\n").repeat(65_536 / (LINE.len() + 1));
    let (status, answer) = post(&site, most).await;
    assert_eq!((status, &answer["refused"]), (StatusCode::SERVICE_UNAVAILABLE, &Value::Null), "{answer}");
}

#[tokio::test]
async fn full_queue_refuses_lines_at_once() {
    let (site, counters, arrivals) = open(Auth::None, 3);
    let five = format!("{LINE}\n").repeat(5);
    let (status, answer, after) = send(&site, Request::post(PATH), format!("nonsense\n{five}")).await;
    assert_eq!((status, &*after), (StatusCode::SERVICE_UNAVAILABLE, "1"));
    assert!(
        answer["detail"].as_str().unwrap().contains("the first 3 of 5 sound lines were taken"),
        "{answer}"
    );
    assert_eq!(arrivals.try_iter().count(), 3);
    counters.handled.fetch_add(3, std::sync::atomic::Ordering::Relaxed);
    assert_eq!(post(&site, LINE).await.0, StatusCode::OK);
    // The engine has ended.
    drop(arrivals);
    assert_eq!(post(&site, LINE).await.0, StatusCode::SERVICE_UNAVAILABLE);
}

#[tokio::test]
async fn site_without_posted_sensor_is_a_problem() {
    let (status, answer) = post(&Site::plain(), LINE).await;
    assert_eq!(status, StatusCode::NOT_FOUND);
    assert!(answer["detail"].as_str().unwrap().contains("format = \"http\""), "{answer}");
    // At the start of the service, before the line is open.
    let (status, _, after) = send(&configured(Auth::None), Request::post(PATH), LINE).await;
    assert_eq!((status, &*after), (StatusCode::SERVICE_UNAVAILABLE, "1"));
}

#[tokio::test]
async fn posting_needs_the_scope_input_alone() {
    let file = std::env::temp_dir().join(format!("utm-fusion-input-{}.toml", std::process::id()));
    let text = format!(
        "desk = {{ sha256 = \"{READER}\", scopes = [\"read\", \"stream\", \"control\"] }}\n\
         gateway = {{ sha256 = \"{SECRET}\", scopes = [\"input\"] }}\n"
    );
    std::fs::write(&file, text).unwrap();
    let (site, _, arrivals) = open(Auth::Tokens { tokens_file: file }, 1_000);
    let by = |request: Builder, token: &str| request.header("authorization", format!("Bearer {token}"));
    assert_eq!(send(&site, Request::post(PATH), LINE).await.0, StatusCode::UNAUTHORIZED);
    assert_eq!(send(&site, by(Request::post(PATH), "reader"), LINE).await.0, StatusCode::FORBIDDEN);
    assert_eq!(arrivals.try_iter().count(), 0);
    assert_eq!(send(&site, by(Request::post(PATH), "secret"), LINE).await.0, StatusCode::OK);
    assert_eq!(send(&site, by(Request::get("/api/v1/tracks"), "secret"), "").await.0, StatusCode::FORBIDDEN);
    assert_eq!(arrivals.try_iter().count(), 1);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]

    /// Any body is answered, and each of its lines is counted.
    #[test]
    fn arbitrary_octets_are_accounted_for(parts in prop::collection::vec(prop_oneof![
        Just(LINE.as_bytes().to_vec()), Just(b"\n".to_vec()), prop::collection::vec(any::<u8>(), 0..40),
    ], 0..40)) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let (answered, arrived) = runtime.block_on(async {
            let (site, _, arrivals) = open(Auth::None, 1_000);
            let answered = post(&site, parts.concat()).await;
            (answered, arrivals.try_iter().count() as u64)
        });
        let (status, answer) = answered;
        prop_assert_eq!(status, StatusCode::OK);
        let refused: u64 = answer["refused"].as_object().unwrap().values().filter_map(Value::as_u64).sum();
        prop_assert_eq!(answer["lines"].as_u64(), Some(arrived + refused));
        prop_assert_eq!(answer["taken"].as_u64(), Some(arrived));
    }
}
