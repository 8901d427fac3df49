//! Unexpected and malformed datagrams.

use std::collections::HashSet;
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::sync::atomic::Ordering;
use std::time::Duration;

use asterix::{DataSource, blocks, cat048, encode_block};
use utm_fusion::config::{Address, Input};
use utm_fusion::formats::{PcapWriter, UdpFlow};

use crate::common::{beside, group, joined, read, replayed};
use crate::http::{address, json, metric};
use crate::recorded::{is_exact, pairs};
use crate::stage::Stage;
use crate::{quick, scenario};

const FEEDER: Ipv4Addr = Ipv4Addr::new(127, 0, 0, 1);
const STRANGER: Ipv4Addr = Ipv4Addr::new(127, 0, 0, 9);

/// A port of this process; unlike its groups, an address is shared by processes.
fn unicast_port() -> u16 {
    23_710 + (std::process::id() % 80) as u16
}

/// A socket of another host on this machine.
fn stranger() -> UdpSocket {
    let socket = socket2::Socket::new(socket2::Domain::IPV4, socket2::Type::DGRAM, None).unwrap();
    socket.bind(&SocketAddrV4::new(STRANGER, 0).into()).unwrap();
    socket.set_multicast_if_v4(&Ipv4Addr::LOCALHOST).unwrap();
    socket.into()
}

#[test]
fn invalid_datagrams_are_counted_by_reason_without_effect() {
    let stage = Stage::new(&scenario(20), 23_700, |config, _| {
        quick(config);
        // The radar's lines accept datagrams from one host, the transponders' line from all. For a group, the kernel
        // filters them.
        let (address, port) = (Address::Unicast(FEEDER), unicast_port());
        let unicast = Input { address, port, source: Some(FEEDER), trailer_octets: None };
        config.sensors[0].inputs[0].source = Some(FEEDER);
        config.sensors[0].inputs.push(unicast);
    });
    let (stop, listener) = stage.listen();
    let mut service = stage.run("run.log");
    let address = address(&mut service);
    let (radar, transponders) = (stage.to(0), stage.to(1));
    let echoed = joined(group(99), stage.config.output.asterix[0].port, Ipv4Addr::LOCALHOST);
    let plots = stage.simulation.datagrams.iter().find(|datagram| datagram.payload[0] == 48).unwrap();
    // The radar's own plots, with the SAC/SIC of an unknown radar.
    let unknown = {
        let block = blocks(&plots.payload).next().unwrap().unwrap();
        let mut records: Vec<cat048::Record> = block.records().map(|record| record.unwrap().record).collect();
        records.iter_mut().for_each(|record| record.data_source = Some(DataSource { sac: 98, sic: 97 }));
        let mut octets = Vec::new();
        encode_block(&records, &mut octets).unwrap();
        (octets, records.len())
    };
    let cut = plots.payload[..plots.payload.len() - 2].to_vec();
    let mut echoes = 0;
    std::thread::scope(|scope| {
        scope.spawn(|| stage.send(0.0, 17.0));
        while metric(address, "utm_fusion_tracks", "") == 0.0 {
            std::thread::sleep(Duration::from_millis(100));
        }
        let (feeder, stranger) = (stage.sender(), stranger());
        // An empty datagram, one octet, two octets, a block shorter than its header, a cut one, and the largest datagram.
        for odd in [vec![], vec![48], vec![48, 0], vec![48, 0, 2], cut, vec![0; 65_507], unknown.0.clone()] {
            feeder.send_to(&odd, radar).unwrap();
        }
        // Another moment of the flight, which would be used.
        stranger.send_to(&stage.simulation.datagrams[82].payload, radar).unwrap();
        stranger.send_to(&stage.simulation.datagrams[83].payload, (FEEDER, unicast_port())).unwrap();
        // The service's own output comes back to it.
        while echoes < 3 {
            let mut octets = [0; 65536];
            if let Ok(length) = echoed.recv(&mut octets)
                && octets[0] == 129
            {
                feeder.send_to(&octets[..length], transponders).unwrap();
                echoes += blocks(&octets[..length]).count();
            }
        }
    });
    std::thread::sleep(Duration::from_millis(1500));

    let status = json(address, "/api/v1/status");
    let mut faults: Vec<(String, u64)> = status["tally"]["faults"]
        .as_array()
        .unwrap()
        .iter()
        .map(|fault| (fault["reason"].as_str().unwrap().to_owned(), fault["count"].as_u64().unwrap()))
        .collect();
    faults.sort();
    let of = |reason: &str| faults.iter().filter(|(of, _)| of == reason).map(|(_, count)| count).sum::<u64>();
    assert_eq!((of("block_past_end"), of("block_too_short")), (3, 2), "{faults:?}");
    assert_eq!(faults.iter().map(|(_, count)| count).sum::<u64>(), 5, "{faults:?}");
    assert_eq!(metric(address, "utm_fusion_line_foreign_total", ""), 1.0);
    let sensors = json(address, "/api/v1/sensors");
    let mut heard: Vec<(bool, u64)> = sensors["unknown"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| (one["own"].as_bool().unwrap_or(false), one["records"].as_u64().unwrap()))
        .collect();
    heard.sort_unstable();
    assert_eq!(heard, [(false, unknown.1 as u64), (true, echoes as u64)], "{sensors}");

    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
    stop.store(true, Ordering::Relaxed);
    let heard = listener.join().unwrap();
    let pairs = pairs(&stage.scratch.path("recordings"));
    assert_eq!(is_exact(&stage.config, &pairs[0], true), heard.len());
    assert!(heard.len() > 20);

    // Without the odd datagrams, the same data is sent.
    let flight: HashSet<&Vec<u8>> =
        stage.simulation.datagrams.iter().map(|datagram| &datagram.payload).collect();
    let (input, output) = &pairs[0];
    let (all, _) = read(input);
    let alone = stage.scratch.path(input.file_name().unwrap());
    let mut pcap = PcapWriter::new(std::fs::File::create(&alone).unwrap()).unwrap();
    let flow = UdpFlow { from: FEEDER, to: radar.0, port: radar.1, ttl: 1 };
    let mut odd = 0;
    for datagram in all {
        if flight.contains(&datagram.payload) {
            pcap.write(flow, datagram.received.unwrap(), &datagram.payload).unwrap();
        } else {
            odd += 1;
        }
    }
    pcap.flush().unwrap();
    assert!(odd > 7, "{odd} odd datagrams were recorded");
    for extension in ["site.toml", "numbers.json"] {
        std::fs::copy(beside(input, extension), beside(&alone, extension)).unwrap();
    }
    assert!(std::fs::read(output).unwrap() == replayed(&alone));
}
