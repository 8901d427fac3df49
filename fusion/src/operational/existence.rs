//! Whether a radar track is a drone: the class that the radar tells, and how it flies.

mod kinematics;

use kinematics::Kinematics;

use serde::{Deserialize, Serialize};

use super::classes::ClassEvidence;
use super::settings::Radar;
use super::tuning::{CLASS_MEMORY_S, CLASS_NEVER, CLASS_PLOT_MAX_S, CLASS_SETTLED_S};
use crate::report::Plot;

/// What the plots so far tell of it.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Existence {
    /// Seconds of plots that told a class, and their mean probability of a drone.
    class_s: f64,
    class_mean: f64,
    /// Natural logarithm of the odds by that mean alone, as the site's radar tracks have it.
    class_log_odds: f64,
    /// How common that mean is among them: natural logarithm of the density.
    class_log_commonness: f64,
    kinematics: Kinematics,
}

impl Existence {
    /// Takes plots in, in the order of their time.
    pub(super) fn add<'a>(&mut self, plots: impl Iterator<Item = &'a Plot> + Clone, radar: &Radar) {
        for probability in plots.clone().filter_map(|plot| plot.uav_probability) {
            let period_s = radar.period_s.min(CLASS_PLOT_MAX_S);
            self.class_s = (self.class_s + period_s).min(CLASS_MEMORY_S);
            self.class_mean += (probability - self.class_mean) * period_s / self.class_s;
        }
        plots.for_each(|plot| self.kinematics.add(plot, radar));
    }

    /// What the site's radar tracks make of its class.
    pub(super) fn classify(&mut self, evidence: &ClassEvidence) {
        self.class_log_odds = evidence.log_odds(self.class_mean);
        self.class_log_commonness = evidence.log_commonness(self.class_mean);
    }

    /// Seconds of plots that told a class, and their mean probability of a drone.
    pub(super) fn class(&self) -> (f64, f64) {
        (self.class_s, self.class_mean)
    }

    /// How common that mean is among the site's tracks: natural logarithm of its density.
    pub(super) fn class_log_commonness(&self) -> f64 {
        self.class_log_commonness
    }

    /// Veto: the radar is certain that it is no drone.
    pub(super) fn is_vetoed(&self) -> bool {
        self.class_s >= CLASS_SETTLED_S && self.class_mean < CLASS_NEVER
    }

    /// Natural logarithm of the odds that it is a drone.
    pub(super) fn log_odds(&self) -> f64 {
        self.class_log_odds * (self.class_s / CLASS_SETTLED_S).min(1.0) + self.kinematics.log_odds
    }
}
