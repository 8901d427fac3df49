//! A request as the handlers see it, and how its parameters are read: each mistake names the parameter and the rule.

use std::net::IpAddr;
use std::str::FromStr;

use axum::body::Body;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::Response;
use serde::Serialize;

use super::ApiState;
use super::auth::Pass;
use super::problem::Problem;

/// What is answered: a response, or a problem.
pub type Answer = Result<Response, Problem>;

/// A request.
#[derive(Debug)]
pub struct Ask {
    /// The service.
    pub state: ApiState,
    /// The parameters behind the `?`, each at most once.
    pub query: Vec<(String, String)>,
    /// The `{id}` in the path.
    pub id: String,
    /// Its headers.
    pub headers: HeaderMap,
    /// Who asks, as a trusted proxy says it; `None` where no socket is in between.
    pub client: Option<IpAddr>,
    /// By which token.
    pub pass: Pass,
}

impl Ask {
    /// A parameter's text, where it is given.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.query.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// A parameter that is `valid`; `rule` says which are.
    pub fn value<T: FromStr>(
        &self,
        name: &str,
        rule: &str,
        valid: impl Fn(&T) -> bool,
    ) -> Result<Option<T>, Problem> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let value = text.parse().ok().filter(valid);
        value.map(Some).ok_or_else(|| Problem::parameter(name, rule))
    }

    /// A list of finite numbers, as many as that.
    pub fn numbers<const N: usize>(&self, name: &str, rule: &str) -> Result<Option<[f64; N]>, Problem> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let read = |part: &str| part.trim().parse().ok().filter(|number: &f64| number.is_finite());
        let numbers: Option<Vec<f64>> = text.split(',').map(read).collect();
        let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
        numbers.map(Some).ok_or_else(|| Problem::parameter(name, rule))
    }

    /// A header's text.
    pub fn header(&self, name: impl header::AsHeaderName) -> Option<&str> {
        self.headers.get(name)?.to_str().ok()
    }
}

/// The parameters of a query; `None` for one that comes twice.
pub fn parse_query(query: &str) -> Result<Vec<(String, String)>, Problem> {
    let mut parameters: Vec<(String, String)> = Vec::new();
    for (name, value) in form_urlencoded::parse(query.as_bytes()) {
        if parameters.iter().any(|(known, _)| *known == name) {
            return Err(Problem::parameter(
                &name,
                "a parameter is given once; values of a list are separated by commas",
            ));
        }
        parameters.push((name.into_owned(), value.into_owned()));
    }
    Ok(parameters)
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
