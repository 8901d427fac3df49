//! A reading taken into a Gaussian state: what was measured is linearised, whitened, and taken in one number after another.

use nalgebra::Vector3;

use super::quantity::Quantity;
use super::reading::{MOST, Reading, Whitening};
use crate::filter::{Gaussian, Rows, Symmetric, Vector};

/// Of a state the numbers that are measured: east, north, up, and their rates. They are its first.
pub(super) const SEEN: usize = 6;

/// Where the estimate lies across the line of sight this many times the range apart, a line through it is no longer the arc:
/// the reading is linearised a second time, where the first led.
const CURVED: f64 = 0.2;

/// A row of the Jacobian, and what was measured less what was expected.
type Row = [f64; SEEN + 1];

/// How well a reading was expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fit {
    /// Squared Mahalanobis distance.
    pub(super) distance: f64,
    /// Determinant of the innovations' covariance, as a multiple of that of the noise.
    pub(super) determinant: f64,
}

/// Which values of a reading say something of an aircraft at each of these states.
pub(super) fn usable<'a, const D: usize>(
    reading: &Reading,
    states: impl IntoIterator<Item = &'a Vector<D>>,
) -> [bool; MOST] {
    let mut usable = [true; MOST];
    for state in states {
        let (position, velocity) = seen(state);
        for (usable, (quantity, _)) in usable.iter_mut().zip(reading.values()) {
            *usable &= quantity.expected(&reading.taken().observer, &position, &velocity).is_some();
        }
    }
    usable
}

fn seen<const D: usize>(state: &Vector<D>) -> (Vector3<f64>, Vector3<f64>) {
    (Vector3::new(state[0], state[1], state[2]), Vector3::new(state[3], state[4], state[5]))
}

/// The rows of the values that are used, about `at`, whitened, with the innovations of a state `of`. `None` where one of them
/// says nothing at `at`.
fn linearised<const D: usize>(
    reading: &Reading,
    whitening: &Whitening,
    at: &Vector<D>,
    of: &Vector<D>,
) -> Option<[Row; MOST]> {
    let (position, velocity) = seen(at);
    let mut rows = [[0.0; SEEN + 1]; MOST];
    for (row, &place) in rows.iter_mut().zip(whitening.places()) {
        let (quantity, value) = reading.values()[place];
        let expected = quantity.expected(&reading.taken().observer, &position, &velocity)?;
        row[..3].copy_from_slice(expected.by_position.as_slice());
        row[3..SEEN].copy_from_slice(expected.by_velocity.as_slice());
        let moved: f64 = (0..SEEN).map(|index| row[index] * (of[index] - at[index])).sum();
        row[SEEN] = quantity.innovation(value, expected.value) - moved;
    }
    whitening.apply(&mut rows);
    Some(rows)
}

/// Takes the values of a reading in that are used; how well they were expected. `None`, and nothing taken in, where none is
/// used or one of them says nothing of this state.
pub(super) fn take_in<const D: usize>(
    state: &mut Gaussian<D>,
    reading: &Reading,
    whitening: &Whitening,
) -> Option<Fit> {
    let prior = *state;
    if whitening.places().is_empty() {
        return None;
    }
    let rows = linearised(reading, whitening, &prior.mean, &prior.mean)?;
    let fit = take_in_rows(state, &prior, &rows, whitening.places().len());
    if is_curved(&prior, reading, whitening)
        && let Some(rows) = linearised(reading, whitening, &state.mean, &prior.mean)
    {
        *state = prior;
        take_in_rows(state, &prior, &rows, whitening.places().len());
    }
    Some(fit)
}

/// How well a reading is expected, without taking it in.
pub(super) fn fit<const D: usize>(
    state: &Gaussian<D>,
    reading: &Reading,
    whitening: &Whitening,
) -> Option<Fit> {
    let rows = linearised(reading, whitening, &state.mean, &state.mean)?;
    Some(take_in_rows(&mut state.clone(), state, &rows, whitening.places().len()))
}

/// Whether the estimate is so wide across the line of sight that the arc of an azimuth shows.
fn is_curved<const D: usize>(prior: &Gaussian<D>, reading: &Reading, whitening: &Whitening) -> bool {
    let is_azimuth = |&place: &usize| reading.values()[place].0 == Quantity::Azimuth;
    if !whitening.places().iter().any(is_azimuth) {
        return false;
    }
    let (position, velocity) = seen(&prior.mean);
    let observer = &reading.taken().observer;
    let Some(azimuth) = Quantity::Azimuth.expected(observer, &position, &velocity) else { return false };
    let away = position - observer.position.0;
    let over = |row: usize, column: usize| {
        azimuth.by_position[row] * prior.covariance.at(row, column) * azimuth.by_position[column]
    };
    let variance = over(0, 0) + 2.0 * over(0, 1) + over(1, 1);
    variance.max(0.0).sqrt() * away.x.hypot(away.y) > CURVED * away.norm()
}

/// Takes the first `count` rows in, whose noise is white with variance 1. Their innovations are those of `prior`.
fn take_in_rows<const D: usize>(
    state: &mut Gaussian<D>,
    prior: &Gaussian<D>,
    rows: &[Row; MOST],
    count: usize,
) -> Fit {
    let mut fit = Fit { distance: 0.0, determinant: 1.0 };
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

/// (I - k h) P (I - k h)ᵀ + k kᵀ, with P hᵀ at hand: stays a covariance however good the measurement (Bar-Shalom (2001),
/// eq. 5.2.3-18).
fn joseph<const D: usize>(
    covariance: &Symmetric<D>,
    row: &Row,
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
fn times<const D: usize>(rows: &Rows<D, D>, row: &Row) -> Vector<D> {
    rows.map(|values| dot(row, &values))
}

fn dot<const D: usize>(row: &Row, vector: &Vector<D>) -> f64 {
    row[..SEEN].iter().zip(vector).map(|(factor, value)| factor * value).sum()
}
