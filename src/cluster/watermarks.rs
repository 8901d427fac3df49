//! How far each sensor has been heard: what is received before that is in the log.

use std::collections::BTreeMap;

use asterix::DataSource;
use fusion::slots::Slot;

/// The end of the last whole slot of each sensor, by whichever gateway was faster.
#[derive(Clone, Debug, Default)]
pub(super) struct Watermarks(BTreeMap<DataSource, Slot>);

/// Slots for which nothing is heard of a sensor, not even that it says nothing, before nobody waits for it: 1 s.
const SILENT: i64 = 4;

impl Watermarks {
    /// This slot of a sensor is whole.
    pub(super) fn note(&mut self, sensor: DataSource, slot: Slot) {
        let known = self.0.entry(sensor).or_insert(slot);
        *known = (*known).max(slot);
    }

    /// The newest slot that is whole of every sensor that is heard at all.
    pub(super) fn whole(&self) -> Option<Slot> {
        let newest = self.0.values().max()?;
        self.0.values().filter(|slot| newest.0 - slot.0 <= SILENT).min().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slot_is_whole_when_it_is_of_every_sensor_that_speaks() {
        let [one, other] = [1, 2].map(|sic| DataSource { sac: 25, sic });
        let mut watermarks = Watermarks::default();
        assert_eq!(watermarks.whole(), None);
        watermarks.note(one, Slot(10));
        assert_eq!(watermarks.whole(), Some(Slot(10)));
        watermarks.note(other, Slot(7));
        assert_eq!(watermarks.whole(), Some(Slot(7)));
        // The slower gateway says nothing new.
        watermarks.note(other, Slot(9));
        watermarks.note(other, Slot(8));
        assert_eq!(watermarks.whole(), Some(Slot(9)));
        // Nobody waits for one that is silent.
        watermarks.note(one, Slot(14));
        assert_eq!(watermarks.whole(), Some(Slot(14)));
    }
}
