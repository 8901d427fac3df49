//! Evaluation of conflicts, after a slot has been published, so that no slot waits for it.

use std::sync::Arc;
use std::time::Duration;

use super::publication::Publisher;
use crate::live::published::PublishedPicture;

/// Maximum delay after a picture was due at which its evaluation is still published.
const LATE: Duration = Duration::from_millis(250);

impl Publisher {
    /// Queues a published slot for evaluation.
    pub(super) fn queue_evaluation(&mut self, frame: Arc<PublishedPicture>) {
        if self.watch.as_ref().is_some_and(|watch| frame.is_due(watch, &self.outlets.hub.maker)) {
            self.unevaluated.push_back(frame);
        }
    }

    /// Evaluates the conflicts of one published slot. A late evaluation is not published, but still made: the next one
    /// depends on it.
    pub(super) fn evaluate_conflicts(&mut self) {
        let Some((frame, watch)) = self.unevaluated.pop_front().zip(self.watch.as_mut()) else { return };
        let began = self.clock.now();
        let Some(outlook) = frame.conflicts(watch, &self.outlets.hub.maker) else { return };
        let ended = self.clock.now();
        let reports = &self.outlets.hub.conflict_reports;
        reports.note_spent(Duration::try_from(ended - began).unwrap_or_default());
        let late = Duration::try_from(ended - frame.due).unwrap_or_default();
        if late > LATE {
            reports.drop_late();
        } else {
            reports.publish(outlook);
        }
    }
}
