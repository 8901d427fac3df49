//! A webhook: each notice is posted, signed, and tried again where it may be taken later.

use std::error::Error;
use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::http::header::{AUTHORIZATION, CONTENT_TYPE, HOST, RETRY_AFTER, USER_AGENT};
use axum::http::response::Parts;
use axum::http::{HeaderValue, Request, StatusCode, Uri};
use futures_util::future::join;
use hyper::client::conn::http1;
use hyper_util::rt::TokioIo;
use jiff::fmt::rfc2822;
use tokio::time::timeout;

use super::body;
use super::desk::Desk;
use super::signature::Secret;
use crate::live::now;
use crate::net::dial::Dial;
use crate::net::health::Answer;
use crate::net::peers::{Closing, closed};
use fusion::time::{SECOND, Time};

const PROGRAM: &str = concat!("utm-fusion/", env!("CARGO_PKG_VERSION"));

/// One receiver.
#[derive(Debug)]
pub(super) struct Webhook {
    pub(super) desk: Arc<Desk>,
    pub(super) url: Uri,
    pub(super) dial: Dial,
    pub(super) secret: Option<Secret>,
    pub(super) authorization: Option<HeaderValue>,
    pub(super) timeout: Duration,
    pub(super) site: String,
    /// What the ids of this run's notices begin with.
    pub(super) run: String,
}

/// Why there is no answer.
type Silence = Box<dyn Error + Send + Sync>;

impl Webhook {
    /// Delivers what comes, one at a time, until the service ends and nothing waits, or what waits cannot be delivered.
    pub(super) async fn deliver(self, mut closing: Closing) {
        loop {
            let notice = tokio::select! {
                notice = self.desk.next() => notice,
                () = closed(&mut closing) => match self.desk.take() {
                    Some(notice) => notice,
                    None => return,
                },
            };
            let id = format!("{}-{}", self.run, notice.number);
            let answer = match self.post(&id, body::of_notice(&notice, &id, &self.site)).await {
                Ok(parts) => answer(&parts, now()),
                Err(why) => Answer::Later { why, after: None },
            };
            let wait = self.desk.settle(notice, answer);
            if wait.is_zero() {
                continue;
            }
            tokio::select! {
                () = tokio::time::sleep(wait) => {}
                () = closed(&mut closing) => return,
            }
        }
    }

    /// Posts a test; what the receiver answers, or what went wrong.
    pub(super) async fn test(&self) -> Result<String, String> {
        let id = format!("{}-test", self.run);
        let parts = self.post(&id, body::of_test(&id, &self.site, now())).await?;
        match answer(&parts, now()) {
            Answer::Taken => Ok(format!("answered {}", parts.status)),
            Answer::Later { why, .. } | Answer::Refused { why } => Err(why),
        }
    }

    /// What the receiver answers.
    async fn post(&self, id: &str, body: Vec<u8>) -> Result<Parts, String> {
        match timeout(self.timeout, self.attempt(id, body)).await {
            Ok(Ok(parts)) => Ok(parts),
            Ok(Err(silence)) => Err(reasons(&*silence)),
            Err(_) => Err(format!("no answer within {} s", self.timeout.as_secs_f64())),
        }
    }

    /// On a connection of its own. Redirects are not followed.
    async fn attempt(&self, id: &str, body: Vec<u8>) -> Result<Parts, Silence> {
        let stream = self.dial.dial().await?;
        let (mut sender, connection) = http1::handshake(TokioIo::new(stream)).await?;
        let request = self.request(id, body)?;
        // What stands in the answer is for people with other tools.
        let answer = async move { sender.send_request(request).await.map(|answer| answer.into_parts().0) };
        let (answer, _) = join(answer, connection).await;
        Ok(answer?)
    }

    fn request(&self, id: &str, body: Vec<u8>) -> Result<Request<Body>, Silence> {
        let path = self.url.path_and_query().map_or("/", |path| path.as_str());
        let authority = self.url.authority().map_or("", |authority| authority.as_str());
        let timestamp_s = now().nanos() / SECOND;
        let mut request = Request::post(path)
            .header(HOST, authority)
            .header(USER_AGENT, PROGRAM)
            .header(CONTENT_TYPE, "application/json")
            .header("webhook-id", id)
            .header("webhook-timestamp", timestamp_s);
        if let Some(secret) = &self.secret {
            request = request.header("webhook-signature", secret.sign(id, timestamp_s, &body));
        }
        if let Some(authorization) = &self.authorization {
            request = request.header(AUTHORIZATION, authorization);
        }
        Ok(request.body(Body::from(body))?)
    }
}

/// An error with what is behind it.
fn reasons(error: &(dyn Error + 'static)) -> String {
    let behind = std::iter::successors(error.source(), |&error| error.source());
    behind.fold(error.to_string(), |reasons, error| format!("{reasons}: {error}"))
}

/// What an answer means: a server that cannot now is asked again, one that does not want to is not.
fn answer(Parts { status, headers, .. }: &Parts, now: Time) -> Answer {
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
