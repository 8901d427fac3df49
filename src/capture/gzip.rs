//! gzip around a capture: unpacked as it is read.

use std::io::{self, ErrorKind, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use flate2::read::MultiGzDecoder;
use thiserror::Error;

/// What a compressed file begins with: the magic number, and the only method there is.
pub(super) const MAGIC: &[u8] = b"\x1F\x8B\x08";

/// Compressed data that cannot be unpacked to their end.
#[derive(Debug, Error)]
pub enum GzipError {
    /// They stop in the middle.
    #[error(
        "the gzip-compressed file ends too early (was a copy interrupted, is it still being written?); copy it again, \
         or read it once it is complete"
    )]
    Cut,
    /// They contradict themselves, a check sum does not hold, or something else follows them.
    #[error(
        "the gzip-compressed file is damaged, or goes on with something else ({0}); try `gzip -t`, copy it again"
    )]
    Corrupt(io::Error),
}

/// Octets unpacked at a time: so much of what is sound may be lost in front of damage.
const STEP: usize = 16 << 10;

/// Unpacks what a reader gives: one compressed file, or several one after the other.
pub(super) struct Gunzip(MultiGzDecoder<Counted>);

impl Gunzip {
    /// The unpacking reader, and the count of compressed octets that it has read.
    pub(super) fn new(reader: Box<dyn Read + Send>) -> (Self, Arc<AtomicU64>) {
        let count = Arc::new(AtomicU64::new(0));
        let counted = Counted { reader, count: Arc::clone(&count) };
        (Self(MultiGzDecoder::new(counted)), count)
    }
}

impl Read for Gunzip {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let most = buffer.len().min(STEP);
        self.0.read(&mut buffer[..most]).map_err(|error| match error.kind() {
            // What the system says comes with its number.
            _ if error.raw_os_error().is_some() => error,
            ErrorKind::UnexpectedEof => io::Error::new(ErrorKind::UnexpectedEof, GzipError::Cut),
            kind @ (ErrorKind::InvalidInput | ErrorKind::InvalidData) => {
                io::Error::new(kind, GzipError::Corrupt(error))
            }
            _ => error,
        })
    }
}

struct Counted {
    reader: Box<dyn Read + Send>,
    count: Arc<AtomicU64>,
}

impl Read for Counted {
    /// Interruptions stay in here: the decoder would take one in a header for the end of it.
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            match self.reader.read(buffer) {
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Ok(read) => {
                    self.count.fetch_add(read as u64, Ordering::Relaxed);
                    return Ok(read);
                }
                Err(error) => return Err(error),
            }
        }
    }
}
