//! HTTP clients that are slow, malicious, or two thousand.

use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, TcpStream};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use socket2::{Domain, Socket, Type};

use crate::http::{Stream, address, get, json, metric, until};
use crate::inside::is_inside;
use crate::stage::Stage;
use crate::{quick, scenario};

/// Raises the limit of open files, so that it does not limit the connections.
const OPEN_FILES: [&str; 4] = ["sh", "-c", "ulimit -S -n 5000 && exec \"$@\"", "sh"];
const HALF_OPEN: usize = 2_000;

/// A connection from this client address.
fn connect(from: u8, to: SocketAddr) -> TcpStream {
    let socket = Socket::new(Domain::IPV4, Type::STREAM, None).unwrap();
    socket.bind(&SocketAddrV4::new(Ipv4Addr::new(127, 0, 1, from), 0).into()).unwrap();
    socket.connect(&to.into()).unwrap();
    let stream: TcpStream = socket.into();
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    stream.set_write_timeout(Some(Duration::from_secs(5))).unwrap();
    stream
}

/// Sends as much as is accepted; returns the first line of the answer, or an empty text, once the connection is closed.
fn answer_to(address: SocketAddr, from: u8, octets: &[u8]) -> String {
    let mut socket = connect(from, address);
    // The answer may arrive, and the connection end, before all is sent.
    let _ = socket.write_all(octets);
    let mut answer = Vec::new();
    let mut some = [0; 4096];
    loop {
        match socket.read(&mut some) {
            Ok(0) => break,
            Ok(count) => answer.extend_from_slice(&some[..count]),
            Err(error) => {
                assert_ne!(error.kind(), ErrorKind::WouldBlock, "neither answered nor closed");
                break;
            }
        }
    }
    String::from_utf8_lossy(&answer).lines().next().unwrap_or("").to_owned()
}

/// Number of open files of the service's process, and its resident memory in KiB.
fn taken(process: u32) -> (usize, u64) {
    let of = Path::new("/proc").join(process.to_string());
    let status = std::fs::read_to_string(of.join("status")).unwrap();
    let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    let resident = resident.split_whitespace().next().unwrap().parse().unwrap();
    (std::fs::read_dir(of.join("fd")).unwrap().count(), resident)
}

#[test]
fn two_thousand_bad_clients_delay_nothing_and_are_closed() {
    let test = "clients::two_thousand_bad_clients_delay_nothing_and_are_closed";
    if !is_inside(&OPEN_FILES, test) {
        return;
    }
    let stage = Stage::new(&scenario(30), 23_800, |config, _| quick(config));
    let mut service = stage.run("run.log");
    let address = address(&mut service);
    let stream = Stream::open(address);
    let before = taken(service.id());
    std::thread::scope(|scope| {
        scope.spawn(|| stage.send(0.0, 20.0));
        let good = scope.spawn(|| {
            let (mut slowest, mut count) = (Duration::ZERO, 0);
            let began = Instant::now();
            while began.elapsed() < Duration::from_secs(18) {
                let start = Instant::now();
                assert_eq!(get(address, "/api/v1/tracks").0, 200);
                slowest = slowest.max(start.elapsed());
                count += 1;
                std::thread::sleep(Duration::from_millis(50));
            }
            (count, slowest)
        });
        let drop_by_drop = scope.spawn(|| {
            let mut socket = connect(200, address);
            let start = Instant::now();
            for octet in b"GET /api/v1/tracks HTTP/1.1\r\nHost: localhost\r\n\r\n" {
                if socket.write_all(&[*octet]).is_err() {
                    return start.elapsed();
                }
                std::thread::sleep(Duration::from_secs(1));
            }
            panic!("an octet a second is waited for");
        });
        // A client that sends a million requests, and never reads the answers.
        let mut deaf = connect(201, address);
        deaf.set_write_timeout(Some(Duration::from_millis(500))).unwrap();
        let asked = b"GET /openapi.json HTTP/1.1\r\nHost: localhost\r\n\r\n".repeat(1_000_000);
        assert!(deaf.write_all(&asked).is_err(), "it is not heard for ever");

        let half_open: Vec<TcpStream> = (0..HALF_OPEN)
            .map(|index| {
                let mut socket = connect((index % 100) as u8, address);
                if index % 2 == 0 {
                    socket.write_all(b"GET /api/v1/tracks HTTP/1.1\r\nHos").unwrap();
                }
                socket
            })
            .collect();
        let opened = Instant::now();
        until("all are let in", Duration::from_secs(5), || taken(service.id()).0 > HALF_OPEN);

        let head =
            |name: &str, octets: usize| format!("GET / HTTP/1.1\r\n{name}: {}\r\n\r\n", "x".repeat(octets));
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(50_000));
        let body =
            |kind: &str| format!("POST /api/v1/stream-tickets HTTP/1.1\r\nHost: localhost\r\n{kind}\r\n\r\n");
        let chunks =
            body("Transfer-Encoding: chunked") + &format!("10000\r\n{}\r\n", "x".repeat(65_536)).repeat(100);
        for (octets, statuses) in [
            (head("Cookie", 4 << 20).into_bytes(), &["431", "400"][..]),
            (many.into_bytes(), &["431", "400"]),
            (format!("GET /{} HTTP/1.1\r\n\r\n", "x".repeat(1 << 20)).into_bytes(), &["414", "431", "400"]),
            ((body("Content-Length: 99999999999") + &"x".repeat(1 << 20)).into_bytes(), &["413"]),
            ((body("Content-Length: -1") + "x").into_bytes(), &["400"]),
            (chunks.into_bytes(), &["200", "413"]),
            (vec![0; 4096], &["400"]),
            (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03".repeat(20), &["400"]),
            (b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n".to_vec(), &["400"]),
        ] {
            let answer = answer_to(address, 202, &octets);
            let status = answer.split(' ').nth(1).unwrap_or("closed");
            let text = String::from_utf8_lossy(&octets[..octets.len().min(40)]).into_owned();
            println!("{text:?}: {status}");
            assert!(status == "closed" || statuses.contains(&status), "{text:?}: {answer:?}");
        }
        // A good request followed by garbage: the first is answered, the second ends the connection.
        let garbage = [b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n".to_vec(), vec![7; 8192]].concat();
        assert!(answer_to(address, 203, &garbage).contains("200"));

        let closed =
            half_open.into_iter().all(|mut socket| matches!(socket.read(&mut [0; 256]), Ok(_) | Err(_)));
        assert!(closed && opened.elapsed() < Duration::from_secs(20), "half-open connections stay");
        assert!(drop_by_drop.join().unwrap() < Duration::from_secs(20));
        drop(deaf);
        let (count, slowest) = good.join().unwrap();
        println!("{count} good requests, the slowest in {slowest:?}");
        assert!(count > 50 && slowest < Duration::from_secs(2), "{count}, {slowest:?}");
    });
    // Except for the files of the recording and of the engine's state. HTTP threads yield to all other work of the machine.
    until("all files are given back", Duration::from_secs(60), || taken(service.id()).0 <= before.0 + 5);
    // The allocator keeps some of it for the HTTP threads: at most 50 KiB for each client.
    until("the memory is given back", Duration::from_secs(60), || {
        assert_eq!(get(address, "/healthz").0, 200);
        taken(service.id()).1 < before.1 + 50 * HALF_OPEN as u64
    });
    let after = taken(service.id());
    println!("files {} to {}, memory {} to {} KiB", before.0, after.0, before.1, after.1);
    assert!(stream.is_unbroken(Duration::from_secs(2)) > 60);
    assert!(metric(address, "utm_fusion_lateness_seconds", "0.99") < 0.5);
    assert_eq!(metric(address, "utm_fusion_http_responses_total", "status=\"5"), 0.0);
    assert_eq!(json(address, "/api/v1/status")["streams"], 1);
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    // After the flight, the silence of its sensors raises an alert, which is unrelated to the clients.
    let is_theirs = |line: &str| line.contains("ERROR") && !line.contains("outage");
    assert!(!log.contains("panicked") && !log.lines().any(is_theirs), "{log}");
}

#[test]
fn low_file_limit_reduces_connections_not_the_recorder() {
    let stage = Stage::new(&scenario(20), 23_900, |config, _| quick(config));
    let mut limited = Command::new("sh");
    limited.args([
        "-c",
        "ulimit -n 300 && exec \"$@\"",
        "sh",
        env!("CARGO_BIN_EXE_utm-fusion"),
        "run",
        "--config",
    ]);
    let mut service = crate::common::Running::start(limited.arg(&stage.site), stage.scratch.path("run.log"));
    let address = address(&mut service);
    service.says("300 files may be open: at most 44 HTTP connections instead of 4000");
    let idle: Vec<TcpStream> = (0..60).map(|index| connect(index, address)).collect();
    // The files of the recording are opened with the first datagram.
    stage.send(0.0, 4.0);
    let recorded = crate::common::files(&stage.scratch.path("recordings"), "input-", ".pcap.part");
    assert_eq!(recorded.len(), 1);
    drop(idle);
    until("an answer", Duration::from_secs(5), || {
        std::panic::catch_unwind(|| get(address, "/healthz").0).is_ok_and(|status| status == 200)
    });
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    assert!(!log.contains("could not be accepted"), "{log}");
}

#[test]
fn connection_flood_from_one_host_blocks_no_other_host() {
    let stage = Stage::new(&scenario(20), 24_600, |config, _| quick(config));
    let mut service = stage.run("run.log");
    let address = address(&mut service);
    let before = taken(service.id());
    let crowd: Vec<TcpStream> = (0..600)
        .map(|_| {
            let mut socket = connect(5, address);
            // The connection may be closed already.
            let _ = socket.write_all(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
            socket
        })
        .collect();
    for probe in 0..29 {
        assert_eq!(get(address, "/healthz").0, 200, "{probe}");
    }
    let during = taken(service.id());
    assert!(during.0 <= before.0 + 64 + 8, "files {} to {}", before.0, during.0);
    // Connections idle for 10 s are closed, which allows a few more.
    assert!(metric(address, "utm_fusion_http_connections_refused_total", "address") >= 300.0);
    service.says("127.0.1.5 has as many HTTP connections as one address may have");
    drop(crowd);
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
}
