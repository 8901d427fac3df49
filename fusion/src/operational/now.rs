//! The picture "now": predicted positions of the known aircraft at the deadline itself.
//!
//! It changes no state: associations and numbers were decided for the delayed picture.

use super::cameras::Cameras;
use super::cycle::Cycle;
use super::manual_association::ManualAssociations;
use super::output::{self, TargetOutput};
use super::shared;
use super::targets::{Target, Targets};
use super::tracklets::Tracklets;
use super::tuning::{NOW_RADAR_SIGMA_M, NOW_RADAR_SIGMAS, NOW_SIGMA_MAX_M};
use crate::point::{Basis, Estimate, Point, RadarPart};
use crate::slots::SlotGrid;

/// The points of the slot that opens with the deadline, in order.
pub(super) fn predict(
    targets: &Targets,
    tracklets: &Tracklets,
    cameras: &Cameras,
    correlations: &ManualAssociations,
    grid: SlotGrid,
    cycle: &Cycle,
) -> Vec<Point> {
    let predicted = shared::map(cycle.settings.threads, targets.as_slice(), |target| {
        let number = targets.number_shown(target).filter(|_| !targets.is_companion(target.id()))?;
        let known = TargetOutput::of(target, tracklets, cameras, cycle);
        let companions: Vec<(&Target, TargetOutput)> = targets
            .companions(target.id())
            .map(|other| (other, TargetOutput::of(other, tracklets, cameras, cycle)))
            .collect();
        let companions = companions.iter().map(|(other, known)| (*other, known));
        let (position, estimated) = output::published_position(target, &known, companions, cycle)?;
        let radar = known.plot.map(RadarPart::from).or(target.radar().map(|radar| radar.0));
        let because = output::because(target, known.tracklet, correlations);
        let source = output::source(target, radar, known.plot, because, position, cycle)?;
        let estimated = Estimate { basis: Basis::Extrapolated, ..estimated };
        (estimated.sigma_m() <= sigma_max_m(target, cycle)).then(|| Point {
            estimate: Some(estimated),
            cameras: target.looked_at_by(cameras, cycle),
            also: output::companion_shares(targets, target, cycle),
            ..Point::new(number.number, position, grid.centre(number.since), source)
        })
    });
    let mut points: Vec<Point> = predicted.into_iter().flatten().collect();
    points.sort_by_key(|point| (point.source.rank(), point.number));
    points
}

/// Maximum standard deviation of each axis over ground for an aircraft in the picture, metres.
fn sigma_max_m(target: &Target, cycle: &Cycle) -> f64 {
    let of_sensor = |sigma_m: f64| NOW_RADAR_SIGMAS * sigma_m + NOW_RADAR_SIGMA_M;
    match (target.transponder(), target.radar()) {
        (None, Some((_, plot_sigma_m))) => of_sensor(plot_sigma_m),
        (None, None) => NOW_SIGMA_MAX_M,
        (Some(transponder), _) => {
            // An aircraft that states a poor accuracy is shown with it, and not omitted.
            let stated_m2 = transponder.bias(cycle.settings).map_or(0.0, |bias| bias.horizontal_m2);
            of_sensor(stated_m2.sqrt()).max(NOW_SIGMA_MAX_M)
        }
    }
}
