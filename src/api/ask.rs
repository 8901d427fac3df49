//! A request as the handlers see it, and the usual answers.

use std::net::IpAddr;
use std::sync::Arc;

use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::Response;
use hyper::upgrade::OnUpgrade;
use serde::Serialize;

use super::door::Place;
use super::problem::Problem;
use super::query::Query;
use super::state::ApiState;
use super::tokens::Pass;

/// What is answered: a response, or a problem.
pub type Answer = Result<Response, Problem>;

/// A request.
#[derive(Debug)]
pub struct Ask {
    /// The service.
    pub state: ApiState,
    /// Its parameters.
    pub query: Query,
    /// What is free in the path.
    pub id: String,
    /// Its headers.
    pub headers: HeaderMap,
    /// The client, as a trusted proxy names it; `None` where there is no socket.
    pub client: Option<IpAddr>,
    /// The token of the request.
    pub pass: Pass,
    /// Its body, where the route reads one.
    pub body: Bytes,
    /// The connection as it will be after a change of protocols, where the client asks for one.
    pub upgrade: Option<OnUpgrade>,
    /// The place of the connection; `None` where there is no socket.
    pub place: Option<Arc<Place>>,
}

impl Ask {
    /// A header's text.
    pub fn header(&self, name: impl header::AsHeaderName) -> Option<&str> {
        self.headers.get(name)?.to_str().ok()
    }
}

/// GeoJSON.
pub const GEO_JSON: &str = "application/geo+json";
/// JSON.
pub const JSON: &str = "application/json";

/// 200 with a body that is not to be kept: everything here is live.
pub fn live(content_type: &'static str, body: impl Into<Body>) -> Response {
    with_type(content_type, "no-store", body)
}

/// 200 with a body that may be kept under that rule.
pub fn with_type(content_type: &'static str, cache: &'static str, body: impl Into<Body>) -> Response {
    let mut response = Response::new(body.into());
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(content_type));
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static(cache));
    response
}

/// 304: what the client has is what there is.
pub fn not_modified() -> Response {
    let mut response = Response::new(Body::empty());
    *response.status_mut() = StatusCode::NOT_MODIFIED;
    response.headers_mut().insert(header::CACHE_CONTROL, HeaderValue::from_static("no-cache"));
    response
}

/// Whether `If-None-Match` names the tag: weak comparison (RFC 9110, 8.8.3.2); our tags hold no comma.
pub fn matches(tags: &str, tag: &HeaderValue) -> bool {
    let opaque = |tag: &str| tag.trim().trim_start_matches("W/").to_owned();
    let own = tag.to_str().map(opaque);
    tags.split(',').any(|known| known.trim() == "*" || own.as_ref().is_ok_and(|own| opaque(known) == *own))
}

/// 200 with a value as JSON.
pub fn json(content_type: &'static str, value: &impl Serialize) -> Answer {
    let octets = serde_json::to_vec(value).map_err(|error| {
        Problem::new(StatusCode::INTERNAL_SERVER_ERROR, format!("this is a bug: {error}"))
    })?;
    Ok(live(content_type, octets))
}
