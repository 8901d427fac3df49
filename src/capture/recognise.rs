//! Recognises a file by its first octets; names and extensions are ignored.
//!
//! A FINAL recording is recognised by its first record: a time below 24 h, data that begin with the header of a block that
//! fits into them, and the trailer. If no such record, or beginning of one, follows, it still is one unless it could be raw
//! ASTERIX. Where only the beginning is damaged, what follows decides.
//!
//! Recordings in other framings (`framed.rs`) are recognised by records in a row whose blocks can be decoded, MAVLink logs by
//! times and frames in a row, 1090 MHz receivers by frames in a row.
//!
//! Nothing marks raw ASTERIX: any octet but 0 is a category. A file is taken for raw ASTERIX when
//! 1. it does not begin with the magic number of another format,
//! 2. its first block is whole: CAT is not 0, LEN is at least 3 and the file is that long,
//! 3. its first record announces items: FSPEC has other bits than those that extend it,
//! 4. it is not text. LEN of a block below 2,304 octets begins with an octet that no text contains; a larger one is
//!    believed only if there are control characters among its first octets, as there are in all binary data,
//! 5. what follows the first block is the end, a stray octet or two, zeros, or the header of another block (CAT not 0,
//!    LEN at least 3), of which the end may be missing. A block of 2,304 octets or more is believed only next to one of
//!    its own category: all but radar video (CAT240) keeps its blocks to the size of an Ethernet frame.

use std::io;

use super::beast;
use super::chain;
use super::raw::{self, HEADER};
use super::window::Window;
use super::{final_recording, framed, gzip, pcapng, tlog};
use crate::gateways::adsb::Framing;
use crate::hex;

/// The kind of a file.
#[derive(Debug)]
pub(super) enum Kind {
    Raw,
    Pcap,
    Pcapng,
    Final,
    Framed(framed::Framed),
    Receiver(Framing),
    Tlog,
    Gzip,
    Empty,
    Foreign { found: String, advice: &'static str },
}

impl Kind {
    /// The kind of what was found in a compressed file.
    pub(super) fn unpacked(self) -> Self {
        match self {
            Self::Foreign { found, advice } => {
                Self::Foreign { found: format!("{found}, gzip-compressed"), advice }
            }
            kind => kind,
        }
    }
}

/// Octets read for a magic number; few, since a pipe may not have more for a while.
const LONGEST_MAGIC: usize = 16;

/// Octets used to distinguish text from binary data.
const SAMPLE: usize = 512;

/// LEN from which a block is unusual, and the smallest that text could be taken for (a tab and a zero).
const LARGE: usize = 0x0900;

/// Category whose blocks are large.
const VIDEO: u8 = 240;

const WHAT_IS_READ: &str = "this program reads raw ASTERIX, pcap, pcapng, FINAL, ORADIS, Beast, AVR and MAVLink logs, also gzip-compressed";
const WITH_STAMPS: &str = "without them it is not known when a frame came; record Beast (usually port 30005), or AVR whose lines begin with @";
const PACKED: &str = "unpack it first";

/// Foreign formats by magic number, and what to do about them.
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

/// Looks at the first octets of a file without consuming any.
pub(super) fn recognise(window: &mut Window) -> io::Result<Kind> {
    if window.peek(1)?.is_empty() {
        return Ok(Kind::Empty);
    }
    let kind = by_content(window);
    if let Kind::Foreign { .. } = kind {
        // An error of reading comes first.
        window.failed()?;
    }
    Ok(kind)
}

fn by_content(window: &mut Window) -> Kind {
    let head = window.glimpse(LONGEST_MAGIC);
    if let [0xA1, 0xB2, 0xC3, 0xD4, ..]
    | [0xD4, 0xC3, 0xB2, 0xA1, ..]
    | [0xA1, 0xB2, 0x3C, 0x4D, ..]
    | [0x4D, 0x3C, 0xB2, 0xA1, ..] = head
    {
        return Kind::Pcap;
    }
    if head.starts_with(&pcapng::SECTION) {
        return Kind::Pcapng;
    }
    if head.starts_with(gzip::MAGIC) {
        return Kind::Gzip;
    }
    if head.first() == Some(&beast::ESCAPE)
        && beast::begins(Framing::Beast, window.glimpse(beast::SAMPLE)).is_some()
    {
        return Kind::Receiver(Framing::Beast);
    }
    if window.glimpse(1).first().is_some_and(|mark| beast::MARKS.contains(mark)) {
        match beast::begins(Framing::Avr, window.glimpse(beast::SAMPLE)) {
            Some(true) => return Kind::Receiver(Framing::Avr),
            Some(false) => {
                return Kind::Foreign { found: "AVR without time stamps".to_owned(), advice: WITH_STAMPS };
            }
            None => {}
        }
    }
    if tlog::begins(window) {
        return Kind::Tlog;
    }
    let head = window.glimpse(LONGEST_MAGIC);
    if let Some((_, found, advice)) = FOREIGN.iter().find(|(magic, ..)| head.starts_with(magic)) {
        return Kind::Foreign { found: (*found).to_owned(), advice };
    }
    if let Some(length) = final_record(window, 0) {
        let goes_on = window.glimpse(length + 1).len() == length || final_record(window, length).is_some();
        if goes_on || objection_to_raw(window).is_some() {
            return Kind::Final;
        }
    }
    if let Some(framed) = framed::recognise(window, framed::Framing::Oradis) {
        return Kind::Framed(framed);
    }
    let Some(objection) = objection_to_raw(window) else { return Kind::Raw };
    if let Some(framed) = framed::recognise(window, framed::Framing::Gps) {
        return Kind::Framed(framed);
    }
    let sample = window.glimpse(SAMPLE);
    let foreign = describe(&sample[..sample.len().min(SAMPLE)], &objection);
    if is_text(&sample[..sample.len().min(SAMPLE)]) {
        return foreign;
    }
    // Its first octets may be damaged.
    if final_recording::find(window, 1).is_some_and(|place| final_record(window, place).is_some()) {
        Kind::Final
    } else if chain::is_near(window) {
        Kind::Raw
    } else {
        foreign
    }
}

/// Octets of the FINAL record at `place`, if there is a whole one.
fn final_record(window: &mut Window, place: usize) -> Option<usize> {
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

/// Why this is not raw ASTERIX, as part of a sentence; `None` if it is.
fn objection_to_raw(window: &mut Window) -> Option<String> {
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

/// Whether the FSPEC at the front of these octets, of which the last bit extends it by another octet, announces an item. A
/// block without records does not say.
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

/// No control character but those of text, and either mostly ASCII or UTF-8 (the sample may end inside a character).
fn is_text(sample: &[u8]) -> bool {
    let control = |octet: &u8| octet.is_ascii_control() && !b"\t\n\x0C\r\x1B".contains(octet);
    let ascii = sample.iter().filter(|octet| octet.is_ascii()).count();
    let utf_8 = str::from_utf8(sample).map_or_else(|error| error.error_len().is_none(), |_| true);
    !sample.iter().any(control) && (utf_8 || ascii * 2 > sample.len())
}

fn describe(sample: &[u8], objection: &str) -> Kind {
    let found = if is_text(sample) {
        let text = sample.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(sample).trim_ascii_start();
        match text {
            // A `[` alone would take TOML for JSON.
            [b'{', ..] | [b'[', b'{' | b'\n' | b'\r', ..] => "JSON",
            [b'<', ..] => "XML or HTML",
            _ => "text",
        }
    } else {
        let first = hexadecimal(&sample[..sample.len().min(8)]);
        let found = format!("nothing known (first octets {first}; {objection})");
        return Kind::Foreign { found, advice: WHAT_IS_READ };
    };
    Kind::Foreign { found: found.to_owned(), advice: WHAT_IS_READ }
}

fn hexadecimal(octets: &[u8]) -> String {
    octets.chunks(1).map(hex::text).collect::<Vec<_>>().join(" ")
}
