//! pcapng: blocks of a type, a length, a body, and the length again
//! (<https://www.ietf.org/archive/id/draft-ietf-opsawg-pcapng-03.html>).
//!
//! A section header states the byte order of all blocks up to the next one. Interfaces are numbered from 0 in each section,
//! and each has its link type, unit of time and offset of time. Packets are in enhanced blocks, in obsolete ones (before
//! 2009), and in simple ones, which have no time. All other blocks (names, statistics, secrets, private extensions) are
//! skipped. A damaged packet in a sound block costs only itself.
//!
//! `pcap-parser` parses an interface's options. Its times are not used: it reads every offset as little-endian, and does
//! not support units that are powers of 2.

use pcap_parser::{
    OptionCode, parse_interfacedescriptionblock_be, parse_interfacedescriptionblock_le,
    parse_sectionheaderblock,
};

use super::CapturedDatagram;
use super::error::Damage;
use super::fragments::Fragments;
use super::link::{self, LinkType};
use super::skipped::{SkipReason, SkippedFrame, SkippedFrames};
use super::window::{CAPACITY, ReadWindow};
use fusion::time::{SECOND, Time};

/// Type of a section header, in either byte order.
pub(super) const SECTION: [u8; 4] = *b"\x0A\x0D\x0D\x0A";
const INTERFACE: u32 = 1;
const OBSOLETE_PACKET: u32 = 2;
const SIMPLE_PACKET: u32 = 3;
const ENHANCED_PACKET: u32 = 6;

/// Octets of type and length.
const HEADER: usize = 8;
/// Length of the shortest block, in octets: type and both lengths. In a section header it includes the byte-order magic.
const SHORTEST: usize = 12;
/// Longest block that is parsed: a frame of 262,144 octets, and the same amount of options.
const LONGEST: usize = CAPACITY;
/// Longest block that is skipped; Wireshark's limit.
const LONGEST_OTHER: usize = 16 << 20;
/// Octets of a long block that are skipped at a time.
const STEP: usize = 64 << 10;
/// Maximum number of interfaces of a section; more is damage.
const MOST_INTERFACES: usize = 65_536;

/// Octets of a block before its frame.
const SIMPLE_FRAME: usize = 12;
const FRAME: usize = 28;

const BLOCK: &str = "pcapng block";

/// State of the current section.
#[derive(Default)]
pub(super) struct Pcapng {
    big_endian: bool,
    interfaces: Vec<Interface>,
    fragments: Fragments,
}

/// A packet in its block.
struct PcapngPacket<'a> {
    interface: usize,
    /// Time in the interface's units.
    time: Option<u64>,
    /// Octets of the block before the frame.
    start: usize,
    frame: &'a [u8],
}

impl Pcapng {
    /// The next UDP datagram; frames without one are counted in `skipped`.
    pub(super) fn next(
        &mut self,
        window: &mut ReadWindow,
        skipped: &mut SkippedFrames,
    ) -> Result<Option<CapturedDatagram>, Damage> {
        loop {
            let position = window.position();
            let octets = window.peek(HEADER)?;
            let Some(header) = octets.first_chunk::<HEADER>().copied() else {
                let present = octets.len();
                return if present == 0 { Ok(None) } else { Err(cut(present, HEADER)) };
            };
            let section = header.starts_with(&SECTION);
            if section {
                self.big_endian = is_big_endian(window.peek(SHORTEST)?)?;
            }
            let (kind, length) = (self.number(&header, 0), self.number(&header, 4) as usize);
            if length < SHORTEST {
                return Err(garbled(format!("claims {length} octets; {SHORTEST} is the least")));
            }
            let of_interest = matches!(kind, INTERFACE | OBSOLETE_PACKET | SIMPLE_PACKET | ENHANCED_PACKET);
            if !section && !of_interest {
                pass_over(window, length, &header)?;
                continue;
            }
            if length > LONGEST {
                return Err(Damage::Absurd { record: BLOCK, length, most: LONGEST });
            }
            let octets = window.peek(length)?;
            if octets.len() < length {
                return Err(cut(octets.len(), length));
            }
            let block = &octets[..length];
            self.check_end(block)?;
            let mut datagram = None;
            if section {
                check_version(block)?;
                self.interfaces.clear();
            } else if kind == INTERFACE {
                if self.interfaces.len() == MOST_INTERFACES {
                    return Err(garbled(format!("describes one more than {MOST_INTERFACES} interfaces")));
                }
                self.interfaces.push(Interface::new(block, self.big_endian));
            } else {
                match self.datagram(kind, block, position) {
                    Ok(read) => {
                        skipped.joined(read.fragments);
                        datagram = Some(read);
                    }
                    Err(lost) => skipped.lost(&lost),
                }
            }
            window.consume(length);
            if datagram.is_some() {
                return Ok(datagram);
            }
        }
    }

    fn datagram(&mut self, kind: u32, block: &[u8], position: u64) -> Result<CapturedDatagram, SkippedFrame> {
        let packet = self.packet(kind, block).ok_or(SkipReason::Malformed)?;
        let interface = self.interfaces.get(packet.interface).ok_or(SkipReason::UnknownInterface)?;
        let link = interface.link.ok_or(SkipReason::LinkType)?;
        let received = packet.time.and_then(|units| interface.time(units));
        let frame_at = position + packet.start as u64;
        link::datagram(link, packet.frame, received, frame_at, &mut self.fragments)
    }

    /// `None` if the block is shorter than it claims.
    fn packet<'a>(&self, kind: u32, block: &'a [u8]) -> Option<PcapngPacket<'a>> {
        let body = &block[..block.len() - 4];
        if kind == SIMPLE_PACKET {
            // It states the length of the frame; the octets kept are limited by the interface.
            let frame = body.get(SIMPLE_FRAME..)?;
            let most = match self.interfaces.first() {
                Some(interface) if interface.snap_length > 0 => interface.snap_length,
                _ => u32::MAX,
            };
            let length = self.number(block, 8).min(most) as usize;
            let frame = &frame[..frame.len().min(length)];
            return Some(PcapngPacket { interface: 0, time: None, start: SIMPLE_FRAME, frame });
        }
        if body.len() < FRAME {
            return None;
        }
        let mut interface = self.number(block, 8);
        if kind == OBSOLETE_PACKET {
            // Interface and lost packets have two octets each.
            interface = if self.big_endian { interface >> 16 } else { interface & 0xFFFF };
        }
        let time = u64::from(self.number(block, 12)) << 32 | u64::from(self.number(block, 16));
        let frame = body[FRAME..].get(..self.number(block, 20) as usize)?;
        Some(PcapngPacket { interface: interface as usize, time: Some(time), start: FRAME, frame })
    }

    fn check_end(&self, block: &[u8]) -> Result<(), Damage> {
        let (first, last) = (self.number(block, 4), self.number(block, block.len() - 4));
        if first == last {
            return Ok(());
        }
        Err(garbled(format!("claims {first} octets at its beginning and {last} at its end")))
    }

    /// The 4-octet number at `place`, which callers have checked to exist.
    fn number(&self, octets: &[u8], place: usize) -> u32 {
        let mut number = [0; 4];
        number.copy_from_slice(&octets[place..place + 4]);
        if self.big_endian { u32::from_be_bytes(number) } else { u32::from_le_bytes(number) }
    }
}

/// An interface of a section. One whose block cannot be parsed keeps its number, without a link type.
struct Interface {
    link: Option<LinkType>,
    /// Maximum number of octets kept of a frame; 0 for all.
    snap_length: u32,
    /// Unit of its times: seconds to the power of -`resolution` of 10, or of 2 if the highest bit is set.
    resolution: u8,
    /// Seconds from the epoch to the zero of its times.
    offset_s: i64,
}

impl Interface {
    /// Microseconds, the default.
    const MICROSECONDS: u8 = 6;

    fn new(block: &[u8], big_endian: bool) -> Self {
        let mut interface = Self { link: None, snap_length: 0, resolution: Self::MICROSECONDS, offset_s: 0 };
        let parse =
            if big_endian { parse_interfacedescriptionblock_be } else { parse_interfacedescriptionblock_le };
        let Ok((_, description)) = parse(block) else { return interface };
        interface.link = u16::try_from(description.linktype.0).ok().and_then(LinkType::from_number);
        interface.snap_length = description.snaplen;
        for option in description.options.iter().take_while(|option| option.code != OptionCode::EndOfOpt) {
            match (option.code, option.as_bytes()) {
                (OptionCode::IfTsresol, Ok(&[resolution])) => interface.resolution = resolution,
                (OptionCode::IfTsoffset, Ok(octets)) => {
                    if let Ok(octets) = octets.try_into() {
                        interface.offset_s =
                            if big_endian { i64::from_be_bytes(octets) } else { i64::from_le_bytes(octets) };
                    }
                }
                _ => {}
            }
        }
        interface
    }

    /// Time of a packet, rounded down to nanoseconds; `None` if it lies outside the years 1678 to 2262.
    fn time(&self, units: u64) -> Option<Time> {
        // Below 2 to the power of 94.
        let scaled = u128::from(units) * u128::from(SECOND.unsigned_abs());
        let exponent = u32::from(self.resolution & 0x7F);
        let nanos = if self.resolution & 0x80 == 0 {
            // A unit too small for 128 bits gives a time of 0.
            10_u128.checked_pow(exponent).map_or(0, |per_second| scaled / per_second)
        } else {
            scaled >> exponent
        };
        let offset = i128::from(self.offset_s) * i128::from(SECOND);
        let nanos = i128::try_from(nanos).ok()?.checked_add(offset)?;
        i64::try_from(nanos).ok().map(Time::from_nanos)
    }
}

/// The byte order of the section that begins with these octets.
fn is_big_endian(section: &[u8]) -> Result<bool, Damage> {
    match section {
        [_, _, _, _, _, _, _, _, 0x1A, 0x2B, 0x3C, 0x4D, ..] => Ok(true),
        [_, _, _, _, _, _, _, _, 0x4D, 0x3C, 0x2B, 0x1A, ..] => Ok(false),
        [_, _, _, _, _, _, _, _, a, b, c, d, ..] => {
            Err(garbled(format!("begins a section without a byte order ({a:02x} {b:02x} {c:02x} {d:02x})")))
        }
        _ => Err(cut(section.len(), SHORTEST)),
    }
}

fn check_version(section: &[u8]) -> Result<(), Damage> {
    let Ok((_, header)) = parse_sectionheaderblock(section) else {
        return Err(garbled("begins a section and is too short for it".to_owned()));
    };
    let (major, minor) = (header.major_version, header.minor_version);
    if major == 1 {
        Ok(())
    } else {
        Err(garbled(format!("begins a section of version {major}.{minor}, not 1")))
    }
}

/// Skips a block of any length, of which only a part is in memory at a time.
fn pass_over(window: &mut ReadWindow, length: usize, header: &[u8; HEADER]) -> Result<(), Damage> {
    if length > LONGEST_OTHER {
        return Err(Damage::Absurd { record: BLOCK, length, most: LONGEST_OTHER });
    }
    let mut left = length;
    // The last step has to contain more than the length at the end.
    while left > 2 * STEP {
        let present = window.peek(STEP)?.len();
        if present < STEP {
            return Err(cut(length - left + present, length));
        }
        window.pass(STEP);
        left -= STEP;
    }
    let octets = window.peek(left)?;
    if octets.len() < left {
        return Err(cut(length - left + octets.len(), length));
    }
    if octets[left - 4..left] != header[4..] {
        return Err(garbled("has another length at its end than at its beginning".to_owned()));
    }
    window.consume(left);
    Ok(())
}

fn cut(present: usize, needed: usize) -> Damage {
    Damage::Cut { record: BLOCK, present, needed }
}

fn garbled(fault: String) -> Damage {
    Damage::Garbled { record: BLOCK, fault }
}
