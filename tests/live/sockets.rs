//! `run` with real sockets, fed by its own sender.

use std::fs;
use std::net::Ipv4Addr;
use std::sync::atomic::Ordering;
use std::time::Duration;

use fusion::time::Time;
use utm_fusion::config::{Address, PictureKind, Sink};

use crate::common::{
    Running, Scratch, datagrams, files, group, joined, only, read, replayed, replayed_now, utm_fusion,
};
use crate::stage::Stage;

const SCENARIO: &str =
    "name = \"live\"\nduration_s = 22\n[drones]\nmultirotors = 2\nequipped = 2\n[birds]\ncount = 3\n";

#[test]
fn sent_recorded_and_replayed_output_are_the_same() {
    let stage = Stage::new(SCENARIO, 21_000, |_, _| {});
    let (stop, listener) = stage.listen();
    // Two processes receive one group; the other one only records.
    let other = stage.scratch.path("other");
    let mut record = Running::start(
        utm_fusion("record").arg("--config").arg(&stage.site).arg("--dir").arg(&other),
        stage.scratch.path("record.log"),
    );
    record.says("listening receive_buffer");
    let service = stage.run("run.log");
    stage.send(0.0, 60.0);
    std::thread::sleep(Duration::from_secs(1));
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    let (code, log) = record.stop();
    assert_eq!(code, Some(0), "{log}");
    assert!(log.contains(" lost=0"), "{log}");
    stop.store(true, Ordering::Relaxed);
    let heard = listener.join().unwrap();

    let directory = stage.scratch.path("recordings");
    let input = only(&directory, "input-", ".pcap");
    let output = only(&directory, "output-", ".pcap");
    let sent: Vec<Vec<u8>> = datagrams(&output).into_iter().map(|(_, payload)| payload).collect();
    assert!(sent.len() > 20, "{} datagrams sent", sent.len());
    assert!(heard == sent, "{} heard, {} recorded", heard.len(), sent.len());
    assert!(fs::read(&output).unwrap() == replayed(&input));

    // All fed datagrams are in both recordings, with their sender, group and port.
    let fed: Vec<&Vec<u8>> = stage.simulation.datagrams.iter().map(|datagram| &datagram.payload).collect();
    for input in [input, only(&other, "input-", ".pcap")] {
        let (recorded, whole) = read(&input);
        assert!(whole && recorded.len() == fed.len(), "{} of {}", recorded.len(), fed.len());
        for datagram in &recorded {
            let endpoints = datagram.endpoints.as_ref().unwrap();
            let sensor = usize::from(datagram.payload[0] == 129);
            let (group, port) = stage.to(sensor);
            assert_eq!(endpoints.destination.to_string(), format!("{group}:{port}"));
            assert!(endpoints.source.ip().is_loopback() && endpoints.source.port() > 0);
        }
        let (mut recorded, mut fed): (Vec<_>, Vec<_>) =
            (recorded.iter().map(|datagram| &datagram.payload).collect(), fed.clone());
        recorded.sort();
        fed.sort();
        assert!(recorded == fed);
    }
    // The transponders' numbers are kept.
    let numbers = utm_fusion::state::read_numbers(&stage.scratch.path("state")).unwrap();
    assert_eq!(numbers.len(), 2);
}

/// A destination for the present picture receives that picture and the status, and not the lagged picture; the recording
/// has only the lagged one.
#[test]
fn present_picture_sent_equals_its_replay() {
    let stage = Stage::new(SCENARIO, 21_600, |config, _| {
        let lagged = config.output.asterix[0];
        let address = Address::Multicast { group: group(98), interface: Ipv4Addr::LOCALHOST };
        config.output.asterix.push(Sink {
            address,
            port: lagged.port + 1,
            picture: PictureKind::Now,
            ..lagged
        });
    });
    let sinks = &stage.config.output.asterix;
    let (stop, listener) = stage.listen();
    let of_now = stage.listen_to(group(98), sinks[1].port, &stop);
    let service = stage.run("run.log");
    stage.send(0.0, 16.0);
    std::thread::sleep(Duration::from_secs(1));
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    stop.store(true, Ordering::Relaxed);
    let (lagged, now) = (listener.join().unwrap(), of_now.join().unwrap());
    let directory = stage.scratch.path("recordings");
    let input = only(&directory, "input-", ".pcap");
    let output = only(&directory, "output-", ".pcap");
    assert!(fs::read(&output).unwrap() == replayed(&input));
    let payloads = |sent: Vec<(Time, Vec<u8>)>| sent.into_iter().map(|sent| sent.1).collect::<Vec<_>>();
    assert!(lagged == payloads(datagrams(&output)));
    assert!(now.len() > 20 && now != lagged, "{} datagrams of now", now.len());
    assert!(now == payloads(replayed_now(&input)));
}

/// A radar that appends a counter and a time to the blocks of each datagram: reported once, recorded unchanged, not a
/// fault.
#[test]
fn recording_with_trailers_replays_to_the_sent_output() {
    let mut stage = Stage::new(SCENARIO, 21_300, |_, _| {});
    let plots = stage.simulation.datagrams.iter_mut().filter(|datagram| datagram.payload[0] != 129);
    for (count, datagram) in plots.enumerate() {
        datagram.payload.extend((count as u64).to_be_bytes());
    }
    let service = stage.run("run.log");
    stage.send(0.0, 12.0);
    std::thread::sleep(Duration::from_secs(1));
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    let told = "a trailer of 8 octets follows the blocks of each datagram from 127.0.0.1 to ";
    assert_eq!(log.matches(told).count(), 1, "{log}");
    assert!(log.contains("trailer_octets=8"), "{log}");
    // Only the first datagrams, until the trailer was recognised; at most once a second.
    assert!(log.matches("LEN is below 3").count() <= 3, "{log}");

    let directory = stage.scratch.path("recordings");
    let input = only(&directory, "input-", ".pcap");
    let (recorded, whole) = read(&input);
    assert!(whole && recorded.len() > 20);
    for datagram in recorded {
        assert_eq!(datagram.trailer.len(), if datagram.payload[0] == 129 { 0 } else { 8 });
    }
    let output = only(&directory, "output-", ".pcap");
    assert!(datagrams(&output).len() > 10);
    assert!(fs::read(&output).unwrap() == replayed(&input));
}

/// A radar whose blocks are in ORADIS framing: read as without it, and recorded unchanged.
#[test]
fn oradis_framing_is_read_live_and_in_the_recording() {
    let mut stage = Stage::new(SCENARIO, 22_050, |_, _| {});
    let plots = stage.simulation.datagrams.iter_mut().filter(|datagram| datagram.payload[0] != 129);
    for datagram in plots {
        let length = (datagram.payload.len() as u16 + 6).to_be_bytes();
        let header = [&length[..], &36_000_000_u32.to_be_bytes()].concat();
        datagram.payload.splice(0..0, header);
    }
    let service = stage.run("run.log");
    stage.send(0.0, 12.0);
    std::thread::sleep(Duration::from_secs(1));
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    assert!(!log.contains("runs past"), "{log}");

    let directory = stage.scratch.path("recordings");
    let input = only(&directory, "input-", ".pcap");
    let (recorded, whole) = read(&input);
    assert!(whole && recorded.iter().any(|datagram| datagram.payload[0] == 48));
    let output = only(&directory, "output-", ".pcap");
    assert!(datagrams(&output).len() > 10);
    assert!(fs::read(&output).unwrap() == replayed(&input));
}

#[test]
fn killed_service_leaves_files_that_the_next_completes() {
    let stage = Stage::new(SCENARIO, 21_100, |_, _| {});
    let mut service = stage.run("run.log");
    stage.send(0.0, 14.0);
    std::thread::sleep(Duration::from_millis(2500));
    service.signal("-KILL");
    service.wait(Duration::from_secs(5));
    let directory = stage.scratch.path("recordings");
    let part = only(&directory, "input-", ".pcap.part");
    let start = stage.start();
    let fed = stage.simulation.datagrams.iter();
    let fed = fed.filter(|datagram| datagram.received.seconds_since(start) <= 14.0).count();
    let (recorded, whole) = read(&part);
    assert!(whole && recorded.len() == fed, "{} of {fed}, whole: {whole}", recorded.len());
    let sent = datagrams(&only(&directory, "output-", ".pcap.part"));
    let scratch = Scratch::new();
    let again = scratch.path("again.pcap");
    fs::write(&again, replayed(&part)).unwrap();
    let again = datagrams(&again);
    assert!(sent.len() > 10 && again.len() >= sent.len() && again[..sent.len()] == sent);

    let service = stage.run("again.log");
    assert!(files(&directory, "", ".part").is_empty());
    only(&directory, "input-", ".pcap");
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    assert!(log.contains("were cut short by the end of a process recordings=2"), "{log}");
}

#[test]
fn odd_datagrams_and_a_lost_disk_stop_no_slot() {
    let stage = Stage::new(SCENARIO, 21_200, |_, _| {});
    let (stop, listener) = stage.listen();
    let directory = stage.scratch.path("recordings");
    // A file in the place of the directory.
    fs::write(&directory, b"in the way").unwrap();
    let mut service = stage.run("run.log");
    service.says("cannot be recorded");
    let sender = stage.sender();
    let odd: Vec<Vec<u8>> = vec![vec![], vec![48], vec![48, 0], vec![0; 65_507]];
    for datagram in &odd {
        sender.send_to(datagram, stage.to(0)).unwrap();
    }
    stage.send(0.0, 9.0);
    // The service's own output comes back.
    let echoed = joined(group(99), stage.config.output.asterix[0].port, Ipv4Addr::LOCALHOST);
    for _ in 0..3 {
        let mut octets = [0; 65536];
        let length = echoed.recv(&mut octets).unwrap();
        sender.send_to(&octets[..length], stage.to(1)).unwrap();
    }
    fs::remove_file(&directory).unwrap();
    stage.send(9.0, 17.0);
    service.says("recording again");
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    assert_eq!(log.matches("cannot be recorded").count(), 1, "{log}");
    stop.store(true, Ordering::Relaxed);
    assert!(listener.join().unwrap().len() > 10, "no slots were sent:\n{log}");
}
