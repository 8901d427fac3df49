//! Interacting multiple models over a state of `D` numbers, and the one Gaussian that stands for their mixture.

use nalgebra::{SMatrix, SVector};

/// Mean and covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gaussian<const D: usize> {
    pub(super) mean: SVector<f64, D>,
    pub(super) covariance: SMatrix<f64, D, D>,
}

/// A Gaussian for each of `M` models, with its probability. Of a single model it is that Gaussian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mixture<const D: usize, const M: usize> {
    pub(super) weights: [f64; M],
    pub(super) parts: [Gaussian<D>; M],
}

/// x' = F x + s + w, w normal with covariance Q.
#[derive(Clone, Copy, Debug)]
pub(super) struct Linear<const D: usize> {
    pub(super) transition: SMatrix<f64, D, D>,
    pub(super) shift: SVector<f64, D>,
    pub(super) noise: SMatrix<f64, D, D>,
}

/// z = H x + v, v normal with covariance R.
#[derive(Clone, Copy, Debug)]
pub(super) struct Observation<const D: usize, const Z: usize> {
    pub(super) value: SVector<f64, Z>,
    pub(super) matrix: SMatrix<f64, Z, D>,
    pub(super) noise: SMatrix<f64, Z, Z>,
}

/// What a prediction leaves for the smoother: the predicted Gaussian, and its covariance with what it was predicted from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bridge<const D: usize> {
    pub(super) predicted: Gaussian<D>,
    pub(super) cross: SMatrix<f64, D, D>,
}

/// The way back from a predicted state: what the smoother needs of a prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Back<const D: usize> {
    predicted: Gaussian<D>,
    gain: SMatrix<f64, D, D>,
}

impl<const D: usize> Bridge<D> {
    pub(super) fn back(&self) -> Back<D> {
        let inverse = self.predicted.covariance.try_inverse();
        let gain = inverse.map_or_else(SMatrix::zeros, |inverse| self.cross * inverse);
        Back { predicted: self.predicted, gain }
    }
}

impl<const D: usize> Gaussian<D> {
    /// Prediction, and the bridge back.
    pub(super) fn predicted(&self, motion: &Linear<D>) -> Bridge<D> {
        let Linear { transition, shift, noise } = motion;
        let cross = self.covariance * transition.transpose();
        let covariance = transition * cross + noise;
        Bridge { predicted: Self { mean: transition * self.mean + shift, covariance }, cross }
    }

    /// Takes an observation in (Joseph form); returns its log-likelihood.
    pub(super) fn observe<const Z: usize>(&mut self, observation: &Observation<D, Z>) -> f64 {
        let Observation { value, matrix, noise } = observation;
        let innovation = value - matrix * self.mean;
        let projected = self.covariance * matrix.transpose();
        let spread = matrix * projected + noise;
        // Noise is positive, so the spread has an inverse.
        let Some(inverse) = spread.try_inverse() else { return 0.0 };
        let gain = projected * inverse;
        self.mean += gain * innovation;
        let keep = SMatrix::<f64, D, D>::identity() - gain * matrix;
        self.covariance = keep * self.covariance * keep.transpose() + gain * noise * gain.transpose();
        let distance = (innovation.transpose() * inverse * innovation).x;
        -0.5 * (distance + determinant_log(&spread) + Z as f64 * std::f64::consts::TAU.ln())
    }

    /// How far an observation is from what is expected: squared Mahalanobis distance.
    pub(super) fn distance<const Z: usize>(&self, observation: &Observation<D, Z>) -> f64 {
        let Observation { value, matrix, noise } = observation;
        let innovation = value - matrix * self.mean;
        let spread = matrix * self.covariance * matrix.transpose() + noise;
        spread.try_inverse().map_or(0.0, |inverse| (innovation.transpose() * inverse * innovation).x)
    }

    /// An observation with so much more noise that it is no further off than `far` (squared Mahalanobis distance): what is
    /// expected may be known so badly that its own noise, several times over, would change little.
    pub(super) fn bounded<const Z: usize>(
        &self,
        mut observation: Observation<D, Z>,
        far: f64,
    ) -> Observation<D, Z> {
        let distance = self.distance(&observation);
        if distance > far {
            let Observation { matrix, noise, .. } = &observation;
            let spread = matrix * self.covariance * matrix.transpose() + noise;
            observation.noise += spread * (distance / far - 1.0);
        }
        observation
    }

    /// One step of the smoother: what is known of this state once the next one is known as `next` (Rauch, Tung,
    /// Striebel; Bar-Shalom (2001), eq. 8.6.2-9 to 8.6.2-11).
    pub(super) fn smoothed(&self, back: &Back<D>, next: &Self) -> Self {
        let Back { predicted, gain } = back;
        let mean = self.mean + gain * (next.mean - predicted.mean);
        let covariance = self.covariance + gain * (next.covariance - predicted.covariance) * gain.transpose();
        Self { mean, covariance: symmetric(&covariance) }
    }
}

impl<const D: usize, const M: usize> Mixture<D, M> {
    /// The Gaussian with the mixture's mean and covariance.
    pub(super) fn combined(&self) -> Gaussian<D> {
        combined(&self.weights, &self.parts)
    }

    /// Prediction with each model's motion; `switch`: the probability of each to have become another one meanwhile. Also
    /// the bridge of the combined Gaussian, which is `before` now.
    pub(super) fn predicted(
        &self,
        before: &Gaussian<D>,
        motions: &[Linear<D>; M],
        switch: &[[f64; M]; M],
    ) -> (Self, Bridge<D>) {
        let mut weights = [0.0; M];
        for (from, row) in switch.iter().enumerate() {
            for (to, probability) in row.iter().enumerate() {
                weights[to] += probability * self.weights[from];
            }
        }
        let mut cross = SMatrix::<f64, D, D>::zeros();
        let mut mixed_means = [SVector::<f64, D>::zeros(); M];
        let parts = std::array::from_fn(|to| {
            let shares = std::array::from_fn(|from| switch[from][to] * self.weights[from] / weights[to]);
            let mixed = combined(&shares, &self.parts);
            mixed_means[to] = mixed.mean;
            let bridge = mixed.predicted(&motions[to]);
            cross += bridge.cross * weights[to];
            bridge.predicted
        });
        let after = Self { weights, parts };
        let predicted = after.combined();
        // What the models' means have in common before and after belongs to the covariance across as well.
        for to in 0..M {
            let (mixed, part) = (mixed_means[to] - before.mean, parts[to].mean - predicted.mean);
            cross += mixed * part.transpose() * weights[to];
        }
        (after, Bridge { predicted, cross })
    }

    /// Takes an observation in.
    pub(super) fn observe<const Z: usize>(&mut self, observation: &Observation<D, Z>) {
        let likelihoods: [f64; M] = std::array::from_fn(|model| self.parts[model].observe(observation));
        let most = likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut sum = 0.0;
        for (weight, likelihood) in self.weights.iter_mut().zip(likelihoods) {
            // No model dies out for good.
            *weight = (*weight * (likelihood - most).exp()).max(1e-6);
            sum += *weight;
        }
        self.weights.iter_mut().for_each(|weight| *weight /= sum);
    }
}

fn combined<const D: usize, const M: usize>(weights: &[f64; M], parts: &[Gaussian<D>; M]) -> Gaussian<D> {
    let mut mean = SVector::<f64, D>::zeros();
    for (weight, part) in weights.iter().zip(parts) {
        mean += part.mean * *weight;
    }
    let mut covariance = SMatrix::<f64, D, D>::zeros();
    for (weight, part) in weights.iter().zip(parts) {
        let apart = part.mean - mean;
        covariance += (part.covariance + apart * apart.transpose()) * *weight;
    }
    Gaussian { mean, covariance }
}

/// The natural logarithm of the determinant of a covariance of one or two dimensions.
fn determinant_log<const Z: usize>(matrix: &SMatrix<f64, Z, Z>) -> f64 {
    match Z {
        1 => matrix[(0, 0)].ln(),
        _ => (matrix[(0, 0)] * matrix[(1, 1)] - matrix[(0, 1)] * matrix[(1, 0)]).ln(),
    }
}

fn symmetric<const D: usize>(matrix: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    (matrix + matrix.transpose()) * 0.5
}
