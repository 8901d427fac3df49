//! `/api/v1/alerts`: what is wrong, what was, and what operators do about it.

use std::sync::Arc;
use std::time::Duration;

use axum::http::StatusCode;
use jiff::SignedDuration;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::ask::Ask;
use super::problem::Problem;
use super::route::Later;
use crate::live::{Alert, AlertJson, AlertKind, AlertWish, NotDone, Wanted};
use crate::picture::Rfc3339;

/// The observer answers at once; without an answer by then the request fails.
const PATIENCE: Duration = Duration::from_secs(2);
/// Alerts that ended, where nobody says how many.
const ENDED: usize = 100;
/// The longest that an alert can be shelved, minutes.
const LONGEST_MIN: f64 = 480.0;
/// Characters of a name, and of a note.
const NAME: usize = 100;
const NOTE: usize = 500;

/// What is wrong, and what was.
#[derive(Serialize, JsonSchema)]
pub struct Alerts {
    time: Rfc3339,
    /// Those that last, the worst first.
    alerts: Vec<AlertJson>,
    /// Those that ended, the latest first: the last 100, or as many as `limit`. The last 5000 are remembered while the service
    /// runs.
    ended: Vec<AlertJson>,
    /// Further ones that ended match and are left off.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    more: bool,
}

/// `?since=`, `?until=`, `?kind=`, `?limit=`.
pub fn all(ask: &Ask) -> Result<Alerts, Problem> {
    let query = &ask.query;
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
    let limit = query.value("limit", rule, |limit| (1..=5_000).contains(limit))?.unwrap_or(ENDED);

    let known = ask.state.hub.alerts();
    let wanted = known.iter().filter(|alert| kinds.as_ref().is_none_or(|kinds| kinds.contains(&alert.kind)));
    let (ended, lasting): (Vec<_>, Vec<_>) = wanted.partition(|alert| alert.until.is_some());
    let is_within = |alert: &&&Arc<Alert>| {
        since.is_none_or(|since| alert.until >= Some(since)) && until.is_none_or(|until| alert.since <= until)
    };
    let mut ended = ended.iter().filter(is_within);
    Ok(Alerts {
        time: ask.state.now().into(),
        alerts: lasting.into_iter().map(|alert| AlertJson::from(&**alert)).collect(),
        ended: ended.by_ref().take(limit).map(|alert| AlertJson::from(&***alert)).collect(),
        more: ended.next().is_some(),
    })
}

/// Who has seen an alert.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "AlertWord")]
pub struct Word {
    /// Who says so, where the service asks for no token: else it is the token's name.
    #[serde(default)]
    #[schemars(length(max = NAME))]
    by: Option<String>,
    /// What is to be remembered with it.
    #[serde(default)]
    #[schemars(length(max = NOTE))]
    note: Option<String>,
}

/// For how long nobody is to be bothered.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "AlertShelf")]
pub struct Shelf {
    /// For how long; at most 8 hours.
    #[schemars(range(min = 0, max = LONGEST_MIN))]
    minutes: f64,
    /// Who says so, where the service asks for no token: else it is the token's name.
    #[serde(default)]
    #[schemars(length(max = NAME))]
    by: Option<String>,
    /// What is to be remembered with it.
    #[serde(default)]
    #[schemars(length(max = NOTE))]
    note: Option<String>,
}

/// Somebody has seen it.
pub fn acknowledge(ask: Ask) -> Later<AlertJson> {
    Box::pin(async move {
        let word = body::<Word>(&ask, "{\"note\": \"seen\"}")?;
        decide(&ask, Wanted::Acknowledge, word).await
    })
}

/// Nobody is to be bothered with it for a while.
pub fn shelve(ask: Ask) -> Later<AlertJson> {
    Box::pin(async move {
        let Shelf { minutes, by, note } = body(&ask, "{\"minutes\": 30}")?;
        if !(minutes > 0.0 && minutes <= LONGEST_MIN) {
            return Err(Problem::parameter(
                "minutes",
                "an alert is shelved for more than 0 and at most 480 minutes",
            ));
        }
        let span = SignedDuration::from_millis((minutes * 60_000.0).ceil() as i64);
        decide(&ask, Wanted::Shelve(span), Word { by, note }).await
    })
}

/// That while is over.
pub fn unshelve(ask: Ask) -> Later<AlertJson> {
    Box::pin(async move {
        let word = body::<Word>(&ask, "{}")?;
        decide(&ask, Wanted::Unshelve, word).await
    })
}

fn body<T: DeserializeOwned>(ask: &Ask, such_as: &str) -> Result<T, Problem> {
    serde_json::from_slice(&ask.body).map_err(|error| {
        Problem::new(StatusCode::BAD_REQUEST, format!("the body is JSON such as {such_as}: {error}"))
    })
}

async fn decide(ask: &Ask, wanted: Wanted, Word { by, note }: Word) -> Result<AlertJson, Problem> {
    let by = line("by", by, NAME)?;
    let note = line("note", note, NOTE)?;
    let by = match (ask.state.terms().name_of(ask.pass), by) {
        (Some(_), Some(_)) => {
            return Err(Problem::parameter("by", "who it is follows from the token; leave it out"));
        }
        (Some(name), None) => name.to_owned(),
        (None, by) => by.unwrap_or_else(|| "somebody without a token".to_owned()),
    };
    let wish = AlertWish { id: ask.id.clone(), wanted, by, note };
    let answer = ask.state.hub.alert_desk.ask(wish).map_err(problem)?;
    let answered = match tokio::time::timeout(PATIENCE, answer).await {
        Ok(Ok(answered)) => answered,
        Ok(Err(_)) | Err(_) => Err(NotDone::Gone),
    };
    Ok(AlertJson::from(&answered.map_err(problem)?))
}

/// Text of a line, which a log can show.
fn line(name: &str, text: Option<String>, most: usize) -> Result<Option<String>, Problem> {
    let Some(text) = text.map(|text| text.trim().to_owned()).filter(|text| !text.is_empty()) else {
        return Ok(None);
    };
    if text.chars().count() > most || text.chars().any(char::is_control) {
        return Err(Problem::parameter(name, format!("a line of at most {most} characters")));
    }
    Ok(Some(text))
}

fn problem(not_done: NotDone) -> Problem {
    let status = match not_done {
        NotDone::Unknown => StatusCode::NOT_FOUND,
        NotDone::Ended | NotDone::NotShelved | NotDone::Full => StatusCode::CONFLICT,
        NotDone::Busy | NotDone::Gone => {
            return Problem::unavailable(not_done.to_string(), Vec::new()).retry_after_s(1);
        }
    };
    Problem::new(status, not_done.to_string())
}
