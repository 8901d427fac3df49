//! Gauss–Newton on the pose. Each round associates again and estimates the noise again.

use fusion::frames::TangentPlane;
use nalgebra::{SMatrix, SVector, Vector2, Vector3};

use crate::noise::{Rows, fitted, total};
use crate::pairing::{Gate, Match, matches};
use crate::path::{Path, PathPoint};
use crate::pieces::Piece;
use crate::pose::{PARAMETERS, PolarResidual, Pose, residual};
use crate::whitening::{AxisNoise, Information, Row, whitened};

/// The parameters and the residual.
const COLUMNS: usize = PARAMETERS + 1;

/// The recording, prepared.
pub(crate) struct Recording<'a> {
    pub(crate) site: &'a TangentPlane,
    pub(crate) pieces: &'a [Piece],
    pub(crate) paths: &'a [Path],
    /// Assumed height of the antenna in the site's frame, metres, and its deviation.
    pub(crate) up_m: (f64, f64),
}

/// Prior deviations. A radar is not expected to be off by more in range; a transponder's delay differs from the mean by the last.
const RANGE_M: f64 = 10.0;
const SCALE: f64 = 0.001;
const FAR_M: f64 = 1e5;
const ANY_BEARING: f64 = 10.0;
const ANY_TIME_S: f64 = 20.0;
const DELAY_S: f64 = 0.08;

/// Prior deviations of the parameters.
pub(crate) fn prior_sigmas(up_sigma_m: f64) -> SVector<f64, PARAMETERS> {
    SVector::from([FAR_M, FAR_M, up_sigma_m, ANY_BEARING, RANGE_M, SCALE, ANY_TIME_S])
}

/// Usual errors of a drone radar and of a transponder (GNSS): azimuth in radians, range in metres.
const AZIMUTH: AxisNoise = AxisNoise { slow: 0.017, time_s: 20.0, white: 0.005, transponder: TRANSPONDER };
const RANGE: AxisNoise = AxisNoise { slow: 5.0, time_s: 20.0, white: 3.0, transponder: TRANSPONDER };
const TRANSPONDER: (f64, f64) = (2.0, 60.0);

/// Factor of the azimuth error that a track keeps: it is larger in turns, where most of what the bearing rests on is measured.
const TURNS: f64 = 1.3;

/// Errors of both axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PolarNoise {
    pub(crate) azimuth: AxisNoise,
    pub(crate) range: AxisNoise,
}

impl Default for PolarNoise {
    fn default() -> Self {
        Self { azimuth: AZIMUTH, range: RANGE }
    }
}

/// A fitted pose.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    pub(crate) pose: Pose,
    pub(crate) noise: PolarNoise,
    pub(crate) matches: Vec<Match>,
    pub(crate) covariance: SMatrix<f64, PARAMETERS, PARAMETERS>,
    /// Robust deviations of the associated plots: azimuth, radians, and range, metres.
    pub(crate) spread: (f64, f64),
    /// Whether the noise is the radar's own.
    learnt: bool,
    /// Last change of the pose, in deviations.
    pub(crate) last_change: f64,
}

/// Residuals and derivatives of both axes, by path.
pub(crate) struct Both {
    azimuth: Rows<COLUMNS>,
    range: Rows<COLUMNS>,
}

/// Rows of both axes; a plot further off than `gate` deviations is left out.
pub(crate) fn rows(recording: &Recording<'_>, pose: &Pose, found: &[Match], gate: &Gate) -> Both {
    let mut both = Both {
        azimuth: vec![Vec::new(); recording.paths.len()],
        range: vec![Vec::new(); recording.paths.len()],
    };
    for one in found {
        let (piece, path) = (&recording.pieces[one.piece], &recording.paths[one.path]);
        for plot in &piece.plots {
            let Some(point) = path.at(plot.time_s + pose.later_s) else { continue };
            let Some(of) = residual(plot, &point, pose) else { continue };
            let ground_m = gate.ground_m.hypot(point.sigma_m);
            let limit = PLOT_DEVIATIONS;
            if of.azimuth.abs() > limit * gate.azimuth.hypot(ground_m / of.over_ground_m)
                || of.range_m.abs() > limit * gate.range_m.hypot(ground_m)
            {
                continue;
            }
            let (azimuth, range) = derivatives(&of, &point, pose);
            let row = |columns, per_metre| Row {
                time_s: plot.time_s,
                run: piece.run,
                columns,
                per_metre,
                sigma_m: point.sigma_m,
            };
            both.azimuth[one.path].push(row(azimuth, 1.0 / of.over_ground_m));
            both.range[one.path].push(row(range, 1.0));
        }
    }
    for rows in both.azimuth.iter_mut().chain(&mut both.range) {
        rows.sort_by(|a, b| a.time_s.total_cmp(&b.time_s).then(a.run.cmp(&b.run)));
    }
    both
}

/// Plots further off than this are left out.
const PLOT_DEVIATIONS: f64 = 3.5;

/// Derivatives of azimuth and range by the parameters, each with its residual as the last value.
fn derivatives(
    of: &PolarResidual,
    point: &PathPoint,
    pose: &Pose,
) -> (SVector<f64, COLUMNS>, SVector<f64, COLUMNS>) {
    let (local, g) = (of.local, of.over_ground_m);
    let clockwise = Vector3::new(local.y, -local.x, 0.0) / (g * g);
    let distance_m = local.norm();
    let outward = local / distance_m;
    let velocity = pose.frame.vector_from_site(point.velocity);
    // The axes at the antenna are turned little against the site's.
    let azimuth = [-clockwise.x, -clockwise.y, 0.0, 1.0, 0.0, 0.0, clockwise.dot(&velocity), of.azimuth];
    let range =
        [-outward.x, -outward.y, -outward.z, 0.0, 1.0, distance_m, outward.dot(&velocity), of.range_m];
    (SVector::from(azimuth), SVector::from(range))
}

/// Information of all paths; the delay of each transponder is eliminated.
fn information(both: &Both, noise: &PolarNoise) -> SMatrix<f64, COLUMNS, COLUMNS> {
    let mut sum = SMatrix::zeros();
    for (azimuth, range) in both.azimuth.iter().zip(&both.range) {
        let one = whitened(azimuth, &noise.azimuth).bordered + whitened(range, &noise.range).bordered;
        sum += without_delay(&one);
    }
    sum
}

/// Eliminates the transponder's own delay. Its column equals the column of the time.
fn without_delay(one: &SMatrix<f64, COLUMNS, COLUMNS>) -> SMatrix<f64, COLUMNS, COLUMNS> {
    let column = one.column(PARAMETERS - 1).into_owned();
    one - column * column.transpose() / (column[PARAMETERS - 1] + DELAY_S.powi(-2))
}

/// Adds the priors to bordered information about changes of the pose.
fn with_priors(
    mut bordered: SMatrix<f64, COLUMNS, COLUMNS>,
    recording: &Recording<'_>,
    pose: &Pose,
) -> SMatrix<f64, COLUMNS, COLUMNS> {
    let sigmas = prior_sigmas(recording.up_m.1);
    let mut centre = pose.parameters();
    centre[2] = recording.up_m.0;
    (centre[4], centre[5]) = (0.0, 0.0);
    let away = centre - pose.parameters();
    for index in 0..PARAMETERS {
        let weight = sigmas[index].powi(-2);
        bordered[(index, index)] += weight;
        bordered[(index, COLUMNS - 1)] += weight * away[index];
        bordered[(COLUMNS - 1, index)] += weight * away[index];
    }
    bordered
}

type Square = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// Change of the pose, and its covariance.
fn solved(bordered: &SMatrix<f64, COLUMNS, COLUMNS>) -> Option<(SVector<f64, PARAMETERS>, Square)> {
    let information = bordered.fixed_view::<PARAMETERS, PARAMETERS>(0, 0).into_owned();
    let gradient = bordered.fixed_view::<PARAMETERS, 1>(0, COLUMNS - 1).into_owned();
    // Scaled to a unit diagonal: the parameters have several units.
    let scale = information.diagonal().map(|value| value.sqrt().recip());
    let scaled: Square =
        SMatrix::from_fn(|row, column| information[(row, column)] * scale[row] * scale[column]);
    let inverse = scaled.cholesky()?.inverse();
    let covariance: Square =
        SMatrix::from_fn(|row, column| inverse[(row, column)] * scale[row] * scale[column]);
    Some((covariance * gradient, covariance))
}

/// Deviation of the pose in each round of association, metres. Later rounds use the last value.
const ROUNDS_M: [f64; 7] = [30.0, 20.0, 15.0, 10.0, 7.0, 5.0, 2.0];
/// Maximum number of rounds.
const ROUNDS: usize = 16;
/// Change, in deviations, below which the pose has converged.
const CONVERGED: f64 = 0.02;
/// Largest steps of a round: metres, radians, seconds.
const STEP: (f64, f64, f64) = (300.0, 0.2, 1.0);

/// A few rounds with the usual noise: enough to compare candidates.
pub(crate) fn coarse(recording: &Recording<'_>, pose: Pose) -> Option<Fit> {
    let mut fit = Fit {
        pose,
        noise: PolarNoise::default(),
        matches: Vec::new(),
        covariance: SMatrix::zeros(),
        spread: USUAL_SPREAD,
        learnt: false,
        last_change: f64::INFINITY,
    };
    for ground_m in [60.0, 60.0, 40.0, 30.0, 20.0] {
        fit = round(recording, &fit, ground_m, false)?;
    }
    Some(fit)
}

/// The pose that fits best near `fit`, with the noise of the radar itself.
pub(crate) fn refined(recording: &Recording<'_>, mut fit: Fit) -> Option<Fit> {
    for count in 0..ROUNDS {
        let ground_m = ROUNDS_M[count.min(ROUNDS_M.len() - 1)];
        fit = round(recording, &fit, ground_m, count >= 3)?;
        if count > ROUNDS_M.len() + 2 && fit.last_change < CONVERGED {
            break;
        }
    }
    Some(fit)
}

/// Root mean square of a piece's distances up to which it is associated.
const DEVIATIONS: f64 = 2.5;

/// Deviations of plots before they are known: azimuth, radians, and range, metres.
pub(crate) const USUAL_SPREAD: (f64, f64) = (0.018, 6.0);
/// Limits of the deviations of plots that are used to associate.
const AZIMUTH_LIMITS: (f64, f64) = (0.006, 0.06);
const RANGE_LIMITS_M: (f64, f64) = (3.0, 25.0);

/// The gate for plots with these deviations.
pub(crate) fn gate((azimuth, range_m): (f64, f64), ground_m: f64) -> Gate {
    Gate { azimuth, range_m, ground_m: ground_m.max(TRANSPONDER.0), deviations: DEVIATIONS }
}

/// Robust deviations of the residuals: the median of their absolute values, which stray associations hardly change.
fn spread(both: &Both) -> (f64, f64) {
    let median = |rows: &Rows<COLUMNS>| {
        let mut values: Vec<f64> = rows.iter().flatten().map(|row| row.columns[PARAMETERS].abs()).collect();
        values.sort_by(f64::total_cmp);
        MEDIAN_TO_SIGMA * values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    (
        median(&both.azimuth).clamp(AZIMUTH_LIMITS.0, AZIMUTH_LIMITS.1),
        median(&both.range).clamp(RANGE_LIMITS_M.0, RANGE_LIMITS_M.1),
    )
}

/// Standard deviation over the median of absolute values, of a normal distribution.
const MEDIAN_TO_SIGMA: f64 = 1.4826;

fn round(recording: &Recording<'_>, fit: &Fit, ground_m: f64, learns: bool) -> Option<Fit> {
    let Fit { pose, mut noise, .. } = fit.clone();
    let gate = gate(fit.spread, ground_m);
    let found = matches(recording.pieces, recording.paths, &pose, &gate);
    if found.len() < 2 {
        return None;
    }
    let both = rows(recording, &pose, &found, &gate);
    let spread = if learns { spread(&both) } else { fit.spread };
    if learns {
        let priors = with_priors(SMatrix::zeros(), recording, &pose);
        let usual = PolarNoise::default();
        let other = without_delay(&total(&both.range, &noise.range).bordered) + priors;
        noise.azimuth.slow /= if fit.learnt { TURNS } else { 1.0 };
        noise.azimuth = fitted(&both.azimuth, noise.azimuth, &usual.azimuth, &other);
        let other = without_delay(&total(&both.azimuth, &noise.azimuth).bordered) + priors;
        noise.azimuth.slow *= TURNS;
        noise.range = fitted(&both.range, noise.range, &usual.range, &other);
    }
    let bordered = with_priors(information(&both, &noise), recording, &pose);
    let (mut change, covariance) = solved(&bordered)?;
    let last_change = (0..PARAMETERS)
        .map(|index| change[index].abs() / covariance[(index, index)].sqrt())
        .fold(0.0, f64::max);
    let over_ground_m = Vector2::new(change[0], change[1]).norm();
    let share = [
        STEP.0 / over_ground_m.max(1e-9),
        STEP.1 / change[3].abs().max(1e-9),
        STEP.2 / change[6].abs().max(1e-9),
    ];
    change *= share.into_iter().fold(1.0, f64::min);
    let pose = pose.changed(recording.site, &change);
    Some(Fit { pose, noise, matches: found, covariance, spread, learnt: learns, last_change })
}

/// Information of a subset of the rows, selected by path and time, at the fitted pose: bordered, without priors.
pub(crate) fn partial(
    both: &Both,
    noise: &PolarNoise,
    is_in: impl Fn(usize, f64) -> bool,
) -> SMatrix<f64, COLUMNS, COLUMNS> {
    let mut sum = SMatrix::zeros();
    for (path, (azimuth, range)) in both.azimuth.iter().zip(&both.range).enumerate() {
        let of = |rows: &[Row<COLUMNS>]| -> Vec<Row<COLUMNS>> {
            rows.iter().filter(|row| is_in(path, row.time_s)).copied().collect()
        };
        let one: Information<COLUMNS> = whitened(&of(azimuth), &noise.azimuth);
        sum += without_delay(&(one.bordered + whitened(&of(range), &noise.range).bordered));
    }
    sum
}
