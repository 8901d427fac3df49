//! `/api/v1/alerts`: active and ended alerts, and operator actions on them.

use std::sync::Arc;
use std::time::Duration;

use axum::http::StatusCode;
use jiff::SignedDuration;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::problem::Problem;
use super::request::{AnswerFuture, ApiRequest};
use picture::Rfc3339;
use service::live::{Alert, AlertAction, AlertJson, AlertKind, AlertRequest, AlertRequestError};

/// Timeout for the observer, which normally answers at once.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(2);
/// Default maximum number of ended alerts in an answer.
const DEFAULT_ENDED: usize = 100;
/// Maximum number of alerts that wait for an acknowledgement in an answer.
const LATCHED: usize = 200;
/// Maximum time for which an alert can be shelved, in minutes.
const MAX_SHELVING_MIN: f64 = 480.0;
/// Maximum length of a name, in characters.
const MAX_NAME: usize = 100;
/// Maximum length of a note, in characters.
const MAX_NOTE: usize = 500;

/// Active and ended alerts.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Alerts")]
pub struct AlertList {
    time: Rfc3339,
    /// Active alerts, most severe first.
    alerts: Vec<AlertJson>,
    /// Ended alerts that were critical and that no operator has acknowledged, latest first; at most 200. They are among the
    /// ended ones too.
    latched: Vec<AlertJson>,
    /// Ended alerts, latest first: the last 100, or at most `limit`. The service keeps the last 5000 while it runs.
    ended: Vec<AlertJson>,
    /// Whether further matching ended alerts were left out.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    more: bool,
}

/// Alerts selected by `?since=`, `?until=`, `?kind=` and `?limit=`.
pub fn all(request: &ApiRequest) -> Result<AlertList, Problem> {
    let query = &request.query;
    let rule = || {
        let kinds = AlertKind::ALL.map(|kind| kind.name());
        format!("kinds of alerts, separated by commas: {}", kinds.join(", "))
    };
    let kinds = query.list("kind", |name| name.parse::<AlertKind>().ok(), rule)?;
    let (since, until) = (query.time("since")?, query.time("until")?);
    if since.zip(until).is_some_and(|(since, until)| until < since) {
        return Err(Problem::parameter("until", "it is not before since"));
    }
    let rule = "alerts that ended at most, 1 to 5000";
    let limit = query.value("limit", rule, |limit| (1..=5_000).contains(limit))?.unwrap_or(DEFAULT_ENDED);

    let known = request.state.hub.alerts();
    let wanted = known.iter().filter(|alert| kinds.as_ref().is_none_or(|kinds| kinds.contains(&alert.kind)));
    let (ended, lasting): (Vec<_>, Vec<_>) = wanted.partition(|alert| alert.until.is_some());
    let is_within = |alert: &&&Arc<Alert>| {
        since.is_none_or(|since| alert.until >= Some(since)) && until.is_none_or(|until| alert.since <= until)
    };
    let latched = ended.iter().filter(|alert| alert.is_latched).take(LATCHED);
    let latched = latched.map(|alert| AlertJson::from(&***alert)).collect();
    let mut ended = ended.iter().filter(is_within);
    Ok(AlertList {
        time: request.state.now().into(),
        alerts: lasting.into_iter().map(|alert| AlertJson::from(&**alert)).collect(),
        latched,
        ended: ended.by_ref().take(limit).map(|alert| AlertJson::from(&***alert)).collect(),
        more: ended.next().is_some(),
    })
}

/// Acknowledgement of an alert, or end of its shelving.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "AlertWord")]
pub struct Acknowledgement {
    /// Name of the operator. Only without authentication; otherwise the name of the token is used.
    #[serde(default)]
    #[schemars(length(max = MAX_NAME))]
    by: Option<String>,
    /// Note stored with the action.
    #[serde(default)]
    #[schemars(length(max = MAX_NOTE))]
    note: Option<String>,
}

/// Shelving: suppresses notifications of an alert for some time.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "AlertShelf")]
pub struct Shelving {
    /// Duration, in minutes; at most 480 (8 hours).
    #[schemars(range(min = 0, max = MAX_SHELVING_MIN))]
    minutes: f64,
    /// Name of the operator. Only without authentication; otherwise the name of the token is used.
    #[serde(default)]
    #[schemars(length(max = MAX_NAME))]
    by: Option<String>,
    /// Note stored with the action.
    #[serde(default)]
    #[schemars(length(max = MAX_NOTE))]
    note: Option<String>,
}

/// Acknowledges an alert.
pub fn acknowledge(request: ApiRequest) -> AnswerFuture<AlertJson> {
    Box::pin(async move {
        let acknowledgement = body::<Acknowledgement>(&request, "{\"note\": \"seen\"}")?;
        decide(&request, AlertAction::Acknowledge, acknowledgement).await
    })
}

/// Shelves an alert for some time.
pub fn shelve(request: ApiRequest) -> AnswerFuture<AlertJson> {
    Box::pin(async move {
        let Shelving { minutes, by, note } = body(&request, "{\"minutes\": 30}")?;
        if !(minutes > 0.0 && minutes <= MAX_SHELVING_MIN) {
            return Err(Problem::parameter(
                "minutes",
                "an alert is shelved for more than 0 and at most 480 minutes",
            ));
        }
        let span = SignedDuration::from_millis((minutes * 60_000.0).ceil() as i64);
        decide(&request, AlertAction::Shelve(span), Acknowledgement { by, note }).await
    })
}

/// Unshelves an alert.
pub fn unshelve(request: ApiRequest) -> AnswerFuture<AlertJson> {
    Box::pin(async move {
        let acknowledgement = body::<Acknowledgement>(&request, "{}")?;
        decide(&request, AlertAction::Unshelve, acknowledgement).await
    })
}

fn body<T: DeserializeOwned>(request: &ApiRequest, such_as: &str) -> Result<T, Problem> {
    serde_json::from_slice(&request.body).map_err(|error| {
        Problem::new(StatusCode::BAD_REQUEST, format!("the body is JSON such as {such_as}: {error}"))
    })
}

async fn decide(
    request: &ApiRequest,
    wanted: AlertAction,
    Acknowledgement { by, note }: Acknowledgement,
) -> Result<AlertJson, Problem> {
    let by = operator_name(request, by)?;
    let note = line("note", note, MAX_NOTE)?;
    let wish = AlertRequest { id: request.id.clone(), action: wanted, by, note };
    let answer = request.state.hub.alert_requests.submit(wish).map_err(problem)?;
    let answered = match tokio::time::timeout(ANSWER_TIMEOUT, answer).await {
        Ok(Ok(answered)) => answered,
        Ok(Err(_)) | Err(_) => Err(AlertRequestError::Gone),
    };
    Ok(AlertJson::from(&answered.map_err(problem)?))
}

/// Name of the operator: that of the token, or without authentication the name `by` that the request gives.
pub(super) fn operator_name(request: &ApiRequest, by: Option<String>) -> Result<String, Problem> {
    let by = line("by", by, MAX_NAME)?;
    match (request.state.access().token_name(request.credential), by) {
        (Some(_), Some(_)) => Err(Problem::parameter("by", "who it is follows from the token; leave it out")),
        (Some(name), None) => Ok(name.to_owned()),
        (None, by) => Ok(by.unwrap_or_else(|| "somebody without a token".to_owned())),
    }
}

/// Checks that a text is one line of at most `most` characters, fit for a log.
fn line(name: &str, text: Option<String>, most: usize) -> Result<Option<String>, Problem> {
    let Some(text) = text.map(|text| text.trim().to_owned()).filter(|text| !text.is_empty()) else {
        return Ok(None);
    };
    if text.chars().count() > most || text.chars().any(char::is_control) {
        return Err(Problem::parameter(name, format!("a line of at most {most} characters")));
    }
    Ok(Some(text))
}

fn problem(not_done: AlertRequestError) -> Problem {
    let status = match not_done {
        AlertRequestError::Unknown => StatusCode::NOT_FOUND,
        AlertRequestError::Ended | AlertRequestError::NotShelved | AlertRequestError::Full => {
            StatusCode::CONFLICT
        }
        AlertRequestError::Busy | AlertRequestError::Gone => {
            return Problem::unavailable(not_done.to_string(), Vec::new()).retry_after_s(1);
        }
    };
    Problem::new(status, not_done.to_string())
}
