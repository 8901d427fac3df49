//! A request to a receiver over HTTP, and what its answer means.

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

use super::dial::Dial;
use super::health::Answer;
use fusion::time::{SECOND, Time};

/// Who asks: the header `User-Agent`.
pub(crate) const PROGRAM: &str = concat!("utm-fusion/", env!("CARGO_PKG_VERSION"));

/// Why there is no answer.
type Silence = Box<dyn Error + Send + Sync>;

/// What the receiver answers within that time, on a connection of its own. Redirects are not followed.
pub(crate) async fn post(dial: &Dial, request: Request<Body>, patience: Duration) -> Result<Parts, String> {
    match timeout(patience, attempt(dial, request)).await {
        Ok(Ok(parts)) => Ok(parts),
        Ok(Err(silence)) => Err(reasons(&*silence)),
        Err(_) => Err(format!("no answer within {} s", patience.as_secs_f64())),
    }
}

async fn attempt(dial: &Dial, request: Request<Body>) -> Result<Parts, Silence> {
    let stream = dial.dial().await?;
    let (mut sender, connection) = http1::handshake(TokioIo::new(stream)).await?;
    // What stands in the answer is for people with other tools.
    let answer = async move { sender.send_request(request).await.map(|answer| answer.into_parts().0) };
    let (answer, _) = join(answer, connection).await;
    Ok(answer?)
}

/// An error with what is behind it.
fn reasons(error: &(dyn Error + 'static)) -> String {
    let behind = std::iter::successors(error.source(), |&error| error.source());
    behind.fold(error.to_string(), |reasons, error| format!("{reasons}: {error}"))
}

/// What an answer means: a server that cannot now is asked again, one that does not want to is not.
pub(crate) fn answer(Parts { status, headers, .. }: &Parts, now: Time) -> Answer {
    let why = || format!("answered {status}");
    match *status {
        status if status.is_success() => Answer::Taken,
        StatusCode::REQUEST_TIMEOUT | StatusCode::TOO_MANY_REQUESTS => {
            Answer::Later { why: why(), after: retry_after(headers.get(RETRY_AFTER), now) }
        }
        status if status.is_server_error() => {
            Answer::Later { why: why(), after: retry_after(headers.get(RETRY_AFTER), now) }
        }
        status if status.is_redirection() => {
            Answer::Refused { why: format!("{}: redirects are not followed", why()) }
        }
        _ => Answer::Refused { why: why() },
    }
}

/// `Retry-After`: seconds, or a date.
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

    fn answered(status: u16, after: &str) -> Answer {
        let mut response = Response::builder().status(status);
        if !after.is_empty() {
            response = response.header(RETRY_AFTER, after);
        }
        // 1994-11-06T08:49:00Z.
        answer(&response.body(()).unwrap().into_parts().0, Time::from_nanos(784_111_740 * SECOND))
    }

    #[test]
    fn what_the_status_of_an_answer_means() {
        for status in [200, 201, 204] {
            assert_eq!(answered(status, ""), Answer::Taken);
        }
        for status in [408, 429, 500, 502, 503, 504] {
            assert!(matches!(answered(status, ""), Answer::Later { after: None, .. }), "{status}");
        }
        for status in [301, 304, 307, 400, 401, 404, 410, 422] {
            assert!(matches!(answered(status, "5"), Answer::Refused { .. }), "{status}");
        }
    }

    #[test]
    fn a_receiver_says_when_to_come_again() {
        let after_s = |text| match answered(503, text) {
            Answer::Later { after, .. } => after.map(|after| after.as_secs()),
            other => panic!("{other:?}"),
        };
        assert_eq!(after_s("120"), Some(120));
        assert_eq!(after_s("Sun, 06 Nov 1994 08:49:37 GMT"), Some(37));
        assert_eq!(after_s("Sun, 06 Nov 1994 08:40:00 GMT"), Some(0));
        assert_eq!(after_s("soon"), None);
    }
}
