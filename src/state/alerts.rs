//! Operators' decisions about alerts, as lines: among those of a recording (`<name>.decisions.jsonl`), and in `[state] dir`
//! `shelved.jsonl`, the alerts that were shelved when the service ended.
//!
//! ```json
//! {"alert":"area","subject":"U-60000","area":"Runway 27","act":"shelved","by":"tower","time":"2026-11-20T10:05:05.125Z","until":"2026-11-20T10:35:05.125Z","after_ns":1795169098875000000}
//! ```
//!
//! An alert is named by what it is about: its id changes from run to run. `after_ns` is the time of what alerts of its kind had
//! been derived from last, nanoseconds since 1970: the decision counts behind that, and before anything later.

use serde::{Deserialize, Serialize};

use crate::config::AlertKind;
use fusion::time::Time;

/// The name of the file of `[state] dir`.
pub const SHELVED: &str = "shelved.jsonl";

/// What an operator decided about an alert.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlertDecision {
    /// The kind of the alert.
    pub kind: AlertKind,
    /// What tells it from others of its kind.
    pub subject: String,
    /// The alert area; empty where it is about none.
    pub area: String,
    /// What was decided.
    pub act: AlertAct,
    /// Who decided.
    pub by: String,
    /// When, to the millisecond.
    pub at: Time,
    /// What he says to it.
    pub note: Option<String>,
    /// It counts behind what alerts of its kind were derived from at this time.
    pub after: Time,
}

/// What can be decided about an alert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlertAct {
    /// Somebody has seen it.
    Acknowledged,
    /// Nobody is to be bothered with it for a while.
    Shelved {
        /// When that ends, to the millisecond.
        until: Time,
    },
    /// That while is over.
    Unshelved,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    alert: String,
    subject: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    area: String,
    act: String,
    by: String,
    time: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    until: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    note: Option<String>,
    after_ns: i64,
}

impl AlertAct {
    /// Its name on the interfaces.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Acknowledged => "acknowledged",
            Self::Shelved { .. } => "shelved",
            Self::Unshelved => "unshelved",
        }
    }
}

/// The line of a decision, with its line feed.
pub fn alert_line(decision: &AlertDecision) -> String {
    let AlertDecision { kind, subject, area, act, by, at, note, after } = decision;
    let line = Line {
        alert: kind.name().to_owned(),
        subject: subject.clone(),
        area: area.clone(),
        act: act.name().to_owned(),
        by: by.clone(),
        time: at.to_string(),
        until: match act {
            AlertAct::Shelved { until } => Some(until.to_string()),
            AlertAct::Acknowledged | AlertAct::Unshelved => None,
        },
        note: note.clone(),
        after_ns: after.nanos(),
    };
    serde_json::to_string(&line).expect("numbers and text are JSON") + "\n"
}

/// The decision of a line; `None`: it is about something else than an alert.
pub(super) fn parse_alert(line: &str) -> Result<Option<AlertDecision>, String> {
    let value: serde_json::Value = serde_json::from_str(line).map_err(|error| error.to_string())?;
    if value.get("alert").is_none() {
        return Ok(None);
    }
    let line: Line = serde_json::from_value(value).map_err(|error| error.to_string())?;
    let Line { alert, subject, area, act, by, time, until, note, after_ns } = line;
    let kind =
        alert.parse().map_err(|error: crate::config::UnknownName| format!("alert {alert:?}: {error}"))?;
    let act = match (&*act, until) {
        ("acknowledged", None) => AlertAct::Acknowledged,
        ("shelved", Some(until)) => AlertAct::Shelved { until: moment(&until)? },
        ("unshelved", None) => AlertAct::Unshelved,
        ("acknowledged" | "unshelved", Some(_)) => {
            return Err("only what is shelved has \"until\"".to_owned());
        }
        ("shelved", None) => return Err("what is shelved needs \"until\"".to_owned()),
        _ => return Err(format!("act {act:?} is none of acknowledged, shelved, unshelved")),
    };
    let (at, after) = (moment(&time)?, Time::from_nanos(after_ns));
    Ok(Some(AlertDecision { kind, subject, area, act, by, at, note, after }))
}

fn moment(text: &str) -> Result<Time, String> {
    let stamp: jiff::Timestamp = text.parse().map_err(|error| format!("{text:?}: {error}"))?;
    let nanos = i64::try_from(stamp.as_nanosecond());
    nanos.map(Time::from_nanos).map_err(|_| format!("{text} is too far from 1970"))
}
