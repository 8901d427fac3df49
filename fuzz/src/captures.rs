//! Random octets as a capture file.

use std::io::{self, Cursor, Read};

use utm_fusion::capture::{Capture, CapturedDatagram, PayloadKind};

/// A reader that returns a few octets at a time, as a pipe may.
struct Trickle(Cursor<Vec<u8>>);

impl Read for Trickle {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let most = buffer.len().min(7);
        self.0.read(&mut buffer[..most])
    }
}

/// Reads the capture at once and in small parts, with equal results. Checks that payloads are at their origin and in order, and
/// that an error comes last.
pub fn exercise(data: &[u8]) {
    let at_once = read(data, Box::new(Cursor::new(data.to_vec())));
    let in_parts = read(data, Box::new(Trickle(Cursor::new(data.to_vec()))));
    assert_eq!(at_once, in_parts);
}

/// The datagrams, and everything else as text.
fn read(data: &[u8], reader: Box<dyn Read + Send>) -> (Vec<CapturedDatagram>, String) {
    let mut capture = match Capture::from_reader("fuzz".to_owned(), reader, Some(data.len() as u64)) {
        Ok(capture) => capture,
        Err(error) => return (Vec::new(), error.to_string()),
    };
    let (mut datagrams, mut error) = (Vec::new(), None);
    let mut end = 0;
    while let Some(item) = capture.next() {
        assert!(error.is_none(), "something came after an error");
        match item {
            Ok(datagram) => {
                let start = datagram.origin as usize;
                // In a compressed capture origins refer to the decompressed data. Translated payloads are not in the file, and
                // fragmented ones are in several places.
                let is_translated = datagram.contents == PayloadKind::Translated;
                let is_elsewhere = is_translated || datagram.fragments > 0 || capture.is_compressed();
                assert!(start >= end || datagram.fragments > 0);
                assert!(is_elsewhere || data[start..].starts_with(&datagram.payload));
                end = match (is_translated, datagram.fragments) {
                    (true, _) => start,
                    (false, 0) => start + datagram.payload.len(),
                    (false, _) => end,
                };
                datagrams.push(datagram);
            }
            Err(damage) => error = Some(damage),
        }
    }
    assert!(capture.next().is_none());
    assert!(capture.consumed() <= data.len() as u64);
    let skipped: Vec<_> = capture.skipped().iter().collect();
    let error = error.map(|damage| damage.to_string());
    (datagrams, format!("{} {} {skipped:?} {error:?}", capture.format(), capture.consumed()))
}
