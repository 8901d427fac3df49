//! Link types of captures: the headers before each frame.

use std::fmt;
use std::net::SocketAddr;

use ::remote_id::{Link, NotHeard};

use super::fragments::Fragments;
use super::packet::{self, FramePart};
use super::skipped::{SkipReason, SkippedFrame};
use super::tunnel::{self, Layer};
use super::{CapturedDatagram, PayloadKind};
use crate::gateways::remote_id;
use fusion::time::Time;

/// Sender and receiver of a datagram: IP addresses and UDP ports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Endpoints {
    /// The sender.
    pub source: SocketAddr,
    /// The receiver: the group and its port for multicast.
    pub destination: SocketAddr,
}

/// The link header of every frame of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkType {
    /// Ethernet II or IEEE 802.3.
    Ethernet,
    /// Linux `-i any`, version 1.
    LinuxCooked,
    /// Linux `-i any`, version 2.
    LinuxCooked2,
    /// No link header: an IPv4 or IPv6 packet.
    RawIp,
    /// BSD and macOS loopback: an address family in 4 octets.
    Loopback,
    /// PPP, with or without its framing, and Cisco's variant.
    Ppp,
    /// PPP over Ethernet, without the Ethernet header.
    Pppoe,
    /// Packets logged by the Linux firewall.
    Nflog,
    /// A header that contains the link type of the following data.
    Ppi,
    /// Radio frames.
    Radio(Link),
}

impl LinkType {
    /// The link type with this number in a capture file (<https://www.tcpdump.org/linktypes.html>).
    pub(super) fn from_number(number: u16) -> Option<Self> {
        match number {
            0 | 108 => Some(Self::Loopback),
            1 => Some(Self::Ethernet),
            9 | 50 | 104 => Some(Self::Ppp),
            // BSD systems wrote 12 and 14 for 101; 228 and 229 are restricted to one version of IP.
            12 | 14 | 101 | 228 | 229 => Some(Self::RawIp),
            51 => Some(Self::Pppoe),
            105 => Some(Self::Radio(Link::Ieee80211)),
            113 => Some(Self::LinuxCooked),
            127 => Some(Self::Radio(Link::Radiotap)),
            187 => Some(Self::Radio(Link::Hci)),
            192 => Some(Self::Ppi),
            201 => Some(Self::Radio(Link::HciDirection)),
            239 => Some(Self::Nflog),
            251 => Some(Self::Radio(Link::LeLinkLayer)),
            254 => Some(Self::Radio(Link::HciMonitor)),
            256 => Some(Self::Radio(Link::LeRadio)),
            272 => Some(Self::Radio(Link::NordicBle)),
            276 => Some(Self::LinuxCooked2),
            _ => None,
        }
    }

    /// Layer and offset of the first octet after the link header of `frame`.
    fn first(self, frame: &[u8]) -> Result<(Layer, usize), SkipReason> {
        let number = |at: usize, header: usize| {
            let number = frame.get(..header).and_then(|header| header.get(at..)?.first_chunk::<2>());
            number.map(|number| u16::from_be_bytes(*number)).ok_or(SkipReason::Truncated)
        };
        match self {
            Self::Ethernet => Ok((Layer::Ethernet, 0)),
            Self::LinuxCooked => Ok((tunnel::cooked(number(14, 16)?), 16)),
            Self::LinuxCooked2 => Ok((tunnel::cooked(number(0, 20)?), 20)),
            Self::RawIp => Ok((Layer::Ip, 0)),
            Self::Loopback => {
                let family = frame.first_chunk::<4>().ok_or(SkipReason::Truncated)?;
                if is_ip_family(*family) { Ok((Layer::Ip, 4)) } else { Err(SkipReason::NotIp) }
            }
            Self::Ppp => Ok((Layer::Ppp, 0)),
            Self::Pppoe => Ok((Layer::Pppoe, 0)),
            Self::Nflog => Ok((Layer::Ip, nflog_packet(frame)?)),
            Self::Ppi | Self::Radio(_) => Err(SkipReason::NotIp),
        }
    }
}

impl fmt::Display for LinkType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ethernet => "Ethernet",
            Self::LinuxCooked => "Linux cooked",
            Self::LinuxCooked2 => "Linux cooked v2",
            Self::RawIp => "raw IP",
            Self::Loopback => "loopback",
            Self::Ppp => "PPP",
            Self::Pppoe => "PPPoE",
            Self::Nflog => "Linux NFLOG",
            Self::Ppi => "PPI",
            Self::Radio(Link::Ieee80211) => "Wi-Fi",
            Self::Radio(Link::Radiotap) => "Wi-Fi with radiotap",
            Self::Radio(Link::NordicBle | Link::LeLinkLayer | Link::LeRadio) => "Bluetooth",
            Self::Radio(Link::Hci | Link::HciDirection | Link::HciMonitor) => "Bluetooth HCI",
        })
    }
}

/// Datagram of a frame at `position` of the file. A fragment returns its datagram if that is now complete.
pub(super) fn datagram(
    link: LinkType,
    frame: &[u8],
    received: Option<Time>,
    position: u64,
    fragments: &mut Fragments,
) -> Result<CapturedDatagram, SkippedFrame> {
    let (link, start, frame) = if link == LinkType::Ppi { behind_ppi(frame)? } else { (link, 0, frame) };
    let position = position + start as u64;
    if let LinkType::Radio(radio) = link {
        let payload = remote_id::heard(&mut fragments.listener, radio, frame, received).map_err(
            |reason| match reason {
                NotHeard::Other => SkipReason::NotRemoteId,
                NotHeard::Damaged => SkipReason::Checksum,
                NotHeard::Cut => SkipReason::Truncated,
            },
        )?;
        let contents = PayloadKind::Translated;
        return Ok(CapturedDatagram {
            received,
            origin: position,
            payload,
            contents,
            ..CapturedDatagram::default()
        });
    }
    let (layer, offset) = link.first(frame)?;
    packet::datagram(layer, FramePart::of_frame(frame, position).behind(offset)?, received, fragments)
}

/// Whether an address family is IPv4 or IPv6. The number is in the byte order of the capturing machine (108: in network
/// order). Each system has its own number for IPv6: 24, 28, 30 (BSDs and macOS), 10 (Linux), 23 (Windows).
fn is_ip_family(family: [u8; 4]) -> bool {
    let number = match family {
        [number, 0, 0, 0] | [0, 0, 0, number] => number,
        _ => return false,
    };
    matches!(number, 2 | 10 | 23 | 24 | 28 | 30)
}

/// Offset of the packet in a frame of link type 239: family, version and number of the log, then values of length, type and
/// contents, padded to 4 octets. Length and type are in the byte order of the capturing machine.
fn nflog_packet(frame: &[u8]) -> Result<usize, SkipReason> {
    const HEADER: usize = 4;
    const PAYLOAD: u16 = 9;
    if frame.len() < HEADER {
        return Err(SkipReason::Truncated);
    }
    let find = |read: fn([u8; 2]) -> u16| {
        let mut at = HEADER;
        while let Some(&[a, b, c, d]) = frame.get(at..).and_then(|rest| rest.first_chunk::<4>()) {
            let (length, kind) = (usize::from(read([a, b])), read([c, d]));
            // The highest bits of a type are flags.
            match (kind & 0x3fff, length) {
                (PAYLOAD, HEADER..) => return Some(at + HEADER),
                (_, HEADER..) => at += length.next_multiple_of(4),
                _ => return None,
            }
        }
        None
    };
    find(u16::from_le_bytes).or_else(|| find(u16::from_be_bytes)).ok_or(SkipReason::NotIp)
}

/// Link type, offset and octets of the data after a PPI header, without the checksum after a Wi-Fi frame.
fn behind_ppi(frame: &[u8]) -> Result<(LinkType, usize, &[u8]), SkipReason> {
    /// The field common to Wi-Fi radios, the offset of its flags, and their bits.
    const COMMON: u16 = 2;
    const FLAGS: usize = 8;
    const HAS_CHECKSUM: u16 = 1;
    const BAD_CHECKSUM: u16 = 4;
    let &[_, _, low, high, a, b, c, d] = frame.first_chunk::<8>().ok_or(SkipReason::Truncated)?;
    let length = usize::from(u16::from_le_bytes([low, high]));
    let link = u16::try_from(u32::from_le_bytes([a, b, c, d])).ok().and_then(LinkType::from_number);
    // A PPI header within a PPI header does not occur.
    let link = link.filter(|link| *link != LinkType::Ppi).ok_or(SkipReason::LinkType)?;
    let (mut fields, mut behind) = frame.split_at_checked(length).ok_or(SkipReason::Truncated)?;
    fields = fields.get(8..).ok_or(SkipReason::Malformed)?;
    while let [a, b, c, d, rest @ ..] = fields {
        let (kind, length) = (u16::from_le_bytes([*a, *b]), usize::from(u16::from_le_bytes([*c, *d])));
        let (field, others) = rest.split_at_checked(length).ok_or(SkipReason::Malformed)?;
        if let (COMMON, Some([low, high])) = (kind, field.get(FLAGS..FLAGS + 2)) {
            let flags = u16::from_le_bytes([*low, *high]);
            if flags & BAD_CHECKSUM != 0 {
                return Err(SkipReason::Checksum);
            }
            let checksum = if flags & HAS_CHECKSUM == 0 { 0 } else { 4 };
            behind = &behind[..behind.len().saturating_sub(checksum)];
        }
        fields = others;
    }
    Ok((link, length, behind))
}

/// Advice for an unsupported link type.
pub(super) fn advice(number: u16) -> &'static str {
    match number {
        119 | 163 => "set the monitor interface to radiotap headers and capture again",
        147..=162 => "the program that wrote it knows its layout; have it write Ethernet",
        189 | 220 | 249 => {
            "it holds the traffic of a USB bus: capture on the network or Bluetooth interface itself"
        }
        195 | 215 | 230 | 283 => "it holds a radio network without Remote ID or IP packets that can be read",
        252 => "have Wireshark save the packets as they were captured instead of exported PDUs",
        _ => "capture on an Ethernet or loopback interface, or with `-i any`",
    }
}

/// Usual name of an unsupported link type.
pub(super) fn usual_name(number: u16) -> &'static str {
    match number {
        6 => "Token Ring",
        8 => "SLIP",
        10 => "FDDI",
        107 => "Frame Relay",
        117 => "OpenBSD pflog",
        119 => "IEEE 802.11 with Prism header",
        147..=162 => "private use",
        163 => "IEEE 802.11 with AVS header",
        189 | 220 => "Linux USB",
        195 | 215 | 230 => "IEEE 802.15.4",
        227 => "SocketCAN",
        249 => "USBPcap",
        252 => "Wireshark upper PDU",
        253 => "Linux netlink",
        _ => "unknown",
    }
}
