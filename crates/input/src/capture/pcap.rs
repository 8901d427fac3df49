//! Classic pcap: a file header of 24 octets, then records of a 16-octet header and a frame each.
//!
//! `pcap-parser` parses the layout; reading and errors are handled here. The header's time zone correction is ignored, as by
//! every known reader and writer: time stamps are UTC.

use std::fmt;

use pcap_parser::nom::{Err as Outcome, Needed};
use pcap_parser::{PcapHeader, parse_pcap_frame, parse_pcap_frame_be, parse_pcap_header};

use super::error::Damage;
use super::fragments::Fragments;
use super::link::{self, LinkType};
use super::skipped::SkippedFrames;
use super::window::ReadWindow;
use super::{CapturedDatagram, OpenError};
use fusion::time::{SECOND, Time};

/// Octets of the file header.
const FILE_HEADER: usize = 24;
/// Octets of a record's header: seconds, fraction, captured length, original length.
const RECORD_HEADER: usize = 16;
/// Longest frame, as in libpcap and Wireshark, whatever the header's snapshot length (0 in some files).
const LONGEST_FRAME: usize = 262_144;

const RECORD: &str = "pcap record";

/// Unit of the fraction in a time stamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resolution {
    /// The usual unit.
    Microseconds,
    /// Used by `tcpdump --time-stamp-precision=nano`, and by `replay`.
    Nanoseconds,
}

impl fmt::Display for Resolution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Microseconds => "microseconds",
            Self::Nanoseconds => "nanoseconds",
        })
    }
}

/// The file header.
pub(super) struct Pcap {
    link: LinkType,
    resolution: Resolution,
    big_endian: bool,
    fragments: Fragments,
}

impl Pcap {
    /// Reads the file header, whose magic number has been recognised.
    pub(super) fn open(name: &str, window: &mut ReadWindow) -> Result<Self, OpenError> {
        let octets = match window.peek(FILE_HEADER) {
            Ok(octets) => octets,
            Err(cause) => return Err(OpenError::Read { name: name.to_owned(), cause }),
        };
        let Ok((_, header)) = parse_pcap_header(octets) else {
            return Err(OpenError::HeaderCut { name: name.to_owned(), octets: octets.len() });
        };
        window.consume(FILE_HEADER);
        Self::from_header(&header).map_err(|number| OpenError::LinkType {
            name: name.to_owned(),
            number,
            link: link::usual_name(number),
            advice: link::advice(number),
        })
    }

    fn from_header(header: &PcapHeader) -> Result<Self, u16> {
        // The upper half of the field is not part of the link type. It may state the length of the frame check sequence,
        // which follows the IP packet and is not used.
        let number = header.network.0 as u16;
        let link = LinkType::from_number(number).ok_or(number)?;
        let resolution =
            if header.is_nanosecond_precision() { Resolution::Nanoseconds } else { Resolution::Microseconds };
        Ok(Self { link, resolution, big_endian: header.is_bigendian(), fragments: Fragments::default() })
    }

    pub(super) fn link(&self) -> LinkType {
        self.link
    }

    pub(super) fn resolution(&self) -> Resolution {
        self.resolution
    }

    /// The next datagram; frames without one are counted in `skipped`.
    pub(super) fn next(
        &mut self,
        window: &mut ReadWindow,
        skipped: &mut SkippedFrames,
    ) -> Result<Option<CapturedDatagram>, Damage> {
        let parse = if self.big_endian { parse_pcap_frame_be } else { parse_pcap_frame };
        let mut needed = RECORD_HEADER;
        loop {
            let position = window.position();
            let octets = window.peek(needed)?;
            if octets.is_empty() {
                return Ok(None);
            }
            if octets.len() < needed {
                return Err(Damage::Cut { record: RECORD, present: octets.len(), needed });
            }
            match parse(octets) {
                Ok((rest, record)) => {
                    let length = octets.len() - rest.len();
                    let received = Some(self.time(record.ts_sec, record.ts_usec));
                    let frame_at = position + RECORD_HEADER as u64;
                    let datagram =
                        link::datagram(self.link, record.data, received, frame_at, &mut self.fragments);
                    window.consume(length);
                    match datagram {
                        Ok(datagram) => {
                            skipped.joined(datagram.fragments);
                            return Ok(Some(datagram));
                        }
                        Err(lost) => skipped.lost(&lost),
                    }
                    needed = RECORD_HEADER;
                }
                // A record is incomplete only if more octets are needed.
                Err(Outcome::Incomplete(Needed::Size(more))) => {
                    needed = octets.len().saturating_add(more.get());
                    let length = needed - RECORD_HEADER;
                    if length > LONGEST_FRAME {
                        return Err(Damage::Absurd { record: RECORD, length, most: LONGEST_FRAME });
                    }
                }
                Err(_) => return Err(Damage::Cut { record: RECORD, present: octets.len(), needed }),
            }
        }
    }

    /// Time of a record. A fraction of a second or more, as some writers produce, carries over.
    fn time(&self, seconds: u32, fraction: u32) -> Time {
        let nanos = match self.resolution {
            Resolution::Microseconds => i64::from(fraction) * 1000,
            Resolution::Nanoseconds => i64::from(fraction),
        };
        Time::from_nanos(i64::from(seconds) * SECOND + nanos)
    }
}
