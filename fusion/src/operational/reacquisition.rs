//! Reacquisition: whether a radar track is a target that no sensor detected for a while, by the target's expected
//! position.

use nalgebra::Matrix2;

use super::ids::TargetId;
use super::manual_association::DecidedPairs;
use super::places::SpatialIndex;
use super::settings::RadarSettings;
use super::targets::{Target, Targets};
use super::tracklets::Tracklet;
use super::transponder::Transponder;
use super::tuning::{
    CLASS_LLR_MAX, DRONE_SPEED_MAX_M_S, GATE_M, GATE_SIGMAS, PLAUSIBLE_CLASS_LLR, PLAUSIBLE_LLR,
    REACQUIRE_GATE, REACQUIRE_SIGMA_MAX_M, SEPARATION_IN_HEIGHT, SEPARATION_OVER_GROUND,
};
use crate::filter::{LineOfSight, StateEstimate};
use crate::frames::Enu;
use crate::report::Plot;
use crate::time::Time;

/// Expected position of a target, if it is known well enough to search for it there.
pub(super) fn expected(target: &Target, time: Time) -> Option<StateEstimate> {
    let mut expected = target.estimate(time).filter(|estimate| estimate.sigma_m() < REACQUIRE_SIGMA_MAX_M)?;
    expected.vertical += target.transponder().map_or(0.0, Transponder::coarse_height_m2);
    Some(expected)
}

/// LLR of a plot for a target with this expected position, against another one; `None` outside the gate.
fn llr(plot: &Plot, expected: &StateEstimate, radar: &RadarSettings) -> Option<f64> {
    let (mut llr, mut distance) = over_ground(plot, expected, radar)?;
    if plot.height_measured {
        let errors = &radar.errors;
        let apart_m = plot.position.0.z - expected.position.0.z;
        let variance = expected.vertical + errors.bias_height_m.powi(2) + errors.noise_height_m.powi(2);
        distance += apart_m * apart_m / variance;
        llr +=
            -0.5 * variance.ln() + SEPARATION_IN_HEIGHT.distance_m.ln() - 0.5 * apart_m * apart_m / variance;
    }
    (distance < REACQUIRE_GATE).then_some(llr)
}

/// LLR over ground alone, with the squared Mahalanobis distance; `None` outside the gate.
fn over_ground(plot: &Plot, expected: &StateEstimate, radar: &RadarSettings) -> Option<(f64, f64)> {
    let covariance = expected.horizontal + plot_spread(plot, radar);
    let apart = (plot.position.0 - expected.position.0).xy();
    let distance = (apart.transpose() * covariance.try_inverse()? * apart).x;
    let llr = -0.5 * covariance.determinant().ln() + 2.0 * SEPARATION_OVER_GROUND.distance_m.ln();
    (distance < REACQUIRE_GATE).then_some((llr - 0.5 * distance, distance))
}

/// Covariance of a plot over ground, m².
fn plot_spread(plot: &Plot, radar: &RadarSettings) -> Matrix2<f64> {
    let errors = &radar.errors;
    LineOfSight::from(radar.position, plot.position).spread(
        errors.bias_range_m.hypot(errors.noise_range_m),
        errors.bias_azimuth.hypot(errors.noise_azimuth),
    )
}

/// Candidate targets of a radar track that is still to begin, by their expected positions at its start, each with its
/// LLR. The nearest first.
pub(super) fn plausible<'a>(
    tracklet: &'a Tracklet,
    radar: &'a RadarSettings,
    targets: &'a Targets,
    measured: &'a MeasuredPositions,
    decided: &'a DecidedPairs,
) -> impl Iterator<Item = (TargetId, f64)> + 'a {
    let as_such = tracklet.existence().log_odds().min(CLASS_LLR_MAX);
    let first = tracklet.nearest(tracklet.first()).filter(|_| !tracklet.existence().is_vetoed());
    let near = first.into_iter().flat_map(move |plot| {
        near(plot, targets, measured, radar).into_iter().map(move |target| (plot, target))
    });
    near.filter_map(move |(plot, target)| {
        let class = target.class_llr(tracklet);
        // A possible target is not excluded because its class differs once.
        let could = Some(class.max(as_such)).filter(|&could| could > 0.0)?;
        let there = expected(target, plot.time)?;
        let llr = decided.leaves(tracklet, target.id()).then(|| llr(plot, &there, radar))??;
        let llr = tracklet.pair_llr(target.id()).unwrap_or(0.0) + llr;
        let most = if class < PLAUSIBLE_CLASS_LLR { PLAUSIBLE_LLR } else { f64::INFINITY };
        (llr + could > PLAUSIBLE_LLR).then_some((target.id(), (llr + class).min(most)))
    })
}

/// Whether a radar track that is still to begin starts over ground where a target may be, at any height. Height is what
/// radars measure worst, often with larger errors than they state.
pub(super) fn begins_over_one(
    tracklet: &Tracklet,
    radar: &RadarSettings,
    targets: &Targets,
    measured: &MeasuredPositions,
    decided: &DecidedPairs,
) -> bool {
    let is_present = |plot: &Plot, target: &Target| {
        let there = expected(target, plot.time).filter(|_| decided.leaves(tracklet, target.id()));
        let llr = there.and_then(|there| over_ground(plot, &there, radar));
        llr.is_some_and(|(llr, _)| llr + tracklet.existence().log_odds().min(CLASS_LLR_MAX) > PLAUSIBLE_LLR)
    };
    tracklet.nearest(tracklet.first()).is_some_and(|plot| {
        near(plot, targets, measured, radar).into_iter().any(|target| is_present(plot, target))
    })
}

/// Gate: the targets that could have flown to a plot from their last measured position, the nearest first.
fn near<'a>(
    plot: &Plot,
    targets: &'a Targets,
    measured: &MeasuredPositions,
    radar: &RadarSettings,
) -> Vec<&'a Target> {
    let off_m = GATE_M + GATE_SIGMAS * radar.plot_sigma_m(plot.position);
    let flown_m = |time: Time| DRONE_SPEED_MAX_M_S * plot.time.seconds_since(time).abs();
    let MeasuredPositions { places, earliest, latest } = measured;
    let furthest_m = flown_m(*earliest).max(flown_m(*latest)) + off_m;
    let near = |&(place, (id, time)): &(Enu, (TargetId, Time))| {
        let away_m = (plot.position.0 - place.0).xy().norm();
        if away_m > flown_m(time) + off_m {
            return None;
        }
        Some((away_m, targets.get(id)?))
    };
    let mut near: Vec<(f64, &Target)> = places.within(plot.position, furthest_m).filter_map(near).collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0)); // stable
    near.into_iter().map(|(_, target)| target).collect()
}

/// Last measured positions of the targets, at the start of the slot's passes.
#[derive(Debug)]
pub(super) struct MeasuredPositions {
    places: SpatialIndex<(TargetId, Time)>,
    earliest: Time,
    latest: Time,
}

impl MeasuredPositions {
    /// Positions of these targets.
    pub(super) fn of(targets: &Targets) -> Self {
        let last = |target: &Target| {
            let last = target.last_measurement()?;
            Some((last.position, (target.id(), last.time)))
        };
        let leads = |target: &&Target| !targets.is_companion(target.id());
        let places = SpatialIndex::of(targets.iter().filter(leads).filter_map(last));
        let times = || places.iter().map(|&(_, (_, time))| time);
        let (earliest, latest) = (times().min().unwrap_or_default(), times().max().unwrap_or_default());
        Self { places, earliest, latest }
    }
}

/// Targets that no sensor detects now, at their expected positions.
#[derive(Debug)]
pub(super) struct UndetectedTargets {
    places: SpatialIndex<(TargetId, StateEstimate)>,
    /// Largest sum of the variances over ground, m².
    spread_m2: f64,
}

impl UndetectedTargets {
    /// Index of these targets.
    pub(super) fn of(unseen: impl Iterator<Item = (TargetId, StateEstimate)>) -> Self {
        let places = SpatialIndex::of(unseen.map(|(id, expected)| (expected.position, (id, expected))));
        let spread = |(_, (_, expected)): &(Enu, (TargetId, StateEstimate))| expected.horizontal.trace();
        let spread_m2 = places.iter().map(spread).fold(0.0, f64::max);
        Self { places, spread_m2 }
    }

    /// Candidate targets of a plot, each with its LLR; by target.
    pub(super) fn near(&self, plot: &Plot, radar: &RadarSettings) -> impl Iterator<Item = (TargetId, f64)> {
        // No eigenvalue of a covariance exceeds its trace; 1 % is added for rounding.
        let spread_m2 = self.spread_m2 + plot_spread(plot, radar).trace();
        let reach_m = (1.01 * REACQUIRE_GATE * spread_m2).sqrt();
        let (plot, radar) = (*plot, *radar);
        self.places
            .within(plot.position, reach_m)
            .filter_map(move |&(_, (id, ref expected))| Some((id, llr(&plot, expected, &radar)?)))
    }
}
