//! Estimates the errors of a radar's velocities, and whether they are usable.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::range_rate::RangeRateError;
use super::sizes::SizeHistogram;

/// Standard deviation of the velocity along a transponder's curve, each axis, metres a second.
const CURVE_M_S: f64 = 0.7;
/// Minimum number of independent velocities for a verdict.
const ENOUGH: f64 = 8.0;
/// Maximum standard deviation of usable velocities, each axis, metres a second. Worse ones add less than the plots of a
/// second or two.
pub(super) const USEFUL_M_S: f64 = 4.0;

/// Verdict on a radar's velocities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum VelocityVerdict {
    /// Too few velocities were compared; they are not used.
    Unknown,
    /// The velocities are used, with this error.
    Used(VelocityErrors),
    /// The velocities are too inaccurate, and are ignored.
    Ignored(VelocityErrors),
}

/// Estimated error of a radar's velocities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VelocityErrors {
    /// Standard deviation of each axis, metres a second.
    pub sigma_m_s: f64,
    /// Standard deviation of that estimate, metres a second.
    pub deviation_m_s: f64,
}

/// Sums of the velocities' errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct VelocitySums {
    /// Errors relative to transponders, each axis.
    pub(super) paired: SizeHistogram,
    pub(super) count: f64,
    /// Errors along the line of sight, relative to the change of the range; sum of the variances of that change, m²/s².
    pub(super) radial: SizeHistogram,
    pub(super) radial_count: f64,
    pub(super) radial_variance: f64,
}

impl VelocitySums {
    pub(super) const NONE: Self = Self {
        paired: SizeHistogram::NONE,
        count: 0.0,
        radial: SizeHistogram::NONE,
        radial_count: 0.0,
        radial_variance: 0.0,
    };

    pub(super) fn add(&mut self, off: &Vector2<f64>) {
        self.paired.add(off.x);
        self.paired.add(off.y);
        self.count += 1.0;
    }

    pub(super) fn add_rate(&mut self, off: &RangeRateError) {
        self.radial.add(off.off_m_s);
        self.radial_count += 1.0;
        self.radial_variance += off.variance;
    }

    pub(super) fn is_learnt_from_transponders(&self) -> bool {
        self.count >= ENOUGH
    }

    pub(super) fn decay(&mut self, kept: f64) {
        self.paired.decay(kept);
        self.radial.decay(kept);
        for sum in [&mut self.count, &mut self.radial_count, &mut self.radial_variance] {
            *sum *= kept;
        }
    }

    /// The verdict, from transponders if there are enough comparisons.
    pub(super) fn verdict(&self) -> VelocityVerdict {
        if self.is_learnt_from_transponders() {
            verdict(&self.paired, CURVE_M_S * CURVE_M_S)
        } else if self.radial_count >= ENOUGH {
            verdict(&self.radial, self.radial_variance / self.radial_count)
        } else {
            VelocityVerdict::Unknown
        }
    }
}

fn verdict(off: &SizeHistogram, other: f64) -> VelocityVerdict {
    let Some(total) = off.variance() else { return VelocityVerdict::Unknown };
    // The remainder is at least what the samples cannot distinguish from zero.
    let unsure = total * (2.0 / off.effective()).sqrt();
    let variance = (total - other).max(unsure);
    let sigma_m_s = variance.sqrt();
    let errors = VelocityErrors { sigma_m_s, deviation_m_s: unsure / (2.0 * sigma_m_s) };
    if sigma_m_s <= USEFUL_M_S { VelocityVerdict::Used(errors) } else { VelocityVerdict::Ignored(errors) }
}
