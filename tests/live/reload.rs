//! SIGHUP: keys that change at once, keys that need a restart, and the rejection of an invalid file.

use std::fs;
use std::io::{Read, Write};
use std::net::Ipv4Addr;
use std::net::TcpStream;
use std::num::NonZeroU32;
use std::path::PathBuf;
use std::time::Duration;

use utm_fusion::config::{Address, AlertArea, Area, AreaKind, Auth, Config};

use crate::common::{Running, Scratch, flight, group, joined, on_own_ports, utm_fusion};

const SCENARIO: &str = "name = \"still\"\nduration_s = 20\n[drones]\nmultirotors = 1\nequipped = 1\n";
/// SHA-256 of "alpha" and of "beta".
const ALPHA: &str = "8ed3f6ad685b959ead7022518e1af76cd816f8e8ec7ccdda1ed4018e8f2223f8";
const BETA: &str = "f44e64e75f3948e9f73f8dfa94721c4ce8cbb4f265c4790c702b2d41cfbf2753";

/// A service, and its configuration, which a test changes.
struct Stage {
    scratch: Scratch,
    config: Config,
    site: PathBuf,
    service: Running,
    port: u16,
    reloads: usize,
}

impl Stage {
    /// `change` has access to the files of tokens and areas.
    fn new(port: u16, change: impl FnOnce(&mut Config, &Scratch)) -> Self {
        let scratch = Scratch::new();
        let mut config = on_own_ports(&flight(SCENARIO, 1, None).config, port, &scratch, None);
        tokens(&scratch, ALPHA);
        change(&mut config, &scratch);
        let site = scratch.file("site.toml", config.to_string());
        let mut service =
            Running::start(utm_fusion("run").arg("--config").arg(&site), scratch.path("run.log"));
        service.says("url=http://");
        let log = service.log();
        let port = log.split("url=http://").nth(1).unwrap().split(['/', ':']).nth(1).unwrap();
        let port = port.parse().unwrap();
        Self { scratch, config, site, service, port, reloads: 0 }
    }

    /// Writes the configuration, and reloads it; returns the log of the reload.
    fn reload(&mut self) -> String {
        let text = self.config.to_string();
        self.reload_text(&text)
    }

    fn reload_text(&mut self, text: &str) -> String {
        fs::write(&self.site, text).unwrap();
        self.service.signal("-HUP");
        self.reloads += 1;
        for _ in 0..1200 {
            std::thread::sleep(Duration::from_millis(50));
            let log = self.service.log();
            let told: Vec<&str> = log.split(" read anew\n").collect();
            // The last line of a reload.
            let is_over = |told: &str| told.contains("SIGHUP is done") || told.contains("SIGHUP is refused");
            if told.len() > self.reloads && is_over(told[self.reloads]) {
                return told[self.reloads].to_owned();
            }
        }
        panic!("nothing was read anew:\n{}", self.service.log());
    }

    /// Status and body of an answer.
    fn get(&self, path: &str, headers: &str) -> (u16, String) {
        let mut answer = String::new();
        self.open(path, &format!("{headers}Connection: close\r\n")).read_to_string(&mut answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        (head.split(' ').nth(1).unwrap().parse().unwrap(), format!("{head}\r\n\r\n{body}"))
    }

    fn open(&self, path: &str, headers: &str) -> TcpStream {
        let mut socket = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        socket.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        socket
            .write_all(format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n{headers}\r\n").as_bytes())
            .unwrap();
        socket
    }

    /// Statuses for these tokens, and without a token.
    fn statuses(&self) -> [u16; 3] {
        ["Authorization: Bearer alpha\r\n", "Authorization: Bearer beta\r\n", ""]
            .map(|headers| self.get("/api/v1/info", headers).0)
    }

    fn stop(self) {
        let (code, log) = self.service.stop();
        assert_eq!(code, Some(0), "{log}");
    }
}

fn tokens(scratch: &Scratch, sha256: &str) -> PathBuf {
    let text = format!("desk = {{ sha256 = \"{sha256}\", scopes = [\"read\", \"stream\"] }}\n");
    scratch.file("tokens.toml", text)
}

fn with_tokens(config: &mut Config, scratch: &Scratch) {
    config.http.auth = Auth::Tokens { tokens_file: scratch.path("tokens.toml") };
}

/// Whether the status, which is sent once a second, arrives at this port.
fn hears_status(port: u16) -> bool {
    let socket = joined(group(99), port, Ipv4Addr::LOCALHOST);
    let mut octets = [0; 64];
    (0..4).any(|_| matches!(socket.recv(&mut octets), Ok(11) if octets[0] == 65))
}

fn area(scratch: &Scratch, name: &str, kind: AreaKind) -> Area {
    let polygon = r#"{"type":"Polygon","coordinates":[[[-0.6,52.5],[-0.5,52.5],[-0.5,52.6],[-0.6,52.5]]]}"#;
    Area { kind, file: scratch.file(&format!("{name}.geojson"), polygon) }
}

#[test]
fn revoked_token_is_rejected_and_its_stream_ends() {
    let mut stage = Stage::new(22_400, with_tokens);
    assert_eq!(stage.statuses(), [200, 401, 401]);
    let mut stream = stage.open("/api/v1/stream", "Authorization: Bearer alpha\r\nConnection: close\r\n");
    let mut head = [0; 15];
    stream.read_exact(&mut head).unwrap();
    assert_eq!(&head, b"HTTP/1.1 200 OK");
    tokens(&stage.scratch, BETA);
    let told = stage.reload();
    assert!(told.contains("1 tokens are accepted") && !told.contains("restart"), "{told}");
    assert_eq!(stage.statuses(), [401, 200, 401]);
    let mut shown = String::new();
    stream.read_to_string(&mut shown).unwrap();
    assert!(shown.contains("event: closed\ndata: {\"reason\":\"the token is no longer known\"}"), "{shown}");

    // An invalid file of tokens neither removes nor adds access.
    tokens(&stage.scratch, "no hash");
    let told = stage.reload();
    assert!(told.contains("everything stays as it was") && told.contains("desk: sha256"), "{told}");
    assert_eq!(stage.statuses(), [401, 200, 401]);
    stage.stop();
}

#[test]
fn reload_applies_changes_and_names_the_rest() {
    let mut stage = Stage::new(22_500, |config, _| config.output.status = true);
    let port = stage.config.output.asterix[0].port;
    let cors = |stage: &Stage| stage.get("/api/v1/info", "Origin: https://map.example\r\n").1;
    assert!(!cors(&stage).contains("access-control-allow-origin"));

    let (alert, mask) = (
        area(&stage.scratch, "field", AreaKind::Alert(AlertArea::default())),
        area(&stage.scratch, "road", AreaKind::Mask),
    );
    stage.config.areas = vec![alert, mask];
    stage.config.http.cors = vec!["https://map.example".to_owned()];
    stage.config.http.hosts = vec!["fusion.example".to_owned()];
    stage.config.http.trusted_proxies = vec!["10.0.0.0/8".parse().unwrap()];
    stage.config.http.connections_per_address = NonZeroU32::new(9);
    stage.config.http.listen.set_port(1);
    stage.config.state.history_mib = 7;
    stage.config.output.asterix[0].port = port + 9;
    stage.config.output.flush_on_stop = false;
    stage.config.sensors[0].period_s = Some(3.5);
    stage.config.fusion.min_samples = 9;
    let told = stage.reload();
    for line in [
        "in force now: http.cors = [\"https://map.example\"], was []",
        "in force now: http.connections_per_address = 9, was 64",
        "in force now: http.hosts = [\"fusion.example\"], was []",
        "in force now: http.trusted_proxies = [\"10.0.0.0/8\"], was []",
        "in force now: output.asterix = ",
        "in force now: state.history_mib = 7, was 512",
        "in force now: areas of kind alert and coverage",
        "needs a restart: fusion.min_samples = 9, was 4",
        "needs a restart: http.listen = \"127.0.0.1:1\", was \"127.0.0.1:0\"",
        "needs a restart: output.flush_on_stop = false, was true",
        "needs a restart: areas of kind mask",
    ] {
        assert!(told.contains(line), "{line}\n{told}");
    }
    let sensor = format!("needs a restart: sensors.{}.period_s = 3.5, was 0.25", stage.config.sensors[0].id);
    assert!(told.contains(&sensor), "{sensor}\n{told}");
    assert_eq!(told.lines().filter(|line| line.contains("restart")).count(), 5, "{told}");
    assert!(cors(&stage).contains("access-control-allow-origin: https://map.example"));
    let (_, areas) = stage.get("/api/v1/areas", "");
    assert!(areas.contains("\"name\":\"field\"") && !areas.contains("\"name\":\"road\""), "{areas}");
    assert_eq!(stage.get("/api/v1/info", "").0, 200);
    assert!(hears_status(port + 9));

    // An output that cannot be opened leaves the old one in place; keys that need a restart are reported again.
    let Address::Multicast { interface, .. } = &mut stage.config.output.asterix[0].address else { panic!() };
    *interface = [192, 0, 2, 1].into();
    stage.config.http.cors.clear();
    let told = stage.reload();
    assert!(told.contains("output.asterix stays as it was: output to"), "{told}");
    assert!(told.contains("in force now: http.cors = []") && told.contains(&sensor), "{told}");
    assert_eq!(told.lines().filter(|line| line.contains("restart")).count(), 5, "{told}");
    assert!(hears_status(port + 9));
    stage.stop();
}

#[test]
fn invalid_file_is_rejected_with_all_errors() {
    let mut stage = Stage::new(22_600, |_, _| {});
    let valid = stage.config.to_string();
    let wrong = valid.replace("cors = []", "cors = [\"https://map.example\"]");
    let wrong = wrong.replace("ratio_min = 0.9", "ratio_min = 2.0").replace("serial = \"uas\"", "serial = 5");
    let told = stage.reload_text(&wrong);
    assert!(told.contains("SIGHUP is refused") && !told.contains("SIGHUP is done"), "{told}");
    for part in ["everything stays as it was", "fusion.ratio_min = 2.0", "output.serial = 5"] {
        assert!(told.contains(part), "{part}\n{told}");
    }
    assert!(!told.contains("in force now"), "{told}");
    let (status, head) = stage.get("/api/v1/info", "Origin: https://map.example\r\n");
    assert!(status == 200 && !head.contains("access-control-allow-origin"), "{head}");
    // An unchanged file is not a change.
    let told = stage.reload_text(&valid);
    assert!(!told.contains("in force now") && !told.contains("restart"), "{told}");
    stage.stop();
}

#[test]
fn token_requirement_cannot_be_lifted_on_a_public_address() {
    let mut stage = Stage::new(22_700, |_, _| {});
    assert_eq!(stage.statuses(), [200, 200, 200]);
    with_tokens(&mut stage.config, &stage.scratch);
    let told = stage.reload();
    assert!(told.contains("in force now: http.auth.mode = \"tokens\", was \"none\""), "{told}");
    assert_eq!(stage.statuses(), [200, 401, 401]);
    stage.config.http.auth = Auth::None;
    stage.reload();
    assert_eq!(stage.statuses(), [200, 200, 200]);
    stage.stop();

    let mut stage = Stage::new(22_800, |config, scratch| {
        config.http.listen = ([0, 0, 0, 0], 0).into();
        with_tokens(config, scratch);
    });
    stage.config.http.listen = ([127, 0, 0, 1], 0).into();
    stage.config.http.auth = Auth::None;
    let told = stage.reload();
    assert!(told.contains("needs a restart: http.auth.mode = \"none\", was \"tokens\""), "{told}");
    assert_eq!(stage.statuses(), [200, 401, 401]);
    stage.stop();
}

#[test]
fn invalid_zone_file_keeps_the_old_zone() {
    let mut stage = Stage::new(22_900, |config, scratch| {
        config.areas = vec![area(scratch, "field", AreaKind::Alert(AlertArea::default()))];
    });
    let has_zone = |stage: &Stage| stage.get("/api/v1/areas", "").1.contains("\"name\":\"field\"");
    assert!(has_zone(&stage));
    let file = stage.config.areas[0].file.clone();
    let uncut = r#"{"type":"Polygon","coordinates":[[[179,52],[-179,52],[-179,53],[179,53],[179,52]]]}"#;
    for (text, part) in [("{\"type\":", "no GeoJSON"), (uncut, "cut in two")] {
        fs::write(&file, text).unwrap();
        let told = stage.reload();
        assert!(told.contains("everything stays as it was"), "{told}");
        assert!(told.contains("field.geojson") && told.contains(part), "{told}");
        assert!(!told.contains("in force now") && has_zone(&stage), "{told}");
    }
    stage.stop();
}
