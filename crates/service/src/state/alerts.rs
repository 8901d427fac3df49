//! Operators' decisions about alerts, as lines. They are among the decisions of a recording (`<name>.decisions.jsonl`). In
//! `[state] dir`, `shelved.jsonl` has the alerts that were shelved when the service ended.
//!
//! ```json
//! {"alert":"area","subject":"U-60000","area":"Runway 27","act":"shelved","by":"tower","time":"2026-11-20T10:05:05.125Z","until":"2026-11-20T10:35:05.125Z","after_ns":1795169098875000000}
//! ```
//!
//! An alert is identified by its subject, because its id changes from run to run. `after_ns` is the time of the last input
//! from which alerts of this kind were derived, in nanoseconds since 1970. The decision applies after that input, and
//! before any later one.

use serde::{Deserialize, Serialize};

use fusion::time::Time;
use site::config::AlertKind;

/// Name of the file in `[state] dir`.
pub const SHELVED: &str = "shelved.jsonl";

/// An operator's decision about an alert.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlertDecision {
    /// Kind of the alert.
    pub kind: AlertKind,
    /// Identifies the alert within its kind.
    pub subject: String,
    /// Name of the alert area; empty if the alert is not about an area.
    pub area: String,
    /// The decision.
    pub act: AlertAct,
    /// Name of the operator.
    pub by: String,
    /// Time of the decision, in milliseconds.
    pub at: Time,
    /// Operator's note.
    pub note: Option<String>,
    /// The decision applies after the input of this time from which alerts of its kind were derived.
    pub after: Time,
}

/// Decision about an alert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlertAct {
    /// Acknowledges the alert.
    Acknowledged,
    /// Suppresses notifications of the alert for some time.
    Shelved {
        /// End of the shelving, in milliseconds.
        until: Time,
    },
    /// Ends the shelving.
    Unshelved,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct AlertLine {
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
    /// Name on the interfaces.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Acknowledged => "acknowledged",
            Self::Shelved { .. } => "shelved",
            Self::Unshelved => "unshelved",
        }
    }
}

/// Line of a decision, with its line feed.
pub fn alert_line(decision: &AlertDecision) -> String {
    let AlertDecision { kind, subject, area, act, by, at, note, after } = decision;
    let line = AlertLine {
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

/// Decision of a line; `None` if the line is not about an alert.
pub(super) fn parse_alert(line: &str) -> Result<Option<AlertDecision>, String> {
    let value: serde_json::Value = serde_json::from_str(line).map_err(|error| error.to_string())?;
    if value.get("alert").is_none() {
        return Ok(None);
    }
    let line: AlertLine = serde_json::from_value(value).map_err(|error| error.to_string())?;
    let AlertLine { alert, subject, area, act, by, time, until, note, after_ns } = line;
    let kind =
        alert.parse().map_err(|error: site::config::UnknownName| format!("alert {alert:?}: {error}"))?;
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
