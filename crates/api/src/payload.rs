//! Octets that are sent to many readers; each encoding of them is made once.

use std::sync::{Arc, OnceLock};

use axum::body::Bytes;

use super::event_text;
use super::gzip_blocks::{Blocks, deflated};
use super::websocket_frames;

/// End of deflate blocks that end on a whole octet, left out by RFC 7692, 7.2.1.
const FLUSHED: [u8; 4] = [0, 0, 0xff, 0xff];

/// Octets with their encodings. Clones are cheap and share the encodings.
#[derive(Clone, Debug)]
pub struct Payload {
    plain: Bytes,
    encodings: Arc<Encodings>,
}

#[derive(Debug, Default)]
struct Encodings {
    blocks: OnceLock<Blocks>,
    /// WebSocket messages, plain and compressed.
    messages: [OnceLock<Bytes>; 2],
}

impl<T: Into<Bytes>> From<T> for Payload {
    fn from(plain: T) -> Self {
        Self { plain: plain.into(), encodings: Arc::default() }
    }
}

impl Payload {
    /// Plain octets.
    pub fn plain(&self) -> Bytes {
        self.plain.clone()
    }

    /// Compressed blocks, as a piece of a gzip file.
    pub fn blocks(&self) -> &Blocks {
        self.encodings.blocks.get_or_init(|| Blocks::of(&self.plain))
    }

    /// A complete gzip file.
    pub fn gzip(&self) -> Bytes {
        self.blocks().file()
    }

    /// An event as a WebSocket frame, plain or compressed.
    pub fn message(&self, is_deflated: bool) -> Bytes {
        let make = || {
            let json = event_text::as_json(&self.plain);
            if !is_deflated {
                return websocket_frames::text(&json, false).into();
            }
            let blocks = deflated(&json);
            websocket_frames::text(blocks.strip_suffix(&FLUSHED).unwrap_or(&blocks), true).into()
        };
        self.encodings.messages[usize::from(is_deflated)].get_or_init(make).clone()
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use flate2::read::DeflateDecoder;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// An independent decoder reads each message by itself, once the omitted end is restored.
        #[test]
        fn a_compressed_message_is_the_plain_one(text in "[a-z\"]{0,400}", times in 0..200usize) {
            let data = serde_json::to_vec(&text.repeat(times)).unwrap();
            let payload = Payload::from(event_text::written("1-2", "tracks", &data));
            let body = |frame: &[u8]| {
                let head = match frame[1] {
                    126 => 4,
                    127 => 10,
                    _ => 2,
                };
                frame[head..].to_vec()
            };
            let (plain, packed) = (payload.message(false), payload.message(true));
            prop_assert_eq!((plain[0], packed[0]), (0x81, 0xc1));
            let mut read = String::new();
            let mut blocks = body(&packed);
            blocks.extend(FLUSHED);
            // The stream continues: the available data are read, and no end is found.
            let ended = DeflateDecoder::new(&blocks[..]).read_to_string(&mut read);
            prop_assert!(ended.is_err());
            prop_assert_eq!(read.as_bytes(), body(&plain));
        }
    }
}
