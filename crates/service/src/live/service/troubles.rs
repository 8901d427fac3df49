//! Faults of the service itself, for alerts.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::EngineThread;
use crate::live::alerts::{ServiceFault, Severity};
use crate::net::listen::LineCounters;
use crate::record::RecorderQueue;
use fusion::numbering::LARGEST_TRANSPONDER_NUMBER;
use fusion::time::{SECOND, Time};
use input::names::counted;
use site::config::Profile;

/// Share of the transponder numbers in use from which an alert is raised.
const NUMBERS_LOW: f64 = 0.9;

impl EngineThread {
    /// Faults of the service itself at `at`, since the last status. Receptions are handled until `handled`.
    pub(super) fn troubles(&mut self, at: Time, handled: Time) -> Vec<ServiceFault> {
        let mut troubles = Vec::new();
        let mut find = |about: &'static str, severity, text: String| {
            troubles.push(ServiceFault { about: about.into(), severity, text });
        };
        let behind_ns = self.driver.pipeline().engine().behind(at).as_nanos() as i64;
        if behind_ns > SECOND {
            let behind_s = behind_ns / SECOND;
            let text = match self.driver.pipeline().engine().is_set_back(at) {
                false => format!(
                    "the clock of this machine was set back: nothing is published for {behind_s} s, until it is caught up"
                ),
                true => format!(
                    "the clock of this machine was set back by {behind_s} s: the picture starts afresh when that has lasted \
                     for 5 s"
                ),
            };
            find(ServiceFault::CLOCK, Severity::Critical, text);
        } else if let Some(text) = self.driver.health().wrong_clock(handled) {
            find(ServiceFault::CLOCK, Severity::Critical, text);
        }
        let count = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let lost = |(_, line): &(_, Arc<LineCounters>)| count(&line.queue_full) + count(&line.kernel_dropped);
        if let Some(lost) = self.input_losses.update(self.lines.iter().map(lost).sum(), at) {
            let text = format!("{lost} datagrams of sensors were lost before the engine could handle them");
            find(ServiceFault::INPUT, Severity::Critical, text);
        }
        let failed = self.publisher.failed_sends
            - std::mem::replace(&mut self.failed_logged, self.publisher.failed_sends);
        if failed > 0 {
            find(
                ServiceFault::OUTPUT,
                Severity::Critical,
                format!("{failed} datagrams could not be sent in a second"),
            );
        }
        if let Some(counts) = self.publisher.outlets.recorder.as_ref().map(RecorderQueue::counts) {
            let missing = self.recorder_losses.update(counts.lost + counts.unwritten, at);
            let text = match missing {
                _ if counts.failing => Some("nothing is recorded: the disk cannot be written".to_owned()),
                Some(missing) => Some(format!("{missing} datagrams are missing in the recording")),
                None => None,
            };
            text.into_iter().for_each(|text| find(ServiceFault::RECORDER, Severity::Warning, text));
        }
        if let Some(seconds) =
            self.conflict_losses.update(self.publisher.outlets.hub.conflict_reports.dropped(), at)
        {
            let text = format!("the conflicts of {} came too late to be shown", counted(seconds, "second"));
            find(ServiceFault::CONFLICTS, Severity::Warning, text);
        }
        let used = self.driver.pipeline().engine().numbers().used();
        if let Some(text) = numbers_low(used, self.config.fusion.profile) {
            find("numbers", Severity::Warning, text);
        }
        troubles
    }
}

/// Text of the alert about few free transponder numbers.
pub(super) fn numbers_low(used: usize, profile: Profile) -> Option<String> {
    let then = match profile {
        Profile::Operational => "a new transponder takes that of the one heard longest ago",
        Profile::Reference => "new transponders are left out",
    };
    (used as f64 >= NUMBERS_LOW * f64::from(LARGEST_TRANSPONDER_NUMBER)).then(|| {
        format!("{used} of {LARGEST_TRANSPONDER_NUMBER} transponder numbers are in use; when all are, {then}")
    })
}
