//! From the first header of a frame down to the payload of its UDP datagram.

use std::net::{IpAddr, SocketAddr};

use etherparse::err::packet::SliceError;
use etherparse::{EtherType, IpNumber, LaxNetSlice, LaxSlicedPacket, UdpHeader, UdpSlice, ether_type};

use super::Datagram;
use super::fragments::{Fragments, Place, Whole};
use super::link::Endpoints;
use super::skipped::{Lost, SkipReason};
use super::tunnel::{self, Layer};
use fusion::time::Time;

/// Headers in each other that are read; mirror ports write three or four.
const DEEPEST: u8 = 16;

/// Octets of a frame behind some headers.
#[derive(Clone, Copy)]
pub(super) struct Part<'a> {
    octets: &'a [u8],
    /// Offset of the first octet in the file.
    origin: u64,
    /// Headers that were read.
    depth: u8,
    /// Frames that it was put together from; 0: it came in one.
    fragments: u32,
    /// Whether the capture holds less of it than there was.
    is_cut: bool,
}

impl<'a> Part<'a> {
    /// A frame that stands at `origin` of the file.
    pub(super) fn of_frame(octets: &'a [u8], origin: u64) -> Self {
        Self { octets, origin, depth: 0, fragments: 0, is_cut: false }
    }

    /// The octets behind a header of that length.
    pub(super) fn behind(self, length: usize) -> Result<Self, Lost> {
        let octets = self.octets.get(length..).ok_or_else(|| self.lost(SkipReason::Truncated))?;
        Ok(self.of(octets))
    }

    /// A part of it.
    fn of(self, octets: &'a [u8]) -> Self {
        let offset = octets.as_ptr().addr() - self.octets.as_ptr().addr();
        Self { octets, origin: self.origin + offset as u64, ..self }
    }

    /// Why no datagram is had of it. What the capture cut does not contradict itself.
    fn lost(&self, reason: SkipReason) -> Lost {
        let reason = match reason {
            SkipReason::Malformed if self.is_cut => SkipReason::Truncated,
            reason => reason,
        };
        Lost { reason, fragments: self.fragments }
    }
}

/// The datagram in what begins with `layer`. A frame cut by the capture is fine as long as the datagram is whole.
pub(super) fn datagram(
    mut layer: Layer,
    mut part: Part<'_>,
    received: Option<Time>,
    fragments: &mut Fragments,
) -> Result<Datagram, Lost> {
    while let Some((inner, offset)) =
        tunnel::within(layer, part.octets).map_err(|reason| part.lost(reason))?
    {
        part = deeper(part)?.behind(offset)?;
        layer = inner;
    }
    let packet = Packet::read(layer, part)?;
    let (addresses, protocol) = (packet.addresses, packet.protocol);
    let Some(place) = packet.place else {
        return behind_ip(protocol, addresses, packet.part, received, fragments);
    };
    if packet.part.is_cut {
        return Err(part.lost(SkipReason::Truncated));
    }
    // A fragment of a fragment is one more frame for each that it came in.
    let frames = part.fragments.max(1);
    let Part { octets, origin, .. } = packet.part;
    let whole = fragments.take(place, octets, received, origin, frames);
    let Whole { octets, origin, fragments: count } = whole.ok_or_else(|| part.lost(SkipReason::Fragment))?;
    let part = Part { octets: &octets, origin, fragments: count, ..packet.part };
    behind_ip(protocol, addresses, part, received, fragments)
}

/// Refuses what is nested too deeply.
fn deeper(part: Part<'_>) -> Result<Part<'_>, Lost> {
    if part.depth == DEEPEST {
        return Err(part.lost(SkipReason::TooDeep));
    }
    Ok(Part { depth: part.depth + 1, ..part })
}

/// The datagram in the payload of an IP packet.
fn behind_ip(
    protocol: IpNumber,
    (source, destination): (IpAddr, IpAddr),
    part: Part<'_>,
    received: Option<Time>,
    fragments: &mut Fragments,
) -> Result<Datagram, Lost> {
    if let Some((layer, offset)) = tunnel::of_ip(protocol.0) {
        return datagram(layer, deeper(part)?.behind(offset)?, received, fragments);
    }
    if protocol != IpNumber::UDP {
        return Err(part.lost(SkipReason::NotUdp));
    }
    let udp = UdpSlice::from_slice(part.octets).map_err(|_| part.lost(SkipReason::Malformed))?;
    if let Some((layer, offset)) = tunnel::of_udp(udp.destination_port(), udp.payload()) {
        return datagram(layer, deeper(part.of(udp.payload()))?.behind(offset)?, received, fragments);
    }
    let endpoints = Endpoints {
        source: SocketAddr::new(source, udp.source_port()),
        destination: SocketAddr::new(destination, udp.destination_port()),
    };
    let (origin, payload) = (part.origin + UdpHeader::LEN as u64, udp.payload().to_vec());
    let fragments = part.fragments;
    Ok(Datagram { received, endpoints: Some(endpoints), origin, payload, fragments, ..Datagram::default() })
}

/// An IP packet that carries UDP or a tunnel, or a fragment of one.
struct Packet<'a> {
    addresses: (IpAddr, IpAddr),
    protocol: IpNumber,
    /// Where it belongs, if it is a fragment.
    place: Option<Place>,
    /// The payload, without padding.
    part: Part<'a>,
}

impl<'a> Packet<'a> {
    fn read(layer: Layer, part: Part<'a>) -> Result<Self, Lost> {
        let kind = match layer {
            Layer::EtherType(number) => EtherType(number),
            // It stands for both: the version is taken from the packet itself.
            _ => ether_type::IPV4,
        };
        let sliced = LaxSlicedPacket::from_ether_type(kind, part.octets);
        let error = sliced.stop_err.as_ref().map(|(error, _)| match error {
            SliceError::Len(_) => SkipReason::Truncated,
            _ => SkipReason::Malformed,
        });
        let Some(ip) = sliced.ip_payload() else {
            // An address resolution packet that is cut is still none of ours.
            let arp = sliced.net.is_some() || kind == ether_type::ARP;
            return Err(part.lost(error.filter(|_| !arp).unwrap_or(SkipReason::NotIp)));
        };
        // The slicing stopped at an extension header; behind it there may have been a datagram. That a TCP or ICMP header
        // is broken is not of interest.
        if let Some(reason) = error
            && ip.ip_number.is_ipv6_ext_header_value()
        {
            return Err(part.lost(reason));
        }
        let protocol = ip.ip_number;
        if protocol != IpNumber::UDP && tunnel::of_ip(protocol.0).is_none() {
            return Err(part.lost(SkipReason::NotUdp));
        }
        let addresses = sliced.net.as_ref().and_then(|net| Some((net, addresses(net)?)));
        let (net, addresses) = addresses.ok_or_else(|| part.lost(SkipReason::NotIp))?;
        let place = if ip.fragmented { Place::of(net, addresses, protocol) } else { None };
        let part = Part { is_cut: part.is_cut || ip.incomplete, ..part.of(ip.payload) };
        Ok(Self { addresses, protocol, place, part })
    }
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
