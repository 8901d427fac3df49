//! The process: notifications to systemd, numbers across restarts, and the commands around the service.

use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::{Duration, Instant};

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use utm_fusion::config::{Address, Config};
use utm_fusion::live::now;

use crate::common::{Running, Scratch, ask, files, flight, on_own_ports, utm_fusion};
use crate::stage::Stage;

const SCENARIO: &str = "name = \"still\"\nduration_s = 20\n[drones]\nmultirotors = 1\nequipped = 1\n";

/// Names of the members of a JSON object. A name that occurs twice in it, or in an object within it, is an error.
#[derive(Default)]
struct UniqueMembers(BTreeSet<String>);

impl<'de> Deserialize<'de> for UniqueMembers {
    fn deserialize<D: Deserializer<'de>>(json: D) -> Result<Self, D::Error> {
        json.deserialize_any(MemberVisitor)
    }
}

struct MemberVisitor;

impl<'de> Visitor<'de> for MemberVisitor {
    type Value = UniqueMembers;

    fn expecting(&self, text: &mut fmt::Formatter<'_>) -> fmt::Result {
        text.write_str("JSON of the log")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<UniqueMembers, A::Error> {
        let mut names = BTreeSet::new();
        while let Some((name, _)) = map.next_entry::<String, UniqueMembers>()? {
            if !names.insert(name.clone()) {
                return Err(A::Error::custom(format!("{name} occurs twice")));
            }
        }
        Ok(UniqueMembers(names))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<UniqueMembers, A::Error> {
        while seq.next_element::<UniqueMembers>()?.is_some() {}
        Ok(UniqueMembers::default())
    }

    fn visit_str<E>(self, _: &str) -> Result<UniqueMembers, E> {
        Ok(UniqueMembers::default())
    }

    fn visit_bool<E>(self, _: bool) -> Result<UniqueMembers, E> {
        Ok(UniqueMembers::default())
    }

    fn visit_u64<E>(self, _: u64) -> Result<UniqueMembers, E> {
        Ok(UniqueMembers::default())
    }

    fn visit_i64<E>(self, _: i64) -> Result<UniqueMembers, E> {
        Ok(UniqueMembers::default())
    }

    fn visit_f64<E>(self, _: f64) -> Result<UniqueMembers, E> {
        Ok(UniqueMembers::default())
    }

    fn visit_unit<E>(self) -> Result<UniqueMembers, E> {
        Ok(UniqueMembers::default())
    }
}

fn told(socket: &UnixDatagram) -> String {
    let mut octets = [0; 256];
    let length = socket.recv(&mut octets).unwrap();
    String::from_utf8(octets[..length].to_vec()).unwrap()
}

#[test]
fn systemd_is_notified_of_ready_watchdog_and_stopping() {
    let scratch = Scratch::new();
    let config = on_own_ports(&flight(SCENARIO, 1, None).config, 22_000, &scratch, None);
    let site = scratch.file("site.toml", config.to_string());
    let path = scratch.path("notify");
    let name = format!("utm-fusion-{}", std::process::id());
    let abstract_name = SocketAddr::from_abstract_name(&name).unwrap();
    for (address, variable) in [
        (SocketAddr::from_pathname(&path).unwrap(), path.display().to_string()),
        (abstract_name, format!("@{name}")),
    ] {
        let socket = UnixDatagram::bind_addr(&address).unwrap();
        socket.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let mut run = utm_fusion("run");
        run.arg("--config").arg(&site).args(["--log-format", "json"]).env("NOTIFY_SOCKET", variable);
        let mut service = Running::start(&mut run, scratch.path("run.log"));
        assert_eq!(told(&socket), "READY=1");
        assert_eq!(told(&socket), "WATCHDOG=1");
        let first = Instant::now();
        assert_eq!(told(&socket), "WATCHDOG=1");
        assert!(first.elapsed() < Duration::from_secs(3));
        // The service continues. Of two pending signals, it may handle the second first.
        service.signal("-HUP");
        service.says("site.toml: read anew");
        let (code, log) = service.stop();
        assert_eq!(code, Some(0), "{log}");
        while told(&socket) != "STOPPING=1" {}
        assert!(log.contains(r#""span":{"line":"239."#), "{log}");
        for line in log.lines() {
            let members = serde_json::from_str::<UniqueMembers>(line).expect(line).0;
            assert!(["timestamp", "level"].iter().all(|name| members.contains(*name)), "{line}");
        }
    }
}

#[test]
fn broken_numbers_file_is_set_aside() {
    let scratch = Scratch::new();
    let config = on_own_ports(&flight(SCENARIO, 1, None).config, 22_100, &scratch, None);
    let site = scratch.file("site.toml", config.to_string());
    fs::create_dir(scratch.path("state")).unwrap();
    scratch.file("state/numbers.json", "{\"version\":1,");
    let mut service = Running::start(utm_fusion("run").arg("--config").arg(&site), scratch.path("run.log"));
    service.says("running");
    assert!(service.is_running());
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    for line in log.lines() {
        let time = line.split(' ').next().unwrap();
        assert!(
            time.len() == "2026-11-28T12:00:00.000Z".len() && time.parse::<jiff::Timestamp>().is_ok(),
            "{log}"
        );
    }
    assert!(log.contains("another one is begun contents=\"transponder numbers\""), "{log}");
    assert_eq!(files(&scratch.path("state"), "numbers.json.damaged-2", "Z").len(), 1);
    assert!(!scratch.path("state/numbers.json").exists());
}

#[test]
fn check_reports_whether_each_line_opens() {
    let scratch = Scratch::new();
    let config = on_own_ports(&flight(SCENARIO, 1, None).config, 22_200, &scratch, None);
    let check = |text: &str| {
        let site = scratch.file("site.toml", text);
        let output = utm_fusion("check").arg("--config").arg(site).arg("--network").output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    };
    let (code, said) = check(&config.to_string());
    assert_eq!((code, said.lines().count(), said.matches(": ok").count()), (Some(0), 3, 3), "{said}");
    // 192.0.2.1 is not an address of any machine.
    let elsewhere = config.to_string().replacen("interface = \"127.0.0.1\"", "interface = \"192.0.2.1\"", 1);
    let (code, said) = check(&elsewhere);
    assert_eq!((code, said.matches(": ok").count()), (Some(1), 2), "{said}");
    assert!(
        said.contains("FAILED") && said.contains("no interface of this machine has the address 192.0.2.1"),
        "{said}"
    );
}

#[test]
fn record_ends_after_its_duration() {
    let scratch = Scratch::new();
    let config = on_own_ports(&flight(SCENARIO, 1, None).config, 22_300, &scratch, None);
    let site = scratch.file("site.toml", config.to_string());
    let began = now();
    let dir = scratch.path("recordings");
    let mut record = Running::start(
        utm_fusion("record").arg("--config").arg(&site).arg("--dir").arg(&dir).args(["--duration", "1s"]),
        scratch.path("record.log"),
    );
    let (code, log) = record.wait(Duration::from_secs(5));
    assert_eq!(code, Some(0), "{log}");
    assert!(now().seconds_since(began) >= 1.0 && log.contains("stopped recorded=0 lost=0"), "{log}");
}

#[test]
fn unusable_configuration_is_reported_at_once() {
    let scratch = Scratch::new();
    let mut config = on_own_ports(&flight(SCENARIO, 1, None).config, 22_350, &scratch, None);
    let site = scratch.file("site.toml", config.to_string());
    config.sensors.iter_mut().for_each(|sensor| sensor.inputs.clear());
    let deaf = scratch.file("deaf.toml", config.to_string());
    let in_the_way = scratch.file("file", "");
    let dir = scratch.path("recordings");
    let ended = |command: &mut std::process::Command| {
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    for command in [&mut utm_fusion("run"), utm_fusion("record").arg("--dir").arg(&dir)] {
        let (code, said) = ended(command.arg("--config").arg(&deaf));
        assert_eq!(code, Some(3), "{said}");
        assert!(said.contains("sensors: no sensor has inputs"), "{said}");
    }
    let (code, said) = ended(utm_fusion("record").arg("--config").arg(&site).arg("--dir").arg(&in_the_way));
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("file: cannot be made: "), "{said}");
    config.sensors = Config::load(&site).unwrap().sensors;
    let Address::Multicast { interface, .. } = &mut config.output.asterix[0].address else { panic!() };
    *interface = [192, 0, 2, 1].into();
    let lost = scratch.file("lost.toml", config.to_string());
    let (code, said) = ended(utm_fusion("run").arg("--config").arg(&lost));
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("(output.asterix); utm-fusion check --network says what to do"), "{said}");
}

#[cfg(feature = "completions")]
#[test]
fn completions_and_man_page_are_generated() {
    let printed = |command: &[&str]| {
        let output = utm_fusion(command[0]).args(&command[1..]).output().unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stdout).unwrap()
    };
    for shell in ["bash", "zsh", "fish"] {
        assert!(printed(&["completions", shell]).contains("replay"), "{shell}");
    }
    let page = printed(&["man"]);
    for wanted in [".TH utm-fusion 1", "UTM\\-FUSION REPLAY", "\\-\\-config", "Exit codes"] {
        assert!(page.contains(wanted), "{wanted}\n{page}");
    }
}

/// A history of some minutes in the state directory of a test.
fn history(scratch: &Scratch) {
    use utm_fusion::history::{HistoryLimits, HistoryPicture, HistoryStore, HistoryTrack};
    fs::create_dir_all(scratch.path("state")).unwrap();
    let limits = HistoryLimits { age: jiff::SignedDuration::from_hours(24), octets: 1 << 30 };
    let store = HistoryStore::open(&scratch.path("state/history.redb"), limits).unwrap();
    let before = now() + jiff::SignedDuration::from_mins(-10);
    let track = |number: u32| HistoryTrack {
        id: format!("F-{number}"),
        source: "radar",
        number,
        latitude_deg: 52.0,
        longitude_deg: -0.5,
        altitude_amsl_m: Some(100.0),
    };
    for second in (0..500).step_by(5) {
        let picture = |second: i64| HistoryPicture {
            time: before + jiff::SignedDuration::from_secs(second),
            tracks: (0..60).map(track).collect(),
        };
        store.keep(&(second..second + 5).map(picture).collect::<Vec<_>>()).unwrap();
    }
}

/// Damages the contents of a file; `None`: a directory takes its place.
type Damage = &'static dyn Fn(Vec<u8>) -> Option<Vec<u8>>;

#[test]
fn damaged_state_is_set_aside_and_the_service_starts() {
    let scratch = Scratch::new();
    let config = on_own_ports(&flight(SCENARIO, 1, None).config, 22_400, &scratch, None);
    let site = scratch.file("site.toml", config.to_string());
    let damages: [(&str, Damage); 5] = [
        ("truncated", &|mut file| {
            file.truncate(file.len() / 2 + 37);
            Some(file)
        }),
        ("three octets more", &|mut file| {
            file.extend([1, 2, 3]);
            Some(file)
        }),
        ("empty", &|_| Some(Vec::new())),
        ("noise", &|file| Some(file.iter().map(|octet| octet.wrapping_mul(31)).collect())),
        ("a directory", &|_| None),
    ];
    for (how, damaged) in damages {
        history(&scratch);
        let names = [
            "history.redb",
            "numbers.json",
            "registration.json",
            "decisions.jsonl",
            "shelved.jsonl",
            "engine.warm",
        ];
        let is_whole = |name: &str| name == "history.redb" && how == "three octets more";
        for name in names {
            let path = scratch.path("state").join(name);
            let file = fs::read(&path).unwrap_or_else(|_| b"{\"version\":1,".repeat(9));
            let _ = fs::remove_file(&path);
            match damaged(file) {
                Some(file) => fs::write(path, file).unwrap(),
                None => fs::create_dir(path).unwrap(),
            }
        }
        let started = Instant::now();
        let mut service =
            Running::start(utm_fusion("run").arg("--config").arg(&site), scratch.path("run.log"));
        service.says("running");
        assert!(started.elapsed() < Duration::from_secs(8), "{how}: {:?}", started.elapsed());
        let empty = how == "empty";
        let until = Instant::now() + Duration::from_secs(10);
        let damaged = || metric(service.http_port(), "utm_fusion_state_damaged_total");
        // Empty lines are valid, and an empty database is a new one; three additional octets may be repaired.
        let expected =
            names.iter().filter(|name| !is_whole(name)).count() as f64 - if empty { 3.0 } else { 0.0 };
        while damaged() < expected {
            assert!(Instant::now() < until, "{how}: {} of {expected}\n{}", damaged(), service.log());
            std::thread::sleep(Duration::from_millis(100));
        }
        let alerted = || {
            let alerts = ask(service.http_port(), "GET", "/api/v1/alerts").1.to_string();
            alerts.contains("damaged state files were set aside")
        };
        while !alerted() {
            assert!(Instant::now() < until, "{how}: no alert\n{}", service.log());
            std::thread::sleep(Duration::from_millis(100));
        }
        assert_eq!(metric(service.http_port(), "utm_fusion_history_failing"), 0.0, "{how}");
        let (code, log) = service.stop();
        assert_eq!(code, Some(0), "{how}: {log}");
        fs::remove_dir_all(scratch.path("state")).unwrap();
    }
}

/// Value of a metric without labels.
fn metric(port: u16, name: &str) -> f64 {
    let mut socket = std::net::TcpStream::connect(("127.0.0.1", port)).unwrap();
    let request = "GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    std::io::Write::write_all(&mut socket, request.as_bytes()).unwrap();
    let text = std::io::read_to_string(socket).unwrap();
    let value = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
    value.unwrap_or_else(|| panic!("no {name}: {text}")).trim().parse().unwrap()
}

#[test]
fn second_service_on_one_state_directory_is_refused() {
    let scratch = Scratch::new();
    let config = on_own_ports(&flight(SCENARIO, 1, None).config, 22_500, &scratch, None);
    let site = scratch.file("site.toml", config.to_string());
    let mut first = Running::start(utm_fusion("run").arg("--config").arg(&site), scratch.path("run.log"));
    first.says("running");
    let output = utm_fusion("run").arg("--config").arg(&site).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    let state = scratch.path("state").display().to_string();
    assert!(said.contains(&state) && said.contains(&format!("process {}", first.id())), "{said}");
    let check = utm_fusion("check").arg("--config").arg(&site).output().unwrap();
    assert_eq!(check.status.code(), Some(0), "{check:?}");
    // After a kill, the lock is released.
    first.signal("-KILL");
    first.wait(Duration::from_secs(5));
    let mut second = Running::start(utm_fusion("run").arg("--config").arg(&site), scratch.path("second.log"));
    second.says("running");
    let (code, log) = second.stop();
    assert_eq!(code, Some(0), "{log}");
}

#[test]
fn state_that_cannot_be_written_is_an_alert_until_it_can() {
    let stage = Stage::new(SCENARIO, 22_600, |config, _| {
        config.output.record = None;
        config.state.checkpoint_s = 1.0;
    });
    let service = stage.run("run.log");
    let port = service.http_port();
    let state = stage.config.state.dir.clone();
    fs::rename(&state, stage.scratch.path("away")).unwrap();
    fs::write(&state, "no directory").unwrap();
    stage.send(0.0, 6.0);
    let wait = |what: &str, done: &dyn Fn() -> bool| {
        let until = Instant::now() + Duration::from_secs(15);
        while !done() {
            assert!(Instant::now() < until, "{what}\n{}", service.log());
            std::thread::sleep(Duration::from_millis(100));
        }
    };
    let lasting = || {
        let alerts = ask(port, "GET", "/api/v1/alerts").1;
        let alerts = alerts["alerts"].as_array().unwrap().clone();
        alerts.iter().filter(|alert| alert["part"] == "state" && alert["until"].is_null()).count()
    };
    let failing = || ask(port, "GET", "/api/v1/status").1["state_failing"].to_string();
    wait("no file fails", &|| failing().contains("engine.warm"));
    wait("no alert", &|| lasting() == 1);
    assert!(metric(port, "utm_fusion_state_failing") >= 1.0);
    fs::remove_file(&state).unwrap();
    stage.send(8.0, 12.0);
    wait("it still fails", &|| metric(port, "utm_fusion_state_failing") == 0.0 && failing() == "[]");
    wait("the alert lasts", &|| lasting() == 0);
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    assert!(state.join("engine.warm").exists());
}

#[test]
fn addresses_are_recorded_without_a_configuration() {
    let scratch = Scratch::new();
    let dir = scratch.path("recorded");
    let mut record = utm_fusion("record");
    record.args(["--listen", "127.0.0.1:22441", "--listen", "127.0.0.1:22442"]).arg("--dir").arg(&dir);
    let mut service = Running::start(&mut record, scratch.path("record.log"));
    service.says("recording");
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    let datagrams: [(&[u8], u16); 2] = [(&[48, 0, 4, 0], 22_441), (b"any datagram at all", 22_442)];
    for (payload, port) in datagrams {
        socket.send_to(payload, ("127.0.0.1", port)).unwrap();
    }
    let files = || -> Vec<std::path::PathBuf> {
        let all = fs::read_dir(&dir).into_iter().flatten().flatten().map(|entry| entry.path());
        all.filter(|file| !file.ends_with(".recorder.lock")).collect()
    };
    let octets = || -> u64 { files().iter().filter_map(|file| Some(fs::metadata(file).ok()?.len())).sum() };
    let patience = Instant::now() + Duration::from_secs(60);
    while octets() < 24 + 2 * (16 + 14 + 28 + 4) {
        assert!(Instant::now() < patience, "nothing is recorded");
        std::thread::sleep(Duration::from_millis(50));
    }
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    // The recording is one file: there is no configuration that belongs to it.
    let files = files();
    let [file] = &files[..] else { panic!("{files:?}") };
    let output = utm_fusion("info").arg(file).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("127.0.0.1:22441") && text.contains("127.0.0.1:22442"), "{text}");

    for (args, why) in [
        (vec!["--listen", "here"], "is no address with a port"),
        (vec!["--listen", "127.0.0.1:8048@127.0.0.1"], "only a multicast group has an interface"),
        (vec!["--listen", "127.0.0.1:8048", "--config", "site.toml"], "cannot be used with"),
        (vec![], "required"),
    ] {
        let output = utm_fusion("record").args(&args).arg("--dir").arg(&dir).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && said.contains(why), "{args:?}: {said}");
    }
}
