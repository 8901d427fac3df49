//! The error of a radar that lasts for a while: a first-order Gauss–Markov process a radar track.

use serde::{Deserialize, Serialize};

use super::errors::RadarErrors;

/// Mean and variance of each of its parts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bias {
    /// Metres and m².
    pub range_m: Moments,
    /// Radians and their square.
    pub azimuth: Moments,
    /// Metres and m².
    pub height_m: Moments,
}

/// Mean and variance, in a unit and its square.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Moments {
    /// The mean.
    pub mean: f64,
    /// The variance.
    pub variance: f64,
}

impl Moments {
    /// Of zero mean.
    const fn centred(variance: f64) -> Self {
        Self { mean: 0.0, variance }
    }
}

/// What becomes of it: x' = kept · x + added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SlowChange {
    pub(super) kept: f64,
    pub(super) added: Bias,
}

impl Bias {
    /// Where there is no radar: nothing, with a spread that keeps the arithmetic sound.
    pub(super) const NONE: Self = Self {
        range_m: Moments::centred(1.0),
        azimuth: Moments::centred(1e-6),
        height_m: Moments::centred(1.0),
    };

    /// Of a radar track of which nothing is known.
    pub fn of(errors: &RadarErrors) -> Self {
        let unknown = |sigma: f64| Moments::centred(sigma * sigma);
        Self {
            range_m: unknown(errors.bias_range_m),
            azimuth: unknown(errors.bias_azimuth),
            height_m: unknown(errors.bias_height_m),
        }
    }

    fn scaled(&self, by: f64) -> Self {
        let scaled = |part: Moments| Moments::centred(part.variance * by);
        Self { range_m: scaled(self.range_m), azimuth: scaled(self.azimuth), height_m: scaled(self.height_m) }
    }
}

const NOTHING: Moments = Moments::centred(0.0);

impl SlowChange {
    /// No radar, or none for which something is estimated.
    pub(super) const NONE: Self =
        Self { kept: 1.0, added: Bias { range_m: NOTHING, azimuth: NOTHING, height_m: NOTHING } };

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
