//! Flights that would show what a recording does not.

use nalgebra::Vector3;

use crate::fit::{Fit, Recording};
use crate::located_radar::{Estimate, LocatedRadar};
use crate::not_located::{Remedy, Unobservable};
use crate::pose::wrapped;

/// Advice from the spread of the drones as the radar sees them.
pub(crate) fn remedy(recording: &Recording<'_>, fit: &Fit) -> Remedy {
    let mut bearings: Vec<f64> = Vec::new();
    let (mut moved_m, mut pieces) = (0.0, 0.0);
    for one in &fit.matches {
        let points: Vec<Vector3<f64>> = recording.pieces[one.piece]
            .plots
            .iter()
            .filter_map(|plot| Some(recording.paths[one.path].at(plot.time_s)?.position))
            .collect();
        if let (Some(first), Some(last)) = (points.first(), points.last()) {
            moved_m += (last - first).norm();
            pieces += 1.0;
        }
        bearings.extend(points.iter().map(|&point| {
            let local = fit.pose.local(point);
            local.x.atan2(local.y)
        }));
    }
    if moved_m < 15.0 * pieces {
        return Remedy::Move;
    }
    let (sin, cos) = bearings.iter().fold((0.0, 0.0), |(sin, cos), b| (sin + b.sin(), cos + b.cos()));
    let mean = f64::atan2(sin, cos);
    let mut away: Vec<f64> = bearings.iter().map(|bearing| wrapped(bearing - mean)).collect();
    away.sort_by(f64::total_cmp);
    let at = |share: f64| away.get((away.len() as f64 * share) as usize).copied().unwrap_or(0.0);
    let sector_deg = (at(0.98) - at(0.02)).to_degrees();
    if sector_deg < 40.0 { Remedy::FlyAcross(sector_deg.max(1.0)) } else { Remedy::Longer }
}

/// Values that the recording does not show.
pub(crate) fn unobservable(located: &LocatedRadar, remedy: Remedy) -> Vec<Unobservable> {
    let across = match remedy {
        Remedy::FlyAcross(_) => remedy,
        _ => Remedy::Distances,
    };
    let mut found = Vec::new();
    let mut check = |estimate: Option<Estimate>, value: &'static str, remedy: Remedy| {
        if estimate.is_none_or(|estimate| !estimate.is_observable()) {
            let remedy = if estimate.is_none() { Remedy::Heights } else { remedy };
            found.push(Unobservable { value, remedy });
        }
    };
    check(Some(located.height_m), "height of the antenna", Remedy::Higher);
    check(Some(located.range_offset_m), "range offset", across);
    check(Some(located.range_scale), "range scale", Remedy::Distances);
    check(located.tilt_east_deg, "tilt about east", across);
    check(located.tilt_north_deg, "tilt about north", across);
    found
}
