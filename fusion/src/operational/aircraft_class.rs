//! How an aircraft looks to each radar: the class probability that its tracks show.
//!
//! A radar shows much the same probability of one aircraft in track after track, so it is a mark of it: a track that shows it
//! again is more likely to be that aircraft than one that shows another, the more so the fewer of the site's tracks show it.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::tracklets::Tracklet;
use super::tuning::{
    CLASS_LLR_MAX, CLASS_SETTLED_S, OWN_CLASS_ELSE, OWN_CLASS_LLR, OWN_CLASS_MEMORY_S, OWN_CLASS_SIGMA,
};
use crate::report::SensorIndex;

/// The class probability of one aircraft, as each radar has shown it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct AircraftClass(BTreeMap<SensorIndex, f64>);

impl AircraftClass {
    /// Takes in what a track of it shows, `dt` seconds after it was asked last.
    pub(super) fn take(&mut self, tracklet: &Tracklet, dt: f64) {
        let (class_s, mean) = tracklet.existence().class();
        if class_s >= CLASS_SETTLED_S {
            let known = self.0.entry(tracklet.key.sensor).or_insert(mean);
            *known += (1.0 - (-dt / OWN_CLASS_MEMORY_S).exp()) * (mean - *known);
        }
    }

    /// LLR that a track is of this aircraft, by its class alone; of one that was not seen yet, as far as it is a drone.
    pub(super) fn llr(&self, tracklet: &Tracklet) -> f64 {
        let existence = tracklet.existence();
        let (class_s, mean) = existence.class();
        self.0.get(&tracklet.key.sensor).map_or(existence.log_odds().min(CLASS_LLR_MAX), |own| {
            let mark = alike(mean - own) - existence.class_log_commonness().max(0.0);
            mark * (class_s / CLASS_SETTLED_S).min(1.0) + OWN_CLASS_LLR
        })
    }
}

/// Logarithm of the density of such a difference between tracks of one aircraft, over that where every probability is as
/// common: a normal one, but for those that look otherwise for once.
fn alike(difference: f64) -> f64 {
    let normal = (-0.5 * (difference / OWN_CLASS_SIGMA).powi(2)).exp() / (OWN_CLASS_SIGMA * TAU.sqrt());
    ((1.0 - OWN_CLASS_ELSE) * normal + OWN_CLASS_ELSE).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_class_speaks_for_one_aircraft_and_another_against_it() {
        assert!(alike(0.0) > 1.0 && alike(0.05) > 0.5);
        assert!(alike(0.3) < -2.0);
        assert!((alike(0.9) - OWN_CLASS_ELSE.ln()).abs() < 1e-3, "but it is no proof");
        // A density over the differences that there may be has the integral 1.
        let step = 1e-3;
        let sum: f64 = (-500..500).map(|index| alike((f64::from(index) + 0.5) * step).exp() * step).sum();
        assert!((sum - 1.0).abs() < 1e-3, "{sum}");
    }
}
