//! Request data for the handlers, and common responses.

use std::future::Future;
use std::net::IpAddr;
use std::pin::Pin;
use std::sync::Arc;

use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::Response;
use hyper::upgrade::OnUpgrade;
use serde::Serialize;

use super::connection_limit::CountedConnection;
use super::problem::Problem;
use super::query::Query;
use super::state::ApiState;
use super::tokens::Credential;

/// Result of a handler: a response, or a problem.
pub type ApiResult = Result<Response, Problem>;

/// Answer of an asynchronous handler.
pub type AnswerFuture<T> = Pin<Box<dyn Future<Output = Result<T, Problem>> + Send>>;

/// A request.
#[derive(Debug)]
pub struct ApiRequest {
    /// State of the API.
    pub state: ApiState,
    /// Query parameters.
    pub query: Query,
    /// Free part of the path.
    pub id: String,
    /// Request headers.
    pub headers: HeaderMap,
    /// Address of the client, as reported by a trusted proxy; `None` without a socket.
    pub client: Option<IpAddr>,
    /// Token of the request.
    pub credential: Credential,
    /// Request body, if the route reads one.
    pub body: Bytes,
    /// Upgraded connection, if the client asks for a change of protocols.
    pub upgrade: Option<OnUpgrade>,
    /// Entry of the connection in the connection limit; `None` without a socket.
    pub connection: Option<Arc<CountedConnection>>,
}

impl ApiRequest {
    /// Text of a header.
    pub fn header(&self, name: impl header::AsHeaderName) -> Option<&str> {
        self.headers.get(name)?.to_str().ok()
    }
}

/// Media type of GeoJSON.
pub const GEO_JSON: &str = "application/geo+json";
/// Media type of JSON.
pub const JSON: &str = "application/json";

/// 200 with a body that must not be cached, because all data here are live.
pub fn live(content_type: &'static str, body: impl Into<Body>) -> Response {
    with_type(content_type, "no-store", body)
}

/// 200 with a body and a `Cache-Control` rule.
pub fn with_type(content_type: &'static str, cache: &'static str, body: impl Into<Body>) -> Response {
    let mut response = Response::new(body.into());
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(content_type));
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static(cache));
    response
}

/// 304: the client's copy is current.
pub fn not_modified() -> Response {
    let mut response = Response::new(Body::empty());
    *response.status_mut() = StatusCode::NOT_MODIFIED;
    response.headers_mut().insert(header::CACHE_CONTROL, HeaderValue::from_static("no-cache"));
    response
}

/// Whether `If-None-Match` contains the tag, by weak comparison (RFC 9110, 8.8.3.2). The tags of this service contain no comma.
pub fn matches(tags: &str, tag: &HeaderValue) -> bool {
    let opaque = |tag: &str| tag.trim().trim_start_matches("W/").to_owned();
    let own = tag.to_str().map(opaque);
    tags.split(',').any(|known| known.trim() == "*" || own.as_ref().is_ok_and(|own| opaque(known) == *own))
}

/// 200 with a value as JSON.
pub fn json(content_type: &'static str, value: &impl Serialize) -> ApiResult {
    let octets = serde_json::to_vec(value).map_err(|error| {
        Problem::new(StatusCode::INTERNAL_SERVER_ERROR, format!("this is a bug: {error}"))
    })?;
    Ok(live(content_type, octets))
}
