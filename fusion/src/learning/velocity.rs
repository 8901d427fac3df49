//! Whether the velocities that a radar tells are worth anything.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::range_rate::RateOff;
use super::sizes::Sizes;

/// The velocity along a transponder's curve is itself off by this, each axis, metres a second.
const CURVE_M_S: f64 = 0.7;
/// Nothing is said before so many independent velocities were compared.
const ENOUGH: f64 = 8.0;
/// Velocities that are worse, each axis, metres a second, say less than the plots themselves do within a second or two.
pub(super) const USEFUL_M_S: f64 = 4.0;

/// What is made of a radar's velocities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum VelocityVerdict {
    /// Too few were compared; they are not used.
    Unknown,
    /// They are used, with this error.
    Used(VelocityErrors),
    /// They are wrong by more than is of use, and not used.
    Ignored(VelocityErrors),
}

/// How wrong a radar's velocities are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VelocityErrors {
    /// One sigma, each axis, metres a second.
    pub sigma_m_s: f64,
    /// Its standard deviation.
    pub deviation_m_s: f64,
}

/// How far they were off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct VelocitySums {
    /// Against transponders, each axis.
    pub(super) paired: Sizes,
    pub(super) count: f64,
    /// Along the line of sight, against the change of the range, and what that itself is off: sum of variances, m²/s².
    pub(super) radial: Sizes,
    pub(super) radial_count: f64,
    pub(super) radial_variance: f64,
}

impl VelocitySums {
    pub(super) const NONE: Self = Self {
        paired: Sizes::NONE,
        count: 0.0,
        radial: Sizes::NONE,
        radial_count: 0.0,
        radial_variance: 0.0,
    };

    pub(super) fn add(&mut self, off: &Vector2<f64>) {
        self.paired.add(off.x);
        self.paired.add(off.y);
        self.count += 1.0;
    }

    pub(super) fn add_rate(&mut self, off: &RateOff) {
        self.radial.add(off.off_m_s);
        self.radial_count += 1.0;
        self.radial_variance += off.variance;
    }

    pub(super) fn is_told_by_transponders(&self) -> bool {
        self.count >= ENOUGH
    }

    pub(super) fn fade(&mut self, kept: f64) {
        self.paired.fade(kept);
        self.radial.fade(kept);
        for sum in [&mut self.count, &mut self.radial_count, &mut self.radial_variance] {
            *sum *= kept;
        }
    }

    /// By transponders where enough of them tell.
    pub(super) fn verdict(&self) -> VelocityVerdict {
        if self.is_told_by_transponders() {
            verdict(&self.paired, CURVE_M_S * CURVE_M_S)
        } else if self.radial_count >= ENOUGH {
            verdict(&self.radial, self.radial_variance / self.radial_count)
        } else {
            VelocityVerdict::Unknown
        }
    }
}

fn verdict(off: &Sizes, other: f64) -> VelocityVerdict {
    let Some(total) = off.variance() else { return VelocityVerdict::Unknown };
    // What is left of it is at least what the samples cannot tell from nothing.
    let unsure = total * (2.0 / off.effective()).sqrt();
    let variance = (total - other).max(unsure);
    let sigma_m_s = variance.sqrt();
    let errors = VelocityErrors { sigma_m_s, deviation_m_s: unsure / (2.0 * sigma_m_s) };
    if sigma_m_s <= USEFUL_M_S { VelocityVerdict::Used(errors) } else { VelocityVerdict::Ignored(errors) }
}
