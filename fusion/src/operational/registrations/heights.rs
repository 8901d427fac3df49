//! The alignment of radars where heights of transponders have offsets.

use super::{Registered, Registrations};
use crate::operational::cycle::Cycle;
use crate::operational::transponder_types::TransponderTypes;
use crate::registration::HeightAlignment;

impl Registered {
    /// Uses this alignment of its heights, and this share of it, where heights of transponders have offsets.
    fn align(&mut self, heights: Option<(&HeightAlignment, f64)>) {
        let heights = heights.map(|(alignment, share)| (*alignment, share));
        if heights != self.heights {
            self.heights = heights;
            self.estimate();
        }
    }
}

impl Registrations {
    /// Judges which heights have offsets, and aligns the radars accordingly.
    pub(super) fn judge_heights(&mut self, types: &mut TransponderTypes, cycle: &Cycle) {
        types.heights.evaluate_radars(cycle.centre);
        for (&sensor, registered) in &mut self.radars {
            registered.align(types.heights.alignment(sensor));
        }
    }
}
