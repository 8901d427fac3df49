//! A Gaussian state of `D` numbers: how it moves, what an observation tells of it, and the way back to it.

use serde::{Deserialize, Serialize};

use super::bias::Moments;
use super::symmetric::{Rows, Symmetric, Vector, add_scaled, difference, scale, transposed};

/// Mean and covariance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Gaussian<const D: usize> {
    #[serde(with = "crate::checkpoint::array")]
    pub(crate) mean: Vector<D>,
    pub(crate) covariance: Symmetric<D>,
}

/// How the first numbers of a state move over an interval: x' = F x + w, w normal with covariance Q. Those behind them are
/// biases of radars, [`Slow`].
pub(crate) trait Motion<const D: usize> {
    /// How many numbers move so.
    const MOVING: usize;

    /// Makes of rows F times these.
    fn carry<const N: usize>(&self, rows: &mut Rows<N, D>);

    /// Adds Q.
    fn add_noise(&self, covariance: &mut Symmetric<D>);
}

/// What becomes of the biases over an interval, each by itself: x' = kept · x + w, w normal. Of the other numbers nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slow<const D: usize> {
    kept: Vector<D>,
    added: [Moments; D],
}

impl<const D: usize> Slow<D> {
    /// Nothing moves.
    pub(crate) const NONE: Self = Self { kept: [1.0; D], added: [Moments { mean: 0.0, variance: 0.0 }; D] };

    pub(super) fn set(&mut self, index: usize, kept: f64, added: Moments) {
        (self.kept[index], self.added[index]) = (kept, added);
    }
}

/// Times a row, a sum of few numbers of the state: each the place of a number, and its factor.
pub(super) type Row = [(usize, f64); 3];

/// z = h x + v, v normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scalar {
    pub(super) row: Row,
    pub(super) value: f64,
    /// Variance of v.
    pub(super) noise: f64,
}

/// Two numbers observed at once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub(super) rows: [Row; 2],
    pub(super) values: [f64; 2],
    /// Covariance of their noise: first, across, second.
    pub(super) noise: [f64; 3],
}

impl Pair {
    /// With noise times a factor.
    pub(super) fn coarser(self, factor: f64) -> Self {
        Self { noise: self.noise.map(|noise| noise * factor), ..self }
    }

    /// The same as two observations with noise of their own: of the second what the first does not tell of its noise.
    pub(super) fn whitened(&self) -> [Scalar; 2] {
        let ([first, across, second], [value, other]) = (self.noise, self.values);
        let share = across / first;
        // Rows with noise in common are those of velocities, which have a place to spare.
        let mut row = self.rows[1];
        if share != 0.0 {
            row[1] = (self.rows[0][0].0, -share * self.rows[0][0].1);
        }
        [
            Scalar { row: self.rows[0], value, noise: first },
            Scalar { row, value: other - share * value, noise: second - share * across },
        ]
    }
}

/// What a prediction leaves for the smoother: the predicted Gaussian, and its covariance with what it was predicted from,
/// rows of the former, columns of the latter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bridge<const D: usize> {
    pub(crate) predicted: Gaussian<D>,
    pub(super) across: Rows<D, D>,
}

/// The way back from a predicted state: what the smoother needs of a prediction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Back<const D: usize> {
    predicted: Gaussian<D>,
    /// The smoother's gain, transposed.
    gain: Rows<D, D>,
}

impl<const D: usize> Bridge<D> {
    pub(super) fn back(&self) -> Back<D> {
        let gain = self.predicted.covariance.solve(self.across).unwrap_or([[0.0; D]; D]);
        Back { predicted: self.predicted, gain }
    }
}

impl<const D: usize> Gaussian<D> {
    /// Prediction, and the bridge back.
    pub(super) fn predicted<M: Motion<D>>(&self, motion: &M, slow: &Slow<D>) -> Bridge<D> {
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

    /// The covariance times a row.
    #[inline]
    fn times(&self, row: &Row) -> Vector<D> {
        let mut product = [0.0; D];
        for term in 0..row.len() {
            add_scaled(&mut product, &self.covariance.rows()[row[term].0], row[term].1);
        }
        product
    }

    /// Takes an observation in: the squared Mahalanobis distance to what was expected, and the variance of that.
    #[inline]
    pub(super) fn observe(&mut self, observation: &Scalar) -> (f64, f64) {
        let Scalar { row, value, noise } = observation;
        let projected = self.times(row);
        let spread = dot(row, &projected) + noise;
        let innovation = value - dot(row, &self.mean);
        add_scaled(&mut self.mean, &projected, innovation / spread);
        self.covariance.add_square(&projected, -spread.recip());
        (innovation * innovation / spread, spread)
    }

    /// Takes two in: the same, and the determinant of their covariance.
    pub(super) fn observe_pair(&mut self, [first, second]: &[Scalar; 2]) -> (f64, f64) {
        let (distance, variance) = self.observe(first);
        let (further, determinant) = self.observe(second);
        (distance + further, variance * determinant)
    }

    /// Covariance of the difference between an observation and what is expected: first, across, second.
    fn spread(&self, observation: &Pair) -> [f64; 3] {
        let [first, second] = &observation.rows;
        let [projected, other] = [first, second].map(|row| self.times(row));
        let [noise, across, noise_of_other] = observation.noise;
        [
            dot(first, &projected) + noise,
            dot(second, &projected) + across,
            dot(second, &other) + noise_of_other,
        ]
    }

    /// How far an observation is from what is expected: squared Mahalanobis distance.
    pub(super) fn distance(&self, observation: &Pair) -> f64 {
        self.distance_by(observation, self.spread(observation))
    }

    fn distance_by(&self, observation: &Pair, [first, across, second]: [f64; 3]) -> f64 {
        let [a, b]: [f64; 2] = std::array::from_fn(|index| {
            observation.values[index] - dot(&observation.rows[index], &self.mean)
        });
        let determinant = first * second - across * across;
        (a * a * second - 2.0 * a * b * across + b * b * first) / determinant
    }

    /// An observation with so much more noise that it is no further off than `far` (squared Mahalanobis distance): what is
    /// expected may be known so badly that its own noise, several times over, would change little.
    pub(super) fn bounded(&self, mut observation: Pair, far: f64) -> Pair {
        let spread = self.spread(&observation);
        let distance = self.distance_by(&observation, spread);
        if distance > far {
            for (noise, spread) in observation.noise.iter_mut().zip(spread) {
                *noise += spread * (distance / far - 1.0);
            }
        }
        observation
    }

    /// The same of one number.
    pub(super) fn bounded_scalar(&self, mut observation: Scalar, far: f64) -> Scalar {
        let spread = dot(&observation.row, &self.times(&observation.row)) + observation.noise;
        let distance = (observation.value - dot(&observation.row, &self.mean)).powi(2) / spread;
        if distance > far {
            observation.noise += spread * (distance / far - 1.0);
        }
        observation
    }

    /// One step of the smoother: what is known of this state once the next one is known as `next` (Rauch, Tung,
    /// Striebel; Bar-Shalom (2001), eq. 8.6.2-9 to 8.6.2-11).
    pub(super) fn smoothed(&self, back: &Back<D>, next: &Self) -> Self {
        let Back { predicted, gain } = back;
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
fn dot<const D: usize>(row: &Row, vector: &Vector<D>) -> f64 {
    row[0].1 * vector[row[0].0] + row[1].1 * vector[row[1].0] + row[2].1 * vector[row[2].0]
}
