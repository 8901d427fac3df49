//! Update of a Gaussian state by a reading: linearised, whitened, and applied one value after another.

use nalgebra::Vector3;

use super::quantity::Quantity;
use super::reading::{MOST, Reading, Whitening};
use fusion::filter::{Gaussian, Rows, Symmetric, Vector};

/// Number of variables that are measured, the first of a state: east, north, up, and their rates.
pub(super) const SEEN: usize = 6;

/// Ratio of the estimate's width across the line of sight to the range, above which the arc of an azimuth is no longer
/// straight: the reading is then linearised a second time, at the first result.
const CURVED: f64 = 0.2;

/// A row of the Jacobian, and the innovation.
type JacobianRow = [f64; SEEN + 1];

/// Agreement of a reading with the prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ReadingFit {
    /// Squared Mahalanobis distance.
    pub(super) distance: f64,
    /// Determinant of the innovations' covariance, as a multiple of that of the noise.
    pub(super) determinant: f64,
}

/// Values of a reading that are usable for an aircraft at each of these states.
pub(super) fn usable<'a, const D: usize>(
    reading: &Reading,
    states: impl IntoIterator<Item = &'a Vector<D>>,
) -> [bool; MOST] {
    let mut usable = [true; MOST];
    for state in states {
        let (position, velocity) = seen(state);
        for (usable, (quantity, _)) in usable.iter_mut().zip(reading.values()) {
            *usable &= quantity.expected(&reading.origin().observer, &position, &velocity).is_some();
        }
    }
    usable
}

fn seen<const D: usize>(state: &Vector<D>) -> (Vector3<f64>, Vector3<f64>) {
    (Vector3::new(state[0], state[1], state[2]), Vector3::new(state[3], state[4], state[5]))
}

/// The whitened rows of the values used, linearised at `at`, with the innovations of a state `of`. `None` if one of
/// them is not usable at `at`.
fn linearised<const D: usize>(
    reading: &Reading,
    whitening: &Whitening,
    at: &Vector<D>,
    of: &Vector<D>,
) -> Option<[JacobianRow; MOST]> {
    let (position, velocity) = seen(at);
    let mut rows = [[0.0; SEEN + 1]; MOST];
    for (row, &place) in rows.iter_mut().zip(whitening.places()) {
        let (quantity, value) = reading.values()[place];
        let expected = quantity.expected(&reading.origin().observer, &position, &velocity)?;
        row[..3].copy_from_slice(expected.by_position.as_slice());
        row[3..SEEN].copy_from_slice(expected.by_velocity.as_slice());
        let moved: f64 = (0..SEEN).map(|index| row[index] * (of[index] - at[index])).sum();
        row[SEEN] = quantity.innovation(value, expected.value) - moved;
    }
    whitening.apply(&mut rows);
    Some(rows)
}

/// Updates the state by the values used; returns their agreement with the prediction. `None`, without an update, if
/// none is used or one of them is not usable at this state.
pub(super) fn apply_reading<const D: usize>(
    state: &mut Gaussian<D>,
    reading: &Reading,
    whitening: &Whitening,
) -> Option<ReadingFit> {
    let prior = *state;
    if whitening.places().is_empty() {
        return None;
    }
    let rows = linearised(reading, whitening, &prior.mean, &prior.mean)?;
    let fit = apply_rows(state, &prior, &rows, whitening.places().len());
    if is_curved(&prior, reading, whitening)
        && let Some(rows) = linearised(reading, whitening, &state.mean, &prior.mean)
    {
        *state = prior;
        apply_rows(state, &prior, &rows, whitening.places().len());
    }
    Some(fit)
}

/// Agreement of a reading with the prediction, without an update.
pub(super) fn fit<const D: usize>(
    state: &Gaussian<D>,
    reading: &Reading,
    whitening: &Whitening,
) -> Option<ReadingFit> {
    let rows = linearised(reading, whitening, &state.mean, &state.mean)?;
    Some(apply_rows(&mut state.clone(), state, &rows, whitening.places().len()))
}

/// Whether the estimate is so wide across the line of sight that the curvature of an azimuth's arc matters.
fn is_curved<const D: usize>(prior: &Gaussian<D>, reading: &Reading, whitening: &Whitening) -> bool {
    let is_azimuth = |&place: &usize| reading.values()[place].0 == Quantity::Azimuth;
    if !whitening.places().iter().any(is_azimuth) {
        return false;
    }
    let (position, velocity) = seen(&prior.mean);
    let observer = &reading.origin().observer;
    let Some(azimuth) = Quantity::Azimuth.expected(observer, &position, &velocity) else { return false };
    let away = position - observer.position.0;
    let over = |row: usize, column: usize| {
        azimuth.by_position[row] * prior.covariance.at(row, column) * azimuth.by_position[column]
    };
    let variance = over(0, 0) + 2.0 * over(0, 1) + over(1, 1);
    variance.max(0.0).sqrt() * away.x.hypot(away.y) > CURVED * away.norm()
}

/// Updates the state by the first `count` rows, whose noise is white with variance 1. Their innovations are those of
/// `prior`.
fn apply_rows<const D: usize>(
    state: &mut Gaussian<D>,
    prior: &Gaussian<D>,
    rows: &[JacobianRow; MOST],
    count: usize,
) -> ReadingFit {
    let mut fit = ReadingFit { distance: 0.0, determinant: 1.0 };
    for row in &rows[..count] {
        let moved: f64 = (0..SEEN).map(|index| row[index] * (state.mean[index] - prior.mean[index])).sum();
        let innovation = row[SEEN] - moved;
        let projected = times(state.covariance.rows(), row);
        let spread = dot(row, &projected) + 1.0;
        let gain = projected.map(|value| value / spread);
        for (mean, gain) in state.mean.iter_mut().zip(gain) {
            *mean += gain * innovation;
        }
        state.covariance = joseph(&state.covariance, row, &projected, &gain);
        fit.distance += innovation * innovation / spread;
        fit.determinant *= spread;
    }
    fit
}

/// (I - k h) P (I - k h)ᵀ + k kᵀ, with P hᵀ given: stays a covariance for any measurement accuracy (Bar-Shalom (2001),
/// eq. 5.2.3-18).
fn joseph<const D: usize>(
    covariance: &Symmetric<D>,
    row: &JacobianRow,
    projected: &Vector<D>,
    gain: &Vector<D>,
) -> Symmetric<D> {
    let mut left = *covariance.rows();
    for (values, gain) in left.iter_mut().zip(gain) {
        values.iter_mut().zip(projected).for_each(|(value, projected)| *value -= gain * projected);
    }
    let across = times(&left, row);
    for ((values, across), gain_of_row) in left.iter_mut().zip(across).zip(gain) {
        values.iter_mut().zip(gain).for_each(|(value, gain)| *value += (gain_of_row - across) * gain);
    }
    Symmetric::of_lower(left)
}

/// A matrix times a row of the Jacobian.
fn times<const D: usize>(rows: &Rows<D, D>, row: &JacobianRow) -> Vector<D> {
    rows.map(|values| dot(row, &values))
}

fn dot<const D: usize>(row: &JacobianRow, vector: &Vector<D>) -> f64 {
    row[..SEEN].iter().zip(vector).map(|(factor, value)| factor * value).sum()
}
