//! Metrics of the pictures sent to other systems, by receiver.

use super::text::Metrics;
use service::sinks::{SinkCounts, SinkLoss, SinkMeter};

impl Metrics {
    /// Metrics of each receiver; no output without receivers.
    pub(super) fn sinks(&mut self, sinks: &SinkMeter) {
        let counts: Vec<(&str, SinkCounts)> = sinks.counts().collect();
        if counts.is_empty() {
            return;
        }
        let of =
            |number: fn(&SinkCounts) -> u64| counts.iter().map(move |(name, counts)| (name, number(counts)));
        let help = "Messages that were sent to a sink of the picture";
        self.by("sink_messages_sent_total", help, "sink", of(|counts| counts.sent));
        let help = "Tracks that the format of a sink cannot hold";
        self.by("sink_tracks_left_out_total", help, "sink", of(|counts| counts.left_out));
        let help = "Attempts to send to a sink, or to connect to it, that failed";
        self.by("sink_failed_total", help, "sink", of(|counts| counts.failed));
        let help = "Seconds whose picture waits for a sink";
        self.by("sink_waiting", help, "sink", of(|counts| counts.waiting as u64));
        let help = "Whether the last attempt to reach a sink failed";
        self.by("sink_failing", help, "sink", of(|counts| counts.is_failing.into()));
        let help = "Seconds whose picture a sink did not get: slow, it takes them more slowly than they come; unreachable, no \
                    connection; refused, it does not want it; overload, the service had no time";
        self.family("sink_seconds_lost_total", help);
        for (name, counts) in &counts {
            for loss in SinkLoss::ALL {
                let labels = [("sink", *name), ("reason", loss.name())];
                self.sample("sink_seconds_lost_total", &labels, counts.lost(loss));
            }
        }
    }
}
