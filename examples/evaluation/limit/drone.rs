//! Queries about a drone's measurements.

use super::inputs::LimitDrone;
use super::smoother::MeasurementKind;

/// Maximum distance in time of a near plot, seconds.
const NEAR_S: f64 = 1.0;

impl LimitDrone {
    /// Whether there is a plot near this time.
    pub fn has_plots(&self, time_s: f64) -> bool {
        let from = self.measured.partition_point(|one| one.time_s < time_s - NEAR_S);
        let near = self.measured[from..].iter().take_while(|one| one.time_s <= time_s + NEAR_S);
        near.clone().any(|one| matches!(one.kind, MeasurementKind::Plot { .. }))
    }
}
