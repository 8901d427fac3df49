//! Reassembly of IP fragments, and of Bluetooth advertising data spread over several frames.

use std::collections::VecDeque;
use std::net::IpAddr;

use etherparse::defrag::IpDefragBuf;
use etherparse::{IpFragOffset, IpNumber, Ipv6ExtensionSlice, LaxNetSlice};
use jiff::SignedDuration;
use remote_id::Listener;

use fusion::time::Time;

/// Maximum number of datagrams waiting for fragments; beyond it the oldest are dropped.
const MOST: usize = 64;
/// Maximum time between the fragments of a datagram (RFC 8200, section 4.5); later its identification may be used again.
const PATIENCE: SignedDuration = SignedDuration::from_secs(60);

/// Identifies the fragments of one packet: sender, receiver, protocol, and the identification assigned by the sender.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct FragmentKey {
    source: IpAddr,
    destination: IpAddr,
    protocol: IpNumber,
    number: u32,
}

/// Position of a fragment in its packet.
#[derive(Clone, Copy, Debug)]
pub(super) struct FragmentPosition {
    key: FragmentKey,
    offset: IpFragOffset,
    has_more: bool,
}

impl FragmentPosition {
    /// Position of an IP packet, if it is a fragment.
    pub(super) fn of(
        net: &LaxNetSlice<'_>,
        (source, destination): (IpAddr, IpAddr),
        protocol: IpNumber,
    ) -> Option<Self> {
        let (number, offset, has_more) = match net {
            LaxNetSlice::Ipv4(ip) => {
                let header = ip.header();
                (header.identification().into(), header.fragments_offset(), header.more_fragments())
            }
            LaxNetSlice::Ipv6(ip) => {
                let header = ip.extensions().clone().into_iter().find_map(|extension| match extension {
                    Ipv6ExtensionSlice::Fragment(header) => Some(header.to_header()),
                    _ => None,
                })?;
                (header.identification, header.fragment_offset, header.more_fragments)
            }
            LaxNetSlice::Arp(_) => return None,
        };
        Some(Self { key: FragmentKey { source, destination, protocol, number }, offset, has_more })
    }
}

/// Reassembled payload of an IP packet, with the number of frames of its fragments.
#[derive(Debug)]
pub(super) struct Whole {
    pub(super) octets: Vec<u8>,
    /// Offset of its first octet in the file.
    pub(super) origin: u64,
    pub(super) fragments: u32,
}

/// Datagrams with missing fragments.
#[derive(Debug, Default)]
pub(super) struct Fragments {
    waiting: VecDeque<PartialPacket>,
    /// Advertising data with missing packets.
    pub(super) listener: Listener,
}

#[derive(Debug)]
struct PartialPacket {
    key: FragmentKey,
    so_far: IpDefragBuf,
    origin: u64,
    fragments: u32,
    latest: Option<Time>,
}

impl Fragments {
    /// Adds a fragment at `position` of the file, from this number of frames. Returns the payload if it is complete.
    pub(super) fn take(
        &mut self,
        place: FragmentPosition,
        payload: &[u8],
        received: Option<Time>,
        position: u64,
        frames: u32,
    ) -> Option<Whole> {
        let waits = self.waiting.iter().position(|waiting| waiting.key == place.key);
        let is_recent = |waiting: &PartialPacket| {
            let pause = received.zip(waiting.latest).map(|(now, latest)| (now - latest).abs());
            pause.is_none_or(|pause| pause <= PATIENCE)
        };
        let waiting = waits.and_then(|at| self.waiting.remove(at)).filter(is_recent);
        let mut waiting = waiting.unwrap_or_else(|| PartialPacket {
            key: place.key,
            so_far: IpDefragBuf::new(place.key.protocol, Vec::new(), Vec::new()),
            origin: position,
            fragments: 0,
            latest: received,
        });
        // Contradicting fragments are all dropped: it is unknown which are right.
        waiting.so_far.add(place.offset, place.has_more, payload).ok()?;
        waiting.fragments += frames;
        waiting.latest = received;
        if place.offset.value() == 0 {
            waiting.origin = position;
        }
        if waiting.so_far.is_complete() {
            let PartialPacket { so_far, origin, fragments, .. } = waiting;
            return Some(Whole { octets: so_far.take_bufs().0, origin, fragments });
        }
        if self.waiting.len() == MOST {
            self.waiting.pop_front();
        }
        self.waiting.push_back(waiting);
        None
    }
}
