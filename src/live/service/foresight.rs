//! Conflicts of the published pictures: looked for when their slots are on their way, so that no slot waits for them.

use std::sync::Arc;
use std::time::Duration;

use super::publication::Publisher;
use crate::live::published::PublishedPicture;

/// An outlook that comes later than this after its picture was due is not shown.
const LATE: Duration = Duration::from_millis(250);

impl Publisher {
    /// Notes a published slot whose conflicts are to be looked for.
    pub(super) fn look_later(&mut self, frame: Arc<PublishedPicture>) {
        if self.watch.as_ref().is_some_and(|watch| frame.is_due(watch, &self.outlets.hub.maker)) {
            self.unseen.push_back(frame);
        }
    }

    /// Looks for the conflicts of one published slot. Each is looked at, also where it comes too late to be shown: what is
    /// found in the next depends on it.
    pub(super) fn look_ahead(&mut self) {
        let Some((frame, watch)) = self.unseen.pop_front().zip(self.watch.as_mut()) else { return };
        let began = self.clock.now();
        let Some(outlook) = frame.conflicts(watch, &self.outlets.hub.maker) else { return };
        let ended = self.clock.now();
        let outlooks = &self.outlets.hub.outlooks;
        outlooks.note_spent(Duration::try_from(ended - began).unwrap_or_default());
        let late = Duration::try_from(ended - frame.due).unwrap_or_default();
        if late > LATE {
            outlooks.drop_late();
        } else {
            outlooks.publish(outlook);
        }
    }
}
