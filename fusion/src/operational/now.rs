//! The picture "now": where the known aircraft are by the deadline itself, predicted.
//!
//! It changes nothing: who is which aircraft, and under which number, was decided for the picture that waits.

use super::cameras::Cameras;
use super::correlation::Correlations;
use super::cycle::Cycle;
use super::output::{self, Known};
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
    correlations: &Correlations,
    grid: SlotGrid,
    cycle: &Cycle,
) -> Vec<Point> {
    let predicted = shared::map(cycle.settings.threads, targets.as_slice(), |target| {
        let number = target.number()?;
        let known = Known::of(target, tracklets, cycle);
        let estimate = known.estimate.filter(|_| known.is_worth_showing(target))?;
        let radar = known.plot.map(RadarPart::from).or(target.radar().map(|radar| radar.0));
        let because = output::because(target, known.tracklet, correlations);
        let source = output::source(target, radar, known.plot, because, &estimate, cycle)?;
        let estimated = output::estimated(target, &estimate, known.seen, known.has_radar_height, cycle);
        let estimated = Estimate { basis: Basis::Extrapolated, ..estimated };
        (estimated.sigma_m() <= sigma_max_m(target, cycle)).then(|| Point {
            estimate: Some(estimated),
            cameras: target.looked_at_by(cameras, cycle),
            ..Point::new(number.number, estimate.position, grid.centre(number.since), source)
        })
    });
    let mut points: Vec<Point> = predicted.into_iter().flatten().collect();
    points.sort_by_key(|point| (point.source.rank(), point.number));
    points
}

/// An aircraft of which less is known is not in the picture, sigma of each axis over ground, metres.
fn sigma_max_m(target: &Target, cycle: &Cycle) -> f64 {
    let of_sensor = |sigma_m: f64| NOW_RADAR_SIGMAS * sigma_m + NOW_RADAR_SIGMA_M;
    match (target.transponder(), target.radar()) {
        (None, Some((_, plot_sigma_m))) => of_sensor(plot_sigma_m),
        (None, None) => NOW_SIGMA_MAX_M,
        (Some(transponder), _) => {
            // One that says that it knows its place badly is shown as badly, and not left out.
            let stated_m2 = transponder.bias(cycle.settings).map_or(0.0, |bias| bias.horizontal_m2);
            of_sensor(stated_m2.sqrt()).max(NOW_SIGMA_MAX_M)
        }
    }
}
