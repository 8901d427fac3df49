//! Two senders with one SAC/SIC: the first is accepted, the other is rejected and named. Lines with the same data, whose
//! hosts `source` names, complete each other.

use std::fs;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, TcpStream, UdpSocket};
use std::path::Path;
use std::time::{Duration, Instant};

use asterix::{blocks, cat034, cat048, encode_block};
use fusion::time::Time;
use serde_json::Value;
use socket2::{Domain, Socket, Type};
use utm_fusion::formats::{PcapWriter, UdpFlow};
use utm_fusion::live::now;
use utm_fusion::simulate::Simulation;

use crate::common::{Running, Scratch, beside, flight, joined, only, read, replayed, utm_fusion};
use crate::stage::Stage;

/// Every drone has a transponder without long silences. Those of another flight have the same serial numbers, and are never
/// accepted.
const SCENARIO: &str = "name = \"live\"\nduration_s = 24\n[drones]\nmultirotors = 2\nequipped = 2\n[birds]\ncount = 3\n\
                        [transponder]\nperiod_s = [1.5, 2.0]\ndropped = 0.0\ngap_every_s = 0.0\n\
                        starts_after_s = [0.0, 1.0]\nends_before_s = [0.0, 0.0]\n";

/// Start of the second sender, in seconds of the flight.
const SECOND_S: f64 = 5.0;
/// End of the second sender, in seconds of the flight.
const SECOND_ENDS_S: f64 = 16.0;

pub(crate) fn json(address: SocketAddr, path: &str) -> Value {
    let mut socket = TcpStream::connect(address).unwrap();
    socket.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    write!(socket, "GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    socket.read_to_string(&mut answer).unwrap();
    serde_json::from_str(answer.split_once("\r\n\r\n").unwrap().1).unwrap()
}

fn address(running: &mut Running) -> SocketAddr {
    running.says("url=http://");
    running.log().split("url=http://").nth(1).unwrap().split('/').next().unwrap().parse().unwrap()
}

/// Sends another flight to the inputs of the stage, like a stray simulator; returns its address.
fn stray(stage: &Stage, other: &Simulation) -> SocketAddr {
    let sender = stage.sender();
    let start = other.datagrams[0].received;
    for datagram in &other.datagrams {
        let at_s = datagram.received.seconds_since(start);
        if !(SECOND_S..SECOND_ENDS_S).contains(&at_s) {
            continue;
        }
        if let Ok(early) = Duration::try_from(datagram.received - now()) {
            std::thread::sleep(early);
        }
        sender.send_to(&datagram.payload, stage.to(usize::from(datagram.payload[0] == 129))).unwrap();
    }
    sender.local_addr().unwrap()
}

/// The recording of one sender alone, with the files beside it.
fn of_one(input: &Path, port: u16, scratch: &Scratch) -> std::path::PathBuf {
    let alone = scratch.path(input.file_name().unwrap().to_str().unwrap());
    for extension in ["site.toml", "numbers.json", "registration.json"] {
        fs::copy(beside(input, extension), beside(&alone, extension)).unwrap();
    }
    let mut pcap = PcapWriter::new(fs::File::create(&alone).unwrap()).unwrap();
    for datagram in read(input).0 {
        let endpoints = datagram.endpoints.unwrap();
        if endpoints.source.port() == port {
            let (SocketAddr::V4(from), SocketAddr::V4(to)) = (endpoints.source, endpoints.destination) else {
                panic!("{endpoints:?}")
            };
            let flow = UdpFlow { from: *from.ip(), to: *to.ip(), port: to.port(), ttl: 1 };
            pcap.write_from(port, flow, datagram.received.unwrap(), &datagram.payload).unwrap();
        }
    }
    alone
}

#[test]
fn first_of_two_senders_is_accepted_and_both_are_named() {
    let stage = Stage::new(SCENARIO, 22_700, |_, _| {});
    let other = flight(SCENARIO, 2, Some(stage.start()));
    let mut service = stage.run("run.log");
    let api = address(&mut service);
    let alerts = |holds: &dyn Fn(&Value) -> bool| -> Vec<String> {
        let all = json(api, "/api/v1/alerts");
        let of_sensors = all["alerts"].as_array().unwrap().iter().filter(|alert| alert["kind"] == "sensor");
        let wanted = of_sensors.filter(|alert| holds(alert));
        wanted.map(|alert| alert["text"].as_str().unwrap_or_default().to_owned()).collect()
    };
    let lasting = || alerts(&|alert| alert["until"].is_null());
    let named = |text: &String| text.contains("was heard first and counts");
    let (stray, told) = std::thread::scope(|scope| {
        scope.spawn(|| stage.send(0.0, 24.0));
        let stray = scope.spawn(|| stray(&stage, &other));
        // At most 5 s after its start, or later if this machine is busy.
        let began = stage.start() + jiff::SignedDuration::from_millis((SECOND_S * 1e3) as i64);
        let mut told: Option<(Time, Vec<String>)> = None;
        let until = Instant::now() + Duration::from_secs(40);
        while told.is_none() && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(100));
            let texts: Vec<String> = lasting().into_iter().filter(named).collect();
            if texts.len() == 2 {
                told = Some((now(), texts));
            }
        }
        let (at, texts) = told.expect("nobody is told");
        let after_s = at.seconds_since(began);
        assert!(after_s < 10.0, "{after_s} s");
        println!("told after {after_s:.1} s");
        (stray.join().unwrap(), texts)
    });
    // Both are named, for the radar and for the transponders.
    let first = told[0].split_whitespace().find(|word| word.starts_with("127.0.0.1:")).unwrap();
    let first: SocketAddr = first.parse().unwrap();
    assert!(
        told.iter().all(|text| text.contains(&format!("127.0.0.1:{} is refused", stray.port()))),
        "{told:?}"
    );
    // The second sender has ended, and so does the alert.
    let until = Instant::now() + Duration::from_secs(20);
    while lasting().iter().any(named) {
        assert!(Instant::now() < until, "{:?}", lasting());
        std::thread::sleep(Duration::from_millis(200));
    }
    let sensors = json(api, "/api/v1/sensors");
    for sensor in sensors["features"].as_array().unwrap() {
        assert!(sensor["properties"]["refused"]["other_sender"].as_u64().unwrap() > 3, "{sensor}");
    }
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    assert!(
        (1..=3).contains(&log.matches("say different things under one SAC/SIC").count()),
        "told once a sensor:\n{log}"
    );

    // The data sent equals the replay of the recording, and that of the first sender alone.
    let dir = stage.scratch.path("recordings");
    let (input, sent) = (only(&dir, "input-", ".pcap"), fs::read(only(&dir, "output-", ".pcap")).unwrap());
    let recorded = read(&input).0;
    let of = |port| recorded.iter().filter(|one| one.endpoints.unwrap().source.port() == port).count();
    assert!(of(stray.port()) > 20 && of(first.port()) > 20, "{} and {}", of(stray.port()), of(first.port()));
    assert!(sent == replayed(&input), "the replay of both");
    let scratch = Scratch::new();
    assert!(sent == replayed(&of_one(&input, first.port(), &scratch)), "the first sender alone");
}

/// A host that joins the radar's group, repeats one of its datagrams every 4 s like a redundant line, and forges plots
/// under its SAC/SIC four times a second; both go to `to`. Returns the number of forged datagrams.
fn forge(stage: &Stage, to: (Ipv4Addr, u16), until: Time) -> u64 {
    let (group, port) = stage.to(0);
    let listener = joined(group, port, Ipv4Addr::LOCALHOST);
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, None).unwrap();
    socket.bind(&SocketAddrV4::new(FORGER, 0).into()).unwrap();
    socket.set_multicast_if_v4(&Ipv4Addr::LOCALHOST).unwrap();
    let sender: UdpSocket = socket.into();
    let (mut copied, mut forged, mut count) = (Time::default(), Time::default(), 0);
    let mut octets = [0; 65536];
    while now() < until {
        let Ok((length, from)) = listener.recv_from(&mut octets) else { continue };
        if from.ip() == FORGER || octets[0] != 48 {
            continue;
        }
        if now().seconds_since(copied) > 4.0 {
            copied = now();
            sender.send_to(&octets[..length], to).unwrap();
        }
        if now().seconds_since(forged) > 0.25 {
            forged = now();
            let block = blocks(&octets[..length]).next().unwrap().unwrap();
            let mut records: Vec<cat048::Record> =
                block.records().map(|record| record.unwrap().record).collect();
            for record in &mut records {
                let polar = record.polar_position.unwrap();
                record.polar_position = polar.with_azimuth_deg((polar.azimuth_deg() + 180.0) % 360.0);
            }
            let mut payload = Vec::new();
            encode_block(&records, &mut payload).unwrap();
            sender.send_to(&payload, to).unwrap();
            count += 1;
        }
    }
    count
}

/// Address of the host of [`forge`].
const FORGER: Ipv4Addr = Ipv4Addr::new(127, 0, 0, 66);

#[test]
fn forger_behind_copies_is_refused_on_every_line_and_named() {
    // Without a source, the radar's group accepts datagrams from any host; with one, the forger uses the transponders'
    // group.
    for (pinned, reason) in [(false, "other_sender"), (true, "foreign_source")] {
        let stage = Stage::new(SCENARIO, if pinned { 22_760 } else { 22_740 }, |config, _| {
            config.sensors[0].inputs[0].source = pinned.then_some(Ipv4Addr::LOCALHOST);
        });
        let mut service = stage.run("run.log");
        let api = address(&mut service);
        let until = stage.start() + jiff::SignedDuration::from_secs(14);
        let to = stage.to(usize::from(pinned));
        let count = std::thread::scope(|scope| {
            scope.spawn(|| stage.send(0.0, 14.5));
            let forger = scope.spawn(|| forge(&stage, to, until));
            forger.join().unwrap()
        });
        std::thread::sleep(Duration::from_millis(1_200));
        let sensors = json(api, "/api/v1/sensors");
        let radar = sensors["features"]
            .as_array()
            .unwrap()
            .iter()
            .find(|one| one["id"] == stage.config.sensors[0].id);
        let radar = &radar.unwrap()["properties"];
        // Status and counters may be a second old.
        assert!(count > 20 && radar["refused"][reason].as_u64() >= Some(count / 2), "{count}: {radar}");
        let contested = radar["contested"].as_array().unwrap();
        assert!(contested.iter().any(|one| one["reason"] == reason), "{radar}");
        let refused = contested[0]["refused"].as_str().unwrap();
        assert!(refused.starts_with("127.0.0.66:"), "{radar}");
        let alerts = json(api, "/api/v1/alerts");
        let names_it = |alert: &&Value| {
            alert["kind"] == "sensor" && alert["text"].as_str().is_some_and(|text| text.contains(refused))
        };
        assert!(alerts["alerts"].as_array().unwrap().iter().any(|alert| names_it(&alert)), "{alerts}");
        // No ghosts: all accepted plots and service messages are from the radar itself.
        let sent = |datagram: &&utm_fusion::simulate::SimulatedDatagram| {
            datagram.payload[0] != 129 && datagram.received.seconds_since(stage.start()) <= 14.5
        };
        let own: usize = stage
            .simulation
            .datagrams
            .iter()
            .filter(sent)
            .flat_map(|datagram| blocks(&datagram.payload).flatten())
            .map(|block| match block.category {
                48 => block.records::<cat048::Record>().count(),
                _ => block.records::<cat034::Record>().count(),
            })
            .sum();
        assert!(radar["accepted"].as_u64() <= Some(own as u64), "{own}: {radar}");
        let (code, log) = service.stop();
        assert_eq!(code, Some(0), "{log}");
        assert!(log.contains(refused), "{log}");
    }
}

/// Hosts of two lines.
const HOSTS: [Ipv4Addr; 2] = [Ipv4Addr::new(10, 0, 0, 1), Ipv4Addr::new(10, 0, 0, 2)];

/// A capture of two lines, each with a loss of a tenth: from two hosts that the inputs name as `source`, or from one.
fn lines(simulation: &Simulation, scratch: &Scratch, two: bool) -> (String, Vec<u8>) {
    let capture = scratch.path(if two { "two.pcap" } else { "one.pcap" });
    let mut config = simulation.config.clone();
    for sensor in &mut config.sensors {
        sensor.inputs.iter_mut().zip(HOSTS).for_each(|(input, host)| input.source = Some(host));
    }
    let is_first = |port| config.sensors.iter().any(|sensor| sensor.inputs[0].port == port);
    let mut pcap = PcapWriter::new(fs::File::create(&capture).unwrap()).unwrap();
    for datagram in &simulation.datagrams {
        let from = HOSTS[usize::from(two && !is_first(datagram.flow.port))];
        let flow = UdpFlow { from, ..datagram.flow };
        pcap.write_from(40_000, flow, datagram.received, &datagram.payload).unwrap();
    }
    pcap.flush().unwrap();
    let (site, out) = (scratch.file("site.toml", config.to_string()), scratch.path("out.pcap"));
    let mut replay = utm_fusion("replay");
    let output = replay.arg(&capture).arg("--config").arg(site).arg("-o").arg(&out).output().unwrap();
    (String::from_utf8(output.stdout).unwrap(), fs::read(out).unwrap())
}

#[test]
fn redundant_lines_with_losses_complete_each_other() {
    let scenario = "name = \"lines\"\nduration_s = 60\n[drones]\nmultirotors = 3\nequipped = 2\n[birds]\ncount = 3\n\
                    [network]\nsecond_line = true\nlost = 0.1\nreordered = 0.05\n";
    let scratch = Scratch::new();
    let simulation = flight(scenario, 3, None);
    let (said_of_one, one) = lines(&simulation, &scratch, false);
    let (said, two) = lines(&simulation, &scratch, true);
    assert!(
        said.contains("repeated datagrams (redundant lines)") && !said.contains("other_sender"),
        "{said}"
    );
    assert_eq!(said, said_of_one);
    assert!(one == two && !one.is_empty(), "{said}");
}
