//! Whether a radar track is a drone: what the radar says of its class, and how it flies.

use super::flight::Flight;
use super::settings::Radar;
use crate::report::Plot;

/// A track is put out from these log-odds on.
pub(super) const CONFIRMED: f64 = 3.0;
/// A mean probability of this says nothing, where birds and drones are as frequent as they are; above it speaks for a drone.
const NEUTRAL: f64 = 0.57;
/// What a mean probability that is higher by 1 would add.
const SLOPE: f64 = 30.0;
/// It adds no more than this, and takes no more away.
const MOST: f64 = 6.0;
/// Successive plots say much the same: a classifier's word has its whole weight after so long, seconds,
const WHOLE_S: f64 = 2.0;
/// and its mean is one over this, seconds.
const MEMORY_S: f64 = 60.0;

/// A classifier whose mean is below this all the time is certain that it is no drone.
const NEVER: f64 = 0.01;

/// What is known of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Existence {
    /// Seconds of plots that told a class, and the mean probability.
    told_s: f64,
    mean: f64,
    flight: Flight,
}

impl Existence {
    pub(super) const NEW: Self = Self { told_s: 0.0, mean: 0.0, flight: Flight::NEW };

    /// With these plots as well, in the order of their time.
    pub(super) fn with<'a>(mut self, plots: impl Iterator<Item = &'a Plot> + Clone, radar: &Radar) -> Self {
        for probability in plots.clone().filter_map(|plot| plot.uav_probability) {
            let period_s = radar.period_s.min(1.0);
            self.told_s = (self.told_s + period_s).min(MEMORY_S);
            self.mean += (probability - self.mean) * period_s / self.told_s;
        }
        self.flight = self.flight.with(plots, radar);
        self
    }

    /// Whether the radar is certain that it is no drone.
    pub(super) fn is_none(&self) -> bool {
        self.told_s >= WHOLE_S && self.mean < NEVER
    }

    /// Natural logarithm of the odds.
    pub(super) fn log_odds(&self) -> f64 {
        let class = (SLOPE * (self.mean - NEUTRAL)).clamp(-MOST, MOST);
        class * (self.told_s / WHOLE_S).min(1.0) + self.flight.score
    }
}
