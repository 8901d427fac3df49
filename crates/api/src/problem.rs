//! Errors as `application/problem+json` (RFC 9457).

use axum::body::Body;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::Serialize;

/// Problem of a request, or reason why it cannot be answered now.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(inline)]
pub struct Problem {
    #[serde(skip)]
    status: StatusCode,
    detail: String,
    /// Parameter that is invalid.
    #[serde(skip_serializing_if = "Option::is_none")]
    parameter: Option<String>,
    /// Several reasons, if a detail is not enough.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    reasons: Vec<String>,
    /// Time after which to try again, in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    retry_after_s: Option<u32>,
}

impl Problem {
    /// Problem with a status and a human-readable detail.
    pub fn new(status: StatusCode, detail: impl Into<String>) -> Self {
        Self { status, detail: detail.into(), parameter: None, reasons: Vec::new(), retry_after_s: None }
    }

    /// 400: a parameter breaks this rule.
    pub fn parameter(name: &str, rule: impl Into<String>) -> Self {
        Self { parameter: Some(name.to_owned()), ..Self::new(StatusCode::BAD_REQUEST, rule) }
    }

    /// 404: the name is unknown.
    pub fn not_found(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::NOT_FOUND, detail)
    }

    /// 503, with the reasons.
    pub fn unavailable(detail: impl Into<String>, reasons: Vec<String>) -> Self {
        Self { reasons, ..Self::new(StatusCode::SERVICE_UNAVAILABLE, detail) }
    }

    /// Sets the time after which to try again.
    pub fn retry_after_s(self, seconds: u32) -> Self {
        Self { retry_after_s: Some(seconds), ..self }
    }

    /// HTTP status.
    pub fn status(&self) -> StatusCode {
        self.status
    }
}

/// Type of a problem that is fully described by its status.
const UNTYPED: &str = "about:blank";

/// RFC 9457.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Problem")]
pub struct ProblemJson<'a> {
    #[schemars(extend("const" = UNTYPED))]
    r#type: &'static str,
    title: &'static str,
    status: u16,
    #[serde(flatten)]
    problem: &'a Problem,
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let title = self.status.canonical_reason().unwrap_or("Error");
        let json = ProblemJson { r#type: UNTYPED, title, status: self.status.as_u16(), problem: &self };
        // Texts and numbers can always be written as JSON.
        let mut response = Response::new(Body::from(serde_json::to_vec(&json).unwrap_or_default()));
        *response.status_mut() = self.status;
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
        if let Some(seconds) = self.retry_after_s {
            headers.insert(header::RETRY_AFTER, seconds.into());
        }
        if self.status == StatusCode::UNAUTHORIZED {
            headers.insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
        }
        response
    }
}
