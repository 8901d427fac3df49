//! Headers around the IP packet with the datagram: tags, labels, and the tunnels of mirror ports.

use super::skipped::SkipReason;

/// Header at the start of octets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layer {
    /// An Ethernet header.
    Ethernet,
    /// Header of this ether type.
    EtherType(u16),
    /// A header of IEEE 802.2.
    Llc,
    /// IPv4 or IPv6.
    Ip,
    /// PPP.
    Ppp,
    /// PPP over Ethernet.
    Pppoe,
    /// MPLS labels.
    Mpls,
    /// Generic routing encapsulation.
    Gre,
}

/// Smallest ether type; smaller numbers are the length of an IEEE 802.3 frame.
const LEAST_ETHER_TYPE: u16 = 0x0600;
const IPV4: u16 = 0x0800;
const IPV6: u16 = 0x86dd;
const PPPOE: u16 = 0x8864;
const PPP: u16 = 0x880b;
const MPLS: [u16; 2] = [0x8847, 0x8848];
/// Encapsulated remote SPAN, types I and II, and type III.
const ERSPAN: u16 = 0x88be;
const ERSPAN_3: u16 = 0x22eb;

/// Ether types of tags, and the octets between a tag and the following ether type: VLANs, Cisco metadata, VN and E tags,
/// HSR and frame replication.
const TAGS: [(u16, usize); 8] =
    [(0x8100, 2), (0x88a8, 2), (0x9100, 2), (0x8909, 6), (0x8926, 4), (0x893f, 6), (0x892f, 4), (0xf1c1, 4)];
/// Ether types of bridged Ethernet, and the octets before its header: transparent bridging, provider backbones, FabricPath.
const BRIDGED: [(u16, usize); 3] = [(0x6558, 0), (0x88e7, 4), (0x8903, 2)];

/// Layer of a protocol number in Linux cooked captures.
pub(super) fn cooked(number: u16) -> Layer {
    /// The protocol number that Linux writes for IEEE 802.2.
    const LLC: u16 = 4;
    if number == LLC { Layer::Llc } else { Layer::EtherType(number) }
}

/// Layer of the type field in an Ethernet header.
fn typed(number: u16) -> Layer {
    if number < LEAST_ETHER_TYPE { Layer::Llc } else { Layer::EtherType(number) }
}

/// Layer within a layer, and the offset of its first octet. `None`: the IP parser handles this layer.
pub(super) fn within(layer: Layer, octets: &[u8]) -> Result<Option<(Layer, usize)>, SkipReason> {
    let inner = match layer {
        Layer::Ip => return Ok(None),
        Layer::EtherType(number) => match ether_type(number, octets)? {
            Some(inner) => inner,
            None => return Ok(None),
        },
        Layer::Ethernet => (typed(number(octets, 12)?), 14),
        Layer::Llc => llc(octets)?,
        Layer::Ppp => ppp(octets)?,
        Layer::Pppoe => match octets {
            // Version 1, type 1, code of a session; session, length.
            [0x11, 0, ..] => (Layer::Ppp, 6),
            _ => return Err(SkipReason::NotIp),
        },
        Layer::Mpls => mpls(octets)?,
        Layer::Gre => gre(octets)?,
    };
    Ok(Some(inner))
}

/// `None`: the IP parser handles this ether type, including ARP and MACsec.
fn ether_type(kind: u16, octets: &[u8]) -> Result<Option<(Layer, usize)>, SkipReason> {
    let inner = match kind {
        IPV4 | IPV6 => (Layer::Ip, 0),
        PPPOE => (Layer::Pppoe, 0),
        PPP => (Layer::Ppp, 0),
        _ if MPLS.contains(&kind) => (Layer::Mpls, 0),
        _ => {
            if let Some((_, between)) = TAGS.iter().find(|(tag, _)| *tag == kind) {
                return Ok(Some((typed(number(octets, *between)?), between + 2)));
            }
            let bridged = BRIDGED.iter().find(|(bridged, _)| *bridged == kind);
            return Ok(bridged.map(|(_, before)| (Layer::Ethernet, *before)));
        }
    };
    Ok(Some(inner))
}

fn llc(octets: &[u8]) -> Result<(Layer, usize), SkipReason> {
    match *octets {
        // SNAP with the organisation of Ethernet, or that of bridged Ethernet types.
        [0xaa, 0xaa, 3, 0, 0, 0 | 0xf8, high, low, ..] => {
            Ok((Layer::EtherType(u16::from_be_bytes([high, low])), 8))
        }
        [0xaa, 0xaa, ..] if octets.len() < 8 => Err(SkipReason::Truncated),
        // IP has its own number.
        [6, 6, 3, ..] => Ok((Layer::Ip, 3)),
        _ => Err(SkipReason::NotIp),
    }
}

fn ppp(octets: &[u8]) -> Result<(Layer, usize), SkipReason> {
    let start = match octets {
        // Cisco's variant has an address, a zero, and an ether type.
        [0x0f | 0x8f, 0, ..] => return Ok((Layer::EtherType(number(octets, 2)?), 4)),
        [0xff, 3, ..] => 2,
        _ => 0,
    };
    // A protocol below 0x100 may be sent in one octet, which is odd.
    let (protocol, length) = match octets.get(start) {
        Some(octet) if octet % 2 == 1 => (u16::from(*octet), 1),
        _ => (number(octets, start)?, 2),
    };
    match protocol {
        0x0021 | 0x0057 => Ok((Layer::Ip, start + length)),
        0x0281 | 0x0283 => Ok((Layer::Mpls, start + length)),
        _ => Err(SkipReason::NotIp),
    }
}

fn mpls(octets: &[u8]) -> Result<(Layer, usize), SkipReason> {
    let labels = octets.chunks_exact(4).position(|label| label[2] & 1 == 1).ok_or(SkipReason::Truncated)?;
    let start = 4 * (labels + 1);
    let behind = &octets[start..];
    // The type of the payload is recognised by its first octets only.
    match behind.first().ok_or(SkipReason::Truncated)? >> 4 {
        4 | 6 => Ok((Layer::Ip, start)),
        0 if is_ethernet(behind.get(4..)) => Ok((Layer::Ethernet, start + 4)),
        _ if is_ethernet(Some(behind)) => Ok((Layer::Ethernet, start)),
        _ => Err(SkipReason::NotIp),
    }
}

/// Whether octets begin with an Ethernet header whose type is one of those that lead to IP.
fn is_ethernet(octets: Option<&[u8]>) -> bool {
    let kind = octets.and_then(|octets| number(octets, 12).ok());
    kind.is_some_and(|kind| {
        matches!(kind, IPV4 | IPV6 | PPPOE)
            || MPLS.contains(&kind)
            || TAGS.iter().any(|(tag, _)| *tag == kind)
    })
}

/// RFC 2784 and 2890; PPTP (RFC 2637) uses version 1.
fn gre(octets: &[u8]) -> Result<(Layer, usize), SkipReason> {
    const CHECKSUM: u16 = 0x8000;
    const ROUTING: u16 = 0x4000;
    const KEY: u16 = 0x2000;
    const SEQUENCE: u16 = 0x1000;
    const ACKNOWLEDGEMENT: u16 = 0x0080;
    let (flags, protocol) = (number(octets, 0)?, number(octets, 2)?);
    let fields = match flags & 7 {
        // Source routes are obsolete.
        _ if flags & ROUTING != 0 => return Err(SkipReason::NotUdp),
        0 => [CHECKSUM, KEY, SEQUENCE],
        1 => [KEY, SEQUENCE, ACKNOWLEDGEMENT],
        _ => return Err(SkipReason::NotUdp),
    };
    let start = 4 + 4 * fields.iter().filter(|field| flags & **field != 0).count();
    let behind = octets.get(start..).ok_or(SkipReason::Truncated)?;
    match protocol {
        // Type I has no header and no sequence number.
        ERSPAN if flags & SEQUENCE == 0 => Ok((Layer::Ethernet, start)),
        ERSPAN | ERSPAN_3 => erspan(behind).map(|(layer, length)| (layer, start + length)),
        _ => Ok((typed(protocol), start)),
    }
}

/// The header of type II or III, by its version.
fn erspan(octets: &[u8]) -> Result<(Layer, usize), SkipReason> {
    match octets.first().ok_or(SkipReason::Truncated)? >> 4 {
        1 => Ok((Layer::Ethernet, 8)),
        2 => {
            // The last two octets state the type of the frame, and whether a subheader of 8 octets follows.
            let last = number(octets, 10)?;
            let length = if last & 1 == 1 { 20 } else { 12 };
            match last >> 10 & 0x1f {
                0 => Ok((Layer::Ethernet, length)),
                2 => Ok((Layer::Ip, length)),
                _ => Err(SkipReason::NotIp),
            }
        }
        _ => Err(SkipReason::NotIp),
    }
}

/// Layer at the start of an IP packet's payload, if it is a tunnel.
pub(super) fn of_ip(protocol: u8) -> Option<(Layer, usize)> {
    match protocol {
        4 | 41 | 94 => Some((Layer::Ip, 0)),
        47 => Some((Layer::Gre, 0)),
        97 => Some((Layer::Ethernet, 2)),
        137 => Some((Layer::Mpls, 0)),
        _ => None,
    }
}

/// Layer within a datagram to the port of a tunnel, and its offset.
pub(super) fn of_udp(port: u16, payload: &[u8]) -> Option<(Layer, usize)> {
    // The ports are not reserved for tunnels.
    if asterix::blocks(payload).all(|block| block.is_ok()) {
        return None;
    }
    match (port, payload) {
        // VXLAN: only the flags of network and policy may be set; 8472 is the port first used by Linux.
        (4789 | 8472, [flags, _, _, _, _, _, _, _, ..]) if flags & !0x80 == 0x08 => {
            Some((Layer::Ethernet, 8))
        }
        (4790, [0x0c, 0, 0, next, _, _, _, _, ..]) => match next {
            1 | 2 => Some((Layer::Ip, 8)),
            3 => Some((Layer::Ethernet, 8)),
            _ => None,
        },
        // GENEVE: version 0 and the length of its options in 4 octets, flags, ether type.
        (6081, [first @ 0..0x40, second, high, low, ..]) if second & 0x3f == 0 => {
            Some((typed(u16::from_be_bytes([*high, *low])), 8 + 4 * usize::from(*first)))
        }
        (6635, _) => Some((Layer::Mpls, 0)),
        (4754, _) => Some((Layer::Gre, 0)),
        (37008, [1, 0 | 1, 0, 1, tags @ ..]) => Some((Layer::Ethernet, 4 + tzsp_tags(tags)?)),
        (2152, [flags @ 0x30..=0x37, 0xff, ..]) => Some((Layer::Ip, gtp_header(*flags, payload)?)),
        _ => None,
    }
}

/// Length of the TZSP (TaZmen Sniffer Protocol) tags in octets, including the one that ends them.
fn tzsp_tags(tags: &[u8]) -> Option<usize> {
    let mut at = 0;
    loop {
        match tags.get(at)? {
            0 => at += 1,
            1 => return Some(at + 1),
            _ => at += 2 + usize::from(*tags.get(at + 1)?),
        }
    }
}

/// Length of the header of a user packet in a mobile network (3GPP TS 29.281), in octets.
fn gtp_header(flags: u8, octets: &[u8]) -> Option<usize> {
    const OPTIONAL: u8 = 0b111;
    const EXTENDED: u8 = 0b100;
    if flags & OPTIONAL == 0 {
        return Some(8);
    }
    let (mut length, mut next) = (12, octets.get(11)?);
    while flags & EXTENDED != 0 && *next != 0 {
        let extension = 4 * usize::from(*octets.get(length)?);
        length += extension.max(4);
        next = octets.get(length - 1)?;
    }
    Some(length)
}

/// The big-endian number of two octets at an offset.
fn number(octets: &[u8], at: usize) -> Result<u16, SkipReason> {
    let number = octets.get(at..).and_then(|octets| octets.first_chunk::<2>());
    number.map(|number| u16::from_be_bytes(*number)).ok_or(SkipReason::Truncated)
}
