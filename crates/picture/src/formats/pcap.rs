//! UDP datagrams as a classic pcap file, for tools that read captures.

use std::io::{self, Write};
use std::net::Ipv4Addr;

use etherparse::PacketBuilder;

use fusion::time::{SECOND, Time};

/// Sender and receiver of a datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UdpFlow {
    /// Address of the sender. The source port equals the destination port.
    pub from: Ipv4Addr,
    /// Address of the receiver, unicast or multicast.
    pub to: Ipv4Addr,
    /// Destination port.
    pub port: u16,
    /// Time to live, in hops.
    pub ttl: u8,
}

/// Writer of Ethernet frames with time stamps in nanoseconds, so that times of the engine are exact.
#[derive(Debug)]
pub struct PcapWriter<W> {
    out: W,
    frame: Vec<u8>,
}

/// Magic number of nanosecond files. The file is little-endian on every machine.
pub const MAGIC_NANOSECONDS: u32 = 0xa1b2_3c4d;
const LINKTYPE_ETHERNET: u32 = 1;
const SNAPLEN: u32 = 262_144;

impl<W: Write> PcapWriter<W> {
    /// Writes the header of the file.
    pub fn new(mut out: W) -> io::Result<Self> {
        out.write_all(&MAGIC_NANOSECONDS.to_le_bytes())?;
        for half in [2_u16, 4] {
            out.write_all(&half.to_le_bytes())?; // version 2.4
        }
        for word in [0, 0, SNAPLEN, LINKTYPE_ETHERNET] {
            out.write_all(&word.to_le_bytes())?;
        }
        Ok(Self { out, frame: Vec::new() })
    }

    /// Writes a datagram sent at `time`.
    ///
    /// # Errors
    /// The file cannot be written, or `time` is outside 1970 to 2106, the range of this format.
    pub fn write(&mut self, flow: UdpFlow, time: Time, datagram: &[u8]) -> io::Result<()> {
        self.write_from(flow.port, flow, time, datagram)
    }

    /// Writes a datagram as [`PcapWriter::write`] does, with another source port.
    ///
    /// # Errors
    /// See [`PcapWriter::write`].
    pub fn write_from(&mut self, sender: u16, flow: UdpFlow, time: Time, datagram: &[u8]) -> io::Result<()> {
        let UdpFlow { from, to, port, ttl } = flow;
        self.frame.clear();
        PacketBuilder::ethernet2([2, 0, 0, 0, 0, 1], mac_of(to))
            .ipv4(from.octets(), to.octets(), ttl)
            .udp(sender, port)
            .write(&mut self.frame, datagram)
            .map_err(io::Error::other)?;
        let seconds = u32::try_from(time.nanos().div_euclid(SECOND)).map_err(|_| {
            io::Error::other(format!("a pcap file holds the years 1970 to 2106, and {time} is none of them"))
        })?;
        let length = self.frame.len() as u32;
        for word in [seconds, time.nanos().rem_euclid(SECOND) as u32, length, length] {
            self.out.write_all(&word.to_le_bytes())?;
        }
        self.out.write_all(&self.frame)
    }

    /// The underlying writer.
    pub fn get_mut(&mut self) -> &mut W {
        &mut self.out
    }

    /// Writes all buffered data.
    pub fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Ethernet address of a multicast group (RFC 1112, section 6.4). For other addresses, a locally administered one.
fn mac_of(address: Ipv4Addr) -> [u8; 6] {
    let [_, b, c, d] = address.octets();
    if address.is_multicast() { [0x01, 0x00, 0x5e, b & 0x7f, c, d] } else { [2, 0, 0, 0, 0, 2] }
}
