//! Captures: files and pipes become a stream of [`CapturedDatagram`]s, in the order of the file.
//!
//! | format | recognised by | one [`CapturedDatagram`] is | reception time |
//! |---|---|---|---|
//! | raw ASTERIX | a plausible first block (see `recognise.rs`) | one data block: CAT, LEN, records | none |
//! | pcap | `a1b2c3d4` or `a1b23c4d`, either byte order | the payload of one UDP datagram | of the capture |
//! | pcapng | `0a0d0d0a` | the payload of one UDP datagram | of the capture; none in a simple packet block |
//! | FINAL | a whole first record, with its `a5a5a5a5` at the end | the data of one record | time of day, without a day |
//! | pcap, pcapng of Wi-Fi or Bluetooth | their link types (see `link.rs`) | the Remote ID of one frame, as lines of a gateway | of the capture |
//! | ORADIS recording | consecutive records whose blocks can be decoded | the blocks of one record | time of day, without a day |
//! | GPS recording (10 octets after each block) | consecutive records whose blocks can be decoded | one data block | none |
//! | Beast, AVR | four consecutive frames of a 1090 MHz receiver | one position, as CAT021 | by its stamps, starting at the time in the file's name |
//! | MAVLink log (`.tlog`) | four consecutive records | one position, as CAT129 or CAT021, or a line of Remote ID | of the log |
//!
//! Each format may be gzip-compressed (`1f8b08`); offsets are then those of the unpacked data. File names are not used,
//! except for the start of a Beast or AVR file. Memory is bounded by one window over the file, and 64 datagrams waiting for
//! IP fragments. Frames without a whole datagram (ARP, TCP, …) are skipped and counted in [`SkippedFrames`]. If octets of a file
//! with only ASTERIX were lost, added or changed, reading resumes at the next block or record; the octets between are
//! [`PayloadKind::Unframed`] and counted in [`Gaps`]. Other damage ends the capture with a [`ReadError`] that states its
//! offset. Broken blocks are reported by the decoder.
//!
//! A new format needs its own file, a line in `recognise.rs`, and a variant of [`CaptureFormat`] and of `CaptureReader`.

mod beast;
mod chain;
mod clock;
mod error;
mod final_recording;
mod fragments;
mod framed;
mod gaps;
mod gzip;
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
mod trailer_buffer;
mod tunnel;
mod window;

use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::gateways::adsb::ReceiverFraming;
use fusion::time::Time;
use gzip::Gunzip;
use recognise::RecognisedKind;
use trailer_buffer::TrailerBuffer;
use window::ReadWindow;

pub use error::{Damage, OpenError, ReadError};
pub use framed::oradis_blocks;
pub use gaps::Gaps;
pub use gzip::GzipError;
pub use link::{Endpoints, LinkType};
pub use merge::{MergedCaptures, Reception, ReceptionKind};
pub use pcap::Resolution;
pub use receivers::SiteReceivers;
pub use skipped::{SkipReason, SkippedFrames};
pub use stamps::StampKind;
pub use trailer::{Ending, Trailers};
pub use trailer::{Trailer, TrailerRules};

/// One UDP datagram or radio frame of a capture, one record of a FINAL recording, or one data block of a raw file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CapturedDatagram {
    /// Time of reception; `None` in a file without reception times.
    pub received: Option<Time>,
    /// Time of reception in a file without dates (FINAL, ORADIS, 1090 MHz frames), in nanoseconds since midnight. `None` in
    /// other files, and if it is 24 h or more.
    pub since_midnight: Option<i64>,
    /// Sender and receiver; `None` in a file without addresses.
    pub endpoints: Option<Endpoints>,
    /// Offset of the payload's first octet in the (unpacked) file.
    pub origin: u64,
    /// UDP payload without padding, at most 65,535 octets. In a raw file, one block with its CAT and LEN; the last one may
    /// be the remainder after the last whole block.
    pub payload: Vec<u8>,
    /// Whether the payload is to be read as blocks.
    pub contents: PayloadKind,
    /// The sender's trailer behind the blocks.
    pub trailer: Vec<u8>,
    /// Number of IP fragments from which it was assembled; 0 if not fragmented. Only the data of the first one is at
    /// `origin`.
    pub fragments: u32,
}

impl CapturedDatagram {
    /// Whether it may hold data other than ASTERIX. Data of an ASTERIX-only file never does, whatever it looks like after
    /// damage.
    pub fn may_be_remote_id(&self) -> bool {
        self.endpoints.is_some() || self.contents == PayloadKind::Translated
    }
}

/// Kind of a payload.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PayloadKind {
    /// Consecutive data blocks.
    #[default]
    Blocks,
    /// Octets of a damaged file that belong to no block, record or frame; a long stretch is split.
    Unframed,
    /// A datagram that a translator of [`crate::gateways`] made from the frame at its origin.
    Translated,
}

/// The format of a capture. `Display`: `pcap (Ethernet, nanoseconds)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaptureFormat {
    /// Concatenated ASTERIX data blocks only.
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
    /// Blocks, each followed by 10 octets.
    Gps,
    /// Frames of a 1090 MHz receiver, binary.
    Beast,
    /// Frames of a 1090 MHz receiver, as text.
    Avr,
    /// MAVLink telemetry log.
    Tlog,
}

impl CaptureFormat {
    /// Whether the file holds only ASTERIX, so that unreadable octets are damage. (A network capture may hold other
    /// traffic.)
    pub fn is_asterix_only(&self) -> bool {
        matches!(self, Self::Raw | Self::Final | Self::Oradis | Self::Gps)
    }

    /// Records to which its frames are translated, if it holds no ASTERIX.
    pub fn translation(&self) -> Option<&'static str> {
        match self {
            Self::Beast | Self::Avr => Some("CAT021"),
            Self::Tlog => Some("CAT129, CAT021 and lines of Remote ID"),
            Self::Raw | Self::Final | Self::Oradis | Self::Gps | Self::Pcap { .. } | Self::Pcapng => None,
        }
    }
}

impl fmt::Display for CaptureFormat {
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

/// An open capture; iterate over it to get its datagrams. The iteration ends after an error.
pub struct Capture {
    name: String,
    size: Option<u64>,
    format: CaptureFormat,
    /// Number of octets read from a compressed file.
    packed: Option<Arc<AtomicU64>>,
    window: ReadWindow,
    reader: CaptureReader,
    skipped: SkippedFrames,
    gaps: Gaps,
    held: TrailerBuffer,
    /// Whether the end, or damage, was reached.
    ended: bool,
    /// The damage that ended the capture, until it is reported.
    damage: Option<ReadError>,
}

enum CaptureReader {
    Raw(raw::RawReader),
    Pcap(pcap::Pcap),
    Pcapng(pcapng::Pcapng),
    Final(final_recording::FinalRecording),
    Framed(framed::Framed),
    Beast(Box<beast::Beast>),
    Tlog(tlog::Tlog),
}

impl Capture {
    /// Opens the file at `path`; `-` is standard input.
    ///
    /// # Errors
    /// The file cannot be opened or read, is empty, or has an unsupported format; the message names the format.
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
        // A pipe or a device has no size for a progress bar.
        let size = metadata.is_file().then_some(metadata.len());
        Self::from_reader(name, Box::new(file), size)
    }

    /// Reads a capture from any reader, which needs no buffer. `name` appears in messages; `size`, in octets, is returned
    /// by [`Capture::size`].
    ///
    /// # Errors
    /// As for [`Capture::open`].
    pub fn from_reader(
        name: String,
        reader: Box<dyn Read + Send>,
        size: Option<u64>,
    ) -> Result<Self, OpenError> {
        let mut window = ReadWindow::new(reader);
        let mut kind = recognise::recognise(&mut window);
        let mut packed = None;
        if let Ok(RecognisedKind::Gzip) = kind {
            let (gunzip, count) = Gunzip::new(window.into_reader());
            window = ReadWindow::new(Box::new(gunzip));
            kind = recognise::recognise(&mut window).map(RecognisedKind::unpacked);
            packed = Some(count);
        }
        let (format, reader) = match kind {
            Ok(RecognisedKind::Raw) => (CaptureFormat::Raw, CaptureReader::Raw(raw::RawReader::default())),
            Ok(RecognisedKind::Pcap) => {
                let pcap = pcap::Pcap::open(&name, &mut window)?;
                (
                    CaptureFormat::Pcap { link: pcap.link(), resolution: pcap.resolution() },
                    CaptureReader::Pcap(pcap),
                )
            }
            Ok(RecognisedKind::Pcapng) => {
                (CaptureFormat::Pcapng, CaptureReader::Pcapng(pcapng::Pcapng::default()))
            }
            Ok(RecognisedKind::Final) => {
                (CaptureFormat::Final, CaptureReader::Final(final_recording::FinalRecording::default()))
            }
            Ok(RecognisedKind::Framed(framed)) => {
                let format = match framed.framing() {
                    framed::RecorderFraming::Oradis => CaptureFormat::Oradis,
                    framed::RecorderFraming::Gps => CaptureFormat::Gps,
                };
                (format, CaptureReader::Framed(framed))
            }
            Ok(RecognisedKind::Receiver(framing)) => {
                let format =
                    if framing == ReceiverFraming::Beast { CaptureFormat::Beast } else { CaptureFormat::Avr };
                (format, CaptureReader::Beast(Box::new(beast::Beast::open(&name, framing))))
            }
            Ok(RecognisedKind::Tlog) => {
                (CaptureFormat::Tlog, CaptureReader::Tlog(tlog::Tlog::open(&SiteReceivers::default())))
            }
            Ok(RecognisedKind::Gzip) => return Err(OpenError::GzipInGzip { name }),
            Ok(RecognisedKind::Empty) => return Err(OpenError::Empty { name }),
            Ok(RecognisedKind::Foreign { found, advice }) => {
                return Err(OpenError::Foreign { name, found, advice });
            }
            Err(cause) => return Err(OpenError::Read { name, cause }),
        };
        Ok(Self {
            name,
            size,
            format,
            packed,
            window,
            reader,
            skipped: SkippedFrames::default(),
            gaps: Gaps::default(),
            held: TrailerBuffer::default(),
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
            CaptureReader::Raw(_) | CaptureReader::Final(_) | CaptureReader::Framed(_) => false,
            CaptureReader::Beast(beast) => beast.is_dated(),
            CaptureReader::Pcap(_) | CaptureReader::Pcapng(_) | CaptureReader::Tlog(_) => true,
        }
    }

    /// The recognised format.
    pub fn format(&self) -> &CaptureFormat {
        &self.format
    }

    /// Whether it is gzip-compressed. Offsets are those of the unpacked data.
    pub fn is_compressed(&self) -> bool {
        self.packed.is_some()
    }

    /// Size of the file in octets, compressed if it is; `None` for standard input and pipes.
    pub fn size(&self) -> Option<u64> {
        self.size
    }

    /// Octets of the file consumed so far (of a compressed one: read), for a progress bar. Less than the size at the end
    /// only if damage ended the capture.
    pub fn consumed(&self) -> u64 {
        self.packed.as_ref().map_or(self.window.position(), |count| count.load(Ordering::Relaxed))
    }

    /// Sets the configured trailers; to be called before the first datagram. Others are recognised.
    #[must_use]
    pub fn with_trailers(mut self, rules: TrailerRules) -> Self {
        self.held = TrailerBuffer::new(rules);
        self
    }

    /// Sets the site's receivers, by which a format other than ASTERIX is translated; to be called before the first
    /// datagram.
    #[must_use]
    pub fn with_receivers(mut self, receivers: &SiteReceivers) -> Self {
        match &mut self.reader {
            CaptureReader::Beast(beast) => beast.set_receivers(receivers),
            CaptureReader::Tlog(tlog) => *tlog = tlog::Tlog::open(receivers),
            CaptureReader::Raw(_)
            | CaptureReader::Pcap(_)
            | CaptureReader::Pcapng(_)
            | CaptureReader::Final(_)
            | CaptureReader::Framed(_) => {}
        }
        self
    }

    /// The streams with a trailer so far.
    pub fn trailers(&self) -> impl Iterator<Item = Trailer> {
        self.held.trailers.all()
    }

    /// Octets returned so far that belong to no block or record ([`PayloadKind::Unframed`]).
    pub fn gaps(&self) -> &Gaps {
        &self.gaps
    }

    /// Frames so far without a whole UDP datagram.
    pub fn skipped(&self) -> &SkippedFrames {
        &self.skipped
    }
}

impl Iterator for Capture {
    type Item = Result<CapturedDatagram, ReadError>;

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
                if datagram.contents == PayloadKind::Unframed {
                    self.gaps.add(datagram.origin, datagram.payload.len());
                }
                Some(Ok(datagram))
            }
            None => self.damage.take().map(Err),
        }
    }
}

impl Capture {
    /// Reads the next datagram. Blocks of files without other octets, and translated positions, are returned; all others
    /// are held until trailers are decided.
    fn read(&mut self) -> Option<CapturedDatagram> {
        let next = match &mut self.reader {
            CaptureReader::Raw(raw) => raw.next(&mut self.window),
            CaptureReader::Pcap(pcap) => pcap.next(&mut self.window, &mut self.skipped),
            CaptureReader::Pcapng(pcapng) => pcapng.next(&mut self.window, &mut self.skipped),
            CaptureReader::Final(recording) => recording.next(&mut self.window),
            CaptureReader::Framed(framed) => framed.next(&mut self.window),
            CaptureReader::Beast(beast) => beast.next(&mut self.window, &mut self.skipped),
            CaptureReader::Tlog(tlog) => tlog.next(&mut self.window, &mut self.skipped),
        };
        let is_held = matches!(
            self.reader,
            CaptureReader::Pcap(_) | CaptureReader::Pcapng(_) | CaptureReader::Final(_)
        );
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
