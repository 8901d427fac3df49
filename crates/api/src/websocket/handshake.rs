//! Opening handshake (RFC 6455, 4.2) and negotiation of compression (RFC 7692).

use axum::body::Body;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use sha1::{Digest, Sha1};

use crate::problem::Problem;

/// RFC 6455, 1.3.
const GUID: &str = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
/// Each message is compressed without context, once for all clients. Messages of clients are not read.
const DEFLATE: &str = "permessage-deflate; server_no_context_takeover; client_no_context_takeover";

/// Result of the negotiation.
#[derive(Debug)]
pub struct Agreed {
    accept: String,
    /// Whether messages are compressed.
    pub is_deflated: bool,
}

impl Agreed {
    /// Handshake of a request; `None` if it is not one of version 13.
    pub fn of(headers: &HeaderMap) -> Option<Self> {
        let key = headers.get("sec-websocket-key")?.to_str().ok()?.trim();
        let is_version = headers.get("sec-websocket-version").is_some_and(|version| version == "13");
        let is_whole = has(headers, header::UPGRADE, "websocket")
            && has(headers, header::CONNECTION, "upgrade")
            && is_version
            && is_key(key);
        is_whole.then(|| Self { accept: accept(key), is_deflated: takes_deflate(headers) })
    }

    /// Response 101.
    pub fn answer(&self) -> Response {
        let mut response = Response::new(Body::empty());
        *response.status_mut() = StatusCode::SWITCHING_PROTOCOLS;
        let headers = response.headers_mut();
        headers.insert(header::UPGRADE, HeaderValue::from_static("websocket"));
        headers.insert(header::CONNECTION, HeaderValue::from_static("upgrade"));
        let accept = HeaderValue::try_from(&self.accept).expect("base64 is letters, digits, + / and =");
        headers.insert(header::SEC_WEBSOCKET_ACCEPT, accept);
        if self.is_deflated {
            headers.insert(header::SEC_WEBSOCKET_EXTENSIONS, HeaderValue::from_static(DEFLATE));
        }
        response
    }
}

/// Response 426, with the protocol required here.
pub fn required() -> Response {
    let detail =
        "this path speaks WebSocket, version 13 (RFC 6455); /api/v1/stream has the same events without";
    let mut response = Problem::new(StatusCode::UPGRADE_REQUIRED, detail).into_response();
    let spoken = [
        (header::UPGRADE, "websocket"),
        (header::CONNECTION, "upgrade"),
        (header::SEC_WEBSOCKET_VERSION, "13"),
    ];
    response.headers_mut().extend(spoken.map(|(name, value)| (name, HeaderValue::from_static(value))));
    response
}

/// Whether a list of tokens contains `token`.
fn has(headers: &HeaderMap, name: HeaderName, token: &str) -> bool {
    let lines = headers.get_all(name).into_iter().filter_map(|line| line.to_str().ok());
    lines.flat_map(|line| line.split(',')).any(|part| part.trim().eq_ignore_ascii_case(token))
}

/// Whether `key` is sixteen octets in base64.
fn is_key(key: &str) -> bool {
    let digits = key.strip_suffix("==").unwrap_or("").as_bytes();
    digits.len() == 22 && digits.iter().all(|digit| digit.is_ascii_alphanumeric() || b"+/".contains(digit))
}

fn accept(key: &str) -> String {
    base64(&Sha1::new().chain_update(key).chain_update(GUID).finalize())
}

/// Base64 of RFC 4648, 4.
fn base64(octets: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let four = |three: &[u8]| {
        let bits =
            (0..3).fold(0, |bits, place| bits << 8 | usize::from(three.get(place).copied().unwrap_or(0)));
        // n octets need n + 1 digits.
        let digits = three.len() + 1;
        let digit =
            move |place| if place < digits { char::from(DIGITS[bits >> (18 - 6 * place) & 63]) } else { '=' };
        (0..4).map(digit)
    };
    octets.chunks(3).flat_map(four).collect()
}

/// Whether an offer of `permessage-deflate` can be accepted: not one that asks for a smaller window.
fn takes_deflate(headers: &HeaderMap) -> bool {
    let lines = headers.get_all(header::SEC_WEBSOCKET_EXTENSIONS).into_iter();
    lines.filter_map(|line| line.to_str().ok()).flat_map(|line| line.split(',')).any(|offer| {
        let mut parts = offer.split(';').map(str::trim);
        let known = |part: &str| {
            let (name, value) =
                part.split_once('=').map_or((part, ""), |(name, value)| (name.trim(), value.trim()));
            match name {
                "server_no_context_takeover" | "client_no_context_takeover" => value.is_empty(),
                "client_max_window_bits" => true,
                "server_max_window_bits" => value.trim_matches('"') == "15",
                _ => false,
            }
        };
        parts.next() == Some("permessage-deflate") && parts.all(known)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(lines: &[(&'static str, &str)]) -> HeaderMap {
        lines.iter().map(|(name, value)| (HeaderName::from_static(name), value.parse().unwrap())).collect()
    }

    /// RFC 6455, 1.3.
    #[test]
    fn key_of_the_rfc_gives_its_answer() {
        assert_eq!(accept("dGhlIHNhbXBsZSBub25jZQ=="), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
        // RFC 4648, 10.
        let pairs = ["", "f", "fo", "foo", "foob", "fooba", "foobar"].map(|text| base64(text.as_bytes()));
        assert_eq!(pairs, ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"]);
    }

    #[test]
    fn incomplete_handshake_is_refused() {
        let whole = [
            ("connection", "keep-alive, Upgrade"),
            ("upgrade", "WebSocket"),
            ("sec-websocket-version", "13"),
            ("sec-websocket-key", "dGhlIHNhbXBsZSBub25jZQ=="),
        ];
        let agreed = Agreed::of(&headers(&whole)).unwrap();
        assert!(!agreed.is_deflated);
        assert!(agreed.answer().headers().get("sec-websocket-extensions").is_none());
        for missing in 0..whole.len() {
            let mut lines = whole.to_vec();
            lines.remove(missing);
            assert!(Agreed::of(&headers(&lines)).is_none(), "{lines:?}");
        }
        for (place, value) in
            [(0, "close"), (1, "h2c"), (2, "8"), (3, "dG hlIHNhbXBsZSBub25jZQ=="), (3, "short==")]
        {
            let mut lines = whole;
            lines[place].1 = value;
            assert!(Agreed::of(&headers(&lines)).is_none(), "{lines:?}");
        }
    }

    #[test]
    fn compression_is_agreed_where_it_can_be_kept() {
        for (offer, taken) in [
            ("permessage-deflate", true),
            ("permessage-deflate; client_max_window_bits", true),
            ("permessage-deflate; server_max_window_bits=15; client_no_context_takeover", true),
            ("permessage-deflate; server_max_window_bits=10, permessage-deflate", true),
            ("permessage-deflate; server_max_window_bits=10", false),
            ("permessage-deflate; nonsense", false),
            ("permessage-bzip2", false),
            ("", false),
        ] {
            assert_eq!(takes_deflate(&headers(&[("sec-websocket-extensions", offer)])), taken, "{offer}");
        }
    }
}
