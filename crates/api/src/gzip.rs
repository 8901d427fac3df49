//! Responses compressed with gzip (RFC 1952), if the client accepts it.

use axum::body::HttpBody;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};

use super::payload::Payload;
use super::render::bug;

/// Minimum length of compressed texts, in octets. A shorter text fits one packet anyway.
const SMALLEST: u64 = 1_024;

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
}
