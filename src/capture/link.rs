//! From a captured frame down to the payload of its UDP datagram, or to the line of Remote ID that it carries.

use std::fmt;
use std::net::{IpAddr, SocketAddr};

use etherparse::err::packet::SliceError;
use etherparse::{EtherType, IpNumber, LaxNetSlice, LaxSlicedPacket, UdpHeader, UdpSlice, ether_type};

use ::remote_id::{Link, NotHeard};

use super::fragments::{Fragments, Place, Whole};
use super::skipped::SkipReason;
use super::{Contents, Datagram};
use crate::gateways::remote_id;
use fusion::time::Time;

/// Sender and receiver of a datagram: IP addresses and UDP ports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Endpoints {
    /// The sender.
    pub source: SocketAddr,
    /// The receiver: for multicast the group and its port.
    pub destination: SocketAddr,
}

/// The link header of every frame of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkType {
    /// Ethernet II, with or without VLAN tags.
    Ethernet,
    /// Linux `-i any`, version 1.
    LinuxCooked,
    /// Linux `-i any`, version 2.
    LinuxCooked2,
    /// No link header: an IPv4 or IPv6 packet.
    RawIp,
    /// BSD and macOS loopback: an address family in 4 octets.
    Loopback,
    /// Wi-Fi, off the air.
    Ieee80211,
    /// The same behind a radiotap header.
    Radiotap,
    /// Bluetooth Low Energy off the air, behind the header of the nRF sniffer.
    NordicBle,
}

impl LinkType {
    /// The link type with this number in a capture file (<https://www.tcpdump.org/linktypes.html>).
    pub(super) fn from_number(number: u16) -> Option<Self> {
        match number {
            0 | 108 => Some(Self::Loopback),
            1 => Some(Self::Ethernet),
            // 12 and 14 are what BSD systems wrote for 101; 228 and 229 are restricted to one version of IP.
            12 | 14 | 101 | 228 | 229 => Some(Self::RawIp),
            105 => Some(Self::Ieee80211),
            113 => Some(Self::LinuxCooked),
            127 => Some(Self::Radiotap),
            272 => Some(Self::NordicBle),
            276 => Some(Self::LinuxCooked2),
            _ => None,
        }
    }

    /// What frames off the air begin with.
    fn radio(self) -> Option<Link> {
        match self {
            Self::Ieee80211 => Some(Link::Ieee80211),
            Self::Radiotap => Some(Link::Radiotap),
            Self::NordicBle => Some(Link::NordicBle),
            _ => None,
        }
    }

    /// What `frame` carries, and at which offset; `None` if the frame is shorter than the link header.
    fn ether_type(self, frame: &[u8]) -> Option<(EtherType, usize)> {
        let (place, header) = match self {
            Self::Ethernet => (12, 14),
            Self::LinuxCooked => (14, 16),
            Self::LinuxCooked2 => (0, 20),
            // `IPV4` stands for both: the version is taken from the packet itself.
            Self::RawIp => return Some((ether_type::IPV4, 0)),
            Self::Loopback => {
                let family = frame.first_chunk::<4>()?;
                let ether_type = if is_ip_family(*family) { ether_type::IPV4 } else { EtherType(0) };
                return Some((ether_type, 4));
            }
            Self::Ieee80211 | Self::Radiotap | Self::NordicBle => return None,
        };
        let number = frame.get(..header)?.get(place..)?.first_chunk::<2>()?;
        Some((EtherType(u16::from_be_bytes(*number)), header))
    }
}

impl fmt::Display for LinkType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ethernet => "Ethernet",
            Self::LinuxCooked => "Linux cooked",
            Self::LinuxCooked2 => "Linux cooked v2",
            Self::RawIp => "raw IP",
            Self::Ieee80211 => "Wi-Fi",
            Self::Radiotap => "Wi-Fi with radiotap",
            Self::NordicBle => "Bluetooth",
            Self::Loopback => "loopback",
        })
    }
}

/// What a frame that stands at `position` of the file carries; of a fragment the datagram, where it is the last one of it.
pub(super) fn datagram(
    link: LinkType,
    frame: &[u8],
    received: Option<Time>,
    position: u64,
    fragments: &mut Fragments,
) -> Result<Datagram, SkipReason> {
    if let Some(radio) = link.radio() {
        let payload = remote_id::heard(radio, frame, received).map_err(|reason| match reason {
            NotHeard::Other => SkipReason::NotRemoteId,
            NotHeard::Damaged => SkipReason::Checksum,
            NotHeard::Cut => SkipReason::Truncated,
        })?;
        let contents = Contents::Translated;
        return Ok(Datagram { received, origin: position, payload, contents, ..Datagram::default() });
    }
    let packet = udp_packet(link, frame)?;
    let start = position + (packet.udp.as_ptr().addr() - frame.as_ptr().addr()) as u64;
    let lacks = if packet.is_cut { SkipReason::Truncated } else { SkipReason::Malformed };
    let put_together = match packet.place {
        Some(_) if packet.is_cut => return Err(lacks),
        Some(place) => Some(fragments.take(place, packet.udp, received, start).ok_or(SkipReason::Fragment)?),
        None => None,
    };
    let (octets, origin, fragments) = match &put_together {
        Some(Whole { octets, origin, fragments }) => (octets.as_slice(), *origin, *fragments),
        None => (packet.udp, start, 0),
    };
    let udp = UdpSlice::from_slice(octets).map_err(|_| lacks)?;
    let (source, destination) = packet.addresses;
    let endpoints = Endpoints {
        source: SocketAddr::new(source, udp.source_port()),
        destination: SocketAddr::new(destination, udp.destination_port()),
    };
    let (origin, payload) = (origin + UdpHeader::LEN as u64, udp.payload().to_vec());
    Ok(Datagram { received, endpoints: Some(endpoints), origin, payload, fragments, ..Datagram::default() })
}

/// Whether an address family is IPv4 or IPv6. The number is in the byte order of the machine that captured (108: in
/// network order), and every system has its own for IPv6: 24, 28, 30 (BSDs and macOS), 10 (Linux), 23 (Windows).
fn is_ip_family(family: [u8; 4]) -> bool {
    let number = match family {
        [number, 0, 0, 0] | [0, 0, 0, number] => number,
        _ => return false,
    };
    matches!(number, 2 | 10 | 23 | 24 | 28 | 30)
}

/// A packet of IP that carries UDP, or a fragment of that.
struct UdpPacket<'a> {
    addresses: (IpAddr, IpAddr),
    /// Where it belongs, if it is a fragment.
    place: Option<Place>,
    /// Header and payload, or a part of them.
    udp: &'a [u8],
    /// Whether the capture holds less of it than there was.
    is_cut: bool,
}

/// The packet in `frame`, without padding. A frame cut by the capture is fine as long as the datagram is whole.
fn udp_packet(link: LinkType, frame: &[u8]) -> Result<UdpPacket<'_>, SkipReason> {
    let (ether_type, start) = link.ether_type(frame).ok_or(SkipReason::Truncated)?;
    let packet = LaxSlicedPacket::from_ether_type(ether_type, &frame[start..]);
    let error = packet.stop_err.as_ref().map(|(error, _)| match error {
        SliceError::Len(_) => SkipReason::Truncated,
        _ => SkipReason::Malformed,
    });
    let Some(ip) = packet.ip_payload() else {
        // An address resolution packet that is cut is still none of ours.
        let arp = packet.net.is_some() || ether_type == ether_type::ARP;
        return Err(error.filter(|_| !arp).unwrap_or(SkipReason::NotIp));
    };
    // The slicing stopped at an extension header; behind it there may have been a datagram. That a TCP or ICMP header
    // is broken is not of interest.
    if let Some(reason) = error
        && ip.ip_number.is_ipv6_ext_header_value()
    {
        return Err(reason);
    }
    if ip.ip_number != IpNumber::UDP {
        return Err(SkipReason::NotUdp);
    }
    let net = packet.net.as_ref().ok_or(SkipReason::NotIp)?;
    let addresses = addresses(net).ok_or(SkipReason::NotIp)?;
    let place = if ip.fragmented { Place::of(net, addresses) } else { None };
    Ok(UdpPacket { addresses, place, udp: ip.payload, is_cut: ip.incomplete })
}

/// Source and destination of an IP header.
fn addresses(net: &LaxNetSlice<'_>) -> Option<(IpAddr, IpAddr)> {
    match net {
        LaxNetSlice::Ipv4(ip) => {
            let header = ip.header();
            Some((header.source_addr().into(), header.destination_addr().into()))
        }
        LaxNetSlice::Ipv6(ip) => {
            let header = ip.header();
            Some((header.source_addr().into(), header.destination_addr().into()))
        }
        LaxNetSlice::Arp(_) => None,
    }
}

/// Usual name of an unsupported link type.
pub(super) fn usual_name(number: u16) -> &'static str {
    match number {
        6 => "Token Ring",
        8 => "SLIP",
        9 | 50 => "PPP",
        10 => "FDDI",
        51 => "PPPoE",
        104 => "Cisco HDLC",
        107 => "Frame Relay",
        117 => "OpenBSD pflog",
        119 => "IEEE 802.11 with Prism header",
        147..=162 => "private use",
        163 => "IEEE 802.11 with AVS header",
        187 | 201 => "Bluetooth HCI",
        189 | 220 => "Linux USB",
        192 => "PPI",
        195 | 215 | 230 => "IEEE 802.15.4",
        227 => "SocketCAN",
        239 => "Linux NFLOG",
        249 => "USBPcap",
        251 | 256 => "Bluetooth Low Energy",
        252 => "Wireshark upper PDU",
        253 => "Linux netlink",
        _ => "unknown",
    }
}
