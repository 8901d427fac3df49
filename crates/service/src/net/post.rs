//! HTTP requests to a receiver, and the meaning of its answers.

use std::error::Error;
use std::time::Duration;

use axum::body::Body;
use axum::http::header::RETRY_AFTER;
use axum::http::response::Parts;
use axum::http::{HeaderValue, Request, StatusCode};
use futures_util::future::join;
use hyper::client::conn::http1;
use hyper_util::rt::TokioIo;
use jiff::fmt::rfc2822;
use tokio::time::timeout;

use super::dial::Dialer;
use super::health::DeliveryResult;
use fusion::time::{SECOND, Time};

/// Value of the header `User-Agent`.
pub(crate) const PROGRAM: &str = concat!("utm-fusion/", env!("CARGO_PKG_VERSION"));

/// Reason for a missing answer.
type NoAnswer = Box<dyn Error + Send + Sync>;

/// Sends a request on a new connection; returns the head of the answer, within this time. Redirects are not followed.
pub(crate) async fn post(dial: &Dialer, request: Request<Body>, patience: Duration) -> Result<Parts, String> {
    match timeout(patience, attempt(dial, request)).await {
        Ok(Ok(parts)) => Ok(parts),
        Ok(Err(silence)) => Err(reasons(&*silence)),
        Err(_) => Err(format!("no answer within {} s", patience.as_secs_f64())),
    }
}

async fn attempt(dial: &Dialer, request: Request<Body>) -> Result<Parts, NoAnswer> {
    let stream = dial.dial().await?;
    let (mut sender, connection) = http1::handshake(TokioIo::new(stream)).await?;
    // The body of the answer is not read.
    let answer = async move { sender.send_request(request).await.map(|answer| answer.into_parts().0) };
    let (answer, _) = join(answer, connection).await;
    Ok(answer?)
}

/// Text of an error with its causes.
fn reasons(error: &(dyn Error + 'static)) -> String {
    let behind = std::iter::successors(error.source(), |&error| error.source());
    behind.fold(error.to_string(), |reasons, error| format!("{reasons}: {error}"))
}

/// Result by the answer's status: after a temporary failure the request is repeated, after a rejection it is not.
pub(crate) fn answer(Parts { status, headers, .. }: &Parts, now: Time) -> DeliveryResult {
    let why = || format!("answered {status}");
    match *status {
        status if status.is_success() => DeliveryResult::Taken,
        StatusCode::REQUEST_TIMEOUT | StatusCode::TOO_MANY_REQUESTS => {
            DeliveryResult::Later { why: why(), after: retry_after(headers.get(RETRY_AFTER), now) }
        }
        status if status.is_server_error() => {
            DeliveryResult::Later { why: why(), after: retry_after(headers.get(RETRY_AFTER), now) }
        }
        status if status.is_redirection() => {
            DeliveryResult::Refused { why: format!("{}: redirects are not followed", why()) }
        }
        _ => DeliveryResult::Refused { why: why() },
    }
}

/// Value of `Retry-After`: seconds, or a date.
fn retry_after(value: Option<&HeaderValue>, now: Time) -> Option<Duration> {
    let text = value?.to_str().ok()?.trim();
    if let Ok(seconds) = text.parse() {
        return Some(Duration::from_secs(seconds));
    }
    let date = rfc2822::DateTimeParser::new().parse_timestamp(text).ok()?;
    let seconds = date.as_second().saturating_sub(now.nanos() / SECOND);
    Some(Duration::from_secs(u64::try_from(seconds).unwrap_or(0)))
}

#[cfg(test)]
mod tests {
    use axum::http::Response;

    use super::*;

    fn answered(status: u16, after: &str) -> DeliveryResult {
        let mut response = Response::builder().status(status);
        if !after.is_empty() {
            response = response.header(RETRY_AFTER, after);
        }
        // 1994-11-06T08:49:00Z.
        answer(&response.body(()).unwrap().into_parts().0, Time::from_nanos(784_111_740 * SECOND))
    }

    #[test]
    fn http_status_maps_to_a_delivery_result() {
        for status in [200, 201, 204] {
            assert_eq!(answered(status, ""), DeliveryResult::Taken);
        }
        for status in [408, 429, 500, 502, 503, 504] {
            assert!(matches!(answered(status, ""), DeliveryResult::Later { after: None, .. }), "{status}");
        }
        for status in [301, 304, 307, 400, 401, 404, 410, 422] {
            assert!(matches!(answered(status, "5"), DeliveryResult::Refused { .. }), "{status}");
        }
    }

    #[test]
    fn retry_after_sets_the_pause() {
        let after_s = |text| match answered(503, text) {
            DeliveryResult::Later { after, .. } => after.map(|after| after.as_secs()),
            other => panic!("{other:?}"),
        };
        assert_eq!(after_s("120"), Some(120));
        assert_eq!(after_s("Sun, 06 Nov 1994 08:49:37 GMT"), Some(37));
        assert_eq!(after_s("Sun, 06 Nov 1994 08:40:00 GMT"), Some(0));
        assert_eq!(after_s("soon"), None);
    }
}
