//! Watermark of each sensor: all data received before it is in the log.

use std::collections::BTreeMap;

use asterix::DataSource;
use fusion::slots::Slot;

/// Last complete slot of each sensor, by the faster gateway.
#[derive(Clone, Debug, Default)]
pub(super) struct Watermarks(BTreeMap<DataSource, Slot>);

/// Number of slots without any message about a sensor after which slots no longer wait for it (1 s).
const SILENT: i64 = 4;

impl Watermarks {
    /// Notes that a slot of a sensor is complete.
    pub(super) fn note(&mut self, sensor: DataSource, slot: Slot) {
        let known = self.0.entry(sensor).or_insert(slot);
        *known = (*known).max(slot);
    }

    /// The newest slot that is complete for all sensors with recent messages.
    pub(super) fn complete_slot(&self) -> Option<Slot> {
        let newest = self.0.values().max()?;
        self.0.values().filter(|slot| newest.0 - slot.0 <= SILENT).min().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slot_is_complete_when_every_active_sensor_reported() {
        let [one, other] = [1, 2].map(|sic| DataSource { sac: 25, sic });
        let mut watermarks = Watermarks::default();
        assert_eq!(watermarks.complete_slot(), None);
        watermarks.note(one, Slot(10));
        assert_eq!(watermarks.complete_slot(), Some(Slot(10)));
        watermarks.note(other, Slot(7));
        assert_eq!(watermarks.complete_slot(), Some(Slot(7)));
        // The slower gateway adds nothing.
        watermarks.note(other, Slot(9));
        watermarks.note(other, Slot(8));
        assert_eq!(watermarks.complete_slot(), Some(Slot(9)));
        // A silent sensor is not waited for.
        watermarks.note(one, Slot(14));
        assert_eq!(watermarks.complete_slot(), Some(Slot(14)));
    }
}
