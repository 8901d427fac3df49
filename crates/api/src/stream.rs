//! `GET /api/v1/stream`: Server-Sent Events.

use std::convert::Infallible;

use axum::body::Body;
use axum::http::{HeaderName, HeaderValue};
use axum::response::Response;
use futures_util::stream;

use super::gzip;
use super::gzip_blocks::GzipStream;
use super::payload::Payload;
use super::reader::EventStream;
use super::request::{ApiRequest, ApiResult, with_type};

/// Opens a stream.
pub fn open(request: &ApiRequest) -> ApiResult {
    let is_gzip = gzip::is_accepted(&request.headers);
    let prepare = if is_gzip { |snapshot: &Payload| _ = snapshot.blocks() } else { |_: &Payload| {} };
    let reader = EventStream::open(request, request.header("last-event-id"), prepare)?;
    let gzip = is_gzip.then(GzipStream::default);
    let events = stream::unfold((reader, gzip), async |(mut reader, mut gzip)| {
        let octets = match (reader.next().await, &mut gzip) {
            (Some(event), Some(gzip)) => gzip.next(event.blocks()),
            (Some(event), None) => event.plain(),
            (None, _) => gzip.take()?.end(),
        };
        Some((Ok::<_, Infallible>(octets), (reader, gzip)))
    });
    let mut response: Response = with_type("text/event-stream", "no-store", Body::from_stream(events));
    let unbuffered = (HeaderName::from_static("x-accel-buffering"), HeaderValue::from_static("no"));
    response.headers_mut().extend([unbuffered]);
    gzip::label(response.headers_mut(), is_gzip);
    Ok(response)
}
