//! Retained messages of a broker: one topic for each active alert. Sans-IO.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::live::{Alert, Severity};

/// Topic without the prefix: `alerts/area/area-7`.
pub(super) type Topic = String;

#[derive(Debug, Default)]
pub(super) struct Mirror {
    /// Messages that the broker shall retain.
    wanted: BTreeMap<Topic, Arc<Alert>>,
    /// Topics that the broker retains, or may retain.
    retained: BTreeSet<Topic>,
    /// Topics with changes not published yet.
    news: BTreeSet<Topic>,
}

impl Mirror {
    /// Updates an alert. `is_shown`: it is retained while active.
    pub(super) fn note(&mut self, alert: &Arc<Alert>, is_shown: bool) {
        let topic = format!("alerts/{}/{}", alert.kind.name(), alert.name());
        if is_shown && alert.until.is_none() {
            self.wanted.insert(topic.clone(), alert.clone());
            self.news.insert(topic);
        } else if self.wanted.remove(&topic).is_some() {
            self.news.insert(topic);
        }
    }

    /// A connection begins: it is unknown what the broker still retains.
    pub(super) fn begin(&mut self) {
        self.news = self.wanted.keys().chain(&self.retained).cloned().collect();
    }

    /// The broker retains a message on this topic, possibly of an earlier run.
    pub(super) fn found(&mut self, topic: &str) {
        if !self.wanted.contains_key(topic) {
            self.retained.insert(topic.to_owned());
            self.news.insert(topic.to_owned());
        }
    }

    /// The service ends: all retained messages are to be cleared, because they would be outdated.
    pub(super) fn end(&mut self) {
        self.wanted.clear();
        self.news = self.retained.clone();
    }

    /// Whether a critical alert waits to be published.
    pub(super) fn is_urgent(&self) -> bool {
        self.first_critical().is_some()
    }

    fn first_critical(&self) -> Option<&Topic> {
        let is_critical = |topic: &&Topic| {
            self.wanted.get(*topic).is_some_and(|alert| alert.severity == Severity::Critical)
        };
        self.news.iter().find(is_critical)
    }

    /// The next topic with a change, critical alerts first; `None` for an alert: the topic is to be cleared.
    pub(super) fn take(&mut self) -> Option<(Topic, Option<Arc<Alert>>)> {
        let mut critical = self.first_critical().cloned();
        critical.iter().for_each(|topic| _ = self.news.remove(topic));
        while let Some(topic) = critical.take().or_else(|| self.news.pop_first()) {
            if let Some(alert) = self.wanted.get(&topic) {
                self.retained.insert(topic.clone());
                return Some((topic, Some(alert.clone())));
            }
            // An alert that ended before it was published needs no clearing.
            if self.retained.contains(&topic) {
                return Some((topic, None));
            }
        }
        None
    }

    /// The broker has cleared the topic.
    pub(super) fn cleared(&mut self, topic: &str) {
        self.retained.remove(topic);
    }
}

#[cfg(test)]
mod tests {
    use super::super::body::tests::alert;
    use super::*;
    use fusion::time::Time;

    fn taken(mirror: &mut Mirror) -> Vec<(String, bool)> {
        let mut taken = Vec::new();
        while let Some((topic, alert)) = mirror.take() {
            if alert.is_none() {
                mirror.cleared(&topic);
            }
            taken.push((topic, alert.is_some()));
        }
        taken
    }

    fn topic(id: u64) -> String {
        format!("alerts/area/area-{id}")
    }

    fn over(id: u64) -> Arc<Alert> {
        Arc::new(Alert { until: Some(Time::default()), ..Alert::clone(&alert(id)) })
    }

    #[test]
    fn alert_is_retained_while_it_lasts() {
        let mut mirror = Mirror::default();
        mirror.note(&alert(1), true);
        mirror.note(&alert(1), true);
        mirror.note(&alert(2), false);
        assert_eq!(taken(&mut mirror), [(topic(1), true)]);
        // Its severity dropped below that of the receiver, and rose again.
        mirror.note(&alert(1), false);
        assert_eq!(taken(&mut mirror), [(topic(1), false)]);
        mirror.note(&alert(1), true);
        assert_eq!(taken(&mut mirror), [(topic(1), true)]);
        mirror.note(&over(1), true);
        mirror.note(&alert(3), true);
        mirror.note(&over(3), true);
        assert_eq!(taken(&mut mirror), [(topic(1), false)]);
    }

    #[test]
    fn critical_alert_is_published_before_others() {
        let mut mirror = Mirror::default();
        mirror.note(&alert(1), true);
        assert!(!mirror.is_urgent());
        mirror.note(&Arc::new(Alert { severity: Severity::Critical, ..Alert::clone(&alert(2)) }), true);
        mirror.note(&alert(3), true);
        assert!(mirror.is_urgent());
        assert_eq!(taken(&mut mirror), [(topic(2), true), (topic(1), true), (topic(3), true)]);
    }

    #[test]
    fn new_connection_publishes_all_and_clears_unknown() {
        let mut mirror = Mirror::default();
        mirror.note(&alert(1), true);
        mirror.note(&alert(2), true);
        taken(&mut mirror);
        mirror.note(&over(2), true);
        // The connection breaks before this is sent.
        assert_eq!(mirror.take(), Some((topic(2), None)));
        mirror.begin();
        mirror.found(&topic(1));
        mirror.found(&topic(7));
        let wanted = [(topic(1), true), (topic(2), false), (topic(7), false)];
        assert_eq!(taken(&mut mirror), wanted);
        mirror.end();
        assert_eq!(taken(&mut mirror), [(topic(1), false)]);
    }
}
