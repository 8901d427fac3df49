//! Headers of a frame, from the first one down to the payload of its UDP datagram.

use std::net::{IpAddr, SocketAddr};

use etherparse::err::packet::SliceError;
use etherparse::{EtherType, IpNumber, LaxNetSlice, LaxSlicedPacket, UdpHeader, UdpSlice, ether_type};

use super::CapturedDatagram;
use super::fragments::{FragmentPosition, Fragments, Whole};
use super::link::Endpoints;
use super::skipped::{SkipReason, SkippedFrame};
use super::tunnel::{self, Layer};
use fusion::time::Time;

/// Maximum number of nested headers that are read; mirror ports write three or four.
const DEEPEST: u8 = 16;

/// Octets of a frame after some headers.
#[derive(Clone, Copy)]
pub(super) struct FramePart<'a> {
    octets: &'a [u8],
    /// Offset of the first octet in the file.
    origin: u64,
    /// Number of headers read.
    depth: u8,
    /// Number of frames from which it was assembled; 0 if not fragmented.
    fragments: u32,
    /// Whether the capture holds only a part of it.
    is_cut: bool,
}

impl<'a> FramePart<'a> {
    /// A frame at `origin` of the file.
    pub(super) fn of_frame(octets: &'a [u8], origin: u64) -> Self {
        Self { octets, origin, depth: 0, fragments: 0, is_cut: false }
    }

    /// Octets after a header of this length.
    pub(super) fn behind(self, length: usize) -> Result<Self, SkippedFrame> {
        let octets = self.octets.get(length..).ok_or_else(|| self.lost(SkipReason::Truncated))?;
        Ok(self.of(octets))
    }

    /// A part of it.
    fn of(self, octets: &'a [u8]) -> Self {
        let offset = octets.as_ptr().addr() - self.octets.as_ptr().addr();
        Self { octets, origin: self.origin + offset as u64, ..self }
    }

    /// Error for a part without a datagram. A part cut by the capture does not count as malformed.
    fn lost(&self, reason: SkipReason) -> SkippedFrame {
        let reason = match reason {
            SkipReason::Malformed if self.is_cut => SkipReason::Truncated,
            reason => reason,
        };
        SkippedFrame { reason, fragments: self.fragments }
    }
}

/// The datagram in octets that begin with `layer`. A frame cut by the capture is accepted if the datagram is whole.
pub(super) fn datagram(
    mut layer: Layer,
    mut part: FramePart<'_>,
    received: Option<Time>,
    fragments: &mut Fragments,
) -> Result<CapturedDatagram, SkippedFrame> {
    while let Some((inner, offset)) =
        tunnel::within(layer, part.octets).map_err(|reason| part.lost(reason))?
    {
        part = deeper(part)?.behind(offset)?;
        layer = inner;
    }
    let packet = IpPacket::read(layer, part)?;
    let (addresses, protocol) = (packet.addresses, packet.protocol);
    let Some(place) = packet.place else {
        return behind_ip(protocol, addresses, packet.part, received, fragments);
    };
    if packet.part.is_cut {
        return Err(part.lost(SkipReason::Truncated));
    }
    // A fragment of a fragment counts each of its frames.
    let frames = part.fragments.max(1);
    let FramePart { octets, origin, .. } = packet.part;
    let whole = fragments.take(place, octets, received, origin, frames);
    let Whole { octets, origin, fragments: count } = whole.ok_or_else(|| part.lost(SkipReason::Fragment))?;
    let part = FramePart { octets: &octets, origin, fragments: count, ..packet.part };
    behind_ip(protocol, addresses, part, received, fragments)
}

/// Rejects headers that are nested too deeply.
fn deeper(part: FramePart<'_>) -> Result<FramePart<'_>, SkippedFrame> {
    if part.depth == DEEPEST {
        return Err(part.lost(SkipReason::TooDeep));
    }
    Ok(FramePart { depth: part.depth + 1, ..part })
}

/// The datagram in the payload of an IP packet.
fn behind_ip(
    protocol: IpNumber,
    (source, destination): (IpAddr, IpAddr),
    part: FramePart<'_>,
    received: Option<Time>,
    fragments: &mut Fragments,
) -> Result<CapturedDatagram, SkippedFrame> {
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
    Ok(CapturedDatagram {
        received,
        endpoints: Some(endpoints),
        origin,
        payload,
        fragments,
        ..CapturedDatagram::default()
    })
}

/// An IP packet that carries UDP or a tunnel, or a fragment of one.
struct IpPacket<'a> {
    addresses: (IpAddr, IpAddr),
    protocol: IpNumber,
    /// Position in its packet, if it is a fragment.
    place: Option<FragmentPosition>,
    /// The payload, without padding.
    part: FramePart<'a>,
}

impl<'a> IpPacket<'a> {
    fn read(layer: Layer, part: FramePart<'a>) -> Result<Self, SkippedFrame> {
        let kind = match layer {
            Layer::EtherType(number) => EtherType(number),
            // The ether type stands for both: the version is read from the packet itself.
            _ => ether_type::IPV4,
        };
        let sliced = LaxSlicedPacket::from_ether_type(kind, part.octets);
        let error = sliced.stop_err.as_ref().map(|(error, _)| match error {
            SliceError::Len(_) => SkipReason::Truncated,
            _ => SkipReason::Malformed,
        });
        let Some(ip) = sliced.ip_payload() else {
            // A truncated ARP packet still counts as not IP.
            let arp = sliced.net.is_some() || kind == ether_type::ARP;
            return Err(part.lost(error.filter(|_| !arp).unwrap_or(SkipReason::NotIp)));
        };
        // The parser stopped at an extension header; a datagram may have followed it. A broken TCP or ICMP header does not
        // matter.
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
        let place = if ip.fragmented { FragmentPosition::of(net, addresses, protocol) } else { None };
        let part = FramePart { is_cut: part.is_cut || ip.incomplete, ..part.of(ip.payload) };
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
