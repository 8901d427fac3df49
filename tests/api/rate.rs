//! Request limits.

use std::net::{Ipv4Addr, SocketAddr};
use std::num::NonZeroU32;
use std::sync::atomic::{AtomicI64, Ordering};

use axum::http::{Request, StatusCode};
use fusion::time::{SECOND, Time};
use tokio::net::TcpSocket;
use utm_fusion::api::Options;
use utm_fusion::config::{Auth, Config};

use crate::common::{Reader, Site, receive, send};

fn limited(config: &mut Config) {
    (config.http.requests_per_s, config.http.requests_burst) = (NonZeroU32::new(10), 5);
}

async fn status(address: SocketAddr, path: &str) -> String {
    let reader = Reader::open(address, path, "Connection: close\r\n").await;
    reader.head.split(' ').nth(1).unwrap().to_owned()
}

/// Number of `count` consecutive requests that were not refused.
async fn accepted(address: SocketAddr, count: usize) -> usize {
    let mut accepted = 0;
    for _ in 0..count {
        accepted += usize::from(status(address, "/api/v1/info").await == "200");
    }
    accepted
}

#[tokio::test]
async fn exceeded_rate_is_refused_with_retry_after() {
    static NOW: AtomicI64 = AtomicI64::new(1_000_000 * SECOND);
    let clock = || Time::from_nanos(NOW.load(Ordering::Relaxed));
    let wait = |ns: i64| NOW.fetch_add(ns, Ordering::Relaxed);
    let site = Site::with(Options { clock, ..Options::default() }, limited);
    let address = site.listen().await;
    assert_eq!(accepted(address, 8).await, 5, "the burst");
    wait(SECOND / 5);
    assert_eq!(accepted(address, 4).await, 2, "then the rate");
    let refused = Reader::open(address, "/api/v1/info", "Connection: close\r\n").await;
    for part in ["429 Too Many Requests", "retry-after: 1", "application/problem+json"] {
        assert!(refused.head.contains(part), "{part}\n{}", refused.head);
    }
    // Page files and unknown paths count as requests; probes do not.
    assert_eq!(status(address, "/").await, "429");
    assert_eq!(status(address, "/nothing").await, "429");
    assert_eq!(status(address, "/healthz").await, "200");
    assert_eq!(status(address, "/readyz").await, "503");
    // Other clients are not limited either.
    let elsewhere = TcpSocket::new_v4().unwrap();
    elsewhere.bind((Ipv4Addr::new(127, 0, 0, 2), 0).into()).unwrap();
    let elsewhere = elsewhere.connect(address).await.unwrap();
    send(&elsewhere, b"GET /api/v1/info HTTP/1.1\r\nHost: localhost\r\n\r\n").await;
    let mut octets = [0; 12];
    receive(&elsewhere, &mut octets).await;
    assert_eq!(&octets, b"HTTP/1.1 200");
    let metrics = site.get("/metrics").await.text;
    assert!(metrics.contains("\nutm_fusion_http_requests_limited_total 8\n"), "{metrics}");
    assert!(metrics.contains("\nutm_fusion_http_responses_total{status=\"429\"} 8\n"), "{metrics}");
    wait(3600 * SECOND);
    assert_eq!(accepted(address, 8).await, 5);
}

#[tokio::test]
async fn a_token_is_limited_wherever_it_is_used() {
    static NOW: AtomicI64 = AtomicI64::new(1_000_000 * SECOND);
    let clock = || Time::from_nanos(NOW.load(Ordering::Relaxed));
    let file = std::env::temp_dir().join(format!("utm-fusion-rate-{}.toml", std::process::id()));
    // SHA-256 of "alpha" and "beta".
    let text = "a = { sha256 = \"8ed3f6ad685b959ead7022518e1af76cd816f8e8ec7ccdda1ed4018e8f2223f8\", scopes = [\"read\"] }\n\
                b = { sha256 = \"f44e64e75f3948e9f73f8dfa94721c4ce8cbb4f265c4790c702b2d41cfbf2753\", scopes = [\"read\"] }\n";
    std::fs::write(&file, text).unwrap();
    let site = Site::with(Options { clock, ..Options::default() }, |config| {
        limited(config);
        config.http.auth = Auth::Tokens { tokens_file: file };
    });
    // Without a socket there is no client address.
    let ask = async |token: &str| {
        let request = Request::get("/api/v1/info").header("authorization", format!("Bearer {token}"));
        site.ask(request).await.status
    };
    for _ in 0..5 {
        assert_eq!(ask("alpha").await, StatusCode::OK);
    }
    assert_eq!(ask("alpha").await, StatusCode::TOO_MANY_REQUESTS);
    assert_eq!(ask("beta").await, StatusCode::OK);
    NOW.fetch_add(SECOND / 10, Ordering::Relaxed);
    assert_eq!(ask("alpha").await, StatusCode::OK);
    assert_eq!(ask("alpha").await, StatusCode::TOO_MANY_REQUESTS);
}

#[tokio::test]
async fn default_rate_limit_admits_a_dashboard() {
    let unlimited = Site::with(Options::default(), |config| config.http.requests_per_s = None);
    let address = unlimited.listen().await;
    assert_eq!(accepted(address, 300).await, 300);
    // The page with all files and its requests, in several tabs at once.
    let usual = Site::plain().listen().await;
    assert_eq!(accepted(usual, 150).await, 150);
}
