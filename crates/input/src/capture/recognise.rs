//! Recognises a file by its first octets; names and extensions are ignored.
//!
//! A FINAL recording is recognised by its first record: a time below 24 h, data that begin with the header of a block that
//! fits into them, and the trailer. If no such record, or beginning of one, follows, it still is one unless it could be raw
//! ASTERIX. If only the beginning is damaged, the following data decides.
//!
//! Recordings in other framings (`framed.rs`) are recognised by consecutive records whose blocks can be decoded, MAVLink
//! logs by consecutive times and frames, 1090 MHz receivers by consecutive frames.
//!
//! Raw ASTERIX has no mark: any octet but 0 is a category. A file is taken for raw ASTERIX when
//! 1. it does not begin with the magic number of another format,
//! 2. its first block is whole: CAT is not 0, LEN is at least 3 and the file is that long,
//! 3. its first record announces items: FSPEC has other bits than those that extend it,
//! 4. it is not text. LEN of a block below 2,304 octets begins with an octet that no text contains; a larger one is
//!    accepted only if there are control characters among its first octets, as there are in all binary data,
//! 5. the first block is followed by the end, a stray octet or two, zeros, or the header of another block (CAT not 0,
//!    LEN at least 3), of which the end may be missing. A block of 2,304 octets or more is accepted only next to one of
//!    its own category: only radar video (CAT240) has blocks larger than an Ethernet frame.

use std::io;

use super::beast;
use super::chain;
use super::raw::{self, HEADER};
use super::window::ReadWindow;
use super::{final_recording, framed, gzip, pcapng, tlog};
use crate::gateways::adsb::ReceiverFraming;
use crate::hex;

/// The kind of a file.
#[derive(Debug)]
pub(super) enum RecognisedKind {
    Raw,
    Pcap,
    Pcapng,
    Final,
    Framed(framed::Framed),
    Receiver(ReceiverFraming),
    Tlog,
    Gzip,
    Empty,
    Foreign { found: String, advice: &'static str },
}

impl RecognisedKind {
    /// The kind of a compressed file with these contents.
    pub(super) fn unpacked(self) -> Self {
        match self {
            Self::Foreign { found, advice } => {
                Self::Foreign { found: format!("{found}, gzip-compressed"), advice }
            }
            kind => kind,
        }
    }
}

/// Number of octets read for a magic number; few, because a pipe may not deliver more for a while.
const LONGEST_MAGIC: usize = 16;

/// Octets used to distinguish text from binary data.
const SAMPLE: usize = 512;

/// LEN from which a block is unusual, and the smallest that can occur in text (a tab and a zero).
const LARGE: usize = 0x0900;

/// Category whose blocks are large.
const VIDEO: u8 = 240;

const WHAT_IS_READ: &str = "this program reads raw ASTERIX, pcap, pcapng, FINAL, ORADIS, Beast, AVR and MAVLink logs, also gzip-compressed";
const WHAT_IS_READ_OF_TEXT: &str = "this program reads raw ASTERIX, pcap, pcapng, FINAL, ORADIS, Beast, AVR and MAVLink logs, also gzip-compressed; if a sensor sends such lines, `utm-fusion check SITE --lines FILE` shows what they become";
const WITH_STAMPS: &str = "without them it is not known when a frame came; record Beast (usually port 30005), or AVR whose lines begin with @";
const PACKED: &str = "unpack it first";

/// Foreign formats by magic number, with advice.
const FOREIGN: &[(&[u8], &str, &str)] = &[
    (b"\x34\xCD\xB2\xA1", "a modified pcap capture", "convert it: editcap -F pcap IN OUT"),
    (b"\xA1\xB2\xCD\x34", "a modified pcap capture", "convert it: editcap -F pcap IN OUT"),
    (b"snoop\0\0\0", "a snoop capture", "convert it: editcap -F pcap IN OUT"),
    (b"btsnoop\0", "a Bluetooth log (btsnoop)", "convert it: editcap -F pcap IN OUT"),
    (b"GMBU", "a Network Monitor capture", "convert it: editcap -F pcap IN OUT"),
    (b"BZh", "bzip2-compressed data", "unpack it first: bunzip2"),
    (b"\xFD7zXZ\0", "xz-compressed data", "unpack it first: unxz"),
    (b"\x28\xB5\x2F\xFD", "Zstandard-compressed data", "unpack it first: unzstd"),
    (b"\x04\x22\x4D\x18", "LZ4-compressed data", "unpack it first: unlz4"),
    (b"7z\xBC\xAF\x27\x1C", "a 7-Zip archive", PACKED),
    (b"PK\x03\x04", "a ZIP archive", PACKED),
    (b"Rar!", "a RAR archive", PACKED),
    (b"\x89PNG", "a PNG image", WHAT_IS_READ),
    (b"\xFF\xD8\xFF", "a JPEG image", WHAT_IS_READ),
    (b"GIF8", "a GIF image", WHAT_IS_READ),
    (b"%PDF", "a PDF document", WHAT_IS_READ),
    (b"\x7FELF", "a Linux program (ELF)", WHAT_IS_READ),
    (b"MZ\x90\0", "a Windows program", WHAT_IS_READ),
    (b"SQLite format 3\0", "an SQLite database", WHAT_IS_READ),
    (b"PAR1", "a Parquet file", WHAT_IS_READ),
    (b"\x89HDF", "an HDF5 file", WHAT_IS_READ),
    (b"\x93NUMPY", "a NumPy array", WHAT_IS_READ),
    (b"RIFF", "a RIFF file (audio, video)", WHAT_IS_READ),
    (b"\xFF\xFE", "text in UTF-16", WHAT_IS_READ),
    (b"\xFE\xFF", "text in UTF-16", WHAT_IS_READ),
];

/// Recognises the first octets of a file without consuming any.
pub(super) fn recognise(window: &mut ReadWindow) -> io::Result<RecognisedKind> {
    if window.peek(1)?.is_empty() {
        return Ok(RecognisedKind::Empty);
    }
    let kind = by_content(window);
    if let RecognisedKind::Foreign { .. } = kind {
        // A read error takes precedence.
        window.failed()?;
    }
    Ok(kind)
}

fn by_content(window: &mut ReadWindow) -> RecognisedKind {
    let head = window.glimpse(LONGEST_MAGIC);
    if let [0xA1, 0xB2, 0xC3, 0xD4, ..]
    | [0xD4, 0xC3, 0xB2, 0xA1, ..]
    | [0xA1, 0xB2, 0x3C, 0x4D, ..]
    | [0x4D, 0x3C, 0xB2, 0xA1, ..] = head
    {
        return RecognisedKind::Pcap;
    }
    if head.starts_with(&pcapng::SECTION) {
        return RecognisedKind::Pcapng;
    }
    if head.starts_with(gzip::MAGIC) {
        return RecognisedKind::Gzip;
    }
    if head.first() == Some(&beast::ESCAPE)
        && beast::begins(ReceiverFraming::Beast, window.glimpse(beast::SAMPLE)).is_some()
    {
        return RecognisedKind::Receiver(ReceiverFraming::Beast);
    }
    if window.glimpse(1).first().is_some_and(|mark| beast::MARKS.contains(mark)) {
        match beast::begins(ReceiverFraming::Avr, window.glimpse(beast::SAMPLE)) {
            Some(true) => return RecognisedKind::Receiver(ReceiverFraming::Avr),
            Some(false) => {
                return RecognisedKind::Foreign {
                    found: "AVR without time stamps".to_owned(),
                    advice: WITH_STAMPS,
                };
            }
            None => {}
        }
    }
    if tlog::begins(window) {
        return RecognisedKind::Tlog;
    }
    let head = window.glimpse(LONGEST_MAGIC);
    if let Some((_, found, advice)) = FOREIGN.iter().find(|(magic, ..)| head.starts_with(magic)) {
        return RecognisedKind::Foreign { found: (*found).to_owned(), advice };
    }
    if let Some(length) = final_record(window, 0) {
        let goes_on = window.glimpse(length + 1).len() == length || final_record(window, length).is_some();
        if goes_on || objection_to_raw(window).is_some() {
            return RecognisedKind::Final;
        }
    }
    if let Some(framed) = framed::recognise(window, framed::RecorderFraming::Oradis) {
        return RecognisedKind::Framed(framed);
    }
    let Some(objection) = objection_to_raw(window) else { return RecognisedKind::Raw };
    if let Some(framed) = framed::recognise(window, framed::RecorderFraming::Gps) {
        return RecognisedKind::Framed(framed);
    }
    let sample = window.glimpse(SAMPLE);
    let foreign = describe(&sample[..sample.len().min(SAMPLE)], &objection);
    if is_text(&sample[..sample.len().min(SAMPLE)]) {
        return foreign;
    }
    // The first octets may be damaged.
    if final_recording::find(window, 1).is_some_and(|place| final_record(window, place).is_some()) {
        RecognisedKind::Final
    } else if chain::is_near(window) {
        RecognisedKind::Raw
    } else {
        foreign
    }
}

/// Octets of the FINAL record at `place`, if there is a whole one.
fn final_record(window: &mut ReadWindow, place: usize) -> Option<usize> {
    let start = window.glimpse(place + final_recording::HEADER + HEADER).get(place..)?;
    let header = start.first_chunk()?;
    final_recording::since_midnight(header)?;
    let length = final_recording::length(header);
    let (_, block) = plausible_header(&start[final_recording::HEADER..])?;
    if final_recording::HEADER + block > length {
        return None;
    }
    let record = window.glimpse(place + length).get(place..place + length)?;
    final_recording::ends_well(record).then_some(length)
}

/// Reason why this is not raw ASTERIX, as part of a sentence; `None` if it is.
fn objection_to_raw(window: &mut ReadWindow) -> Option<String> {
    let octets = window.glimpse(HEADER);
    let Some((category, length)) = plausible_header(octets) else {
        return Some("they are not the header of an ASTERIX block".to_owned());
    };
    let octets = window.glimpse(length + HEADER);
    if octets.len() < length {
        let end = octets.len();
        return Some(format!(
            "as ASTERIX, they would begin a block of category {category} and {length} octets, but the file ends after {end}"
        ));
    }
    if !announces_items(&octets[HEADER..length]) {
        return Some("as ASTERIX, their first record would announce no items".to_owned());
    }
    if is_text(&octets[..length.min(SAMPLE)]) {
        return Some("they are text".to_owned());
    }
    let next = &octets[length..];
    let is_large = |category, length| length >= LARGE && category != VIDEO;
    let follows = match (next, plausible_header(next)) {
        (_, Some((next_category, next_length))) => {
            next_category == category || !(is_large(category, length) || is_large(next_category, next_length))
        }
        ([] | [_] | [_, _], None) => true,
        ([0, 0, 0, ..], None) => !is_large(category, length),
        (_, None) => false,
    };
    (!follows).then(|| {
        format!(
            "as ASTERIX, they would begin a block of category {category} and {length} octets, but no block follows \
             it ({} at offset {length})",
            hexadecimal(&next[..HEADER])
        )
    })
}

/// Whether the FSPEC at the start of these octets announces an item; its last bit extends it by another octet. `true` for a
/// block without records.
fn announces_items(octets: &[u8]) -> bool {
    let extended = octets.iter().take_while(|octet| **octet == 1).count();
    octets.get(extended).is_none_or(|octet| *octet != 0) && (extended == 0 || extended < octets.len())
}

/// CAT and LEN, if these octets can begin a block.
fn plausible_header(octets: &[u8]) -> Option<(u8, usize)> {
    let category = *octets.first()?;
    let length = raw::block_length(octets)?;
    (category != 0 && length >= HEADER).then_some((category, length))
}

/// Whether a sample is text: no control characters but those of text, and either mostly ASCII or UTF-8 (the sample may end
/// inside a character).
fn is_text(sample: &[u8]) -> bool {
    let control = |octet: &u8| octet.is_ascii_control() && !b"\t\n\x0C\r\x1B".contains(octet);
    let ascii = sample.iter().filter(|octet| octet.is_ascii()).count();
    let utf_8 = str::from_utf8(sample).map_or_else(|error| error.error_len().is_none(), |_| true);
    !sample.iter().any(control) && (utf_8 || ascii * 2 > sample.len())
}

fn describe(sample: &[u8], objection: &str) -> RecognisedKind {
    let found = if is_text(sample) {
        let text = sample.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(sample).trim_ascii_start();
        match text {
            // A `[` alone would also match TOML.
            [b'{', ..] | [b'[', b'{' | b'\n' | b'\r', ..] => "JSON",
            [b'<', ..] => "XML or HTML",
            _ => "text",
        }
    } else {
        let first = hexadecimal(&sample[..sample.len().min(8)]);
        let found = format!("nothing known (first octets {first}; {objection})");
        return RecognisedKind::Foreign { found, advice: WHAT_IS_READ };
    };
    let advice = if found == "XML or HTML" { WHAT_IS_READ } else { WHAT_IS_READ_OF_TEXT };
    RecognisedKind::Foreign { found: found.to_owned(), advice }
}

fn hexadecimal(octets: &[u8]) -> String {
    octets.chunks(1).map(hex::text).collect::<Vec<_>>().join(" ")
}
