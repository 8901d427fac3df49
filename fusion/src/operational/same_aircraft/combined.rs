//! Position of an aircraft from the positions of several transponders.

use nalgebra::Matrix2;

use crate::frames::Enu;
use crate::operational::tuning::{SAME_COMPARABLE, SAME_GAP_MAX_S, SAME_GAP_S};
use crate::point::{Basis, Estimate};

/// Position of an aircraft from one of its transponders.
#[derive(Clone, Copy, Debug)]
pub(in crate::operational) struct TransponderShare {
    pub(in crate::operational) position: Enu,
    pub(in crate::operational) estimate: Estimate,
    /// Time between the reports before and after, seconds.
    pub(in crate::operational) gap_s: f64,
}

/// The mean of the positions, velocities and covariances, over ground and in height, weighted by [`weights`].
///
/// The errors of several receivers on one aircraft are partly correlated. The mean of the covariances bounds the
/// covariance of the mean for any correlation.
pub(in crate::operational) fn combined(parts: &[TransponderShare]) -> Option<(Enu, Estimate)> {
    let (first, rest) = parts.split_first()?;
    if rest.is_empty() {
        return Some((first.position, first.estimate));
    }
    let over_ground = weights(parts, |part| part.horizontal.trace() / 2.0);
    let in_height = weights(parts, |part| part.vertical_m2);
    let TransponderShare { mut position, mut estimate, .. } = *first;
    position.0.fill(0.0);
    estimate.velocity.fill(0.0);
    for matrix in
        [&mut estimate.horizontal, &mut estimate.velocity_covariance, &mut estimate.position_velocity]
    {
        *matrix = Matrix2::zeros();
    }
    (estimate.vertical_m2, estimate.height_climb, estimate.climb_m2s2) = (0.0, 0.0, 0.0);
    for ((weight, up), TransponderShare { position: place, estimate: part, .. }) in
        over_ground.into_iter().zip(in_height).zip(parts)
    {
        for axis in 0..3 {
            let weight = if axis < 2 { weight } else { up };
            position.0[axis] += place.0[axis] * weight;
            estimate.velocity[axis] += part.velocity[axis] * weight;
        }
        estimate.horizontal += part.horizontal * weight;
        estimate.velocity_covariance += part.velocity_covariance * weight;
        estimate.position_velocity += part.position_velocity * weight;
        estimate.vertical_m2 += part.vertical_m2 * up;
        estimate.height_climb += part.height_climb * up;
        estimate.climb_m2s2 += part.climb_m2s2 * up;
    }
    let rank = |basis: Basis| match basis {
        Basis::Measured => 0,
        Basis::Interpolated => 1,
        Basis::Extrapolated => 2,
    };
    for TransponderShare { estimate: part, .. } in rest {
        if rank(part.basis) < rank(estimate.basis) {
            estimate.basis = part.basis;
        }
        estimate.last_measurement = estimate.last_measurement.max(part.last_measurement);
    }
    Some((position, estimate))
}

/// Weights with a sum of one. The more accurate position counts more. Stated accuracies are not comparable enough to
/// weight by their squares, unless they differ widely. In a gap an aircraft may turn by more than the covariance allows
/// for.
fn weights(parts: &[TransponderShare], variance: impl Fn(&Estimate) -> f64) -> Vec<f64> {
    let sigma_m = |part: &TransponderShare| variance(&part.estimate).max(1e-6).sqrt();
    let best_m = parts.iter().map(sigma_m).fold(f64::INFINITY, f64::min);
    let weight = |part: &TransponderShare| {
        let poorer = sigma_m(part) / best_m;
        let far_poorer = (SAME_COMPARABLE / poorer).min(1.0).powi(4);
        let gap = part.gap_s.min(SAME_GAP_MAX_S) / SAME_GAP_S;
        far_poorer / poorer / (1.0 + gap.powi(4))
    };
    let weights: Vec<f64> = parts.iter().map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / sum).collect()
}

#[cfg(test)]
mod tests;
