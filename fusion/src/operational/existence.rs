//! Whether a radar track is a drone, from the radar's class probability and the track's motion.

mod kinematics;

use kinematics::Kinematics;

use serde::{Deserialize, Serialize};

use super::classes::ClassEvidence;
use super::settings::RadarSettings;
use super::tuning::{CLASS_MEMORY_S, CLASS_NEVER, CLASS_PLOT_MAX_S, CLASS_SETTLED_S};
use crate::report::Plot;

/// Evidence of the plots so far.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Existence {
    /// Duration of the plots with a class, seconds, and their mean probability of a drone.
    class_s: f64,
    class_mean: f64,
    /// Log-odds of a drone from that mean, given the class statistics of the site's radar tracks.
    class_log_odds: f64,
    /// Logarithm of the density of that mean among the site's radar tracks.
    class_log_commonness: f64,
    kinematics: Kinematics,
}

impl Existence {
    /// Adds plots, in order of time.
    pub(super) fn add<'a>(&mut self, plots: impl Iterator<Item = &'a Plot> + Clone, radar: &RadarSettings) {
        for probability in plots.clone().filter_map(|plot| plot.uav_probability) {
            let period_s = radar.period_s.min(CLASS_PLOT_MAX_S);
            self.class_s = (self.class_s + period_s).min(CLASS_MEMORY_S);
            self.class_mean += (probability - self.class_mean) * period_s / self.class_s;
        }
        plots.for_each(|plot| self.kinematics.add(plot, radar));
    }

    /// Updates the log-odds by the class statistics of the site's radar tracks.
    pub(super) fn classify(&mut self, evidence: &ClassEvidence) {
        self.class_log_odds = evidence.log_odds(self.class_mean);
        self.class_log_commonness = evidence.log_commonness(self.class_mean);
    }

    /// Duration of the plots with a class, seconds, and their mean probability of a drone.
    pub(super) fn class(&self) -> (f64, f64) {
        (self.class_s, self.class_mean)
    }

    /// Logarithm of the density of that mean among the site's radar tracks.
    pub(super) fn class_log_commonness(&self) -> f64 {
        self.class_log_commonness
    }

    /// Veto: the radar is certain that the track is no drone.
    pub(super) fn is_vetoed(&self) -> bool {
        self.class_s >= CLASS_SETTLED_S && self.class_mean < CLASS_NEVER
    }

    /// Log-odds that the track is a drone.
    pub(super) fn log_odds(&self) -> f64 {
        self.class_log_odds * (self.class_s / CLASS_SETTLED_S).min(1.0) + self.kinematics.log_odds
    }
}
