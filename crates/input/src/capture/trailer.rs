//! Trailers: octets that some senders append to the blocks of each datagram, such as a counter, a time or a checksum.
//!
//! No standard describes them, so they are recognised. If [`ALIKE`] consecutive datagrams from one sender to one receiver
//! end in the same number of octets after at least one block, these octets are a trailer, whatever their contents. It is
//! removed before blocks are read. `trailer_octets` of an input sets it from the start.

use std::collections::BTreeMap;
use std::fmt;
use std::net::{IpAddr, SocketAddr};

use asterix::blocks;

use super::Endpoints;
use super::chain::is_filled;
use site::config::{Address, Config, LONGEST_TRAILER};

/// Number of consecutive datagrams that must end alike.
const ALIKE: u8 = 4;

/// Maximum number of streams distinguished; further ones have no trailer.
const STREAMS: usize = 1024;

/// Sending host and receiver; `None` in a recording without addresses.
type DatagramStream = Option<(IpAddr, SocketAddr)>;

/// Ending of a datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// A block, or octets that cannot be read.
    Block,
    /// Octets that are a trailer if the next datagrams of the stream end alike.
    Undecided {
        /// Number of consecutive datagrams that end alike, from 1 on.
        alike: u8,
    },
    /// A trailer of this number of octets.
    Trailer(usize),
}

/// The configured trailers.
#[derive(Clone, Debug, Default)]
pub struct TrailerRules(Vec<TrailerRule>);

#[derive(Clone, Copy, Debug)]
struct TrailerRule {
    address: IpAddr,
    port: u16,
    source: Option<IpAddr>,
    octets: usize,
}

impl TrailerRules {
    /// The trailers of inputs with `trailer_octets`.
    pub fn of(config: &Config) -> Self {
        let inputs = config.sensors.iter().flat_map(|sensor| &sensor.inputs);
        let rule = |input: &site::config::Input| {
            let address = match input.address {
                Address::Multicast { group, .. } => group,
                Address::Unicast(address) => address,
            };
            let source = input.source.map(IpAddr::V4);
            let octets = usize::from(input.trailer_octets?);
            Some(TrailerRule { address: address.into(), port: input.port, source, octets })
        };
        Self(inputs.filter_map(rule).collect())
    }

    /// Configured trailer of a stream in octets, 0 for none; `None` if not configured.
    fn octets(&self, (source, destination): (IpAddr, SocketAddr)) -> Option<usize> {
        let is_it = |rule: &&TrailerRule| {
            rule.port == destination.port()
                && (rule.address == destination.ip() || rule.address.is_unspecified())
                && rule.source.is_none_or(|wanted| wanted == source)
        };
        self.0.iter().find(is_it).map(|rule| rule.octets)
    }
}

/// A stream whose datagrams have a trailer. `Display`: `a trailer of 8 octets follows the blocks of each datagram from
/// 10.0.0.1 to 239.192.48.1:8048`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Trailer {
    /// Sending host; `None` in a recording without addresses.
    pub source: Option<IpAddr>,
    /// Receiver.
    pub destination: Option<SocketAddr>,
    /// Length in octets.
    pub octets: usize,
    /// Number of datagrams with it.
    pub datagrams: u64,
}

impl fmt::Display for Trailer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = if self.octets == 1 { "" } else { "s" };
        write!(f, "a trailer of {} octet{plural} follows the blocks of each datagram", self.octets)?;
        match self.source.zip(self.destination) {
            Some((source, destination)) => write!(f, " from {source} to {destination}"),
            None => Ok(()),
        }
    }
}

/// Recognises trailers.
#[derive(Debug, Default)]
pub struct Trailers {
    rules: TrailerRules,
    streams: BTreeMap<DatagramStream, StreamEnding>,
    /// Trailers recognised and not reported yet.
    news: Vec<Trailer>,
}

/// Ending of the datagrams of a stream.
#[derive(Clone, Copy, Debug, Default)]
struct StreamEnding {
    octets: usize,
    /// Number of consecutive datagrams that ended alike, at most [`ALIKE`].
    alike: u8,
    /// Datagrams whose trailer was removed.
    datagrams: u64,
    told: bool,
}

impl Trailers {
    /// No stream seen yet.
    pub fn new(rules: TrailerRules) -> Self {
        Self { rules, ..Self::default() }
    }

    /// Ending of the next datagram of a stream.
    pub fn examine(&mut self, endpoints: Option<Endpoints>, payload: &[u8]) -> Ending {
        let stream = stream(endpoints);
        let ends_in = |octets: usize| {
            payload.len().checked_sub(octets).is_some_and(|end| end > 0 && is_filled(&payload[..end]))
        };
        let ending = if let Some(octets) = stream.and_then(|stream| self.rules.octets(stream)) {
            // Also removed from a datagram that is broken anyway.
            let has_it = octets > 0 && payload.len() > octets && (ends_in(octets) || !is_filled(payload));
            if has_it { Ending::Trailer(octets) } else { Ending::Block }
        } else {
            let known = self.streams.get(&stream).copied().unwrap_or_default();
            if known.alike == ALIKE && ends_in(known.octets) {
                Ending::Trailer(known.octets)
            } else {
                self.learn(stream, known, remainder(payload))
            }
        };
        if let Ending::Trailer(octets) = ending {
            self.count(stream, octets, 1);
        }
        ending
    }

    /// Counts further datagrams of a stream with its trailer.
    pub fn count(&mut self, stream: DatagramStream, octets: usize, datagrams: u64) {
        if self.streams.len() >= STREAMS && !self.streams.contains_key(&stream) {
            return;
        }
        let seen = self.streams.entry(stream).or_default();
        seen.octets = octets;
        seen.datagrams += datagrams;
        if !std::mem::replace(&mut seen.told, true) {
            let seen = *seen;
            self.news.push(trailer(&stream, &seen));
        }
    }

    fn learn(&mut self, stream: DatagramStream, known: StreamEnding, remainder: Remainder) -> Ending {
        let (octets, alike) = match remainder {
            Remainder::None if known.octets > 0 => (0, 0),
            Remainder::None | Remainder::Broken => return Ending::Block,
            Remainder::Short(octets) if octets == known.octets => (octets, (known.alike + 1).min(ALIKE)),
            Remainder::Short(octets) => (octets, 1),
        };
        if self.streams.len() >= STREAMS && !self.streams.contains_key(&stream) {
            return Ending::Block;
        }
        self.streams.insert(stream, StreamEnding { octets, alike, ..known });
        match alike {
            0 => Ending::Block,
            ALIKE => Ending::Trailer(octets),
            _ => Ending::Undecided { alike },
        }
    }

    /// The trailers recognised since the last call.
    pub fn take_new(&mut self) -> Vec<Trailer> {
        std::mem::take(&mut self.news)
    }

    /// Streams that have, or had, a trailer.
    pub fn all(&self) -> impl Iterator<Item = Trailer> {
        self.streams.iter().filter(|(_, seen)| seen.datagrams > 0).map(|(stream, seen)| trailer(stream, seen))
    }
}

fn trailer(stream: &DatagramStream, seen: &StreamEnding) -> Trailer {
    let (source, destination) = stream.unzip();
    Trailer { source, destination, octets: seen.octets, datagrams: seen.datagrams }
}

/// The stream of a datagram.
pub(super) fn stream(endpoints: Option<Endpoints>) -> DatagramStream {
    endpoints.map(|endpoints| (endpoints.source.ip(), endpoints.destination))
}

/// Octets after the last whole block of a datagram.
#[derive(Clone, Copy)]
enum Remainder {
    None,
    /// At most [`LONGEST_TRAILER`] octets, after at least one block.
    Short(usize),
    /// No block, more octets, or the beginning of a block of a category in the datagram, which is probably a truncated
    /// block.
    Broken,
}

fn remainder(payload: &[u8]) -> Remainder {
    let mut end = 0;
    let mut categories = [false; 256];
    for block in blocks(payload) {
        match block {
            Ok(block) => {
                end = block.offset + block.octets.len();
                categories[usize::from(block.category)] = true;
            }
            Err(_) => break,
        }
    }
    match &payload[end..] {
        [] => Remainder::None,
        _ if end == 0 => Remainder::Broken,
        [category, high, low, ..] if categories[usize::from(*category)] && (*high, *low) > (0, 2) => {
            Remainder::Broken
        }
        rest if rest.len() > LONGEST_TRAILER => Remainder::Broken,
        rest => Remainder::Short(rest.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLOCK: [u8; 6] = [48, 0, 6, 0x80, 25, 200];

    fn datagram(trailer: &[u8]) -> Vec<u8> {
        [&BLOCK, trailer].concat()
    }

    fn endings(datagrams: &[Vec<u8>]) -> Vec<Ending> {
        let mut trailers = Trailers::default();
        datagrams.iter().map(|datagram| trailers.examine(None, datagram)).collect()
    }

    #[test]
    fn trailer_is_recognised_after_four_in_a_row() {
        let like_a_block = [48, 0, 8, 0x80, 25, 200, 0, 0];
        let mut all: Vec<_> = (0..5).map(|count| datagram(&[0, 0, 0, count, 1, 2, 3, 4])).collect();
        all.push(datagram(&like_a_block));
        let trailer = Ending::Trailer(8);
        let undecided = |alike| Ending::Undecided { alike };
        assert_eq!(endings(&all), [undecided(1), undecided(2), undecided(3), trailer, trailer, trailer]);
    }

    #[test]
    fn other_lengths_and_cut_blocks_are_no_trailer() {
        let undecided = |alike| Ending::Undecided { alike };
        let of = |lengths: &[usize]| {
            let all: Vec<_> = lengths.iter().map(|&length| datagram(&vec![0; length])).collect();
            endings(&all)
        };
        assert_eq!(of(&[8, 8, 8, 7, 8, 8, 8]), [1, 2, 3, 1, 1, 2, 3].map(undecided));
        let sound = Ending::Block;
        assert_eq!(of(&[8, 8, 8, 0, 8]), [undecided(1), undecided(2), undecided(3), sound, undecided(1)]);
        assert_eq!(of(&[33; 6]), [Ending::Block; 6]);
        let cut: Vec<_> = (0..6).map(|_| datagram(&[48, 0, 20, 0x80, 1])).collect();
        assert_eq!(endings(&cut), [Ending::Block; 6]);
        assert_eq!(endings(&vec![vec![0; 8]; 6]), [Ending::Block; 6], "no block at all");
    }

    #[test]
    fn trailer_ends_when_the_sender_omits_it() {
        let mut all: Vec<_> = (0..4).map(|_| datagram(&[0; 8])).collect();
        all.extend([datagram(&[]), datagram(&BLOCK), datagram(&[0; 8])]);
        assert_eq!(endings(&all)[4..], [Ending::Block, Ending::Block, Ending::Undecided { alike: 1 }]);
    }
}
