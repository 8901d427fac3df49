//! Requests that exceed a limit or are invalid.

use std::time::Duration;

use axum::http::{Request, StatusCode};
use proptest::prelude::*;
use tokio::net::TcpStream;
use utm_fusion::api::Options;

use crate::common::{Answered, Reader, Site, receive, send};

fn is_problem(answer: &Answered, status: u16) {
    assert_eq!(answer.status, status, "{}", answer.text);
    assert_eq!(answer.header("content-type"), "application/problem+json");
    let json = answer.json();
    assert_eq!(json["status"], status);
    for key in ["type", "title", "detail"] {
        assert!(json[key].is_string(), "{key}: {json}");
    }
}

#[tokio::test]
async fn every_refusal_is_a_problem() {
    let mut site = Site::plain();
    site.publish(1).await;
    for (path, status) in [
        ("/nothing", 404),
        ("/api/v1/tracks/nobody", 404),
        ("/api/v1/tracks/%FF", 400),
        ("/uss/flights", 400),
        ("/uss/flights?view=50,0,51,1", 413),
        ("/uss/flights/nobody/details", 404),
    ] {
        is_problem(&site.get(path).await, status);
    }
    let wrong = site.ask(Request::delete("/api/v1/tracks")).await;
    is_problem(&wrong, 405);
    assert!(wrong.header("allow").contains("GET"));
    let large = Request::post("/api/v1/stream-tickets").header("content-length", "65537");
    is_problem(&site.ask(large).await, 413);
    is_problem(&site.get(&format!("/{}", "x".repeat(9_000))).await, 414);
    for (name, query) in [
        ("bbox", "bbox=1,2,3"),
        ("bbox", "bbox=0,10,1,9"),
        ("bbox", "bbox=0,0,181,1"),
        ("bbox", "bbox=NaN,0,1,1"),
        ("source", "source=bird"),
        ("sensor", "sensor=nobody"),
        ("alt_min", "alt_min=inf"),
        ("alt_max", "alt_max=high"),
        ("ids", "ids="),
        ("max_accuracy_m", "max_accuracy_m=0.9"),
        ("max_accuracy_m", "max_accuracy_m=10001"),
        ("max_accuracy_m", "max_accuracy_m=NaN"),
        ("max_accuracy_m", "max_accuracy_m=poor"),
        ("limit", "limit=0"),
        ("limit", "limit=-1"),
        ("limit", "limit=1&limit=2"),
        ("trail_s", "trail_s=0"),
        ("trail_s", "trail_s=601"),
        ("color", "color=red"),
    ] {
        let answer = site.get(&format!("/api/v1/tracks?{query}")).await;
        is_problem(&answer, 400);
        assert_eq!(answer.json()["parameter"], name, "{query}");
    }
    is_problem(&site.get("/api/v1/stream?interval_ms=249").await, 400);
    is_problem(&site.get("/api/v1/raw?after=-1").await, 400);
}

#[tokio::test]
async fn half_open_clients_are_dropped() {
    let options = Options { header_timeout: Duration::from_secs(2), ..Options::default() };
    let site = Site::with(options, |config| config.http.connections_per_address = None);
    let address = site.listen().await;
    let mut half_open = Vec::new();
    for _ in 0..300 {
        let socket = TcpStream::connect(address).await.unwrap();
        send(&socket, b"GET /api/v1/tra").await;
        half_open.push(socket);
    }
    let answer = tokio::time::timeout(Duration::from_secs(2), Reader::open(address, "/healthz", ""));
    assert!(answer.await.expect("no answer").head.contains("200 OK"));
    for socket in half_open {
        let ended = async { while receive(&socket, &mut [0; 1024]).await > 0 {} };
        tokio::time::timeout(Duration::from_secs(10), ended).await.expect("a half-open connection stays");
    }
}

#[tokio::test]
async fn client_that_reads_nothing_is_disconnected() {
    let options = Options { stuck_timeout: Duration::from_secs(2), ..Options::default() };
    let site = Site::with(options, |_| {});
    let address = site.listen().await;
    let socket = TcpStream::connect(address).await.unwrap();
    let request = b"GET /openapi.json HTTP/1.1\r\nHost: localhost\r\n\r\n";
    let flood = async {
        // Sends until the buffers of both ends are full, then until the connection is closed.
        loop {
            socket.writable().await.unwrap();
            match socket.try_write(request) {
                Err(error) if error.kind() != std::io::ErrorKind::WouldBlock => break,
                _ => {}
            }
        }
    };
    tokio::time::timeout(Duration::from_secs(20), flood).await.expect("it is waited for");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_query_is_never_a_server_error(
        path in prop::sample::select(vec!["/api/v1/tracks", "/api/v1/sensors", "/uss/flights", "/data/aircraft.json"]),
        parameters in prop::collection::vec((
            prop::sample::select(vec!["bbox", "source", "sensor", "alt_min", "alt_max", "ids", "limit", "view", "x"]),
            "[-0-9.,eEinfNa%&=A-F]{0,24}",
        ), 0..4),
    ) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let query: Vec<String> = parameters.iter().map(|(name, value)| format!("{name}={value}")).collect();
        let (status, text) = runtime.block_on(async {
            let mut site = Site::plain();
            site.publish(1).await;
            let answer = site.get(&format!("{path}?{}", query.join("&"))).await;
            (answer.status, answer.text)
        });
        prop_assert!(status.as_u16() < 500, "{status} {text}");
        prop_assert!(serde_json::from_str::<serde_json::Value>(&text).is_ok());
        if status == StatusCode::BAD_REQUEST {
            prop_assert!(text.contains("\"parameter\""), "{text}");
        }
    }
}
