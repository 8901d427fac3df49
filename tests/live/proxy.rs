//! The recipe for a reverse proxy, `docker/nginx.conf`, with nginx, if installed.

use std::net::TcpListener;
use std::num::NonZeroU32;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{Running, Scratch, flight, on_own_ports, utm_fusion};
use crate::tls::{Issued, NAME};

const RECIPE: &str = include_str!("../../docker/nginx.conf");

/// nginx, which ends with the test.
struct Nginx(Child);

impl Drop for Nginx {
    fn drop(&mut self) {
        // A single process without workers.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn nginx() -> Option<&'static str> {
    let found = ["nginx", "/usr/sbin/nginx"].into_iter().find(|path| {
        Command::new(path).arg("-v").stderr(Stdio::null()).status().is_ok_and(|status| status.success())
    });
    if found.is_none() {
        println!("skipped: nginx is not installed");
    }
    found
}

/// Starts nginx with the recipe, between this port and the service, with files of this test.
fn proxy(nginx: &str, scratch: &Scratch, port: u16, service: u16) -> Nginx {
    let mut recipe = RECIPE.to_owned();
    for (written, here) in [
        ("listen 443 ssl;", format!("listen 127.0.0.1:{port} ssl;")),
        ("server 127.0.0.1:8080;", format!("server 127.0.0.1:{service};")),
        ("/etc/ssl/certs/fusion.example.pem", scratch.path("certificate.pem").display().to_string()),
        ("/etc/ssl/private/fusion.example.key", scratch.path("key.pem").display().to_string()),
    ] {
        assert!(recipe.contains(written), "{written}");
        recipe = recipe.replace(written, &here);
    }
    scratch.file("recipe.conf", recipe);
    let temporary = ["client_body", "proxy", "fastcgi", "uwsgi", "scgi"]
        .map(|kind| format!("{kind}_temp_path {};\n", scratch.path(kind).display()))
        .concat();
    let main = format!(
        "daemon off;\nmaster_process off;\npid {};\nerror_log stderr;\nevents {{}}\nhttp {{\naccess_log off;\n{temporary}include {};\n}}\n",
        scratch.path("nginx.pid").display(),
        scratch.path("recipe.conf").display(),
    );
    let main = scratch.file("nginx.conf", main);
    let child = Command::new(nginx)
        .arg("-c")
        .arg(main)
        .arg("-p")
        .arg(scratch.path(""))
        .args(["-e", "stderr"])
        .stdin(Stdio::null())
        .spawn()
        .unwrap();
    Nginx(child)
}

#[test]
fn proxy_recipe_forwards_streams_and_client_addresses() {
    let Some(nginx) = nginx() else { return };
    let scratch = Scratch::new();
    let scenario = "name = \"still\"\nduration_s = 20\n[drones]\nmultirotors = 1\nequipped = 1\n";
    let mut config = on_own_ports(&flight(scenario, 1, None).config, 24_400, &scratch, None);
    config.http.hosts = vec![NAME.to_owned()];
    config.http.trusted_proxies = vec!["127.0.0.1".parse().unwrap()];
    (config.http.requests_per_s, config.http.requests_burst) = (NonZeroU32::new(1), 20);
    let site = scratch.file("site.toml", config.to_string());
    let mut service = Running::start(utm_fusion("run").arg("--config").arg(&site), scratch.path("run.log"));
    service.says("url=http://127.0.0.1:");
    let log = service.log();
    let own = log.split("url=http://127.0.0.1:").nth(1).unwrap().split('/').next().unwrap();

    let issued = Issued::new();
    scratch.file("certificate.pem", &issued.certificate);
    scratch.file("key.pem", &issued.key);
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let _nginx = proxy(nginx, &scratch, port, own.parse().unwrap());
    let end = Instant::now() + Duration::from_secs(20);
    while issued.connect(port).and_then(|mut proxy| proxy.status("GET /healthz", "")).ok() != Some(200) {
        assert!(Instant::now() < end, "nginx does not answer");
        std::thread::sleep(Duration::from_millis(100));
    }

    // A buffering proxy would deliver after some kilobytes; a heartbeat has a hundred octets.
    let mut stream = issued.connect_from([127, 0, 0, 9], port).unwrap();
    stream.answer("/api/v1/stream", "", "event: snapshot").unwrap();
    for _ in 0..3 {
        stream.until("event: heartbeat").unwrap();
    }

    // A WebSocket passes the proxy, too.
    let mut socket = issued.connect_from([127, 0, 0, 5], port).unwrap();
    let handshake = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
                     Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nOrigin: https://fusion.example\r\n";
    assert_eq!(socket.status("GET /api/v1/stream/ws", handshake).unwrap(), 101);
    for _ in 0..2 {
        socket.until("\"event\":\"heartbeat\"").unwrap();
    }

    // The service's own page is accepted, another origin is not.
    let mut page = issued.connect_from([127, 0, 0, 8], port).unwrap();
    let mut post = |origin: &str| {
        page.status("POST /api/v1/stream-tickets", &format!("Content-Length: 0\r\nOrigin: {origin}\r\n"))
    };
    assert_eq!(post("https://fusion.example").unwrap(), 200);
    assert_eq!(post("https://strange.example").unwrap(), 403);

    // Each client has its own limit, whatever headers it forges.
    let mut greedy = issued.connect_from([127, 0, 0, 7], port).unwrap();
    let mut statuses = Vec::new();
    for number in 0..200 {
        let forged = format!("X-Forwarded-For: 203.0.113.{number}\r\nForwarded: for=203.0.113.{number}\r\n");
        statuses.push(greedy.status("GET /api/v1/info", &forged).unwrap());
        if statuses.last() == Some(&429) {
            break;
        }
    }
    assert!(statuses[..20].iter().all(|status| *status == 200), "{statuses:?}");
    assert!(statuses.contains(&429), "{statuses:?}");
    assert_eq!(
        issued.connect_from([127, 0, 0, 6], port).unwrap().status("GET /api/v1/info", "").unwrap(),
        200
    );
    drop(stream);
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
}
