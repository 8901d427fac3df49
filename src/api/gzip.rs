//! gzip (RFC 1952) of what many readers get, made once.
//!
//! A text becomes deflate blocks that refer to nothing in front of them and end on a whole octet. A gzip file is any such
//! blocks in a row, between a head and a tail: so readers of streams share the blocks of an event although each has a file
//! of its own, of which the service keeps nothing but the checksum.

use axum::body::{Bytes, HttpBody};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use flate2::{Compress, Compression, Crc, FlushCompress};

use super::payload::Payload;
use super::render::bug;

/// Of 1 to 9. 404 kB of a city's tracks become 61, 53, 46, 44, 43, 42 kB in 0.8, 1.4, 2.2, 2.3, 3.0, 6.8 ms.
const LEVEL: Compression = Compression::new(4);
/// Below this a packet is a packet.
const SMALLEST: u64 = 1_024;
/// Deflate, no name, no time, an unknown system.
const HEAD: [u8; 10] = [0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 0xff];
/// The last block, which is empty.
const LAST: [u8; 2] = [3, 0];

/// A text as deflate blocks that stand on their own.
#[derive(Debug)]
pub struct Blocks {
    octets: Bytes,
    crc: Crc,
}

impl Blocks {
    /// Compresses it.
    pub fn of(text: &[u8]) -> Self {
        let mut crc = Crc::new();
        crc.update(text);
        Self { octets: deflated(text).into(), crc }
    }

    /// As a whole gzip file.
    pub fn file(&self) -> Bytes {
        let mut file = GzipStream::default();
        [file.next(self), file.end()].concat().into()
    }
}

/// The gzip file that a reader gets piece by piece.
#[derive(Debug, Default)]
pub struct GzipStream {
    crc: Crc,
    is_begun: bool,
}

impl GzipStream {
    /// The next piece of it; whoever has it can read all of the text.
    pub fn next(&mut self, Blocks { octets, crc }: &Blocks) -> Bytes {
        self.crc.combine(crc);
        if std::mem::replace(&mut self.is_begun, true) {
            return octets.clone();
        }
        [&HEAD, &octets[..]].concat().into()
    }

    /// Its end.
    pub fn end(self) -> Bytes {
        [&LAST[..], &self.crc.sum().to_le_bytes(), &self.crc.amount().to_le_bytes()].concat().into()
    }
}

/// Deflate blocks that stand on their own, the last of them an empty one that ends on a whole octet.
pub fn deflated(text: &[u8]) -> Vec<u8> {
    let mut deflate = Compress::new(LEVEL, false);
    let mut out = Vec::with_capacity(text.len() / 6 + 256);
    loop {
        // Of what is in memory, 64 bits count all.
        let rest = &text[deflate.total_in() as usize..];
        deflate
            .compress_vec(rest, &mut out, FlushCompress::Sync)
            .expect("compressing has no state that it could be wrong in");
        // Room that is left is room that was not needed.
        if out.len() < out.capacity() {
            return out;
        }
        out.reserve(out.capacity());
    }
}

/// Whether a client takes gzip, and likes it no less than none (RFC 9110, 12.5.3).
pub fn is_accepted(headers: &HeaderMap) -> bool {
    let (mut gzip, mut any, mut plain) = (None, None, None);
    let lines = headers.get_all(header::ACCEPT_ENCODING).iter().filter_map(|line| line.to_str().ok());
    for coding in lines.flat_map(|line| line.split(',')) {
        let mut parts = coding.split(';').map(str::trim);
        let name = parts.next().unwrap_or("").to_ascii_lowercase();
        let weight = parts.find_map(|part| part.strip_prefix("q=").or_else(|| part.strip_prefix("Q=")));
        // What cannot be read is not wanted.
        let weight: f32 = weight.map_or(1.0, |weight| weight.trim().parse().unwrap_or(0.0));
        match &*name {
            "gzip" | "x-gzip" => gzip = Some(weight),
            "*" => any = Some(weight),
            "identity" => plain = Some(weight),
            _ => {}
        }
    }
    let gzip = gzip.or(any).unwrap_or(0.0);
    gzip > 0.0 && gzip >= plain.unwrap_or(0.0)
}

/// Says that the answer depends on what the client takes and, where that is so, that it is gzip.
pub fn label(headers: &mut HeaderMap, is_gzip: bool) {
    headers.append(header::VARY, HeaderValue::from_static("accept-encoding"));
    if is_gzip {
        headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    }
}

/// Marks a response that is as the client takes it.
#[derive(Clone, Copy, Debug)]
struct Answered;

/// The answer as the client takes it: whole texts from about a kilobyte on are compressed. What is in the response's
/// extensions as its [`Payload`] is compressed once for all.
pub async fn answer(mut response: Response, accepted: bool) -> Response {
    if response.extensions_mut().insert(Answered).is_some() {
        return response;
    }
    let is_text = response.headers().get(header::CONTENT_TYPE).is_some_and(is_text);
    if response.headers().contains_key(header::CONTENT_ENCODING) || !is_text {
        return response;
    }
    let size = response.body().size_hint().exact();
    let is_gzip =
        accepted && response.status() == StatusCode::OK && size.is_some_and(|size| size >= SMALLEST);
    label(response.headers_mut(), is_gzip);
    if !is_gzip {
        return response;
    }
    let shared = response.extensions_mut().remove::<Payload>();
    let (mut parts, body) = response.into_parts();
    let payload = match shared {
        Some(payload) => payload,
        // Its size is known: all of it is there, and nothing is waited for.
        None => match axum::body::to_bytes(body, usize::MAX).await {
            Ok(octets) => octets.into(),
            Err(error) => return bug(&error).into_response(),
        },
    };
    parts.headers.remove(header::CONTENT_LENGTH);
    Response::from_parts(parts, payload.gzip().into())
}

/// Whether it is worth compressing.
fn is_text(content_type: &HeaderValue) -> bool {
    let kind = content_type.to_str().unwrap_or("");
    kind != "text/event-stream"
        && (kind.starts_with("text/") || ["json", "xml"].iter().any(|kinds| kind.contains(kinds)))
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use flate2::read::GzDecoder;
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_client_says_what_it_takes() {
        for (line, accepted) in [
            ("gzip", true),
            ("gzip, deflate, br, zstd", true),
            ("br;q=1.0, GZIP;q=0.8, *;q=0.1", true),
            ("*", true),
            ("deflate", false),
            ("", false),
            ("gzip;q=0", false),
            ("gzip; q=0.000, *", false),
            ("*;q=0", false),
            ("identity, gzip;q=0.5", false),
            ("identity;q=0.5, gzip", true),
            ("gzip;q=high", false),
        ] {
            let headers = HeaderMap::from_iter([(header::ACCEPT_ENCODING, line.parse().unwrap())]);
            assert_eq!(is_accepted(&headers), accepted, "{line}");
        }
        assert!(!is_accepted(&HeaderMap::new()));
    }

    fn text() -> impl Strategy<Value = Vec<u8>> {
        prop_oneof![
            prop::collection::vec(any::<u8>(), 0..5_000),
            ("[a-f]{0,40}", 0..3_000usize).prop_map(|(text, times)| text.repeat(times).into_bytes()),
        ]
    }

    proptest! {
        /// Another decoder reads each piece as soon as it has it, and at the end finds the checksum right.
        #[test]
        fn a_stream_of_payloads_is_one_gzip_file(texts in prop::collection::vec(text(), 1..8)) {
            let payloads: Vec<Blocks> = texts.iter().map(|text| Blocks::of(text)).collect();
            // Another reader has had them before, in another order.
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
