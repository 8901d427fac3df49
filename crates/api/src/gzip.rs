//! gzip (RFC 1952) of texts that many clients receive, compressed once.
//!
//! A text becomes deflate blocks that refer to no earlier data and end on a whole octet. A gzip file is any sequence of such
//! blocks between a header and a trailer. So all readers of a stream share the blocks of an event, although each receives its own
//! file, of which the service stores only the checksum.

use axum::body::{Bytes, HttpBody};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use flate2::{Compress, Compression, Crc, FlushCompress};

use super::payload::Payload;
use super::render::bug;

/// Level, 1 to 9. For 404 kB of tracks of a city, levels 1 to 6 give 61, 53, 46, 44, 43, 42 kB in 0.8, 1.4, 2.2, 2.3, 3.0, 6.8
/// ms.
const LEVEL: Compression = Compression::new(4);
/// Minimum length of compressed texts, in octets. A shorter text fits one packet anyway.
const SMALLEST: u64 = 1_024;
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

/// Whether a client accepts gzip, and prefers it or has no preference (RFC 9110, 12.5.3).
pub fn is_accepted(headers: &HeaderMap) -> bool {
    let (mut gzip, mut any, mut plain) = (None, None, None);
    let lines = headers.get_all(header::ACCEPT_ENCODING).iter().filter_map(|line| line.to_str().ok());
    for coding in lines.flat_map(|line| line.split(',')) {
        let mut parts = coding.split(';').map(str::trim);
        let name = parts.next().unwrap_or("").to_ascii_lowercase();
        let weight = parts.find_map(|part| part.strip_prefix("q=").or_else(|| part.strip_prefix("Q=")));
        // An unreadable weight means not wanted.
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

/// Sets `Vary`, and `Content-Encoding` if the response is compressed.
pub fn label(headers: &mut HeaderMap, is_gzip: bool) {
    headers.append(header::VARY, HeaderValue::from_static("accept-encoding"));
    if is_gzip {
        headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    }
}

/// Marks a response that has the wanted encoding already.
#[derive(Clone, Copy, Debug)]
struct Answered;

/// Compresses a response if the client accepts it. Texts are compressed from about a kilobyte on. A [`Payload`] in the extensions
/// of the response is compressed once for all clients.
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
        // The size is known, so the whole body is available without waiting.
        None => match axum::body::to_bytes(body, usize::MAX).await {
            Ok(octets) => octets.into(),
            Err(error) => return bug(&error).into_response(),
        },
    };
    parts.headers.remove(header::CONTENT_LENGTH);
    Response::from_parts(parts, payload.gzip().into())
}

/// Whether a content type is worth compressing.
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
    fn gzip_is_used_if_accepted() {
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
