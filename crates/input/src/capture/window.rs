//! A window that slides over a reader: the only buffer between a file and its datagrams.

use std::io::{self, Cursor, ErrorKind, Read};

/// Size in octets: more than the longest pcap record and the longest ASTERIX block.
pub(super) const CAPACITY: usize = 512 * 1024;

/// Shows the next octets of a reader before they are consumed.
///
/// It reads no further than needed, except for what one `read` happens to return, so a slow pipe is served as it delivers.
pub(super) struct ReadWindow {
    reader: Box<dyn Read + Send>,
    buffer: Box<[u8]>,
    start: usize,
    end: usize,
    position: u64,
    /// Octets after the position that were already released.
    passed: u64,
    /// The error that ended reading, until it is reported.
    failure: Option<io::Error>,
    at_end: bool,
}

impl ReadWindow {
    pub(super) fn new(reader: Box<dyn Read + Send>) -> Self {
        let buffer = vec![0; CAPACITY].into_boxed_slice();
        Self { reader, buffer, start: 0, end: 0, position: 0, passed: 0, failure: None, at_end: false }
    }

    /// The next octets: at least `count` of them (at most [`CAPACITY`]), fewer only at the end of the file.
    ///
    /// An error of the reader is returned when more octets are requested than were read before it.
    pub(super) fn peek(&mut self, count: usize) -> io::Result<&[u8]> {
        if self.glimpse(count).len() < count {
            self.failed()?;
        }
        Ok(&self.buffer[self.start..self.end])
    }

    /// Like [`peek`](Self::peek), but an error of the reader looks like the end of the file and is kept for later.
    pub(super) fn glimpse(&mut self, count: usize) -> &[u8] {
        debug_assert!(count <= CAPACITY, "callers bound what they ask for");
        if self.start + count > CAPACITY {
            self.buffer.copy_within(self.start..self.end, 0);
            self.end -= self.start;
            self.start = 0;
        }
        while self.end - self.start < count && !self.at_end {
            match self.reader.read(&mut self.buffer[self.end..]) {
                // Remembered, because a terminal would continue after its end of file, with wrong offsets.
                Ok(0) => self.at_end = true,
                Ok(read) => self.end += read,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => {
                    self.failure = Some(error);
                    self.at_end = true;
                }
            }
        }
        &self.buffer[self.start..self.end]
    }

    /// The error that ended reading, if it has not been reported.
    pub(super) fn failed(&mut self) -> io::Result<()> {
        self.failure.take().map_or(Ok(()), Err)
    }

    /// Consumes the next `count` octets, which `peek` has shown.
    pub(super) fn consume(&mut self, count: usize) {
        self.pass(count);
        self.position += self.passed;
        self.passed = 0;
    }

    /// Releases the next `count` octets, which `peek` has shown, without moving the position. For a record longer than the
    /// window, the position stays at its beginning until the rest is consumed.
    pub(super) fn pass(&mut self, count: usize) {
        debug_assert!(count <= self.end - self.start, "only what was shown can be consumed");
        self.start += count;
        self.passed += count as u64;
    }

    /// Offset in the file of the next octet.
    pub(super) fn position(&self) -> u64 {
        self.position
    }

    /// The reader with the shown octets put back. No octets may have been consumed.
    pub(super) fn into_reader(self) -> Box<dyn Read + Send> {
        debug_assert!(self.position == 0, "what was consumed cannot be read again");
        let shown = self.buffer[self.start..self.end].to_vec();
        Box::new(Cursor::new(shown).chain(self.reader))
    }
}
