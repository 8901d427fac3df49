//! Whether a radar track is a drone: the class that the radar tells, and how it flies.

mod kinematics;

use kinematics::Kinematics;

use super::settings::Radar;
use super::tuning::{
    CLASS_LOG_ODDS_MAX, CLASS_MEMORY_S, CLASS_NEUTRAL, CLASS_NEVER, CLASS_PLOT_MAX_S, CLASS_SETTLED_S,
    CLASS_SLOPE,
};
use crate::report::Plot;

/// What the plots so far tell of it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Existence {
    /// Seconds of plots that told a class, and their mean probability of a drone.
    class_s: f64,
    class_mean: f64,
    kinematics: Kinematics,
}

impl Existence {
    /// With these plots as well, in the order of their time.
    pub(super) fn with<'a>(mut self, plots: impl Iterator<Item = &'a Plot> + Clone, radar: &Radar) -> Self {
        for probability in plots.clone().filter_map(|plot| plot.uav_probability) {
            let period_s = radar.period_s.min(CLASS_PLOT_MAX_S);
            self.class_s = (self.class_s + period_s).min(CLASS_MEMORY_S);
            self.class_mean += (probability - self.class_mean) * period_s / self.class_s;
        }
        plots.for_each(|plot| self.kinematics.add(plot, radar));
        self
    }

    /// Veto: the radar is certain that it is no drone.
    pub(super) fn is_vetoed(&self) -> bool {
        self.class_s >= CLASS_SETTLED_S && self.class_mean < CLASS_NEVER
    }

    /// Natural logarithm of the odds that it is a drone.
    pub(super) fn log_odds(&self) -> f64 {
        let class =
            (CLASS_SLOPE * (self.class_mean - CLASS_NEUTRAL)).clamp(-CLASS_LOG_ODDS_MAX, CLASS_LOG_ODDS_MAX);
        class * (self.class_s / CLASS_SETTLED_S).min(1.0) + self.kinematics.log_odds
    }
}
