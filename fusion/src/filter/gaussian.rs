//! A Gaussian state of `D` variables: prediction, update by observations, and smoothing.

use serde::{Deserialize, Serialize};

use super::bias::Moments;
use super::symmetric::{Rows, Symmetric, Vector, add_scaled, difference, scale, transposed};

/// Mean and covariance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gaussian<const D: usize> {
    /// Mean.
    #[serde(with = "crate::checkpoint::array")]
    pub mean: Vector<D>,
    /// Covariance.
    pub covariance: Symmetric<D>,
}

/// Motion of the first variables of a state over an interval: x' = F x + w, w normal with covariance Q. The variables
/// after them are biases of radars, [`BiasTransition`].
pub trait LinearMotion<const D: usize> {
    /// Number of variables that move.
    const MOVING: usize;

    /// Multiplies rows by F.
    fn carry<const N: usize>(&self, rows: &mut Rows<N, D>);

    /// Adds Q.
    fn add_noise(&self, covariance: &mut Symmetric<D>);
}

/// Change of the biases over an interval, each on its own: x' = kept · x + w, w normal. Other variables do not change.
#[derive(Clone, Copy, Debug)]
pub struct BiasTransition<const D: usize> {
    kept: Vector<D>,
    added: [Moments; D],
}

impl<const D: usize> BiasTransition<D> {
    /// No change.
    pub const NONE: Self = Self { kept: [1.0; D], added: [Moments { mean: 0.0, variance: 0.0 }; D] };

    pub(super) fn set(&mut self, index: usize, kept: f64, added: Moments) {
        (self.kept[index], self.added[index]) = (kept, added);
    }
}

/// Row of an observation matrix with few non-zero elements: index of the variable, and its factor.
pub(super) type ObservationRow = [(usize, f64); 3];

/// A scalar observation: z = h x + v, v normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScalarObservation {
    pub(super) row: ObservationRow,
    pub(super) value: f64,
    /// Variance of v.
    pub(super) noise: f64,
}

/// An observation of two values at once.
#[derive(Clone, Copy, Debug)]
pub(super) struct PairObservation {
    pub(super) rows: [ObservationRow; 2],
    pub(super) values: [f64; 2],
    /// Covariance of the noise: variance of the first, covariance, variance of the second.
    pub(super) noise: [f64; 3],
}

impl PairObservation {
    /// This observation with its noise covariance multiplied by a factor.
    pub(super) fn coarser(self, factor: f64) -> Self {
        Self { noise: self.noise.map(|noise| noise * factor), ..self }
    }

    /// The equivalent two observations with independent noise: the second is reduced by the part that correlates with
    /// the first.
    pub(super) fn whitened(&self) -> [ScalarObservation; 2] {
        let ([first, across, second], [value, other]) = (self.noise, self.values);
        let share = across / first;
        // Only rows of velocities have correlated noise, and these have an unused element.
        let mut row = self.rows[1];
        if share != 0.0 {
            row[1] = (self.rows[0][0].0, -share * self.rows[0][0].1);
        }
        [
            ScalarObservation { row: self.rows[0], value, noise: first },
            ScalarObservation { row, value: other - share * value, noise: second - share * across },
        ]
    }
}

/// Result of a prediction: the predicted Gaussian, and its covariance with the state before; rows are of the predicted
/// state, columns of the state before.
#[derive(Clone, Copy, Debug)]
pub struct Bridge<const D: usize> {
    pub predicted: Gaussian<D>,
    pub(super) across: Rows<D, D>,
}

/// A prediction as the smoother needs it.
#[derive(Clone, Copy, Debug)]
pub(super) struct BackwardStep<const D: usize> {
    predicted: Gaussian<D>,
    /// The smoother's gain, transposed.
    gain: Rows<D, D>,
}

impl<const D: usize> Bridge<D> {
    pub(super) fn back(&self) -> BackwardStep<D> {
        let gain = self.predicted.covariance.solve(self.across).unwrap_or([[0.0; D]; D]);
        BackwardStep { predicted: self.predicted, gain }
    }
}

impl<const D: usize> Gaussian<D> {
    pub(super) const ZERO: Self = Self { mean: [0.0; D], covariance: Symmetric::ZERO };

    /// Predicts the state; returns it with its covariance to the state before.
    pub(super) fn predicted<M: LinearMotion<D>>(&self, motion: &M, slow: &BiasTransition<D>) -> Bridge<D> {
        let carry = |rows: &mut Rows<D, D>| {
            motion.carry(rows);
            for index in M::MOVING..D {
                scale(&mut rows[index], slow.kept[index]);
            }
        };
        let mut across = *self.covariance.rows();
        carry(&mut across);
        let mut square = transposed(&across);
        carry(&mut square);
        let mut covariance = Symmetric::of_lower(square);
        motion.add_noise(&mut covariance);
        let mut column = [[0.0]; D];
        for index in 0..D {
            column[index][0] = self.mean[index];
        }
        motion.carry(&mut column);
        let mut mean = [0.0; D];
        for index in 0..D {
            mean[index] = column[index][0];
        }
        for index in M::MOVING..D {
            mean[index] = mean[index] * slow.kept[index] + slow.added[index].mean;
            covariance.add_at(index, index, slow.added[index].variance);
        }
        Bridge { predicted: Self { mean, covariance }, across }
    }

    /// The covariance matrix times a row.
    #[inline]
    fn times(&self, row: &ObservationRow) -> Vector<D> {
        let mut product = [0.0; D];
        for term in 0..row.len() {
            add_scaled(&mut product, &self.covariance.rows()[row[term].0], row[term].1);
        }
        product
    }

    /// Updates the state by an observation; returns the squared Mahalanobis distance to the predicted value, and the
    /// variance of the innovation.
    #[inline]
    pub(super) fn observe(&mut self, observation: &ScalarObservation) -> (f64, f64) {
        let ScalarObservation { row, value, noise } = observation;
        let projected = self.times(row);
        let spread = dot(row, &projected) + noise;
        let innovation = value - dot(row, &self.mean);
        add_scaled(&mut self.mean, &projected, innovation / spread);
        self.covariance.add_square(&projected, -spread.recip());
        (innovation * innovation / spread, spread)
    }

    /// Updates the state by two observations; returns the squared Mahalanobis distance and the determinant of the
    /// innovation's covariance.
    pub(super) fn observe_pair(&mut self, [first, second]: &[ScalarObservation; 2]) -> (f64, f64) {
        let (distance, variance) = self.observe(first);
        let (further, determinant) = self.observe(second);
        (distance + further, variance * determinant)
    }

    /// Covariance of the innovation: variance of the first, covariance, variance of the second.
    fn spread(&self, observation: &PairObservation) -> [f64; 3] {
        let [first, second] = &observation.rows;
        let [projected, other] = [first, second].map(|row| self.times(row));
        let [noise, across, noise_of_other] = observation.noise;
        [
            dot(first, &projected) + noise,
            dot(second, &projected) + across,
            dot(second, &other) + noise_of_other,
        ]
    }

    /// Squared Mahalanobis distance between an observation and its predicted value.
    pub(super) fn distance(&self, observation: &PairObservation) -> f64 {
        self.distance_by(observation, self.spread(observation))
    }

    fn distance_by(&self, observation: &PairObservation, [first, across, second]: [f64; 3]) -> f64 {
        let [a, b]: [f64; 2] = std::array::from_fn(|index| {
            observation.values[index] - dot(&observation.rows[index], &self.mean)
        });
        let determinant = first * second - across * across;
        (a * a * second - 2.0 * a * b * across + b * b * first) / determinant
    }

    /// The observation with its noise enlarged so that its squared Mahalanobis distance is at most `far`. The noise
    /// grows by a multiple of the innovation's covariance: where the prediction is uncertain, a multiple of the
    /// observation's own noise would change little.
    pub(super) fn bounded(&self, mut observation: PairObservation, far: f64) -> PairObservation {
        let spread = self.spread(&observation);
        let distance = self.distance_by(&observation, spread);
        if distance > far {
            for (noise, spread) in observation.noise.iter_mut().zip(spread) {
                *noise += spread * (distance / far - 1.0);
            }
        }
        observation
    }

    /// Like [`Self::bounded`], for a scalar observation.
    pub(super) fn bounded_scalar(&self, mut observation: ScalarObservation, far: f64) -> ScalarObservation {
        let spread = dot(&observation.row, &self.times(&observation.row)) + observation.noise;
        let distance = (observation.value - dot(&observation.row, &self.mean)).powi(2) / spread;
        if distance > far {
            observation.noise += spread * (distance / far - 1.0);
        }
        observation
    }

    /// One step of the smoother: this state given the smoothed next state `next` (Rauch, Tung, Striebel; Bar-Shalom
    /// (2001), eq. 8.6.2-9 to 8.6.2-11).
    pub(super) fn smoothed(&self, back: &BackwardStep<D>, next: &Self) -> Self {
        let BackwardStep { predicted, gain } = back;
        let mut smoothed = *self;
        let apart = difference(&next.mean, &predicted.mean);
        for index in 0..D {
            add_scaled(&mut smoothed.mean, &gain[index], apart[index]);
        }
        let mut learnt = next.covariance;
        learnt.add(&predicted.covariance, -1.0);
        smoothed.covariance.add_between(gain, &learnt);
        smoothed
    }
}

#[inline]
fn dot<const D: usize>(row: &ObservationRow, vector: &Vector<D>) -> f64 {
    row[0].1 * vector[row[0].0] + row[1].1 * vector[row[1].0] + row[2].1 * vector[row[2].0]
}
