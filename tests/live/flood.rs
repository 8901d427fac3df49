//! Thousands of invented identities beside real drones, through real sockets.

use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use utm_fusion::areas::Masks;
use utm_fusion::capture::Reception;
use utm_fusion::config::{Config, SensorKind};
use utm_fusion::evaluate::{OutputPoint, output};
use utm_fusion::live::now;

use crate::common::{Running, beside, datagrams, only, replayed};
use crate::invented::{PREFIX, admit, invented, is_invented, received};
use crate::stage::Stage;

const SCENARIO: &str =
    "name = \"flood\"\nduration_s = 24\n[drones]\nmultirotors = 3\nequipped = 3\n[birds]\ncount = 3\n";
/// Number of invented identities, each sent once, and their rate per second.
const INVENTED: u64 = 4_000;
const A_SECOND: u32 = 1_000;

/// `/metrics` of the service, at the address in its log.
fn metrics(service: &Running) -> String {
    let log = service.log();
    let address = log.split("http://").nth(1).unwrap().split('/').next().unwrap();
    let mut socket = TcpStream::connect(address).unwrap();
    socket.write_all(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    socket.read_to_string(&mut answer).unwrap();
    answer
}

/// Value of a sample.
fn sample(metrics: &str, name: &str) -> Option<u64> {
    metrics.lines().find_map(|line| line.strip_prefix(name)?.trim().parse().ok())
}

/// Points that a site publishes for these receptions.
fn points(config: &Config, received: impl Iterator<Item = Reception>) -> Vec<OutputPoint> {
    output(received.map(Ok), config, Masks::default()).unwrap()
}

#[test]
fn invented_identities_affect_no_drone_and_are_reported() {
    let stage = Stage::new(SCENARIO, 21_700, |config, _| admit(config, 20));
    let (stop, listener) = stage.listen();
    let mut service = stage.run("run.log");
    let transponder = stage.config.sensors.iter().position(|s| matches!(s.kind, SensorKind::Transponder(_)));
    let to = stage.to(transponder.unwrap());
    let sender = stage.sender();
    let like = stage.simulation.datagrams.iter().find(|datagram| datagram.payload[0] == 129).unwrap();
    std::thread::scope(|scope| {
        scope.spawn(|| stage.send(0.0, 60.0));
        let from = stage.start();
        if let Ok(early) = Duration::try_from(from - now()) {
            std::thread::sleep(early + Duration::from_secs(6));
        }
        for number in 0..INVENTED {
            sender.send_to(&invented(&like.payload, number, now()), to).unwrap();
            std::thread::sleep(Duration::from_secs(1) / A_SECOND / 2);
        }
        service.says("degraded: a flood of new identities, up to ");
        // All invented identities and the drones; on a slow machine this takes a while.
        let heard = "utm_fusion_new_identities_total{sensor=\"drone-it\",fate=\"heard\"} ";
        let admitted = "utm_fusion_new_identities_total{sensor=\"drone-it\",fate=\"admitted\"} ";
        let until = Instant::now() + Duration::from_secs(60);
        let told = loop {
            let told = metrics(&service);
            if sample(&told, heard) == Some(INVENTED + 3) && sample(&told, admitted) >= Some(3) {
                break told;
            }
            assert!(Instant::now() < until, "{told}");
            std::thread::sleep(Duration::from_millis(200));
        };
        assert_eq!(sample(&told, admitted), Some(3), "{told}");
        assert_eq!(sample(&told, "utm_fusion_transponder_numbers_used "), Some(3));
        assert_eq!(sample(&told, "utm_fusion_transponder_numbers_free "), Some(429_493));
    });
    std::thread::sleep(Duration::from_secs(1));
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    stop.store(true, Ordering::Relaxed);
    let heard = listener.join().unwrap();
    assert!(!heard.is_empty());
    let is_told_of = |payload: &Vec<u8>| payload.windows(PREFIX.len()).any(|octets| octets == PREFIX);
    assert!(!heard.iter().any(is_told_of), "an invented aircraft was published");

    // The data sent equals the replay of the recording, and its replay without the invented identities.
    let directory = stage.scratch.path("recordings");
    let input = only(&directory, "input-", ".pcap");
    assert!(fs::read(only(&directory, "output-", ".pcap")).unwrap() == replayed(&input));
    let config = Config::load(beside(&input, "site.toml")).unwrap();
    let receptions: Vec<Reception> =
        datagrams(&input).into_iter().map(|(at, payload)| received(at, payload)).collect();
    assert_eq!(
        receptions.iter().filter(|reception| is_invented(&reception.payload)).count() as u64,
        INVENTED
    );
    let real = || receptions.iter().filter(|reception| !is_invented(&reception.payload)).cloned();
    let without = points(&config, real());
    assert!(without.len() > 50, "{} points", without.len());
    assert!(points(&config, receptions.iter().cloned()) == without);
}
