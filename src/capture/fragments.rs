//! IP fragments and Bluetooth advertising data that come in several frames, put together.

use std::collections::VecDeque;
use std::net::IpAddr;

use etherparse::defrag::IpDefragBuf;
use etherparse::{IpFragOffset, IpNumber, Ipv6ExtensionSlice, LaxNetSlice};
use jiff::SignedDuration;
use remote_id::Listener;

use fusion::time::Time;

/// Datagrams that may wait for the rest of their fragments; then the oldest are given up.
const MOST: usize = 64;
/// A datagram whose fragments are farther apart than this is given up (RFC 8200, section 4.5): its number may have come again.
const PATIENCE: SignedDuration = SignedDuration::from_secs(60);

/// Which fragments belong together: sender, receiver, protocol, and the number that the sender gave their packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Key {
    source: IpAddr,
    destination: IpAddr,
    protocol: IpNumber,
    number: u32,
}

/// Where a fragment belongs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    key: Key,
    offset: IpFragOffset,
    has_more: bool,
}

impl Place {
    /// Of an IP packet that is a fragment.
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
        Some(Self { key: Key { source, destination, protocol, number }, offset, has_more })
    }
}

/// The payload of an IP packet, and the number of frames that its fragments came in.
#[derive(Debug)]
pub(super) struct Whole {
    pub(super) octets: Vec<u8>,
    /// Offset of its first octet in the file.
    pub(super) origin: u64,
    pub(super) fragments: u32,
}

/// Datagrams of which fragments are still to come.
#[derive(Debug, Default)]
pub(super) struct Fragments {
    waiting: VecDeque<Waiting>,
    /// Advertising data of which packets are still to come.
    pub(super) listener: Listener,
}

#[derive(Debug)]
struct Waiting {
    key: Key,
    so_far: IpDefragBuf,
    origin: u64,
    fragments: u32,
    latest: Option<Time>,
}

impl Fragments {
    /// Takes a fragment that stands at `position` of the file and came in that many frames; the payload, if this was the last
    /// one of it.
    pub(super) fn take(
        &mut self,
        place: Place,
        payload: &[u8],
        received: Option<Time>,
        position: u64,
        frames: u32,
    ) -> Option<Whole> {
        let waits = self.waiting.iter().position(|waiting| waiting.key == place.key);
        let is_recent = |waiting: &Waiting| {
            let pause = received.zip(waiting.latest).map(|(now, latest)| (now - latest).abs());
            pause.is_none_or(|pause| pause <= PATIENCE)
        };
        let waiting = waits.and_then(|at| self.waiting.remove(at)).filter(is_recent);
        let mut waiting = waiting.unwrap_or_else(|| Waiting {
            key: place.key,
            so_far: IpDefragBuf::new(place.key.protocol, Vec::new(), Vec::new()),
            origin: position,
            fragments: 0,
            latest: received,
        });
        // Of fragments that contradict each other nobody knows which are right: all are given up.
        waiting.so_far.add(place.offset, place.has_more, payload).ok()?;
        waiting.fragments += frames;
        waiting.latest = received;
        if place.offset.value() == 0 {
            waiting.origin = position;
        }
        if waiting.so_far.is_complete() {
            let Waiting { so_far, origin, fragments, .. } = waiting;
            return Some(Whole { octets: so_far.take_bufs().0, origin, fragments });
        }
        if self.waiting.len() == MOST {
            self.waiting.pop_front();
        }
        self.waiting.push_back(waiting);
        None
    }
}
