//! A delivery: one notice, or a summary of many similar ones.

use std::collections::BTreeMap;

use serde::Serialize;

use super::queue::{Notice, NoticeEffect};
use crate::live::AlertDetails;
use fusion::time::Time;

/// Maximum number of areas that a summary names.
const AREAS: usize = 10;

/// The notices of a delivery, at least one. Those of a summary have the same kind, severity and effect.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NoticeBatch {
    first: Notice,
    others: Vec<Notice>,
}

impl NoticeBatch {
    pub(super) fn new(first: Notice, others: Vec<Notice>) -> Self {
        Self { first, others }
    }

    /// The notice, if the delivery is not a summary.
    pub(super) fn single(&self) -> Option<&Notice> {
        self.others.is_empty().then_some(&self.first)
    }

    pub(super) fn len(&self) -> usize {
        1 + self.others.len()
    }

    pub(super) fn notices(&self) -> impl Iterator<Item = &Notice> {
        std::iter::once(&self.first).chain(&self.others)
    }

    pub(super) fn into_notices(self) -> impl Iterator<Item = Notice> {
        std::iter::once(self.first).chain(self.others)
    }

    /// Id of the delivery; different content has a different id.
    pub(super) fn id(&self, run: &str) -> String {
        let newest = self.notices().map(|notice| notice.number).max().unwrap_or(self.first.number);
        match self.len() {
            1 => format!("{run}-{newest}"),
            several => format!("{run}-{newest}-{several}"),
        }
    }

    /// Time of the latest change.
    pub(super) fn at(&self) -> Time {
        self.notices().map(|notice| notice.at).max().unwrap_or(self.first.at)
    }

    pub(super) fn summary(&self) -> NoticeSummary {
        let (kind, severity) = (self.first.alert.kind.name(), self.first.severity.name());
        let effect = self.first.effect().map_or("changed", NoticeEffect::name);
        let mut counted: BTreeMap<&str, usize> = BTreeMap::new();
        for notice in self.notices() {
            if let AlertDetails::Area { area, .. } | AlertDetails::AreaPredicted { area, .. } =
                &notice.alert.details
            {
                *counted.entry(&area.name).or_default() += 1;
            }
        }
        let mut areas: Vec<AreaCount> =
            counted.into_iter().map(|(name, count)| AreaCount { name: name.to_owned(), count }).collect();
        areas.sort_by_key(|area| std::cmp::Reverse(area.count));
        let count = self.len();
        let mut text = format!("{count} alerts of kind {kind} ({severity}): {effect}");
        for (index, AreaCount { name, count }) in areas.iter().take(AREAS).enumerate() {
            text += if index == 0 { "; " } else { ", " };
            text += &format!("{name}: {count}");
        }
        if areas.len() > AREAS {
            text += &format!(" and {} more areas", areas.len() - AREAS);
            areas.truncate(AREAS);
        }
        let ids = self.notices().map(|notice| notice.alert.name()).collect();
        NoticeSummary { kind, severity, effect, count, text, areas, ids }
    }
}

/// Summary of many similar alerts.
#[derive(Debug, PartialEq, Serialize)]
pub(super) struct NoticeSummary {
    kind: &'static str,
    severity: &'static str,
    /// Effect, the same for all alerts.
    effect: &'static str,
    count: usize,
    /// Text of the summary.
    text: String,
    /// Areas of the alerts, those with the most alerts first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    areas: Vec<AreaCount>,
    /// Ids of the alerts.
    ids: Vec<String>,
}

#[derive(Debug, PartialEq, Serialize)]
struct AreaCount {
    name: String,
    count: usize,
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::body::tests::alert;
    use super::super::queue::PendingNotices;
    use super::*;
    use crate::live::{Alert, AlertChange, AreaName};

    #[test]
    fn summary_counts_alerts_and_areas() {
        let mut queue = PendingNotices::new(100, 2);
        for id in 1..=16 {
            let name = if id <= 5 { "Airfield".to_owned() } else { format!("Field {id}") };
            let area = AreaName { name, identifier: None, kind: None };
            let details = AlertDetails::Area { label: area.name.clone(), area, is_height_unknown: false };
            queue.push(
                AlertChange::Began,
                Arc::new(Alert { details, ..Alert::clone(&alert(id)) }),
                Time::default(),
            );
        }
        let batch = queue.take(Time::default(), |_| {}).unwrap();
        assert_eq!((batch.single(), batch.len(), batch.id("run")), (None, 16, "run-16-16".to_owned()));
        let summary = batch.summary();
        assert_eq!((summary.kind, summary.severity, summary.effect), ("area", "warning", "began"));
        assert_eq!((summary.areas.len(), summary.ids.len(), &*summary.ids[15]), (10, 16, "area-16"));
        assert!(
            summary.text.starts_with("16 alerts of kind area (warning): began; Airfield: 5, Field 10: 1")
        );
        assert!(summary.text.ends_with(" and 2 more areas"), "{}", summary.text);
    }
}
