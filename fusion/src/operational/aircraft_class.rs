//! Class probability of an aircraft, as the tracks of each radar show it.
//!
//! A radar reports a similar probability for one aircraft in all of its tracks, so the value helps to identify the
//! aircraft. A new track with the same value is more likely to be that aircraft than one with another value, in
//! particular if few tracks of the site have it.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::tracklets::Tracklet;
use super::tuning::{
    CLASS_LLR_MAX, CLASS_SETTLED_S, OWN_CLASS_ELSE, OWN_CLASS_LLR, OWN_CLASS_MEMORY_S, OWN_CLASS_SIGMA,
};
use crate::report::SensorIndex;

/// Mean class probability of one aircraft, by radar.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct AircraftClass(BTreeMap<SensorIndex, f64>);

impl AircraftClass {
    /// Updates the class by a track of the aircraft, `dt` seconds after the last update.
    pub(super) fn update(&mut self, tracklet: &Tracklet, dt: f64) {
        let (class_s, mean) = tracklet.existence().class();
        if class_s >= CLASS_SETTLED_S {
            let known = self.0.entry(tracklet.key.sensor).or_insert(mean);
            *known += (1.0 - (-dt / OWN_CLASS_MEMORY_S).exp()) * (mean - *known);
        }
    }

    /// LLR that a track is of this aircraft, from its class alone. For a radar without a known class it is the evidence
    /// for a drone.
    pub(super) fn llr(&self, tracklet: &Tracklet) -> f64 {
        let existence = tracklet.existence();
        let (class_s, mean) = existence.class();
        self.0.get(&tracklet.key.sensor).map_or(existence.log_odds().min(CLASS_LLR_MAX), |own| {
            let mark = alike(mean - own) - existence.class_log_commonness().max(0.0);
            mark * (class_s / CLASS_SETTLED_S).min(1.0) + OWN_CLASS_LLR
        })
    }
}

/// Logarithm of the density of a class difference between tracks of one aircraft, relative to a uniform one. The
/// density is normal, with a share of outliers.
fn alike(difference: f64) -> f64 {
    let normal = (-0.5 * (difference / OWN_CLASS_SIGMA).powi(2)).exp() / (OWN_CLASS_SIGMA * TAU.sqrt());
    ((1.0 - OWN_CLASS_ELSE) * normal + OWN_CLASS_ELSE).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn same_class_supports_one_aircraft_and_other_class_opposes() {
        assert!(alike(0.0) > 1.0 && alike(0.05) > 0.5);
        assert!(alike(0.3) < -2.0);
        assert!((alike(0.9) - OWN_CLASS_ELSE.ln()).abs() < 1e-3, "but it is no proof");
        // A density over all possible differences has the integral 1.
        let step = 1e-3;
        let sum: f64 = (-500..500).map(|index| alike((f64::from(index) + 0.5) * step).exp() * step).sum();
        assert!((sum - 1.0).abs() < 1e-3, "{sum}");
    }
}
