//! The persistent part of a radar's error: a first-order Gauss–Markov process for each radar track.

use serde::{Deserialize, Serialize};

use super::errors::RadarErrors;

/// Mean and variance of each part of the bias.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bias {
    /// Bias of the range: metres and m².
    pub range_m: Moments,
    /// Bias of the azimuth: radians and rad².
    pub azimuth: Moments,
    /// Bias of the height: metres and m².
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
    /// Moments with a mean of zero.
    const fn centred(variance: f64) -> Self {
        Self { mean: 0.0, variance }
    }
}

/// Change of a bias over an interval: x' = kept · x + added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SlowChange {
    pub(super) kept: f64,
    pub(super) added: Bias,
}

impl Bias {
    /// Bias without a radar: zero, with variances that keep the matrices positive definite.
    pub(super) const NONE: Self = Self {
        range_m: Moments::centred(1.0),
        azimuth: Moments::centred(1e-6),
        height_m: Moments::centred(1.0),
    };

    /// Prior bias of a new radar track.
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
    /// No change: no radar, or none whose bias is estimated.
    pub(super) const NONE: Self =
        Self { kept: 1.0, added: Bias { range_m: NOTHING, azimuth: NOTHING, height_m: NOTHING } };

    /// Change over `dt` seconds for the same radar track.
    pub(super) fn after(errors: &RadarErrors, dt: f64) -> Self {
        let kept = (-dt / errors.correlation_s).exp();
        Self { kept, added: Bias::of(errors).scaled(1.0 - kept * kept) }
    }

    /// Change to another radar track with this prior bias.
    pub(super) const fn reset(known: Bias) -> Self {
        Self { kept: 0.0, added: known }
    }
}
