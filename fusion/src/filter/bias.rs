//! The error of a radar that lasts for a while: a first-order Gauss–Markov process a radar track.

use super::errors::RadarErrors;

/// What is known of it: mean and variance of each part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bias {
    /// Metres.
    pub range_m: (f64, f64),
    /// Radians.
    pub azimuth: (f64, f64),
    /// Metres.
    pub height_m: (f64, f64),
}

/// What becomes of it: x' = kept · x + added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SlowChange {
    pub(super) kept: f64,
    pub(super) added: Bias,
}

impl Bias {
    /// Where there is no radar: nothing, with a spread that keeps the arithmetic sound.
    pub(super) const NONE: Self = Self { range_m: (0.0, 1.0), azimuth: (0.0, 1e-6), height_m: (0.0, 1.0) };

    /// Of a radar track of which nothing is known.
    pub fn of(errors: &RadarErrors) -> Self {
        let unknown = |deviation: f64| (0.0, deviation * deviation);
        Self {
            range_m: unknown(errors.bias_range_m),
            azimuth: unknown(errors.bias_azimuth),
            height_m: unknown(errors.bias_height_m),
        }
    }

    fn scaled(&self, by: f64) -> Self {
        let scaled = |(_, variance): (f64, f64)| (0.0, variance * by);
        Self { range_m: scaled(self.range_m), azimuth: scaled(self.azimuth), height_m: scaled(self.height_m) }
    }
}

impl SlowChange {
    /// No radar, or none for which something is estimated.
    pub(super) const NONE: Self =
        Self { kept: 1.0, added: Bias { range_m: (0.0, 0.0), azimuth: (0.0, 0.0), height_m: (0.0, 0.0) } };

    /// `dt` seconds later of the same radar track.
    pub(super) fn after(errors: &RadarErrors, dt: f64) -> Self {
        let kept = (-dt / errors.correlation_s).exp();
        Self { kept, added: Bias::of(errors).scaled(1.0 - kept * kept) }
    }

    /// Another radar track, of which this is known.
    pub(super) const fn anew(known: Bias) -> Self {
        Self { kept: 0.0, added: known }
    }
}
