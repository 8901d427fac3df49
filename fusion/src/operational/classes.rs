//! Class statistics: how many radar tracks of a site have which class probability.
//!
//! Radar tracks with a transponder are certainly drones: their class probabilities are labelled without further effort.
//! All others are the background: birds, and drones without a transponder. If a class probability is many times more
//! frequent in the background than drones explain, a track with it is a bird, whatever the radar reports. Each radar
//! classifies in its own way, so each has its own statistics. They only ever count against a drone: a probability with
//! few tracks gives no evidence.

mod labelling;

use std::array;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::tuning::{
    CLASS_BINS, CLASS_EVEN_TRACKS, CLASS_EVIDENCE_S, CLASS_KERNEL, CLASS_LOG_ODDS_MAX, CLASS_NEUTRAL,
    CLASS_SHARE_PRIOR, CLASS_SLOPE, CLASS_SPARE_TRACKS, CLASS_SURE,
};
use crate::frames::Enu;
use crate::report::SensorIndex;

/// Numbers of radar tracks by mean class probability.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ClassEvidence {
    /// Tracks with a transponder.
    drones: [f64; CLASS_BINS],
    background: [f64; CLASS_BINS],
}

impl Default for ClassEvidence {
    fn default() -> Self {
        Self { drones: [0.0; CLASS_BINS], background: [0.0; CLASS_BINS] }
    }
}

/// Centre of a bin.
fn middle(bin: usize) -> f64 {
    (bin as f64 + 0.5) / CLASS_BINS as f64
}

impl ClassEvidence {
    /// Adds a radar track with this mean class probability.
    fn add(&mut self, mean: f64, is_drone: bool) {
        let counts = if is_drone { &mut self.drones } else { &mut self.background };
        // Another track of the same target would have a similar probability.
        let near: [f64; CLASS_BINS] = array::from_fn(|bin| {
            (-0.5 * ((middle(bin) - mean.clamp(0.0, 1.0)) / CLASS_KERNEL).powi(2)).exp()
        });
        let sum: f64 = near.iter().sum();
        counts.iter_mut().zip(near).for_each(|(count, near)| *count += near / sum);
    }

    /// Lets the statistics fade over `dt` seconds.
    fn decay(&mut self, dt: f64) {
        let kept = (-dt / CLASS_EVIDENCE_S).exp();
        self.drones.iter_mut().chain(&mut self.background).for_each(|count| *count *= kept);
    }

    /// Log-odds that an unassigned radar track with this mean class probability is a drone: those of the radar, or
    /// lower ones from the site's statistics.
    pub(super) fn log_odds(&self, mean: f64) -> f64 {
        let sure = |counts: &[f64; CLASS_BINS]| -> f64 {
            (0..CLASS_BINS).filter(|&bin| middle(bin) > CLASS_SURE).map(|bin| counts[bin]).sum()
        };
        // Ratio of drones without to drones with a transponder, from the tracks with the highest class probabilities.
        let (without, with) = CLASS_SHARE_PRIOR;
        let share = (sure(&self.background) + without) / (sure(&self.drones) + with);
        let bin = ((mean.clamp(0.0, 1.0) * CLASS_BINS as f64) as usize).min(CLASS_BINS - 1);
        let drones = share * self.drones[bin] + CLASS_SPARE_TRACKS;
        let told = (CLASS_SLOPE * (mean - CLASS_NEUTRAL)).clamp(-CLASS_LOG_ODDS_MAX, CLASS_LOG_ODDS_MAX);
        match self.background[bin] > drones {
            true => told.min((drones / self.background[bin]).ln()),
            false => told,
        }
    }

    /// Logarithm of the density of this mean class probability among the site's tracks, relative to a uniform
    /// distribution.
    pub(super) fn log_commonness(&self, mean: f64) -> f64 {
        let bin = ((mean.clamp(0.0, 1.0) * CLASS_BINS as f64) as usize).min(CLASS_BINS - 1);
        let all: f64 = self.drones.iter().chain(&self.background).sum();
        let share = self.drones[bin] + self.background[bin] + CLASS_EVEN_TRACKS / CLASS_BINS as f64;
        (share * CLASS_BINS as f64 / (all + CLASS_EVEN_TRACKS)).ln()
    }
}

/// A radar track with a settled class that is known to be a drone, or not to be one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LabelledTrack {
    /// The radar.
    pub radar: SensorIndex,
    /// Its last position, in the engine's frame.
    pub position: Enu,
    /// Mean class probability of its plots, 0 to 1.
    pub uav_probability: f64,
    /// Whether the track has a transponder; otherwise it certainly has none.
    pub is_drone: bool,
}

/// The statistics of each radar.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Classes {
    radars: BTreeMap<SensorIndex, ClassEvidence>,
    none: ClassEvidence,
    /// Labelled tracks that are not counted yet, if statistics are shared.
    labelled: Vec<LabelledTrack>,
    /// Statistics learnt by other engines; `None`: this engine uses its own.
    pub(super) shared: Option<BTreeMap<SensorIndex, ClassEvidence>>,
}

impl Classes {
    /// The statistics used for a radar.
    pub(super) fn of(&self, sensor: SensorIndex) -> &ClassEvidence {
        let radars = self.shared.as_ref().unwrap_or(&self.radars);
        radars.get(&sensor).unwrap_or(&self.none)
    }

    /// The statistics learnt by this engine.
    pub(super) fn learnt(&self, sensor: SensorIndex) -> &ClassEvidence {
        self.radars.get(&sensor).unwrap_or(&self.none)
    }

    /// State kept at a restart of the engine: the statistics learnt by others.
    pub(super) fn only_shared(self) -> Self {
        Self { shared: self.shared, ..Self::default() }
    }

    /// Returns the tracks whose class has settled since the last call, if statistics are shared. Each must be counted
    /// by one engine.
    pub(super) fn take_labelled(&mut self) -> Vec<LabelledTrack> {
        std::mem::take(&mut self.labelled)
    }

    /// Counts a track that this or another engine has labelled.
    pub(super) fn count(&mut self, track: &LabelledTrack) {
        self.radars.entry(track.radar).or_default().add(track.uav_probability, track.is_drone);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds `tracks` tracks with probabilities evenly between the bounds.
    fn with(evidence: &mut ClassEvidence, tracks: u32, [low, high]: [f64; 2], is_drone: bool) {
        for track in 0..tracks {
            let mean = low + (high - low) * (f64::from(track) + 0.5) / f64::from(tracks);
            evidence.add(mean, is_drone);
        }
    }

    fn told(mean: f64) -> f64 {
        ClassEvidence::default().log_odds(mean)
    }

    #[test]
    fn probability_of_many_birds_is_no_drone_evidence() {
        let mut evidence = ClassEvidence::default();
        with(&mut evidence, 300, [0.5, 0.95], true);
        with(&mut evidence, 75, [0.5, 0.95], false);
        with(&mut evidence, 480, [0.4, 0.6], false);
        assert!(evidence.log_odds(0.58) < -1.0, "{}", evidence.log_odds(0.58));
        assert_eq!(evidence.log_odds(0.8), told(0.8));
    }

    #[test]
    fn few_drones_without_transponder_remain_drones() {
        let mut evidence = ClassEvidence::default();
        with(&mut evidence, 20, [0.7, 0.8], true);
        with(&mut evidence, 14, [0.5, 0.7], false);
        assert_eq!(evidence.log_odds(0.6), told(0.6));
    }

    #[test]
    fn many_drones_keep_the_radars_probability() {
        let mut evidence = ClassEvidence::default();
        with(&mut evidence, 2000, [0.3, 0.95], true);
        for mean in [0.0, 0.4, 0.57, 0.7, 1.0] {
            assert_eq!(evidence.log_odds(mean), told(mean));
        }
    }

    #[test]
    fn a_probability_that_many_show_is_common() {
        let mut evidence = ClassEvidence::default();
        assert_eq!(evidence.log_commonness(0.3), 0.0);
        with(&mut evidence, 480, [0.4, 0.6], false);
        assert!((1.0..1.8).contains(&evidence.log_commonness(0.5)), "{}", evidence.log_commonness(0.5));
        assert!(evidence.log_commonness(0.9) < -2.0);
    }

    #[test]
    fn old_observations_are_discarded() {
        let mut evidence = ClassEvidence::default();
        with(&mut evidence, 480, [0.5, 0.6], false);
        assert!(evidence.log_odds(0.6) < told(0.6));
        evidence.decay(10.0 * CLASS_EVIDENCE_S);
        assert_eq!(evidence.log_odds(0.6), told(0.6));
    }
}
