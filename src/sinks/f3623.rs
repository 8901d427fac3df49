//! `[[output.f3623]]`: observations for surveillance supplementary data (ASTM F3623), posted once a second.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::http::header::{AUTHORIZATION, CONTENT_TYPE, HOST, USER_AGENT};
use axum::http::{HeaderValue, Request, Uri};
use tokio::time::{sleep, timeout};

use super::Sink;
use super::counts::Loss;
use super::desk::Desk;
use super::second::Second;
use crate::config;
use crate::formats::observations;
use crate::live::now;
use crate::net::dial::{Dial, Proofs};
use crate::net::health::Answer;
use crate::net::peers::{Closing, closed, is_local};
use crate::net::post::{PROGRAM, answer, post};
use crate::net::secret::secret;

/// One sink.
pub(super) struct Posts {
    pub(super) desk: Arc<Desk>,
    url: Uri,
    dial: Dial,
    /// Read at each post: whoever renews the token has to say nothing.
    token_file: Option<PathBuf>,
    timeout: Duration,
}

impl fmt::Debug for Posts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Posts").field("desk", &self.desk).field("dial", &self.dial).finish_non_exhaustive()
    }
}

/// Opens a sink; nobody is connected to yet.
pub(super) fn open(f3623: &config::F3623) -> Result<Sink, String> {
    let config::F3623 { id, url, token_file, ca, picture, timeout_s } = f3623;
    let host = url.host().unwrap_or_default();
    let dial = if f3623.is_tls() {
        let proofs = Proofs { ca: ca.as_deref(), ..Proofs::default() };
        Dial::tls(host, url.port_u16().unwrap_or(443), &proofs)?
    } else {
        Dial::plain(host, url.port_u16().unwrap_or(80))
    };
    let posts = Posts {
        desk: Arc::new(Desk::new(format!("f3623:{id}"), *picture)),
        url: url.clone(),
        dial,
        token_file: token_file.clone(),
        timeout: timeout_s.unsigned_abs(),
    };
    posts.authorization()?;
    Ok(Sink::Posts(posts))
}

/// For people: what follows the host may be a secret.
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

/// What works and should not stay so.
pub(super) fn warning(f3623: &config::F3623) -> Option<String> {
    let is_open = f3623.token_file.is_some() && !f3623.is_tls();
    (is_open && !is_local(f3623.url.host().unwrap_or_default()))
        .then(|| format!("f3623:{}: its token travels beyond this machine without TLS", f3623.id))
}

impl Posts {
    /// Posts what comes until the service ends. One post at a time: what comes meanwhile waits.
    pub(super) async fn deliver(self, mut closing: Closing) {
        loop {
            let second = tokio::select! {
                second = self.desk.next() => second,
                () = closed(&mut closing) => match self.desk.take() {
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

    /// Whether it can be connected to.
    pub(super) async fn reach(&self) -> Result<(), String> {
        match timeout(self.timeout, self.dial.dial()).await {
            Ok(connected) => connected.map(drop).map_err(|error| error.to_string()),
            Err(_) => Err(format!("no connection within {} s", self.timeout.as_secs_f64())),
        }
    }

    /// Posts a second; how long to wait where it was not taken.
    async fn send(&self, second: &Second) -> Option<Duration> {
        let (body, left_out) = observations(second.tracks(), &second.maker);
        self.desk.left_out(left_out);
        let sent = async {
            let request = self.request(body)?;
            post(&self.dial, request, self.timeout).await
        };
        let answered = sent.await.map(|parts| answer(&parts, now()));
        match answered.unwrap_or_else(|why| Answer::Later { why, after: None }) {
            Answer::Taken => {
                self.desk.sent(1);
                self.desk.works();
                None
            }
            Answer::Later { why, after } => {
                let wait = self.desk.fails(why, Some(Loss::Unreachable));
                Some(after.map_or(wait, |after| after.max(wait).min(LONGEST_ASKED)))
            }
            Answer::Refused { why } => Some(self.desk.fails(why, Some(Loss::Refused))),
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

/// The longest that a receiver may ask for: what comes later is another picture.
const LONGEST_ASKED: Duration = Duration::from_secs(300);
