//! `[[output.f3623]]`: observations for surveillance supplementary data (ASTM F3623), posted once a second.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::http::header::{AUTHORIZATION, CONTENT_TYPE, HOST, USER_AGENT};
use axum::http::{HeaderValue, Request, Uri};
use tokio::time::{sleep, timeout};

use super::PictureSink;
use super::counts::SinkLoss;
use super::delivery::SinkQueue;
use super::second::PictureSecond;
use crate::live::now;
use crate::net::dial::{Certificates, Dialer};
use crate::net::health::DeliveryResult;
use crate::net::peers::{Closing, closed, is_local};
use crate::net::post::{PROGRAM, answer, post};
use crate::net::secret::secret;
use picture::formats::observations;
use site::config;

/// A sink that posts over HTTP.
pub(super) struct F3623Sink {
    pub(super) queue: Arc<SinkQueue>,
    url: Uri,
    dial: Dialer,
    /// File of the token, read at each post, so that a renewed token needs no restart.
    token_file: Option<PathBuf>,
    timeout: Duration,
}

impl fmt::Debug for F3623Sink {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("F3623Sink")
            .field("queue", &self.queue)
            .field("dial", &self.dial)
            .finish_non_exhaustive()
    }
}

/// Opens a sink; no connection is made yet.
pub(super) fn open(f3623: &config::F3623) -> Result<PictureSink, String> {
    let config::F3623 { id, url, token_file, ca, picture, timeout_s } = f3623;
    let host = url.host().unwrap_or_default();
    let dial = if f3623.is_tls() {
        let proofs = Certificates { ca: ca.as_deref(), ..Certificates::default() };
        Dialer::tls(host, url.port_u16().unwrap_or(443), &proofs)?
    } else {
        Dialer::plain(host, url.port_u16().unwrap_or(80))
    };
    let posts = F3623Sink {
        queue: Arc::new(SinkQueue::new(format!("f3623:{id}"), *picture)),
        url: url.clone(),
        dial,
        token_file: token_file.clone(),
        timeout: timeout_s.unsigned_abs(),
    };
    posts.authorization()?;
    Ok(PictureSink::Posts(posts))
}

/// A description of the sink. The URL's path is left out, because it may be a secret.
pub(super) fn line(f3623: &config::F3623) -> String {
    let config::F3623 { id, url, token_file, picture, .. } = f3623;
    let origin = format!(
        "{}://{}/…",
        url.scheme_str().unwrap_or_default(),
        url.authority().map_or("", |authority| authority.as_str())
    );
    let who = if token_file.is_some() { "with a token" } else { "without a token" };
    format!("picture to f3623:{id}: {origin}, {who}, {}", picture.name())
}

/// A weakness of the configuration that the operator should remove.
pub(super) fn warning(f3623: &config::F3623) -> Option<String> {
    let is_open = f3623.token_file.is_some() && !f3623.is_tls();
    (is_open && !is_local(f3623.url.host().unwrap_or_default()))
        .then(|| format!("f3623:{}: its token travels beyond this machine without TLS", f3623.id))
}

impl F3623Sink {
    /// Posts one second at a time until the service ends.
    pub(super) async fn deliver(self, mut closing: Closing) {
        loop {
            let second = tokio::select! {
                second = self.queue.next() => second,
                () = closed(&mut closing) => match self.queue.take() {
                    Some(second) => second,
                    None => return,
                },
            };
            let Some(wait) = self.send(&second).await else { continue };
            tokio::select! {
                () = sleep(wait) => {}
                () = closed(&mut closing) => return,
            }
        }
    }

    /// Whether the receiver accepts a connection.
    pub(super) async fn reach(&self) -> Result<(), String> {
        match timeout(self.timeout, self.dial.dial()).await {
            Ok(connected) => connected.map(drop).map_err(|error| error.to_string()),
            Err(_) => Err(format!("no connection within {} s", self.timeout.as_secs_f64())),
        }
    }

    /// Posts a second; returns the pause after a failure.
    async fn send(&self, second: &PictureSecond) -> Option<Duration> {
        let (body, left_out) = observations(second.tracks(), &second.maker);
        self.queue.left_out(left_out);
        let sent = async {
            let request = self.request(body)?;
            post(&self.dial, request, self.timeout).await
        };
        let answered = sent.await.map(|parts| answer(&parts, now()));
        match answered.unwrap_or_else(|why| DeliveryResult::Later { why, after: None }) {
            DeliveryResult::Taken => {
                self.queue.sent(1);
                self.queue.works();
                None
            }
            DeliveryResult::Later { why, after } => {
                let wait = self.queue.fails(why, Some(SinkLoss::Unreachable));
                Some(after.map_or(wait, |after| after.max(wait).min(LONGEST_ASKED)))
            }
            DeliveryResult::Refused { why } => Some(self.queue.fails(why, Some(SinkLoss::Refused))),
        }
    }

    fn request(&self, body: Vec<u8>) -> Result<Request<Body>, String> {
        let path = self.url.path_and_query().map_or("/", |path| path.as_str());
        let authority = self.url.authority().map_or("", |authority| authority.as_str());
        let mut request = Request::post(path)
            .header(HOST, authority)
            .header(USER_AGENT, PROGRAM)
            .header(CONTENT_TYPE, "application/json");
        if let Some(authorization) = self.authorization()? {
            request = request.header(AUTHORIZATION, authorization);
        }
        request.body(Body::from(body)).map_err(|error| error.to_string())
    }

    fn authorization(&self) -> Result<Option<HeaderValue>, String> {
        let Some(token) = secret(self.token_file.as_deref(), None)? else { return Ok(None) };
        let value = HeaderValue::from_str(&format!("Bearer {token}"));
        let mut value = value.map_err(|_| "token_file holds what no header can".to_owned())?;
        value.set_sensitive(true);
        Ok(Some(value))
    }
}

/// Maximum pause that a receiver may ask for.
const LONGEST_ASKED: Duration = Duration::from_secs(300);
