//! Assumed motion of aircraft within the horizon.

/// Assumed motion of aircraft: straight on for a while, then a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extrapolation {
    /// Prediction horizon, seconds.
    pub horizon_s: f64,
    /// Power spectral density of the acceleration over ground of turning aircraft, m²/s³ on each axis.
    pub acceleration: f64,
    /// Mean time for which a pair flies straight on, seconds.
    pub straight_s: f64,
    /// Reduced errors of aircraft that fly straight on.
    pub steady: SteadyFlightRatios,
}

/// Ratios of real to stated standard deviations while an aircraft flies straight on. The stated ones include the
/// filter's allowance for a turn that has just begun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyFlightRatios {
    /// Ratio of the position over ground.
    pub place: f64,
    /// Ratio of the velocity over ground.
    pub velocity: f64,
    /// Ratio of the height, in straight flight and in turns.
    pub height: f64,
    /// Ratio of the climb, in straight flight and in turns.
    pub climb: f64,
}

impl SteadyFlightRatios {
    /// Ratios found in simulated flights (docs/CONFLICTS.md).
    pub const MEASURED: Self = Self { place: 0.45, velocity: 0.2, height: 0.6, climb: 0.25 };
}

impl Extrapolation {
    /// Variance that random acceleration adds to a position over ground in `t` seconds, m² on each axis.
    pub(super) fn grown_m2(&self, t: f64) -> f64 {
        self.acceleration * t.powi(3) / 3.0
    }
}
