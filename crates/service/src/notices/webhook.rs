//! Webhook: each notice is signed and posted, and posted again after a temporary failure.

use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::http::header::{AUTHORIZATION, CONTENT_TYPE, HOST, USER_AGENT};
use axum::http::response::Parts;
use axum::http::{HeaderValue, Request, Uri};

use super::body;
use super::delivery::NoticeQueue;
use super::signature::SigningSecret;
use crate::live::now;
use crate::net::dial::Dialer;
use crate::net::health::DeliveryResult;
use crate::net::peers::{Closing, closed};
use crate::net::post::{PROGRAM, answer, post};
use fusion::time::SECOND;

/// A webhook as receiver.
#[derive(Debug)]
pub(super) struct Webhook {
    pub(super) queue: Arc<NoticeQueue>,
    pub(super) url: Uri,
    pub(super) dial: Dialer,
    pub(super) secret: Option<SigningSecret>,
    pub(super) authorization: Option<HeaderValue>,
    pub(super) timeout: Duration,
    pub(super) site: String,
    /// Prefix of the ids of this run's notices.
    pub(super) run: String,
}

impl Webhook {
    /// Delivers one notice at a time. When the service ends it returns once the queue is empty, or a delivery fails.
    pub(super) async fn deliver(self, mut closing: Closing) {
        loop {
            let batch = tokio::select! {
                batch = self.queue.next() => batch,
                () = closed(&mut closing) => match self.queue.take() {
                    Some(batch) => batch,
                    None => return,
                },
            };
            let id = batch.id(&self.run);
            let answer = match self.post(&id, body::of_batch(&batch, &id, &self.site)).await {
                Ok(parts) => answer(&parts, now()),
                Err(why) => DeliveryResult::Later { why, after: None },
            };
            let wait = self.queue.settle(batch, answer);
            if wait.is_zero() {
                continue;
            }
            tokio::select! {
                () = tokio::time::sleep(wait) => {}
                () = closed(&mut closing) => return,
            }
        }
    }

    /// Posts a test; returns the receiver's answer, or the error.
    pub(super) async fn test(&self) -> Result<String, String> {
        let id = format!("{}-test", self.run);
        let parts = self.post(&id, body::of_test(&id, &self.site, now())).await?;
        match answer(&parts, now()) {
            DeliveryResult::Taken => Ok(format!("answered {}", parts.status)),
            DeliveryResult::Later { why, .. } | DeliveryResult::Refused { why } => Err(why),
        }
    }

    /// Posts a body; returns the head of the answer.
    async fn post(&self, id: &str, body: Vec<u8>) -> Result<Parts, String> {
        let request = self.request(id, body).map_err(|error| error.to_string())?;
        post(&self.dial, request, self.timeout).await
    }

    fn request(&self, id: &str, body: Vec<u8>) -> Result<Request<Body>, axum::http::Error> {
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
        request.body(Body::from(body))
    }
}
