//! What the engine is told once.

use std::collections::BTreeMap;

use crate::slots::{RING, SlotGrid};

/// The rules of the `reference` profile with their numbers. `SlotGrid` and whole slots, so that no two parts round
/// differently.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The slots.
    pub grid: SlotGrid,
    /// Slots a slot waits before it is emitted (25: 6.25 s).
    pub latency_slots: i64,
    /// Slots in the window (100: 25 s).
    pub window_slots: i64,
    /// How far ahead of its reception a report may be, nanoseconds (1 s).
    pub max_future_ns: i64,
    /// No interpolation inside a gap between knots longer than this, nanoseconds (25 s).
    pub max_gap_ns: i64,
    /// Distance below which radar and transponder agree.
    pub gate: Gate,
    /// Least share of slots within the gate among those where both are present, in millionths (900,000).
    pub ratio_min_ppm: u64,
    /// Least number of slots where both are present (4).
    pub min_samples: u32,
    /// The radar's weight in a fused position (1).
    pub weight_radar: f64,
    /// The transponder's weight in a fused position (10).
    pub weight_transponder: f64,
    /// A radar track alone is put out when it was a UAV for longer than this, seconds (8).
    pub radar_only_min_s: f64,
    /// A transponder alone is held back this many slots around an association (16: 4 s).
    pub suppress_slots: i64,
    /// By sensor: seconds between two detections of one target, at least a slot; what one detection counts for.
    pub period_s: Vec<f64>,
    /// Track numbers that the configuration gives to serial numbers.
    pub transponder_numbers: BTreeMap<Vec<u8>, u32>,
    /// The `operational` profile; `None`: the `reference` profile.
    pub operational: Option<crate::operational::Settings>,
}

impl Settings {
    /// Whether the ring holds the window, the slot that is about to leave it, and the reports that wait ahead: the one
    /// bound that the engine itself needs.
    pub fn fits_ring(&self) -> bool {
        (1..self.window_slots).contains(&self.latency_slots)
            && 1 + self.window_slots + self.waiting_slots() <= RING as i64
    }

    /// Length of the window, nanoseconds.
    pub(super) fn window_ns(&self) -> i64 {
        self.window_slots * self.grid.slot_ns()
    }

    /// Slots ahead of the window that a report may be of.
    pub(super) fn waiting_slots(&self) -> i64 {
        self.max_future_ns / self.grid.slot_ns() + 1
    }
}

/// The association threshold D(ρ): piecewise linear in slant range, constant beyond its ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Gate {
    /// Slant range and distance, metres; ranges increase.
    rows: Vec<(f64, f64)>,
}

impl Gate {
    /// From rows of slant range and distance, metres; `None` without a row, or where ranges do not increase.
    pub fn new(rows: Vec<(f64, f64)>) -> Option<Self> {
        let increasing = rows.windows(2).all(|pair| pair[0].0 < pair[1].0);
        (!rows.is_empty() && increasing).then_some(Self { rows })
    }

    /// D at a slant range, metres.
    pub fn at(&self, slant_range_m: f64) -> f64 {
        let above = self.rows.partition_point(|&(range, _)| range <= slant_range_m);
        if above == 0 {
            return self.rows[0].1;
        }
        let (range, distance) = self.rows[above - 1];
        match self.rows.get(above) {
            Some(&(next_range, next_distance)) => {
                distance + (next_distance - distance) * (slant_range_m - range) / (next_range - range)
            }
            None => distance,
        }
    }

    /// The largest D, metres.
    pub fn widest_m(&self) -> f64 {
        self.rows.iter().map(|row| row.1).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gate_is_linear_between_its_rows_and_constant_beyond() {
        let gate = Gate::new(vec![(0.0, 60.0), (333.33, 60.0), (4333.33, 300.0)]).unwrap();
        for (range, expected) in
            [(1.0, 60.0), (333.33, 60.0), (2333.33, 180.0), (4333.33, 300.0), (9000.0, 300.0)]
        {
            assert!((gate.at(range) - expected).abs() < 1e-9, "{range}");
        }
        assert_eq!(gate.widest_m(), 300.0);
        assert_eq!(Gate::new(vec![]), None);
        assert_eq!(Gate::new(vec![(5.0, 1.0), (5.0, 2.0)]), None);
    }
}
