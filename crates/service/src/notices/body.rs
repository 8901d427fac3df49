//! JSON of a notice.

use serde::Serialize;

use super::batch::{NoticeBatch, NoticeSummary};
use super::queue::Notice;
use crate::live::{Alert, AlertChange, AlertDetails, AlertJson, AlertKind, Severity};
use fusion::time::Time;
use picture::Rfc3339;

/// Body of a posted notice, or of a published event.
#[derive(Debug, Serialize)]
struct NoticeBody<'a> {
    id: &'a str,
    site: &'a str,
    change: &'static str,
    /// Earlier changes that were not sent.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    earlier: Vec<&'static str>,
    at: Rfc3339,
    alert: AlertJson,
}

/// Body of a summary.
#[derive(Debug, Serialize)]
struct SummaryBody<'a> {
    id: &'a str,
    site: &'a str,
    change: &'static str,
    at: Rfc3339,
    summary: NoticeSummary,
}

/// Body of a delivery; the same `id` means the same content.
pub(super) fn of_batch(batch: &NoticeBatch, id: &str, site: &str) -> Vec<u8> {
    if let Some(notice) = batch.single() {
        return of_notice(notice, id, site);
    }
    let (at, summary) = (batch.at().into(), batch.summary());
    json(&SummaryBody { id, site, change: "summary", at, summary })
}

fn of_notice(notice: &Notice, id: &str, site: &str) -> Vec<u8> {
    let Notice { change, earlier, alert, at, .. } = notice;
    let (change, earlier) = (name(*change), earlier.iter().copied().map(name).collect());
    json(&NoticeBody { id, site, change, earlier, at: (*at).into(), alert: AlertJson::from(&**alert) })
}

/// Body of a test: an alert of the service that ends as it begins.
pub(super) fn of_test(id: &str, site: &str, now: Time) -> Vec<u8> {
    let alert = Alert {
        id: 0,
        kind: AlertKind::Service,
        severity: Severity::Warning,
        worst: Severity::Warning,
        since: now,
        until: Some(now),
        text: "this is a test".to_owned(),
        subject: "test".to_owned(),
        details: AlertDetails::None,
        acknowledged: None,
        shelved: None,
        is_latched: false,
        revision: 0,
    };
    json(&NoticeBody {
        id,
        site,
        change: "test",
        earlier: Vec::new(),
        at: now.into(),
        alert: AlertJson::from(&alert),
    })
}

/// JSON of an alert alone, as in the API.
pub(super) fn of_alert(alert: &Alert) -> Vec<u8> {
    json(&AlertJson::from(alert))
}

fn json(value: &impl Serialize) -> Vec<u8> {
    serde_json::to_vec(value).expect("texts and numbers are JSON")
}

const fn name(change: AlertChange) -> &'static str {
    match change {
        AlertChange::Began => "began",
        AlertChange::Changed => "changed",
        AlertChange::Amended => "amended",
        AlertChange::Acknowledged => "acknowledged",
        AlertChange::Shelved => "shelved",
        AlertChange::Unshelved => "unshelved",
        AlertChange::Ended => "ended",
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::live::Shelved;

    /// An active alert.
    pub(in super::super) fn alert(id: u64) -> Arc<Alert> {
        Arc::new(Alert {
            id,
            kind: AlertKind::Area,
            severity: Severity::Warning,
            worst: Severity::Warning,
            since: Time::from_nanos(1_763_000_000_000_000_000),
            until: None,
            text: "T-1 is inside Airfield".to_owned(),
            subject: "T-1".to_owned(),
            details: AlertDetails::None,
            acknowledged: None,
            shelved: None,
            is_latched: false,
            revision: 0,
        })
    }

    pub(in super::super) fn shelved(id: u64) -> Arc<Alert> {
        let (at, until) = (Time::default(), Time::from_nanos(60_000_000_000));
        let shelf = Shelved { by: "desk".to_owned(), at, until, note: None };
        Arc::new(Alert { shelved: Some(shelf), ..Alert::clone(&alert(id)) })
    }

    #[test]
    fn notice_contains_the_alert_json_of_the_api() {
        let notice = Notice {
            number: 3,
            change: AlertChange::Acknowledged,
            earlier: vec![AlertChange::Began],
            alert: alert(7),
            at: Time::from_nanos(1_763_000_001_250_000_000),
            severity: Severity::Warning,
        };
        let body = String::from_utf8(of_notice(&notice, "a-3", "north")).unwrap();
        let wanted = concat!(
            r#"{"id":"a-3","site":"north","change":"acknowledged","earlier":["began"],"#,
            r#""at":"2025-11-13T02:13:21.250Z","alert":{"id":"area-7","kind":"area","severity":"warning","#,
            r#""since":"2025-11-13T02:13:20.000Z","text":"T-1 is inside Airfield","track":"T-1"}}"#
        );
        assert_eq!(body, wanted);
    }
}
