//! Who is let in: connections of an address, clients behind a proxy, names and pages.

use std::net::{Ipv4Addr, SocketAddr};
use std::num::NonZeroU32;
use std::time::Duration;

use fusion::time::{SECOND, Time};
use tokio::net::{TcpSocket, TcpStream};
use utm_fusion::api::Options;
use utm_fusion::config::Config;

use crate::common::{Reader, Site, receive};

/// A connection from an address of its own.
async fn connect(from: u8, to: SocketAddr) -> TcpStream {
    let socket = TcpSocket::new_v4().unwrap();
    socket.bind((Ipv4Addr::new(127, 0, 0, from), 0).into()).unwrap();
    socket.connect(to).await.unwrap()
}

/// Sends a request; the status, or `None` where the connection is closed instead.
async fn ask(socket: &TcpStream, request: &str) -> Option<u16> {
    // What is closed already takes nothing.
    let _ = socket.try_write(request.as_bytes());
    let mut octets = [0; 1 << 16];
    let count = tokio::time::timeout(Duration::from_secs(60), receive(socket, &mut octets)).await.unwrap();
    let text = String::from_utf8_lossy(&octets[..count]);
    text.split(' ').nth(1)?.parse().ok()
}

const HEALTH: &str = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n";

/// How many of `count` connections are let in, and the connections.
async fn crowd(from: u8, to: SocketAddr, count: usize) -> (usize, Vec<TcpStream>) {
    let (mut inside, mut all) = (0, Vec::new());
    for _ in 0..count {
        let socket = connect(from, to).await;
        inside += usize::from(ask(&socket, HEALTH).await == Some(200));
        all.push(socket);
    }
    (inside, all)
}

/// Idle connections stay, however slow this machine is.
fn patient() -> Options {
    Options { header_timeout: Duration::from_secs(600), ..Options::default() }
}

fn trusting(networks: &[&str]) -> impl FnOnce(&mut Config) {
    let networks = networks.iter().map(|network| network.parse().unwrap()).collect();
    |config| config.http.trusted_proxies = networks
}

#[tokio::test]
async fn one_address_has_so_many_connections_and_hinders_nobody_else() {
    let site = Site::with(patient(), |_| {});
    let address = site.listen().await;
    let (inside, mut all) = crowd(2, address, 100).await;
    assert_eq!(inside, 64);
    for from in [1, 3] {
        assert_eq!(ask(&connect(from, address).await, HEALTH).await, Some(200), "127.0.0.{from}");
    }
    let metrics = site.get("/metrics").await.text;
    for line in [
        "utm_fusion_http_connections_refused_total{reason=\"address\"} 36",
        "utm_fusion_http_connections_refused_total{reason=\"full\"} 0",
    ] {
        assert!(metrics.contains(line), "{line}\n{metrics}");
    }
    // Who leaves makes room.
    all.truncate(60);
    let mut again = None;
    for _ in 0..200 {
        again = ask(&connect(2, address).await, HEALTH).await;
        if again.is_some() {
            break;
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    assert_eq!(again, Some(200));
}

#[tokio::test]
async fn as_many_connections_as_there_may_be_and_not_one_more() {
    let options = Options { connections: 20, ..patient() };
    let site = Site::with(options, |config| config.http.connections_per_address = None);
    let address = site.listen().await;
    assert_eq!(crowd(2, address, 30).await.0, 20);
    let metrics = site.get("/metrics").await.text;
    assert!(metrics.contains("_refused_total{reason=\"full\"} 10\n"), "{metrics}");
}

#[tokio::test]
async fn a_trusted_proxy_is_not_capped_and_its_clients_are_told_apart() {
    // Time stands still: no bucket fills again.
    let clock = || Time::from_nanos(1_000_000 * SECOND);
    let site = Site::with(Options { streams_per_address: 1, clock, ..patient() }, |config| {
        (config.http.requests_per_s, config.http.requests_burst) = (NonZeroU32::new(1), 5);
        trusting(&["127.0.0.2"])(config);
    });
    let address = site.listen().await;
    assert_eq!(crowd(2, address, 100).await.0, 100);

    let statuses = async |from: u8, headers: &str, count: usize| {
        let mut statuses = Vec::new();
        let socket = connect(from, address).await;
        for _ in 0..count {
            let request = format!("GET /api/v1/info HTTP/1.1\r\nHost: localhost\r\n{headers}\r\n");
            statuses.push(ask(&socket, &request).await.unwrap());
        }
        statuses
    };
    let (six, refused) = (6, [200, 200, 200, 200, 200, 429]);
    // What a client writes itself does not change whose its requests are.
    assert_eq!(statuses(2, "X-Forwarded-For: 203.0.113.1, 198.51.100.7\r\n", six).await, refused);
    assert_eq!(statuses(2, "X-Forwarded-For: 203.0.113.2, 198.51.100.7\r\n", 1).await, [429]);
    assert_eq!(statuses(2, "Forwarded: for=\"[2001:db8::1]:4711\"\r\n", six).await, refused);
    assert_eq!(statuses(2, "Forwarded: for=\"[2001:db8::2]\"\r\n", 1).await, [429], "one subscriber");
    assert_eq!(statuses(2, "X-Forwarded-For: 198.51.100.8\r\n", 1).await, [200]);
    // Nobody else is believed.
    assert_eq!(statuses(3, "X-Forwarded-For: 198.51.100.7\r\n", 1).await, [200]);

    let stream = "GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\nX-Forwarded-For: ";
    let mut held = Vec::new();
    for (client, status) in [("198.51.100.20", 200), ("198.51.100.20", 429), ("198.51.100.21", 200)] {
        let socket = connect(2, address).await;
        assert_eq!(ask(&socket, &format!("{stream}{client}\r\n\r\n")).await, Some(status), "{client}");
        held.push(socket);
    }
}

#[tokio::test]
async fn a_name_that_is_not_ours_is_not_answered() {
    let site = Site::with(Options::default(), |config| config.http.hosts = vec!["fusion.example".to_owned()]);
    let address = site.listen().await;
    for path in ["/", "/healthz", "/api/v1/tracks", "/api/v1/stream", "/map.js", "/nothing"] {
        let rebound = Reader::open(address, path, "Connection: close\r\n").await;
        assert!(!rebound.head.contains(" 421 "), "{path}: {}", rebound.head);
        let request = format!("GET {path} HTTP/1.1\r\nHost: rebound.example:{}\r\n\r\n", address.port());
        assert_eq!(ask(&connect(2, address).await, &request).await, Some(421), "{path}");
    }
    for (request, status) in [
        ("GET /healthz HTTP/1.1\r\nHost: 127.0.0.1:8080\r\n\r\n", 200),
        ("GET /healthz HTTP/1.1\r\nHost: 192.0.2.7\r\n\r\n", 200),
        ("GET /healthz HTTP/1.1\r\nHost: [::1]:80\r\n\r\n", 200),
        ("GET /healthz HTTP/1.1\r\nHost: LocalHost.:9\r\n\r\n", 200),
        ("GET /healthz HTTP/1.1\r\nHost: fusion.example\r\n\r\n", 200),
        ("GET http://fusion.example/healthz HTTP/1.1\r\nHost: fusion.example\r\n\r\n", 200),
        ("GET http://rebound.example/healthz HTTP/1.1\r\nHost: localhost\r\n\r\n", 421),
        ("GET /healthz HTTP/1.1\r\nHost: fusion.example.rebound.example\r\n\r\n", 421),
        ("GET /healthz HTTP/1.1\r\nHost: 127.0.0.1.rebound.example\r\n\r\n", 421),
        // What a proxy says of the name is not asked.
        ("GET /healthz HTTP/1.1\r\nHost: rebound.example\r\nX-Forwarded-Host: localhost\r\n\r\n", 421),
        ("GET /healthz HTTP/1.1\r\n\r\n", 400),
        ("GET /healthz HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n\r\n", 400),
        ("GET /healthz HTTP/1.1\r\nHost: rebound.example@localhost\r\n\r\n", 400),
        ("GET /healthz HTTP/1.1\r\nHost:\r\n\r\n", 400),
        ("GET /healthz HTTP/1.0\r\n\r\n", 200),
    ] {
        assert_eq!(ask(&connect(3, address).await, request).await, Some(status), "{request}");
    }
    let told = site.ask(axum::http::Request::get("/healthz").header("host", "rebound.example")).await;
    assert!(
        told.text.contains("the name rebound.example") && told.text.contains("http.hosts"),
        "{}",
        told.text
    );
}

#[tokio::test]
async fn a_page_of_another_origin_steers_nothing() {
    let site = Site::with(Options::default(), |config| {
        config.http.cors = vec!["https://map.example".to_owned()];
        config.http.hosts = vec!["fusion.example".to_owned()];
    });
    let address = site.listen().await;
    for (headers, status) in [
        // No browser.
        ("", 200),
        ("Content-Type: application/json\r\n", 200),
        // Its own page, straight and behind a proxy that has a name.
        ("Origin: http://127.0.0.1:8080\r\nSec-Fetch-Site: same-origin\r\n", 200),
        ("Origin: https://fusion.example\r\nSec-Fetch-Site: same-origin\r\n", 200),
        // A listed one.
        ("Origin: https://map.example\r\nSec-Fetch-Site: cross-site\r\n", 200),
        ("Origin: https://strange.example\r\nSec-Fetch-Site: cross-site\r\n", 403),
        ("Origin: https://strange.example\r\n", 403),
        ("Origin: null\r\n", 403),
        ("Origin: http://127.0.0.1:3000\r\nSec-Fetch-Site: same-site\r\n", 403),
        ("Origin: https://fusion.example:8443\r\n", 403),
        ("Sec-Fetch-Site: cross-site\r\n", 403),
        ("Content-Type: application/x-www-form-urlencoded\r\n", 415),
        ("Content-Type: Text/Plain; charset=utf-8\r\n", 415),
    ] {
        let post = "POST /api/v1/stream-tickets HTTP/1.1\r\nHost: 127.0.0.1:8080\r\n";
        let request = format!("{post}{headers}\r\n");
        assert_eq!(ask(&connect(2, address).await, &request).await, Some(status), "{headers}");
    }
    // `curl -d` calls its body a form: the answer names the header that it needs.
    let verdict = axum::http::Request::post("/api/v1/integrity/X")
        .header("content-type", "application/x-www-form-urlencoded");
    let refused = site.ask(verdict).await;
    assert_eq!(refused.status, axum::http::StatusCode::UNSUPPORTED_MEDIA_TYPE);
    assert!(refused.text.contains("Content-Type: application/json"), "{}", refused.text);
    // It may ask, and its browser shows it nothing.
    let request = "GET /api/v1/info HTTP/1.1\r\nHost: localhost\r\nOrigin: https://strange.example\r\n\r\n";
    assert_eq!(ask(&connect(2, address).await, request).await, Some(200));
}
