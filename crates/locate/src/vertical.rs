//! Tilts and height offset, from measured heights against the transponders'.

use nalgebra::{SMatrix, SVector};

use crate::fit::{Fit, Recording, gate};
use crate::located_radar::Estimate;
use crate::noise::{Rows, fitted, total};
use crate::pose::residual;
use crate::whitening::{AxisNoise, Row};

/// Parameters: height offset, tilt about east, tilt about north; and the residual.
const COLUMNS: usize = 4;

/// Usual errors of measured heights. A transponder's height may be off for a whole flight.
const HEIGHT: AxisNoise = AxisNoise { slow: 8.0, time_s: 20.0, white: 4.0, transponder: (4.0, 200.0) };

/// Prior deviations: metres, radians.
const PRIOR: [f64; 3] = [20.0, 0.017, 0.017];

/// Minimum number of plots with a measured height.
const FEWEST: usize = 30;

/// Tilts and height offset of a radar.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertical {
    pub(crate) offset_m: Estimate,
    pub(crate) tilt_east_deg: Estimate,
    pub(crate) tilt_north_deg: Estimate,
    /// Standard deviation of a plot's height, metres.
    pub(crate) sigma_m: f64,
}

/// `None` if the radar reports no heights.
pub(crate) fn vertical(
    recording: &Recording<'_>,
    fit: &Fit,
    height_of: impl Fn(f64, f64, f64) -> f64,
) -> Option<Vertical> {
    let mut rows: Rows<COLUMNS> = vec![Vec::new(); recording.paths.len()];
    let gate = gate(fit.spread, 0.0);
    let mut count = 0;
    for one in &fit.matches {
        let (piece, path) = (&recording.pieces[one.piece], &recording.paths[one.path]);
        for plot in &piece.plots {
            let Some(measured_m) = plot.height_m else { continue };
            let Some(point) = path.at(plot.time_s + fit.pose.later_s) else { continue };
            let Some(of) = residual(plot, &point, &fit.pose) else { continue };
            if of.azimuth.abs() > 4.0 * gate.azimuth.hypot(gate.ground_m / of.over_ground_m) {
                continue;
            }
            let local = fit.pose.local(point.position);
            let at = point.position;
            let off_m = measured_m - height_of(at.x, at.y, at.z);
            count += 1;
            rows[one.path].push(Row {
                time_s: plot.time_s,
                run: piece.run,
                columns: SVector::from([1.0, local.y, -local.x, off_m]),
                per_metre: 1.0,
                sigma_m: point.sigma_m,
            });
        }
    }
    if count < FEWEST {
        return None;
    }
    for rows in &mut rows {
        rows.sort_by(|a, b| a.time_s.total_cmp(&b.time_s).then(a.run.cmp(&b.run)));
    }
    let mut priors = SMatrix::<f64, COLUMNS, COLUMNS>::zeros();
    for (index, sigma) in PRIOR.into_iter().enumerate() {
        priors[(index, index)] = sigma.powi(-2);
    }
    let noise = fitted(&rows, HEIGHT, &HEIGHT, &priors);
    let bordered = total(&rows, &noise).bordered + priors;
    let covariance = bordered.fixed_view::<3, 3>(0, 0).into_owned().cholesky()?.inverse();
    let values = covariance * bordered.fixed_view::<3, 1>(0, 3);
    let estimate = |index: usize, unit: f64| Estimate {
        value: values[index] * unit,
        sigma: covariance[(index, index)].sqrt() * unit,
        prior_sigma: PRIOR[index] * unit,
    };
    let degrees = 1_f64.to_degrees();
    Some(Vertical {
        offset_m: estimate(0, 1.0),
        tilt_east_deg: estimate(1, degrees),
        tilt_north_deg: estimate(2, degrees),
        sigma_m: noise.total(),
    })
}
