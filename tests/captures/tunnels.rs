//! Datagrams inside tags, labels and tunnels, as from mirror ports and other link types.

use proptest::prelude::*;
use utm_fusion::capture::{Capture, OpenError, SkipReason};

use crate::writer::{PcapWriter, UDP, ethernet, ipv4, ipv6, udp};
use crate::{BLOCKS, endpoints, open, payloads, read};

const IPV4: [u8; 2] = [0x08, 0x00];
const IPV6: [u8; 2] = [0x86, 0xDD];
const GRE: u8 = 47;

fn packet() -> Vec<u8> {
    ipv4(UDP, 0, &udp(BLOCKS[0]))
}

/// An Ethernet frame with the datagram.
fn frame() -> Vec<u8> {
    [ethernet(&[], IPV4), packet()].concat()
}

/// A datagram to this port.
fn to_port(port: u16, payload: &[u8]) -> Vec<u8> {
    let mut datagram = udp(payload);
    datagram[2..4].copy_from_slice(&port.to_be_bytes());
    ipv4(UDP, 0, &datagram)
}

/// An Ethernet frame with this ether type.
fn of_type(ether_type: u16, contents: &[&[u8]]) -> Vec<u8> {
    [ethernet(&[], ether_type.to_be_bytes()), contents.concat()].concat()
}

fn on_ethernet(packet: impl AsRef<[u8]>) -> Vec<u8> {
    of_type(0x0800, &[packet.as_ref()])
}

/// PPP over Ethernet, from its own header on.
fn pppoe(protocol: &[u8], packet: &[u8]) -> Vec<u8> {
    let length = ((protocol.len() + packet.len()) as u16).to_be_bytes();
    [&[0x11, 0, 0, 1][..], &length, protocol, packet].concat()
}

fn gre(header: &[u8], contents: impl AsRef<[u8]>) -> Vec<u8> {
    on_ethernet(ipv4(GRE, 0, &[header, contents.as_ref()].concat()))
}

/// A header of `length` octets, of which only the first and the last two have a meaning.
fn erspan(length: usize, first: u8, last: [u8; 2]) -> Vec<u8> {
    let mut header = vec![0; length];
    header[0] = first;
    if length > 8 {
        header[10..12].copy_from_slice(&last);
    }
    header
}

fn capture(link: u32, frames: &[Vec<u8>]) -> Vec<u8> {
    let mut file = PcapWriter::new(false, false, link);
    (0..).zip(frames).for_each(|(second, frame)| file.record(1_700_000_000 + second, 0, frame));
    file.octets
}

#[test]
fn encapsulated_datagram_is_read() {
    let with_sequence = [&[0x10, 0, 0x88, 0xbe, 0, 0, 0, 1][..], &erspan(8, 0x10, [0; 2])].concat();
    let erspan_3 = |last: [u8; 2], length: usize| {
        [&[0x10, 0, 0x22, 0xeb, 0, 0, 0, 1][..], &erspan(length, 0x20, last)].concat()
    };
    let llc = |length: u16, header: &[u8]| of_type(length, &[header, &packet()]);
    let tag = |ether_type: u16, between: usize| {
        let between = vec![0; between];
        of_type(ether_type, &[&between, &IPV4, &packet()])
    };
    let in_udp =
        |port: u16, header: &[u8], inner: Vec<u8>| on_ethernet(to_port(port, &[header, &inner].concat()));
    let label = [0, 1, 0x01, 64];
    for (name, link, octets) in [
        ("LLC and SNAP", 1, llc(48, &[0xaa, 0xaa, 3, 0, 0, 0, 8, 0])),
        ("LLC of IP", 1, llc(43, &[6, 6, 3])),
        ("LLC within a VLAN", 1, tag_of(&[0, 7, 0, 48, 0xaa, 0xaa, 3, 0, 0, 0, 8, 0])),
        ("three VLANs", 1, of_type(0x88a8, &[&[0, 7, 0x81, 0, 0, 8, 0x91, 0, 0, 9], &IPV4, &packet()])),
        ("Cisco metadata", 1, tag(0x8909, 6)),
        ("VN tag", 1, tag(0x8926, 4)),
        ("E tag", 1, tag(0x893f, 6)),
        ("HSR", 1, tag(0x892f, 4)),
        ("frame replication", 1, tag(0xf1c1, 4)),
        ("provider backbone", 1, of_type(0x88e7, &[&[0; 4], &frame()])),
        ("FabricPath", 1, of_type(0x8903, &[&[0; 2], &frame()])),
        ("PPPoE", 1, of_type(0x8864, &[&pppoe(&[0, 0x21], &packet())])),
        ("PPPoE, short protocol", 1, of_type(0x8864, &[&pppoe(&[0x21], &packet())])),
        (
            "PPPoE in two VLANs",
            1,
            of_type(0x88a8, &[&[0, 7, 0x81, 0, 0, 8, 0x88, 0x64], &pppoe(&[0, 0x21], &packet())]),
        ),
        ("MPLS", 1, of_type(0x8847, &[&label, &packet()])),
        ("MPLS, two labels", 1, of_type(0x8848, &[&[0, 1, 0, 64], &label, &packet()])),
        ("Ethernet over MPLS", 1, of_type(0x8847, &[&label, &frame()])),
        ("the same with a control word", 1, of_type(0x8847, &[&label, &[0; 4], &frame()])),
        ("GRE", 1, gre(&[0, 0, 8, 0], packet())),
        ("GRE with all fields", 1, gre(&[[0xb0, 0, 8, 0], [0; 4], [1; 4], [2; 4]].concat(), packet())),
        ("GRE, bridged", 1, gre(&[0, 0, 0x65, 0x58], frame())),
        (
            "GRE of PPTP",
            1,
            gre(&[&[0x30, 0x81, 0x88, 0x0b][..], &[0; 12], &[0xff, 3, 0, 0x21]].concat(), packet()),
        ),
        ("GRE with MPLS", 1, gre(&[&[0, 0, 0x88, 0x47][..], &label].concat(), packet())),
        ("ERSPAN I", 1, gre(&[0, 0, 0x88, 0xbe], frame())),
        ("ERSPAN II", 1, gre(&with_sequence, frame())),
        ("ERSPAN III", 1, gre(&erspan_3([0, 0], 12), frame())),
        ("ERSPAN III with a subheader", 1, gre(&erspan_3([0, 1], 20), frame())),
        ("ERSPAN III of IP", 1, gre(&erspan_3([2 << 2, 0], 12), packet())),
        ("IP in IP", 1, on_ethernet(ipv4(4, 0, &packet()))),
        ("IP in IPv6", 1, of_type(0x86dd, &[&ipv6(4, &packet())])),
        ("Ethernet in IP", 1, on_ethernet(ipv4(97, 0, &[&[0x30, 0][..], &frame()].concat()))),
        ("MPLS in IP", 1, on_ethernet(ipv4(137, 0, &[&label, &packet()[..]].concat()))),
        ("VXLAN", 1, in_udp(4789, &[8, 0, 0, 0, 0, 0, 7, 0], frame())),
        ("VXLAN with a policy", 1, in_udp(8472, &[0x88, 0, 0, 5, 0, 0, 7, 0], frame())),
        ("VXLAN-GPE", 1, in_udp(4790, &[0x0c, 0, 0, 1, 0, 0, 7, 0], packet())),
        ("GENEVE", 1, in_udp(6081, &[0, 0, 0x65, 0x58, 0, 0, 7, 0], frame())),
        (
            "GENEVE with options",
            1,
            in_udp(6081, &[&[2, 0, 8, 0, 0, 0, 7, 0][..], &[9; 8]].concat(), packet()),
        ),
        ("MPLS in UDP", 1, in_udp(6635, &label, packet())),
        ("GRE in UDP", 1, in_udp(4754, &[0, 0, 8, 0], packet())),
        ("TZSP", 1, in_udp(37008, &[1, 0, 0, 1, 0, 10, 1, 0xc4, 1], frame())),
        ("GTP", 1, in_udp(2152, &[0x30, 0xff, 0, 0, 0, 0, 0, 1], packet())),
        (
            "GTP with extensions",
            1,
            in_udp(2152, &[0x34, 0xff, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0x85, 1, 0, 0, 0], packet()),
        ),
        ("VXLAN in ERSPAN in a VLAN", 1, {
            let outer = ipv4(
                GRE,
                0,
                &[&with_sequence[..], &in_udp(4789, &[8, 0, 0, 0, 0, 0, 7, 0], frame())].concat(),
            );
            tag_of(&[&[0, 7][..], &IPV4, &outer].concat())
        }),
        ("PPP", 9, [&[0xff, 3, 0, 0x21][..], &packet()].concat()),
        ("PPP without framing", 9, [&[0, 0x21][..], &packet()].concat()),
        ("PPP in HDLC", 50, [&[0xff, 3, 0, 0x21][..], &packet()].concat()),
        ("PPPoE alone", 51, pppoe(&[0, 0x21], &packet())),
        ("Cisco HDLC", 104, [&[0x0f, 0, 8, 0][..], &packet()].concat()),
        (
            "Linux cooked with LLC",
            113,
            [&[0; 14][..], &[0, 4, 0xaa, 0xaa, 3, 0, 0, 0, 8, 0], &packet()].concat(),
        ),
        ("Linux cooked with a VLAN", 113, [&[0; 14][..], &[0x81, 0, 0, 7, 8, 0], &packet()].concat()),
        ("NFLOG", 239, nflog(u16::to_le_bytes)),
        ("NFLOG of the other order", 239, nflog(u16::to_be_bytes)),
        ("PPI", 192, [&[0, 0, 8, 0, 1, 0, 0, 0][..], &frame()].concat()),
    ] {
        let octets = capture(link, &[octets]);
        let mut capture = open(&octets).unwrap();
        let (datagrams, error) = read(&octets, &mut capture);
        assert!(error.is_none(), "{name}");
        assert_eq!(payloads(&datagrams), [BLOCKS[0]], "{name}: {}", capture.skipped());
        assert_eq!(datagrams[0].endpoints, endpoints(4), "{name}");
    }
    let six = of_type(0x8847, &[&label, &ipv6(UDP, &udp(BLOCKS[1]))]);
    let in_four = on_ethernet(ipv4(41, 0, &ipv6(UDP, &udp(BLOCKS[1]))));
    let ppp = of_type(0x8864, &[&pppoe(&[0, 0x57], &ipv6(UDP, &udp(BLOCKS[1])))]);
    let geneve =
        on_ethernet(to_port(6081, &[&[0, 0][..], &IPV6, &[0; 4], &ipv6(UDP, &udp(BLOCKS[1]))].concat()));
    let octets = capture(1, &[six, in_four, ppp, geneve]);
    let (datagrams, _) = read(&octets, &mut open(&octets).unwrap());
    assert_eq!(payloads(&datagrams), [BLOCKS[1]; 4]);
    assert!(datagrams.iter().all(|datagram| datagram.endpoints == endpoints(6)));
}

/// A VLAN tag, and the octets between its ether type and the packet.
fn tag_of(contents: &[u8]) -> Vec<u8> {
    let is_whole = contents.len() > 20;
    let packet = if is_whole { Vec::new() } else { packet() };
    of_type(0x8100, &[contents, &packet])
}

/// A packet of the firewall's log, after a prefix of three octets.
fn nflog(number: fn(u16) -> [u8; 2]) -> Vec<u8> {
    let value = |kind: u16, contents: &[u8]| {
        let padding = vec![0; contents.len().wrapping_neg() % 4];
        [&number(4 + contents.len() as u16)[..], &number(kind), contents, &padding].concat()
    };
    [&[2, 0, 0, 1][..], &value(10, b"up\0"), &value(9, &packet())].concat()
}

#[test]
fn datagram_to_the_port_of_a_tunnel_stays_one() {
    for port in [4789, 8472, 4790, 6081, 6635, 4754, 37008, 2152] {
        for payload in [BLOCKS[0], b"{\"transmitter\":\"a\"}", &[0xff; 30]] {
            let octets = capture(101, &[to_port(port, payload)]);
            let mut capture = open(&octets).unwrap();
            let (datagrams, _) = read(&octets, &mut capture);
            // MPLS and GRE can be recognised by their port only.
            if ![6635, 4754].contains(&port) || payload == BLOCKS[0] {
                assert_eq!(payloads(&datagrams), [payload], "{port}");
            }
        }
    }
}

#[test]
fn nesting_is_read_to_a_limit() {
    let nested = |depth: usize| (0..depth).fold(packet(), |inner, _| ipv4(4, 0, &inner));
    let octets = capture(101, &[nested(16), nested(17), nested(3_000)]);
    let mut capture_of_all = open(&octets).unwrap();
    let (datagrams, _) = read(&octets, &mut capture_of_all);
    assert_eq!(payloads(&datagrams), [BLOCKS[0]]);
    assert_eq!(capture_of_all.skipped().count(SkipReason::TooDeep), 2);
    assert_eq!(capture_of_all.skipped().to_string(), "2 nested too deeply");
    // Tags and bridged frames count as encapsulation, too.
    let tagged = of_type(0x8100, &[&[0, 7, 0x81, 0].repeat(100), &IPV4, &packet()]);
    let octets = capture(1, &[tagged]);
    let mut of_tags = open(&octets).unwrap();
    assert!(read(&octets, &mut of_tags).0.is_empty());
    assert_eq!(of_tags.skipped().count(SkipReason::TooDeep), 1);
}

#[test]
fn fragmented_tunnel_is_put_together() {
    let block = [&[48, 7, 208][..], &[1; 1_997]].concat();
    let outer = |inner: &[u8], number: u16| {
        let tunnel = [&[0, 0, 0x65, 0x58][..], &ethernet(&[], IPV4), inner].concat();
        let (first, last) = tunnel.split_at(1_200);
        [(first, 0x2000), (last, 150)].map(|(part, field)| {
            let mut packet = ipv4(GRE, field, part);
            packet[4..6].copy_from_slice(&number.to_be_bytes());
            packet
        })
    };
    let octets = capture(101, &outer(&ipv4(UDP, 0, &udp(&block)), 7));
    let mut of_one = open(&octets).unwrap();
    let (datagrams, _) = read(&octets, &mut of_one);
    assert_eq!((payloads(&datagrams), datagrams[0].fragments), (vec![&block[..]], 2));
    assert_eq!(of_one.skipped().total(), 0);
    // Fragments inside fragments: frames of two datagrams.
    let datagram = udp(&[&[48, 11, 184][..], &[2; 2_997]].concat());
    let (first, last) = datagram.split_at(1_600);
    let frames = [outer(&ipv4(UDP, 0x2000, first), 8), outer(&ipv4(UDP, 200, last), 9)].concat();
    let octets = capture(101, &frames);
    let mut of_four = open(&octets).unwrap();
    let (datagrams, _) = read(&octets, &mut of_four);
    assert_eq!((datagrams[0].payload.len(), datagrams[0].fragments), (3_000, 4));
    assert_eq!(of_four.skipped().total(), 0);
    // A reassembled packet without a datagram is counted by its kind.
    let octets = capture(101, &outer(&ipv4(6, 0, &[0; 1_500]), 7));
    let mut of_tcp = open(&octets).unwrap();
    assert!(read(&octets, &mut of_tcp).0.is_empty());
    assert_eq!(of_tcp.skipped().to_string(), "2 not UDP");
}

#[test]
fn ppi_names_the_link_type_behind_it() {
    // A field common to Wi-Fi radios, whose flags state that a checksum follows the frame.
    let field = [&[2, 0, 20, 0][..], &[0; 8], &[1, 0], &[0; 10]].concat();
    let header = [&[0, 0, 32, 0, 105, 0, 0, 0][..], &field].concat();
    let element = [&[221, 30, 0xfa, 0x0b, 0xbc, 0x0d, 7][..], &[0x32], &[0; 24]].concat();
    let beacon = [&[0x80, 0, 0, 0][..], &[0xff; 6], &[1; 12], &[0; 14], &element].concat();
    let octets = capture(192, &[[header, beacon, vec![0xde; 4]].concat()]);
    let capture_of_all = open(&octets).unwrap();
    let lines: Vec<String> =
        capture_of_all.map(|line| String::from_utf8(line.unwrap().payload).unwrap()).collect();
    assert_eq!(lines.len(), 1);
    assert!(lines[0].ends_with(&format!("\"message\":\"32{}\"}}", "00".repeat(24))), "{lines:?}");
    let other = capture(192, &[[0, 0, 8, 0, 99, 0, 0, 0].to_vec()]);
    let mut of_other = open(&other).unwrap();
    assert!(of_other.next().is_none());
    assert_eq!(of_other.skipped().count(SkipReason::LinkType), 1);
}

#[test]
fn link_type_that_is_not_read_has_fitting_advice() {
    for (number, advice) in [
        (249, "capture on the network or Bluetooth interface itself"),
        (119, "radiotap"),
        (252, "Wireshark"),
        (10, "Ethernet or loopback interface"),
    ] {
        let error = open(&capture(number, &[])).unwrap_err();
        assert!(matches!(error, OpenError::LinkType { .. }) && error.to_string().contains(advice), "{error}");
    }
    let log: &[u8] = b"btsnoop\0\0\0\0\x01\0\0\x03\xea";
    let error = Capture::from_reader("log".to_owned(), Box::new(log), None).unwrap_err();
    assert!(error.to_string().contains("editcap"), "{error}");
}

proptest! {
    /// No content of a frame stops the reader.
    #[test]
    fn any_frame_is_read_or_counted(
        link in prop::sample::select(vec![1_u32, 9, 51, 101, 105, 113, 127, 187, 192, 201, 239, 251, 254, 256, 272]),
        start in prop::sample::select(vec![
            vec![], frame(), of_type(0x8864, &[]), of_type(0x8847, &[]), gre(&[0x10, 0, 0x88, 0xbe], vec![]),
            on_ethernet(to_port(6081, &[2, 0, 8, 0])), on_ethernet(to_port(2152, &[0x34, 0xff])),
        ]),
        octets in prop::collection::vec(any::<u8>(), 0..120),
    ) {
        let octets = capture(link, &[[start, octets].concat()]);
        let mut all = open(&octets).unwrap();
        let read = all.by_ref().count() as u64;
        prop_assert_eq!(read + all.skipped().total(), 1);
    }
}
