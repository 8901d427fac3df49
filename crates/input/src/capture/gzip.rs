//! gzip around a capture, unpacked while it is read.

use std::io::{self, ErrorKind, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use flate2::read::MultiGzDecoder;
use thiserror::Error;

/// The magic number, and the only compression method there is.
pub(super) const MAGIC: &[u8] = b"\x1F\x8B\x08";

/// Compressed data that cannot be unpacked to the end.
#[derive(Debug, Error)]
pub enum GzipError {
    /// The data ends early.
    #[error(
        "the gzip-compressed file ends too early (was a copy interrupted, is it still being written?); copy it again, \
         or read it once it is complete"
    )]
    Cut,
    /// The data is inconsistent, a checksum fails, or other data follows.
    #[error(
        "the gzip-compressed file is damaged, or goes on with something else ({0}); try `gzip -t`, copy it again"
    )]
    Corrupt(io::Error),
}

/// Number of octets unpacked at a time; up to this much sound data may be lost before damage.
const STEP: usize = 16 << 10;

/// Unpacks one compressed file, or several concatenated ones.
pub(super) struct Gunzip(MultiGzDecoder<CountingReader>);

impl Gunzip {
    /// The unpacking reader, and the count of compressed octets that it has read.
    pub(super) fn new(reader: Box<dyn Read + Send>) -> (Self, Arc<AtomicU64>) {
        let count = Arc::new(AtomicU64::new(0));
        let counted = CountingReader { reader, count: Arc::clone(&count) };
        (Self(MultiGzDecoder::new(counted)), count)
    }
}

impl Read for Gunzip {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let most = buffer.len().min(STEP);
        self.0.read(&mut buffer[..most]).map_err(|error| match error.kind() {
            // An error of the system has a number.
            _ if error.raw_os_error().is_some() => error,
            ErrorKind::UnexpectedEof => io::Error::new(ErrorKind::UnexpectedEof, GzipError::Cut),
            kind @ (ErrorKind::InvalidInput | ErrorKind::InvalidData) => {
                io::Error::new(kind, GzipError::Corrupt(error))
            }
            _ => error,
        })
    }
}

struct CountingReader {
    reader: Box<dyn Read + Send>,
    count: Arc<AtomicU64>,
}

impl Read for CountingReader {
    /// Retries interrupted reads, which the decoder would take for the end within a header.
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
