//! Metrics of notices of alerts, by receiver.

use super::text::Metrics;
use service::notices::{NoticeCounts, NoticeLoss, Notices};

impl Metrics {
    /// Metrics of each receiver; no output without receivers.
    pub(super) fn notices(&mut self, notices: &Notices) {
        let counts: Vec<(&str, NoticeCounts)> = notices.counts().collect();
        if counts.is_empty() {
            return;
        }
        let of = |number: fn(&NoticeCounts) -> u64| {
            counts.iter().map(move |(name, counts)| (name, number(counts)))
        };
        let help = "Notices of alerts that a receiver took";
        self.by("notices_sent_total", help, "receiver", of(|counts| counts.sent));
        let help = "Attempts to deliver notices that failed";
        self.by("notices_failed_total", help, "receiver", of(|counts| counts.failed));
        let help = "Notices that wait for a receiver";
        self.by("notices_waiting", help, "receiver", of(|counts| counts.waiting as u64));
        let help = "Whether the last attempt to reach a receiver failed";
        self.by("notices_failing", help, "receiver", of(|counts| counts.is_failing.into()));
        let help = "Notices lost: full, too many waited; refused, the receiver does not want it; stale, it was long over";
        self.family("notices_lost_total", help);
        for (name, counts) in &counts {
            for loss in NoticeLoss::ALL {
                let labels = [("receiver", *name), ("reason", loss.name())];
                self.sample("notices_lost_total", &labels, counts.lost(loss));
            }
        }
    }
}
