//! `--udp`: the datagrams of the files, on loopback multicast, in real time. A single test, because each sensor has one
//! group.

use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use socket2::{Domain, Protocol, Socket, Type};
use utm_fusion::capture::Capture;

use crate::common::{Scratch, between, ran, utm_fusion};

/// A socket that receives the group on this machine only.
fn joined(group: Ipv4Addr, port: u16) -> UdpSocket {
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP)).unwrap();
    socket.set_reuse_address(true).unwrap();
    // Bound to the group, so that nothing else on this port is received.
    socket.bind(&SocketAddrV4::new(group, port).into()).unwrap();
    socket.join_multicast_v4(&group, &Ipv4Addr::LOCALHOST).unwrap();
    socket.set_read_timeout(Some(Duration::from_millis(200))).unwrap();
    socket.into()
}

#[test]
fn datagrams_come_in_real_time_as_in_the_files() {
    let scratch = Scratch::new();
    let toml =
        "name = \"live\"\nduration_s = 20\n[drones]\nmultirotors = 2\nequipped = 2\n[birds]\ncount = 4\n";
    let scenario = scratch.file("live.toml", toml);
    let directory = scratch.path("out");

    let sensors = [(Ipv4Addr::new(239, 192, 48, 1), 8048), (Ipv4Addr::new(239, 192, 129, 1), 8129)];
    let (stop, stopped): (Vec<_>, Vec<_>) = sensors.iter().map(|_| mpsc::channel::<()>()).unzip();
    let listeners: Vec<_> = sensors
        .into_iter()
        .zip(stopped)
        .map(|((group, port), stopped)| {
            let socket = joined(group, port);
            thread::spawn(move || {
                let mut heard = Vec::new();
                let mut octets = [0; 65536];
                loop {
                    match socket.recv_from(&mut octets) {
                        Ok((length, from)) => heard.push((from, Instant::now(), octets[..length].to_vec())),
                        Err(_) if stopped.try_recv().is_ok() => return heard,
                        Err(_) => {}
                    }
                }
            })
        })
        .collect();

    let begun = Instant::now();
    let (code, _, said) =
        ran(utm_fusion("simulate").arg(&scenario).arg("--udp").arg("--out").arg(&directory));
    assert_eq!(code, 0, "{said}");
    let took_s = begun.elapsed().as_secs_f64();
    // 2 to 3 s until the beginning, 20 s of flight; the last detections arrive up to 1.5 s later.
    between("until it stops by itself, s", 21.0, took_s, 30.0);
    stop.iter().for_each(|stop| stop.send(()).unwrap());
    let heard: Vec<Vec<(SocketAddr, Instant, Vec<u8>)>> =
        listeners.into_iter().map(|listener| listener.join().unwrap()).collect();

    let captured: Vec<_> =
        Capture::open(&directory.join("capture.pcap")).unwrap().map(Result::unwrap).collect();
    for ((_, port), heard) in sensors.iter().zip(&heard) {
        let sent: Vec<_> = captured
            .iter()
            .filter(|datagram| datagram.endpoints.as_ref().unwrap().destination.port() == *port)
            .collect();
        assert!(sent.len() > 5, "port {port}");
        // Other senders to the group on this machine have another port.
        let mut senders: Vec<SocketAddr> = heard.iter().map(|(from, ..)| *from).collect();
        senders.sort_unstable();
        senders.dedup();
        let ours = senders.iter().find_map(|sender| {
            let of_sender = || heard.iter().filter(|(from, ..)| from == sender);
            let octets = of_sender().map(|(.., octets)| octets);
            let same = octets.eq(sent.iter().map(|datagram| &datagram.payload));
            same.then(|| of_sender().map(|(_, at, _)| *at).collect::<Vec<Instant>>())
        });
        let times = ours.unwrap_or_else(|| {
            panic!("port {port}: {} sent, {} heard of {senders:?}: other octets", sent.len(), heard.len())
        });
        let heard_s = (times[times.len() - 1] - times[0]).as_secs_f64();
        let sent_s = sent[sent.len() - 1].received.unwrap().seconds_since(sent[0].received.unwrap());
        between("from the first to the last, later than in the file, s", -1.0, heard_s - sent_s, 1.0);
    }
}
