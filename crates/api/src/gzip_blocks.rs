//! gzip (RFC 1952) of texts that many clients receive, compressed once.
//!
//! A text becomes deflate blocks that refer to no earlier data and end on a whole octet. A gzip file is any sequence of such
//! blocks between a header and a trailer. So all readers of a stream share the blocks of an event, although each receives its own
//! file, of which the service stores only the checksum.

use axum::body::Bytes;
use flate2::{Compress, Compression, Crc, FlushCompress};

/// Level, 1 to 9. For 404 kB of tracks of a city, levels 1 to 6 give 61, 53, 46, 44, 43, 42 kB in 0.8, 1.4, 2.2, 2.3, 3.0, 6.8
/// ms.
const LEVEL: Compression = Compression::new(4);
/// Header of a gzip file: deflate, no name, no time, unknown system.
const HEAD: [u8; 10] = [0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 0xff];
/// The last deflate block, which is empty.
const LAST: [u8; 2] = [3, 0];

/// A text as self-contained deflate blocks.
#[derive(Debug)]
pub struct Blocks {
    octets: Bytes,
    crc: Crc,
}

impl Blocks {
    /// Compresses `text`.
    pub fn of(text: &[u8]) -> Self {
        let mut crc = Crc::new();
        crc.update(text);
        Self { octets: deflated(text).into(), crc }
    }

    /// The text as a complete gzip file.
    pub fn file(&self) -> Bytes {
        let mut file = GzipStream::default();
        [file.next(self), file.end()].concat().into()
    }
}

/// State of a gzip file that is sent to a client in pieces.
#[derive(Debug, Default)]
pub struct GzipStream {
    crc: Crc,
    is_begun: bool,
}

impl GzipStream {
    /// Next piece of the file. A client that has it can read all of the text so far.
    pub fn next(&mut self, Blocks { octets, crc }: &Blocks) -> Bytes {
        self.crc.combine(crc);
        if std::mem::replace(&mut self.is_begun, true) {
            return octets.clone();
        }
        [&HEAD, &octets[..]].concat().into()
    }

    /// Trailer of the file.
    pub fn end(self) -> Bytes {
        [&LAST[..], &self.crc.sum().to_le_bytes(), &self.crc.amount().to_le_bytes()].concat().into()
    }
}

/// `text` as self-contained deflate blocks; the last one is empty and ends on a whole octet.
pub fn deflated(text: &[u8]) -> Vec<u8> {
    let mut deflate = Compress::new(LEVEL, false);
    let mut out = Vec::with_capacity(text.len() / 6 + 256);
    loop {
        // 64 bits count any text in memory.
        let rest = &text[deflate.total_in() as usize..];
        deflate
            .compress_vec(rest, &mut out, FlushCompress::Sync)
            .expect("compressing has no state that it could be wrong in");
        // Unused capacity means that the output is complete.
        if out.len() < out.capacity() {
            return out;
        }
        out.reserve(out.capacity());
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use flate2::read::GzDecoder;
    use proptest::prelude::*;

    use super::*;

    fn text() -> impl Strategy<Value = Vec<u8>> {
        prop_oneof![
            prop::collection::vec(any::<u8>(), 0..5_000),
            ("[a-f]{0,40}", 0..3_000usize).prop_map(|(text, times)| text.repeat(times).into_bytes()),
        ]
    }

    proptest! {
        /// An independent decoder reads each piece at once, and confirms the checksum at the end.
        #[test]
        fn a_stream_of_payloads_is_one_gzip_file(texts in prop::collection::vec(text(), 1..8)) {
            let payloads: Vec<Blocks> = texts.iter().map(|text| Blocks::of(text)).collect();
            // Another reader received the payloads before, in another order.
            let mut other = GzipStream::default();
            payloads.iter().rev().for_each(|blocks| drop(other.next(blocks)));
            let (mut stream, mut file, mut plain) = (GzipStream::default(), Vec::new(), Vec::new());
            for (blocks, text) in payloads.iter().zip(&texts) {
                file.extend_from_slice(&stream.next(blocks));
                plain.extend_from_slice(text);
                let mut so_far = vec![0; plain.len()];
                GzDecoder::new(&file[..]).read_exact(&mut so_far).unwrap();
                prop_assert_eq!(&so_far, &plain);
            }
            file.extend_from_slice(&stream.end());
            let mut read = Vec::new();
            GzDecoder::new(&file[..]).read_to_end(&mut read).unwrap();
            prop_assert_eq!(&read, &plain);
            let mut read = Vec::new();
            GzDecoder::new(&payloads[0].file()[..]).read_to_end(&mut read).unwrap();
            prop_assert_eq!(&read, &texts[0]);
        }
    }
}
