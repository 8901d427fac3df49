//! Captures in: files and pipes become a stream of [`Datagram`]s, in the order of the file.
//!
//! | format | recognised by | one [`Datagram`] is | reception time |
//! |---|---|---|---|
//! | raw ASTERIX | a plausible first block (see `recognise.rs`) | one data block: CAT, LEN, records | none |
//! | pcap | `a1b2c3d4` or `a1b23c4d`, either byte order | the payload of one UDP datagram | of the capture |
//! | pcapng | `0a0d0d0a` | the payload of one UDP datagram | of the capture; none in a simple packet block |
//! | FINAL | a whole first record, with its `a5a5a5a5` at the end | the data of one record | time of day, without a day |
//! | pcap, pcapng of Wi-Fi or Bluetooth | their link types (see `link.rs`) | the Remote ID of one frame, as lines of a gateway | of the capture |
//! | ORADIS recording | records in a row whose blocks can be decoded | the blocks of one record | time of day, without a day |
//! | GPS recording (10 octets behind each block) | the same | one data block | none |
//! | Beast, AVR | four frames of a 1090 MHz receiver in a row | one position, as CAT021 | by its stamps, from the time in the file's name on |
//! | MAVLink log (`.tlog`) | four records in a row | one position, as CAT129 or CAT021, or a line of Remote ID | of the log |
//!
//! Each may be gzip-compressed (`1f8b08`); offsets are then those of the unpacked data. File names say nothing, but for the time of a Beast or AVR file. Memory is
//! bounded by one window over the file, and 64 datagrams that came in IP fragments and wait for the rest of them. Frames that hold no
//! whole datagram (ARP, TCP, …) are skipped and counted in
//! [`Skipped`]. Where octets of a file that holds nothing else than ASTERIX were lost, added or changed, reading resumes at the next
//! block or record; the octets between are [`Contents::Unframed`] and counted in [`Gaps`]. Other damage ends the capture
//! with a [`ReadError`] that says where. Broken blocks are for the decoder to report.
//!
//! A new format takes a file of its own, a line in `recognise.rs`, and a variant of [`Format`] and of `Reader`.

mod beast;
mod chain;
mod clock;
mod error;
mod final_recording;
mod fragments;
mod framed;
mod gaps;
mod gzip;
mod held;
mod link;
mod merge;
mod packet;
mod pcap;
mod pcapng;
mod raw;
mod receivers;
mod recognise;
mod skipped;
mod stamps;
mod tlog;
mod trailer;
mod tunnel;
mod window;

use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::gateways::adsb::Framing;
use fusion::time::Time;
use gzip::Gunzip;
use held::Held;
use recognise::Kind;
use window::Window;

pub use error::{Damage, OpenError, ReadError};
pub(crate) use framed::oradis_blocks;
pub use gaps::Gaps;
pub use gzip::GzipError;
pub use link::{Endpoints, LinkType};
pub use merge::{Merged, Reception, ReceptionKind};
pub use pcap::Resolution;
pub use receivers::Receivers;
pub use skipped::{SkipReason, Skipped};
pub use stamps::Stamps;
pub(crate) use trailer::{Ending, Trailers};
pub use trailer::{Trailer, TrailerRules};

/// One UDP datagram or radio frame of a capture, one record of a FINAL recording, or one data block of a raw file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Datagram {
    /// Time of reception; `None` in a file without reception times.
    pub received: Option<Time>,
    /// Time of reception in a file that has no date (FINAL, ORADIS, 1090 MHz frames): nanoseconds after midnight. `None`
    /// elsewhere, and where it is 24 h or more.
    pub since_midnight: Option<i64>,
    /// Sender and receiver; `None` in a file without addresses.
    pub endpoints: Option<Endpoints>,
    /// Offset of the payload's first octet in the (unpacked) file.
    pub origin: u64,
    /// UDP payload without padding, at most 65,535 octets. In a raw file one block with its CAT and LEN; the last one may be
    /// the remainder behind the last whole block.
    pub payload: Vec<u8>,
    /// Whether the payload is to be read as blocks.
    pub contents: Contents,
    /// The sender's trailer behind the blocks.
    pub trailer: Vec<u8>,
    /// From how many IP fragments it was put together; 0: from none. Only what was in the first one lies at `origin`.
    pub fragments: u32,
}

impl Datagram {
    /// Whether it may hold something else than ASTERIX: of a file that holds nothing else it does not, whatever it looks like
    /// where that is damaged.
    pub fn may_be_remote_id(&self) -> bool {
        self.endpoints.is_some() || self.contents == Contents::Translated
    }
}

/// What a payload is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Contents {
    /// Data blocks, one after the other.
    #[default]
    Blocks,
    /// Octets of a damaged file that belong to no block, record or frame; a long stretch comes in parts.
    Unframed,
    /// A datagram that a translator of [`crate::gateways`] made of the frame at its origin.
    Translated,
}

/// The format of a capture. `Display`: `pcap (Ethernet, nanoseconds)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Concatenated ASTERIX data blocks, nothing else.
    Raw,
    /// Classic pcap.
    Pcap {
        /// Link type of every frame.
        link: LinkType,
        /// Unit of the fraction in its time stamps.
        resolution: Resolution,
    },
    /// pcapng; link types and units of time may change within the file.
    Pcapng,
    /// FINAL recording.
    Final,
    /// ORADIS recording.
    Oradis,
    /// Blocks, each with 10 octets behind it.
    Gps,
    /// Frames of a 1090 MHz receiver, binary.
    Beast,
    /// Frames of a 1090 MHz receiver, as text.
    Avr,
    /// MAVLink telemetry log.
    Tlog,
}

impl Format {
    /// Whether the file holds nothing but ASTERIX, so that unreadable octets are damage. (A network capture may hold anything.)
    pub fn is_asterix_only(&self) -> bool {
        matches!(self, Self::Raw | Self::Final | Self::Oradis | Self::Gps)
    }

    /// The records that its frames are translated to, if it holds no ASTERIX.
    pub fn translation(&self) -> Option<&'static str> {
        match self {
            Self::Beast | Self::Avr => Some("CAT021"),
            Self::Tlog => Some("CAT129, CAT021 and lines of Remote ID"),
            Self::Raw | Self::Final | Self::Oradis | Self::Gps | Self::Pcap { .. } | Self::Pcapng => None,
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Raw => f.write_str("raw ASTERIX"),
            Self::Pcap { link, resolution } => write!(f, "pcap ({link}, {resolution})"),
            Self::Pcapng => f.write_str("pcapng"),
            Self::Final => f.write_str("FINAL recording"),
            Self::Oradis => f.write_str("ORADIS recording"),
            Self::Gps => f.write_str("GPS recording (10 octets behind each block)"),
            Self::Beast => f.write_str("Beast (1090 MHz)"),
            Self::Avr => f.write_str("AVR (1090 MHz)"),
            Self::Tlog => f.write_str("MAVLink log"),
        }
    }
}

/// An open capture: iterate over it to get its datagrams. After an error the iteration is over.
pub struct Capture {
    name: String,
    size: Option<u64>,
    format: Format,
    /// Octets read of a compressed file.
    packed: Option<Arc<AtomicU64>>,
    window: Window,
    reader: Reader,
    skipped: Skipped,
    gaps: Gaps,
    held: Held,
    /// Whether the end, or damage, was reached.
    ended: bool,
    /// The damage that ended it, until it is reported.
    damage: Option<ReadError>,
}

enum Reader {
    Raw(raw::Raw),
    Pcap(pcap::Pcap),
    Pcapng(pcapng::Pcapng),
    Final(final_recording::Recording),
    Framed(framed::Framed),
    Beast(Box<beast::Beast>),
    Tlog(tlog::Tlog),
}

impl Capture {
    /// Opens the file at `path`; `-` is standard input.
    ///
    /// # Errors
    /// The file cannot be opened or read, is empty, or is nothing this program reads; the message says what it is.
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        if path == Path::new("-") {
            return Self::from_reader("standard input".to_owned(), Box::new(io::stdin()), None);
        }
        let name = path.display().to_string();
        let cannot = |cause| OpenError::Open { name: name.clone(), cause };
        #[expect(clippy::disallowed_methods, reason = "this is the place where captures are opened")]
        let file = File::open(path).map_err(cannot)?;
        let metadata = file.metadata().map_err(cannot)?;
        if metadata.is_dir() {
            return Err(OpenError::Directory { name });
        }
        // A pipe or a device has no size to show progress against.
        let size = metadata.is_file().then_some(metadata.len());
        Self::from_reader(name, Box::new(file), size)
    }

    /// Reads a capture from any reader, which needs no buffer. `name` appears in messages; `size`, in octets, is returned by
    /// [`Capture::size`].
    ///
    /// # Errors
    /// As [`Capture::open`].
    pub fn from_reader(
        name: String,
        reader: Box<dyn Read + Send>,
        size: Option<u64>,
    ) -> Result<Self, OpenError> {
        let mut window = Window::new(reader);
        let mut kind = recognise::recognise(&mut window);
        let mut packed = None;
        if let Ok(Kind::Gzip) = kind {
            let (gunzip, count) = Gunzip::new(window.into_reader());
            window = Window::new(Box::new(gunzip));
            kind = recognise::recognise(&mut window).map(Kind::unpacked);
            packed = Some(count);
        }
        let (format, reader) = match kind {
            Ok(Kind::Raw) => (Format::Raw, Reader::Raw(raw::Raw::default())),
            Ok(Kind::Pcap) => {
                let pcap = pcap::Pcap::open(&name, &mut window)?;
                (Format::Pcap { link: pcap.link(), resolution: pcap.resolution() }, Reader::Pcap(pcap))
            }
            Ok(Kind::Pcapng) => (Format::Pcapng, Reader::Pcapng(pcapng::Pcapng::default())),
            Ok(Kind::Final) => (Format::Final, Reader::Final(final_recording::Recording::default())),
            Ok(Kind::Framed(framed)) => {
                let format = match framed.framing() {
                    framed::Framing::Oradis => Format::Oradis,
                    framed::Framing::Gps => Format::Gps,
                };
                (format, Reader::Framed(framed))
            }
            Ok(Kind::Receiver(framing)) => {
                let format = if framing == Framing::Beast { Format::Beast } else { Format::Avr };
                (format, Reader::Beast(Box::new(beast::Beast::open(&name, framing))))
            }
            Ok(Kind::Tlog) => (Format::Tlog, Reader::Tlog(tlog::Tlog::open(&Receivers::default()))),
            Ok(Kind::Gzip) => return Err(OpenError::GzipInGzip { name }),
            Ok(Kind::Empty) => return Err(OpenError::Empty { name }),
            Ok(Kind::Foreign { found, advice }) => return Err(OpenError::Foreign { name, found, advice }),
            Err(cause) => return Err(OpenError::Read { name, cause }),
        };
        Ok(Self {
            name,
            size,
            format,
            packed,
            window,
            reader,
            skipped: Skipped::default(),
            gaps: Gaps::default(),
            held: Held::default(),
            ended: false,
            damage: None,
        })
    }

    /// Name in messages: its path, or `standard input`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether its days are known: from the capture, or from the name of a Beast or AVR file.
    pub fn is_dated(&self) -> bool {
        match &self.reader {
            Reader::Raw(_) | Reader::Final(_) | Reader::Framed(_) => false,
            Reader::Beast(beast) => beast.is_dated(),
            Reader::Pcap(_) | Reader::Pcapng(_) | Reader::Tlog(_) => true,
        }
    }

    /// The recognised format.
    pub fn format(&self) -> &Format {
        &self.format
    }

    /// Whether it is gzip-compressed around its format. Offsets are those of the unpacked data.
    pub fn is_compressed(&self) -> bool {
        self.packed.is_some()
    }

    /// Size of the file in octets, compressed if it is; `None` for standard input and pipes.
    pub fn size(&self) -> Option<u64> {
        self.size
    }

    /// Octets of the file consumed so far (read, of a compressed one), for a progress bar. Less than the size at the end
    /// only if damage ended the capture.
    pub fn consumed(&self) -> u64 {
        self.packed.as_ref().map_or(self.window.position(), |count| count.load(Ordering::Relaxed))
    }

    /// Sets the configured trailers, before the first datagram; others are recognised.
    #[must_use]
    pub fn with_trailers(mut self, rules: TrailerRules) -> Self {
        self.held = Held::new(rules);
        self
    }

    /// States the site's receivers, before the first datagram, by which a file of another format than ASTERIX is translated.
    #[must_use]
    pub fn with_receivers(mut self, receivers: &Receivers) -> Self {
        match &mut self.reader {
            Reader::Beast(beast) => beast.set_receivers(receivers),
            Reader::Tlog(tlog) => *tlog = tlog::Tlog::open(receivers),
            Reader::Raw(_) | Reader::Pcap(_) | Reader::Pcapng(_) | Reader::Final(_) | Reader::Framed(_) => {}
        }
        self
    }

    /// The streams with a trailer so far.
    pub fn trailers(&self) -> impl Iterator<Item = Trailer> {
        self.held.trailers.all()
    }

    /// Octets handed out so far that belong to no block or record ([`Contents::Unframed`]).
    pub fn gaps(&self) -> &Gaps {
        &self.gaps
    }

    /// Frames without a whole UDP datagram so far.
    pub fn skipped(&self) -> &Skipped {
        &self.skipped
    }
}

impl Iterator for Capture {
    type Item = Result<Datagram, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        let next = loop {
            if self.ended || self.held.is_ready() {
                break self.held.pop();
            }
            if let Some(block) = self.read() {
                break Some(block);
            }
        };
        match next {
            Some(datagram) => {
                if datagram.contents == Contents::Unframed {
                    self.gaps.add(datagram.origin, datagram.payload.len());
                }
                Some(Ok(datagram))
            }
            None => self.damage.take().map(Err),
        }
    }
}

impl Capture {
    /// Reads the next datagram. Blocks of files without other octets, and translated positions, are returned; all else is held
    /// until trailers are decided.
    fn read(&mut self) -> Option<Datagram> {
        let next = match &mut self.reader {
            Reader::Raw(raw) => raw.next(&mut self.window),
            Reader::Pcap(pcap) => pcap.next(&mut self.window, &mut self.skipped),
            Reader::Pcapng(pcapng) => pcapng.next(&mut self.window, &mut self.skipped),
            Reader::Final(recording) => recording.next(&mut self.window),
            Reader::Framed(framed) => framed.next(&mut self.window),
            Reader::Beast(beast) => beast.next(&mut self.window, &mut self.skipped),
            Reader::Tlog(tlog) => tlog.next(&mut self.window, &mut self.skipped),
        };
        let is_held = matches!(self.reader, Reader::Pcap(_) | Reader::Pcapng(_) | Reader::Final(_));
        match next {
            Ok(Some(block)) if !is_held => return Some(block),
            Ok(Some(datagram)) => {
                framed::unwrapped(datagram).into_iter().for_each(|part| self.held.take(part));
            }
            Ok(None) => self.ended = true,
            Err(damage) => {
                self.ended = true;
                let unpacked = if self.is_compressed() { ", unpacked" } else { "" };
                let name = format!("{}{unpacked}", self.name);
                self.damage = Some(ReadError { name, offset: self.window.position(), damage });
            }
        }
        if self.ended {
            self.held.release();
        }
        None
    }
}

impl fmt::Debug for Capture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Capture")
            .field("name", &self.name)
            .field("format", &self.format)
            .field("consumed", &self.consumed())
            .finish_non_exhaustive()
    }
}
