//! Residuals from which radars and transponders are learnt: plots minus the transponder's position.

use nalgebra::Vector2;

use super::cycle::Cycle;
use super::settings::{OperationalSettings, RadarSettings};
use super::targets::{Target, Targets};
use super::tracklets::{CorrectedPlot, Tracklet};
use super::transponder::{CurveCursor, Transponder, lowered};
use super::tuning::{NEAR_M, STEEP, VELOCITY_HALF_BASE_S};
use crate::filter::LineOfSight;
use crate::frames::Enu;
use crate::learning::{ComparedPlot, RatePlot};
use crate::registration::{Correction, Residual};
use crate::report::Plot;
use crate::time::{SECOND, Time};

/// The plots since the last slot, each compared with the position of the associated transponder.
pub(super) fn residuals<'a>(
    tracklet: &'a Tracklet,
    targets: &Targets,
    cycle: &Cycle,
) -> Vec<(&'a CorrectedPlot, Residual)> {
    let radar = cycle.settings.radar(tracklet.key.sensor);
    let target = tracklet.target().and_then(|target| targets.get(target));
    let Some((radar, target)) = radar.zip(target) else { return Vec::new() };
    if tracklet.corrected_between(cycle.previous, cycle.centre).next().is_none() {
        return Vec::new();
    }
    let Some(mut curve) = ReportedCurve::of(target, cycle.settings) else { return Vec::new() };
    residuals_with(tracklet, target, &mut curve, radar, cycle)
}

/// The plots since the last slot, each compared with the position of this transponder.
pub(super) fn residuals_with<'a>(
    tracklet: &'a Tracklet,
    target: &Target,
    curve: &mut ReportedCurve,
    radar: &RadarSettings,
    cycle: &Cycle,
) -> Vec<(&'a CorrectedPlot, Residual)> {
    let plots = tracklet.corrected_between(cycle.previous, cycle.centre);
    plots.filter_map(|plot| Some((plot, residual(plot, target, curve, radar)?))).collect()
}

/// A transponder's curve, with the values that are the same for all plots of a slot.
pub(super) struct ReportedCurve<'a> {
    walk: CurveCursor<'a>,
    /// Delay that is taken off the time stamps, seconds.
    delay_s: f64,
    /// Offset that is taken off the heights, metres.
    height_offset_m: f64,
    /// Standard deviation of the receiver's positions over ground, metres.
    lasting_m: f64,
}

impl<'a> ReportedCurve<'a> {
    pub(super) fn of(target: &'a Target, settings: &OperationalSettings) -> Option<Self> {
        let transponder = target.transponder()?;
        Some(Self {
            walk: transponder.walk(settings)?,
            delay_s: settings.delay(&transponder.identity, &transponder.kind())?.applied_s,
            height_offset_m: settings.height_offset_m(&transponder.identity),
            lasting_m: settings.transponder(transponder.sensor)?.horizontal_m,
        })
    }
}

/// Compares an uncorrected plot with the transponder's position by its time stamps.
///
/// Position and velocity come from the curve with the applied delay. The position is then moved back by the velocity times that
/// delay, so the velocity is correct for late time stamps. `None` outside the curve, and where the curve leads to a jump or back:
/// a false position and speed would appear as an accurately known delay.
fn residual(
    plot: &CorrectedPlot,
    target: &Target,
    curve: &mut ReportedCurve,
    radar: &RadarSettings,
) -> Option<Residual> {
    let CorrectedPlot { plot, raw } = plot;
    let ReportedCurve { ref mut walk, delay_s, height_offset_m, lasting_m } = *curve;
    let mut at = |after_s: f64| {
        walk.at(Time::from_nanos(plot.time.nanos() + (after_s * SECOND as f64).round() as i64))
    };
    let (here, before, after) = (at(0.0)?, at(-VELOCITY_HALF_BASE_S)?, at(VELOCITY_HALF_BASE_S)?);
    if target.jumps_at(plot.time) {
        return None;
    }
    let velocity = (after.position.0 - before.position.0) / (2.0 * VELOCITY_HALF_BASE_S);
    Some(Residual {
        time: plot.time,
        plot: radar.frame.from_site(*raw),
        // The reported height: the offset that is taken off it rests on this.
        target: radar
            .frame
            .from_site(lowered(Enu::from(here.position.0 - velocity * delay_s), -height_offset_m)),
        velocity: radar.frame.vector_from_site(velocity),
        height_measured: plot.height_measured && here.height_measured,
        lasting_m,
        curve_m: here.sigma_m,
        spacing_s: here.spacing_s,
    })
}

/// Ground range of a plot, and its rate as reported by the radar; `None` if the radar reports no velocity.
pub(super) fn rate_plot(plot: &Plot, radar: &RadarSettings) -> Option<RatePlot> {
    let LineOfSight { range_m, outward, .. } = LineOfSight::from(radar.position, plot.position);
    Some(RatePlot { time: plot.time, range_m, reported_m_s: plot.velocity?.dot(&outward) })
}

/// The residual on each axis, after correction of the plot. `None` where the azimuth is inaccurate.
pub(super) fn compared(
    residual: &Residual,
    plot: &CorrectedPlot,
    correction: &Correction,
    transponder: &Transponder,
    settings: &OperationalSettings,
) -> Option<ComparedPlot> {
    let Residual { time, plot: seen, mut target, velocity, height_measured, curve_m, .. } = *residual;
    target.0.z -= settings.height_offset_m(&transponder.identity);
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
    let curve_m2 = curve_m * curve_m;
    let [_, climb_m] = transponder.white_m(receiver);
    let climb_m2 = climb_m * climb_m;
    let left = [left.range_m, left.azimuth * 1000.0, left.height_m];
    Some(ComparedPlot {
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
        reported_velocity: plot.plot.velocity,
    })
}
