//! Errors of a capture. Each message states the place and what to do.
//!
//! Messages include their cause, so that one line in a log is enough.

use std::io;

use thiserror::Error;

use super::gzip::GzipError;

/// A capture that cannot be read.
#[derive(Debug, Error)]
pub enum OpenError {
    /// The file cannot be opened: it is missing, permission is denied, …
    #[error("{name}: cannot be opened: {cause}; check the path and its permissions")]
    Open {
        /// Its path.
        name: String,
        /// Error of the system.
        cause: io::Error,
    },
    /// A directory where a file is expected.
    #[error("{name}: is a directory; give the capture files in it, one by one")]
    Directory {
        /// Its path.
        name: String,
    },
    /// The first octets cannot be read.
    #[error("{name}: cannot be read: {cause}")]
    Read {
        /// Its path.
        name: String,
        /// Error of the system.
        cause: io::Error,
    },
    /// The file is empty.
    #[error("{name}: is empty; did the recording start, was the disk full?")]
    Empty {
        /// Its path.
        name: String,
    },
    /// A format that is not supported.
    #[error("{name}: is not a capture: it looks like {found}; {advice}")]
    Foreign {
        /// Its path.
        name: String,
        /// Probable format, or its first octets in hexadecimal.
        found: String,
        /// Advice for the operator.
        advice: &'static str,
    },
    /// The file is compressed twice.
    #[error("{name}: is gzip-compressed twice; unpack it once: gunzip")]
    GzipInGzip {
        /// Its path.
        name: String,
    },
    /// A pcap that ends inside its file header.
    #[error("{name}: is a pcap of {octets} octets, cut inside its file header of 24; nothing can be saved")]
    HeaderCut {
        /// Its path.
        name: String,
        /// Its size.
        octets: usize,
    },
    /// A pcap of an unsupported link type.
    #[error("{name}: is a pcap of link type {number} ({link}), which cannot be read; {advice}")]
    LinkType {
        /// Its path.
        name: String,
        /// The number in the file header.
        number: u16,
        /// Its usual name, or `unknown`.
        link: &'static str,
        /// Advice for the operator.
        advice: &'static str,
    },
}

/// Damage that ends a capture; everything before it was read.
#[derive(Debug, Error)]
#[error("{name}: at offset {offset}: {damage}")]
pub struct ReadError {
    /// Path of the capture, marked if the offset is that of its unpacked data.
    pub name: String,
    /// Offset in the file of the record that could not be read.
    pub offset: u64,
    /// The damage.
    pub damage: Damage,
}

/// Damage at the offset of a [`ReadError`].
#[derive(Debug, Error)]
pub enum Damage {
    /// The system reports an error.
    #[error("cannot be read further: {0}; check the disk or the connection and try again")]
    Io(io::Error),
    /// A compressed file cannot be unpacked to its end.
    #[error("cannot be read further: {0}; all records before it were read")]
    Gzip(GzipError),
    /// The file ends inside a record.
    #[error(
        "the file ends in the middle of a {record} ({present} of {needed} octets); the recording was cut off \
         (process killed, disk full, or still being written?), all records before it are complete and were read"
    )]
    Cut {
        /// Name of the record in its format.
        record: &'static str,
        /// Octets of the record that are present, its header included.
        present: usize,
        /// Octets that it needs; at least the size of its header.
        needed: usize,
    },
    /// A record longer than any frame: the file is damaged, or an earlier length was wrong.
    #[error(
        "a {record} claims {length} octets (at most {most} are possible); the file is damaged from here on, all \
         records before it were read; copy it again from where it was recorded"
    )]
    Absurd {
        /// Name of the record in its format.
        record: &'static str,
        /// Length stated by its header, in octets.
        length: usize,
        /// The limit.
        most: usize,
    },
    /// A record that contradicts itself, so that the next one cannot be found.
    #[error(
        "a {record} {fault}; the file is damaged from here on, all records before it were read; copy it again from \
         where it was recorded"
    )]
    Garbled {
        /// Name of the record in its format.
        record: &'static str,
        /// The fault, as the rest of a sentence.
        fault: String,
    },
}

impl From<io::Error> for Damage {
    fn from(error: io::Error) -> Self {
        error.downcast().map_or_else(Self::Io, Self::Gzip)
    }
}
