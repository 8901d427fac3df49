//! Whether a radar track is a target that no sensor saw for a while: by where the target must be.

use super::correlation::Decided;
use super::ids::TargetId;
use super::settings::Radar;
use super::targets::{Target, Targets};
use super::tracklets::Tracklet;
use super::tuning::{
    CLASS_LLR_MAX, DRONE_SPEED_MAX_M_S, GATE_M, GATE_SIGMAS, PLAUSIBLE_LLR, REACQUIRE_GATE,
    REACQUIRE_SIGMA_MAX_M, SEPARATION_IN_HEIGHT, SEPARATION_OVER_GROUND,
};
use crate::filter::{LineOfSight, StateEstimate};
use crate::report::Plot;
use crate::time::Time;

/// Where a target is, as far as that is known well enough to look for it there.
pub(super) fn expected(target: &Target, time: Time) -> Option<StateEstimate> {
    target.estimate(time).filter(|estimate| estimate.sigma_m() < REACQUIRE_SIGMA_MAX_M)
}

/// LLR of a plot's being of a target that is expected there, against its being of another one; `None` outside the gate.
pub(super) fn llr(plot: &Plot, expected: &StateEstimate, radar: &Radar) -> Option<f64> {
    let errors = &radar.errors;
    let seen = LineOfSight::from(radar.position, plot.position);
    let covariance = expected.horizontal
        + seen.spread(
            errors.bias_range_m.hypot(errors.noise_range_m),
            errors.bias_azimuth.hypot(errors.noise_azimuth),
        );
    let apart = plot.position.0 - expected.position.0;
    let mut distance = (apart.xy().transpose() * covariance.try_inverse()? * apart.xy()).x;
    let mut llr = -0.5 * covariance.determinant().ln() + 2.0 * SEPARATION_OVER_GROUND.distance_m.ln();
    if plot.height_measured {
        let variance = expected.vertical + errors.bias_height_m.powi(2) + errors.noise_height_m.powi(2);
        distance += apart.z * apart.z / variance;
        llr += -0.5 * variance.ln() + SEPARATION_IN_HEIGHT.distance_m.ln();
    }
    (distance < REACQUIRE_GATE).then_some(llr - 0.5 * distance)
}

/// The targets that a radar track that is still to begin could be, by where they are when it begins, each with its LLR. The
/// nearest first.
pub(super) fn plausible<'a>(
    tracklet: &'a Tracklet,
    radar: &'a Radar,
    targets: &'a Targets,
    decided: &'a Decided,
) -> impl Iterator<Item = (TargetId, f64)> + 'a {
    let log_odds = tracklet.existence().log_odds();
    let first = tracklet.nearest(tracklet.first()).filter(|_| log_odds > 0.0);
    let near = first
        .into_iter()
        .flat_map(move |plot| near(plot, targets, radar).into_iter().map(move |target| (plot, target)));
    near.filter_map(move |(plot, target)| {
        let there = expected(target, plot.time)?;
        let llr = decided.leaves(tracklet, target.id()).then(|| llr(plot, &there, radar))??;
        let llr = tracklet.pair_llr(target.id()).unwrap_or(0.0) + llr + log_odds.min(CLASS_LLR_MAX);
        (llr > PLAUSIBLE_LLR).then_some((target.id(), llr))
    })
}

/// Gate: the targets that could have flown to a plot from where they were measured last, the nearest first.
fn near<'a>(plot: &Plot, targets: &'a Targets, radar: &Radar) -> Vec<&'a Target> {
    let off_m = GATE_M + GATE_SIGMAS * radar.plot_sigma_m(plot.position);
    let near = |target: &'a Target| {
        let last = target.last_measurement()?;
        let flown_m = DRONE_SPEED_MAX_M_S * plot.time.seconds_since(last.time).abs();
        let away_m = (plot.position.0 - last.position.0).xy().norm();
        (away_m <= flown_m + off_m).then_some((away_m, target))
    };
    let mut near: Vec<(f64, &Target)> = targets.iter().filter_map(near).collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0)); // stable
    near.into_iter().map(|(_, target)| target).collect()
}
