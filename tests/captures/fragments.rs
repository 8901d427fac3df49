//! Datagrams received in IP fragments.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use utm_fusion::capture::{CapturedDatagram, SkipReason};

use crate::writer::{PcapWriter, PcapngWriter, UDP, ipv4, ipv6, udp};
use crate::{BLOCKS, endpoints, open, payloads, read};

/// A block too long for one Ethernet frame.
fn block(octets: u16, filled: u8) -> Vec<u8> {
    let length = octets.to_be_bytes();
    [&[48, length[0], length[1]][..], &vec![filled; usize::from(octets) - 3]].concat()
}

/// The packets of a datagram with this number, each with `size` octets of it.
fn fragments(version: u8, number: u16, payload: &[u8], size: usize) -> Vec<Vec<u8>> {
    let datagram = udp(payload);
    let parts = datagram.chunks(size).collect::<Vec<_>>();
    let packet = |(index, part): (usize, &&[u8])| {
        let (offset, has_more) = ((index * size / 8) as u16, index + 1 < parts.len());
        if version == 4 {
            let mut packet = ipv4(UDP, offset | u16::from(has_more) << 13, part);
            packet[4..6].copy_from_slice(&number.to_be_bytes());
            packet
        } else {
            let field = (offset << 3 | u16::from(has_more)).to_be_bytes();
            let number = number.to_be_bytes();
            let header = [UDP, 0, field[0], field[1], 0, 0, number[0], number[1]];
            ipv6(44, &[&header, *part].concat())
        }
    };
    parts.iter().enumerate().map(packet).collect()
}

/// A capture of raw IP packets, each with its time in seconds.
fn capture(packets: &[(u32, Vec<u8>)]) -> Vec<u8> {
    let mut file = PcapWriter::new(false, false, 101);
    packets.iter().for_each(|(second, packet)| file.record(*second, 0, packet));
    file.octets
}

/// The datagrams read, and the number of fragments left over.
fn of(packets: &[(u32, Vec<u8>)]) -> (Vec<CapturedDatagram>, u64) {
    let octets = capture(packets);
    let mut capture = open(&octets).expect("a capture");
    let (datagrams, error) = read(&octets, &mut capture);
    assert!(error.is_none());
    assert_eq!(capture.skipped().total(), capture.skipped().count(SkipReason::Fragment));
    (datagrams, capture.skipped().total())
}

#[test]
fn fragments_in_any_order_of_several_datagrams_are_joined() {
    let (long, longer) = (block(3_000, 1), block(60_000, 2));
    for (version, seed) in [4, 6].into_iter().zip([1, 2]) {
        let mut packets = fragments(version, 7, &long, 1_480);
        packets.extend(fragments(version, 8, &longer, 1_480));
        packets.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
        let packets: Vec<_> = (10..).zip(packets).collect();
        let (mut datagrams, left) = of(&packets);
        datagrams.sort_by_key(|datagram| datagram.payload.len());
        assert_eq!((payloads(&datagrams), left), (vec![&long[..], &longer[..]], 0));
        assert_eq!(datagrams[0].fragments, 3);
        for datagram in &datagrams {
            assert_eq!(datagram.endpoints, endpoints(version));
            // The origin is the beginning of the payload, even if that arrived last.
            let octets = capture(&packets);
            assert!(octets[datagram.origin as usize..].starts_with(&datagram.payload[..1_472]));
        }
    }
}

#[test]
fn datagram_is_received_with_its_last_fragment() {
    let long = block(2_000, 1);
    let mut packets: Vec<_> = (10..).zip(fragments(4, 7, &long, 1_480)).collect();
    packets.insert(1, (10, ipv4(UDP, 0, &udp(BLOCKS[0]))));
    let (datagrams, left) = of(&packets);
    assert_eq!((payloads(&datagrams), left), (vec![BLOCKS[0], &long[..]], 0));
    assert_eq!(datagrams[1].received.unwrap().nanos(), 11_000_000_000);
    assert_eq!(datagrams.iter().map(|datagram| datagram.fragments).collect::<Vec<_>>(), [0, 2]);
}

#[test]
fn of_a_datagram_that_is_not_whole_all_fragments_are_counted() {
    let long = block(3_000, 1);
    let whole = fragments(4, 7, &long, 1_480);
    for missing in 0..3 {
        let mut packets: Vec<_> = whole.iter().map(|packet| (10, packet.clone())).collect();
        packets.remove(missing);
        assert_eq!(of(&packets), (Vec::new(), 2), "{missing}");
    }
    // The number is used again for another datagram an hour later.
    let mut packets = vec![(10, whole[0].clone())];
    packets.extend(fragments(4, 7, &block(2_000, 9), 1_480).into_iter().map(|packet| (3_610, packet)));
    let (datagrams, left) = of(&packets);
    assert_eq!((payloads(&datagrams), left), (vec![&block(2_000, 9)[..]], 1));
    // A fragment that contradicts the others: two ends.
    let packets = [whole[2].clone(), fragments(4, 7, &block(2_000, 9), 1_480)[1].clone()];
    assert_eq!(of(&packets.map(|packet| (10, packet))), (Vec::new(), 2));
}

#[test]
fn memory_is_for_64_datagrams() {
    let long = block(2_000, 1);
    let of_number = |number| fragments(4, number, &long, 1_480);
    let mut packets: Vec<_> = (0..65).map(|number| (10, of_number(number)[0].clone())).collect();
    packets.extend((0..65).rev().map(|number| (11, of_number(number)[1].clone())));
    let (datagrams, left) = of(&packets);
    // The first datagram was given up to make space for the last.
    assert_eq!((datagrams.len(), left), (64, 2));
    let again: Vec<_> = (0..65).flat_map(of_number).map(|packet| (10, packet)).collect();
    assert_eq!(of(&again).0.len(), 65);
}

#[test]
fn in_pcapng_too() {
    let long = block(3_000, 1);
    let mut file = PcapngWriter::new(false);
    file.interface(101, 0, &[]);
    fragments(6, 7, &long, 1_480).iter().for_each(|packet| file.packet(0, 0, packet));
    let mut capture = open(&file.octets).unwrap();
    let (datagrams, _) = read(&file.octets, &mut capture);
    assert_eq!((payloads(&datagrams), capture.skipped().total()), (vec![&long[..]], 0));
}
