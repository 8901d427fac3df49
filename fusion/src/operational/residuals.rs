//! What a radar and its transponders learn from: plots against where the transponder was that their track goes with.

use nalgebra::Vector2;

use super::cycle::Cycle;
use super::settings::{Radar, Settings};
use super::targets::{Target, Targets};
use super::tracklets::{CorrectedPlot, Tracklet};
use super::transponder::Transponder;
use super::tuning::{NEAR_M, STEEP, VELOCITY_HALF_BASE_S};
use crate::filter::LineOfSight;
use crate::learning::{Compared, Seen};
use crate::registration::{Correction, Residual};
use crate::report::Plot;
use crate::time::{SECOND, Time};

/// The plots since the last slot, each against where the transponder was that the radar track goes with.
pub(super) fn residuals<'a>(
    tracklet: &'a Tracklet,
    targets: &Targets,
    cycle: &Cycle,
) -> Vec<(&'a CorrectedPlot, Residual)> {
    let radar = cycle.settings.radar(tracklet.key.sensor);
    let target = tracklet.target().and_then(|target| targets.get(target));
    let Some((radar, target)) = radar.zip(target) else { return Vec::new() };
    let plots = tracklet.corrected_between(cycle.previous, cycle.centre);
    plots.filter_map(|plot| Some((plot, residual(plot, target, radar, cycle.settings)?))).collect()
}

/// A plot, uncorrected, against where the transponder was by its time as it is stamped. `None` outside its curve, and where that
/// leads to a jump or back: a place and a speed that were made up look like a delay, and a certain one.
fn residual(plot: &CorrectedPlot, target: &Target, radar: &Radar, settings: &Settings) -> Option<Residual> {
    let transponder = target.transponder()?;
    let receiver = settings.transponder(transponder.sensor)?;
    let delay_s = settings.delay(&transponder.identity, &transponder.kind())?.applied_s;
    let CorrectedPlot { plot, raw } = plot;
    let stamped = |after_s: f64| {
        Time::from_nanos(plot.time.nanos() + ((after_s - delay_s) * SECOND as f64).round() as i64)
    };
    let at = |after_s: f64| transponder.on_curve(stamped(after_s), settings);
    let (here, before, after) = (at(0.0)?, at(-VELOCITY_HALF_BASE_S)?, at(VELOCITY_HALF_BASE_S)?);
    if target.jumps_at(stamped(0.0)) {
        return None;
    }
    Some(Residual {
        time: plot.time,
        plot: radar.frame.from_site(*raw),
        target: radar.frame.from_site(here.position),
        velocity: radar.frame.vector_from_site(after.position.0 - before.position.0)
            / (2.0 * VELOCITY_HALF_BASE_S),
        height_measured: plot.height_measured && here.height_measured,
        sigma_m: here.sigma_m.hypot(receiver.horizontal_m),
    })
}

/// How far a plot lies away over ground, and how fast the radar says that it goes away; `None` where it does not say.
pub(super) fn seen(plot: &Plot, radar: &Radar) -> Option<Seen> {
    let LineOfSight { range_m, outward, .. } = LineOfSight::from(radar.position, plot.position);
    Some(Seen { time: plot.time, range_m, told_m_s: plot.velocity?.dot(&outward) })
}

/// The residual as an aligned radar would have it, by axis; `None` where azimuth means little.
pub(super) fn compared(
    residual: &Residual,
    plot: &CorrectedPlot,
    correction: &Correction,
    transponder: &Transponder,
    settings: &Settings,
) -> Option<Compared> {
    let Residual { time, plot: seen, target, velocity, height_measured, sigma_m } = *residual;
    let bias = transponder.bias(settings)?;
    let receiver = settings.transponder(transponder.sensor)?;
    let (corrected, target) = match height_measured {
        true => (correction.apply(seen).0, target.0),
        false => (correction.apply_without_height(seen).0, target.0),
    };
    let ground_m = target.xy().norm();
    if ground_m < NEAR_M || corrected.xy().norm() < NEAR_M || target.z.abs() > STEEP * ground_m {
        return None;
    }
    let left = correction.remaining(target.into());
    let clockwise = Vector2::new(target.y, -target.x) / ground_m;
    let milli_m = 1000.0 / ground_m;
    let turned = corrected.xy().dot(&clockwise).atan2(corrected.xy().dot(&target.xy()) / ground_m);
    let rates = [velocity.dot(&target) / target.norm(), velocity.xy().dot(&clockwise) * milli_m, velocity.z];
    let curve_m2 = (sigma_m * sigma_m - receiver.horizontal_m * receiver.horizontal_m).max(0.0);
    let [_, climb_m] = transponder.white_m(receiver);
    let climb_m2 = climb_m * climb_m;
    let left = [left.range_m, left.azimuth * 1000.0, left.height_m];
    Some(Compared {
        time,
        offsets: [
            Some(corrected.norm() - target.norm()),
            Some(turned * 1000.0),
            height_measured.then_some(corrected.z - target.z),
        ],
        slow: [bias.horizontal_m2, bias.horizontal_m2 * milli_m * milli_m, bias.vertical_m2],
        curve: [curve_m2, curve_m2 * milli_m * milli_m, climb_m2],
        constant: std::array::from_fn(|axis| {
            left[axis] * left[axis] + bias.time_s2 * rates[axis] * rates[axis]
        }),
        velocity: velocity.xy(),
        told_velocity: plot.plot.velocity,
    })
}
