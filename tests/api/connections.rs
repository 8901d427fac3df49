//! Access: connections per address, clients behind a proxy, host names and origins.

use std::net::{Ipv4Addr, SocketAddr};
use std::num::NonZeroU32;
use std::time::Duration;

use fusion::time::{SECOND, Time};
use tokio::net::{TcpSocket, TcpStream};
use utm_fusion::api::Options;
use utm_fusion::config::Config;

use crate::common::{Reader, Site, receive};

/// Connects from its own loopback address.
async fn connect(from: u8, to: SocketAddr) -> TcpStream {
    let socket = TcpSocket::new_v4().unwrap();
    socket.bind((Ipv4Addr::new(127, 0, 0, from), 0).into()).unwrap();
    socket.connect(to).await.unwrap()
}

/// Sends a request. Returns the status, or `None` if the connection is closed instead.
async fn ask(socket: &TcpStream, request: &str) -> Option<u16> {
    // A closed connection accepts nothing.
    let _ = socket.try_write(request.as_bytes());
    let mut octets = [0; 1 << 16];
    let count = tokio::time::timeout(Duration::from_secs(60), receive(socket, &mut octets)).await.unwrap();
    let text = String::from_utf8_lossy(&octets[..count]);
    text.split(' ').nth(1)?.parse().ok()
}

const HEALTH: &str = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n";

/// Opens `count` connections. Returns the number accepted, and the connections.
async fn crowd(from: u8, to: SocketAddr, count: usize) -> (usize, Vec<TcpStream>) {
    let (mut inside, mut all) = (0, Vec::new());
    for _ in 0..count {
        let socket = connect(from, to).await;
        inside += usize::from(ask(&socket, HEALTH).await == Some(200));
        all.push(socket);
    }
    (inside, all)
}

/// Options that keep idle connections open, however slow this machine is.
fn patient() -> Options {
    Options { header_timeout: Duration::from_secs(600), ..Options::default() }
}

fn trusting(networks: &[&str]) -> impl FnOnce(&mut Config) {
    let networks = networks.iter().map(|network| network.parse().unwrap()).collect();
    |config| config.http.trusted_proxies = networks
}

#[tokio::test]
async fn connections_per_address_are_limited() {
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
    // Closed connections make way for new ones.
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
async fn connections_in_total_are_limited() {
    let options = Options { connections: 20, ..patient() };
    let site = Site::with(options, |config| config.http.connections_per_address = None);
    let address = site.listen().await;
    assert_eq!(crowd(2, address, 30).await.0, 20);
    let metrics = site.get("/metrics").await.text;
    assert!(metrics.contains("_refused_total{reason=\"full\"} 10\n"), "{metrics}");
}

#[tokio::test]
async fn trusted_proxy_has_no_cap_and_its_clients_are_distinguished() {
    // The clock stands still, so that no bucket refills.
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
    // Entries written by the client do not change the address that its requests count for.
    assert_eq!(statuses(2, "X-Forwarded-For: 203.0.113.1, 198.51.100.7\r\n", six).await, refused);
    assert_eq!(statuses(2, "X-Forwarded-For: 203.0.113.2, 198.51.100.7\r\n", 1).await, [429]);
    assert_eq!(statuses(2, "Forwarded: for=\"[2001:db8::1]:4711\"\r\n", six).await, refused);
    assert_eq!(statuses(2, "Forwarded: for=\"[2001:db8::2]\"\r\n", 1).await, [429], "one subscriber");
    assert_eq!(statuses(2, "X-Forwarded-For: 198.51.100.8\r\n", 1).await, [200]);
    // Other peers' headers are not trusted.
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
async fn unknown_host_name_is_refused() {
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
        // A proxy's statement of the host name is ignored.
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
async fn page_of_another_origin_cannot_act() {
    let site = Site::with(Options::default(), |config| {
        config.http.cors = vec!["https://map.example".to_owned()];
        config.http.hosts = vec!["fusion.example".to_owned()];
    });
    let address = site.listen().await;
    for (headers, status) in [
        // Not a browser.
        ("", 200),
        ("Content-Type: application/json\r\n", 200),
        // The service's own page, directly and behind a proxy with a host name.
        ("Origin: http://127.0.0.1:8080\r\nSec-Fetch-Site: same-origin\r\n", 200),
        ("Origin: https://fusion.example\r\nSec-Fetch-Site: same-origin\r\n", 200),
        // A listed origin.
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
    // `curl -d` sends its body as a form. The answer names the required header.
    let verdict = axum::http::Request::post("/api/v1/integrity/X")
        .header("content-type", "application/x-www-form-urlencoded");
    let refused = site.ask(verdict).await;
    assert_eq!(refused.status, axum::http::StatusCode::UNSUPPORTED_MEDIA_TYPE);
    assert!(refused.text.contains("Content-Type: application/json"), "{}", refused.text);
    // The request is answered, but a browser does not show the answer to the page.
    let request = "GET /api/v1/info HTTP/1.1\r\nHost: localhost\r\nOrigin: https://strange.example\r\n\r\n";
    assert_eq!(ask(&connect(2, address).await, request).await, Some(200));
}
