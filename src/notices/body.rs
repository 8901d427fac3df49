//! A notice as JSON.

use serde::Serialize;

use super::batch::{Batch, Summary};
use super::queue::Notice;
use crate::live::{Alert, AlertJson, AlertKind, Change, Details, Severity};
use crate::picture::Rfc3339;
use fusion::time::Time;

/// What is posted, and published as an event.
#[derive(Debug, Serialize)]
struct Body<'a> {
    id: &'a str,
    site: &'a str,
    change: &'static str,
    /// What had become of it before, unheard.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    earlier: Vec<&'static str>,
    at: Rfc3339,
    alert: AlertJson,
}

/// Many notices in one.
#[derive(Debug, Serialize)]
struct SummaryBody<'a> {
    id: &'a str,
    site: &'a str,
    change: &'static str,
    at: Rfc3339,
    summary: Summary,
}

/// Body of a delivery; `id` is the same wherever the content is.
pub(super) fn of_batch(batch: &Batch, id: &str, site: &str) -> Vec<u8> {
    if let Some(notice) = batch.single() {
        return of_notice(notice, id, site);
    }
    let (at, summary) = (batch.at().into(), batch.summary());
    json(&SummaryBody { id, site, change: "summary", at, summary })
}

fn of_notice(notice: &Notice, id: &str, site: &str) -> Vec<u8> {
    let Notice { change, earlier, alert, at, .. } = notice;
    let (change, earlier) = (name(*change), earlier.iter().copied().map(name).collect());
    json(&Body { id, site, change, earlier, at: (*at).into(), alert: AlertJson::from(&**alert) })
}

/// That of a test: an alert of the service that ended as it began.
pub(super) fn of_test(id: &str, site: &str, now: Time) -> Vec<u8> {
    let alert = Alert {
        id: 0,
        kind: AlertKind::Service,
        severity: Severity::Warning,
        since: now,
        until: Some(now),
        text: "this is a test".to_owned(),
        subject: "test".to_owned(),
        details: Details::None,
        acknowledged: None,
        shelved: None,
        revision: 0,
    };
    json(&Body {
        id,
        site,
        change: "test",
        earlier: Vec::new(),
        at: now.into(),
        alert: AlertJson::from(&alert),
    })
}

/// An alert alone, as the API shows it.
pub(super) fn of_alert(alert: &Alert) -> Vec<u8> {
    json(&AlertJson::from(alert))
}

fn json(value: &impl Serialize) -> Vec<u8> {
    serde_json::to_vec(value).expect("texts and numbers are JSON")
}

const fn name(change: Change) -> &'static str {
    match change {
        Change::Began => "began",
        Change::Changed => "changed",
        Change::Amended => "amended",
        Change::Acknowledged => "acknowledged",
        Change::Shelved => "shelved",
        Change::Unshelved => "unshelved",
        Change::Ended => "ended",
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::live::Shelved;

    /// An alert that lasts.
    pub(in super::super) fn alert(id: u64) -> Arc<Alert> {
        Arc::new(Alert {
            id,
            kind: AlertKind::Area,
            severity: Severity::Warning,
            since: Time::from_nanos(1_763_000_000_000_000_000),
            until: None,
            text: "T-1 is inside Airfield".to_owned(),
            subject: "T-1".to_owned(),
            details: Details::None,
            acknowledged: None,
            shelved: None,
            revision: 0,
        })
    }

    pub(in super::super) fn shelved(id: u64) -> Arc<Alert> {
        let (at, until) = (Time::default(), Time::from_nanos(60_000_000_000));
        let shelf = Shelved { by: "desk".to_owned(), at, until, note: None };
        Arc::new(Alert { shelved: Some(shelf), ..Alert::clone(&alert(id)) })
    }

    #[test]
    fn a_notice_holds_the_alert_as_the_api_shows_it() {
        let notice = Notice {
            number: 3,
            change: Change::Acknowledged,
            earlier: vec![Change::Began],
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
