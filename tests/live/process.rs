//! The process: what systemd is told, numbers across restarts, the commands around the service.

use std::fs;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::{Duration, Instant};

use utm_fusion::config::{Address, Config};
use utm_fusion::live::now;

use crate::common::{Running, Scratch, files, flight, on_own_ports, utm_fusion};

const SCENARIO: &str = "name = \"still\"\nduration_s = 20\n[drones]\nmultirotors = 1\nequipped = 1\n";

fn told(socket: &UnixDatagram) -> String {
    let mut octets = [0; 256];
    let length = socket.recv(&mut octets).unwrap();
    String::from_utf8(octets[..length].to_vec()).unwrap()
}

#[test]
fn systemd_is_told_that_it_is_ready_alive_and_stopping() {
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
        socket.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        let mut run = utm_fusion("run");
        run.arg("--config").arg(&site).args(["--log-format", "json"]).env("NOTIFY_SOCKET", variable);
        let mut service = Running::start(&mut run, scratch.path("run.log"));
        assert_eq!(told(&socket), "READY=1");
        assert_eq!(told(&socket), "WATCHDOG=1");
        let first = Instant::now();
        assert_eq!(told(&socket), "WATCHDOG=1");
        assert!(first.elapsed() < Duration::from_secs(3));
        // The service goes on. Of two signals that wait, it may see the second first.
        service.signal("-HUP");
        service.says("site.toml: read anew");
        let (code, log) = service.stop();
        assert_eq!(code, Some(0), "{log}");
        while told(&socket) != "STOPPING=1" {}
        for line in log.lines() {
            let line: serde_json::Value = serde_json::from_str(line).expect(line);
            assert!(line["timestamp"].is_string() && line["level"].is_string(), "{line}");
        }
    }
}

#[test]
fn a_broken_file_of_numbers_is_set_aside() {
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
    assert!(log.contains("begun anew contents=\"transponder numbers\""), "{log}");
    assert_eq!(files(&scratch.path("state"), "numbers.json.broken-2", "Z").len(), 1);
    assert!(!scratch.path("state/numbers.json").exists());
}

#[test]
fn check_tells_of_each_line_whether_it_opens() {
    let scratch = Scratch::new();
    let config = on_own_ports(&flight(SCENARIO, 1, None).config, 22_200, &scratch, None);
    let check = |text: &str| {
        let site = scratch.file("site.toml", text);
        let output = utm_fusion("check").arg("--config").arg(site).arg("--network").output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    };
    let (code, said) = check(&config.to_string());
    assert_eq!((code, said.lines().count(), said.matches(": ok").count()), (Some(0), 3, 3), "{said}");
    // 192.0.2.1 is of no machine.
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
fn what_can_never_work_is_told_at_once() {
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

#[test]
fn a_packager_gets_completions_and_a_page() {
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
