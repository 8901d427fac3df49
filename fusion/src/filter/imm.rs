//! Interacting multiple models for a state of `D` variables, and the Gaussian that approximates their mixture.

use serde::{Deserialize, Serialize};

use super::gaussian::{BiasTransition, Bridge, Gaussian, LinearMotion, PairObservation};
use super::symmetric::{Rows, Symmetric, add_scaled, difference, scale};

/// Minimum weight of a model after an observation, relative to the likeliest, so that no model vanishes.
const WEIGHT_MIN: f64 = 1e-6;

/// A Gaussian for each of `M` models, with its probability. With a single model it is that Gaussian.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mixture<const D: usize, const M: usize> {
    /// Probability of each model.
    #[serde(with = "crate::checkpoint::array")]
    pub weights: [f64; M],
    /// State under each model.
    #[serde(with = "crate::checkpoint::array")]
    pub parts: [Gaussian<D>; M],
}

impl<const D: usize, const M: usize> Mixture<D, M> {
    /// The Gaussian with the mixture's mean and covariance.
    pub fn combined(&self) -> Gaussian<D> {
        let mut mean = [0.0; D];
        for model in 0..M {
            add_scaled(&mut mean, &self.parts[model].mean, self.weights[model]);
        }
        let mut covariance = Symmetric::ZERO;
        for model in 0..M {
            let part = &self.parts[model];
            covariance.add(&part.covariance, self.weights[model]);
            covariance.add_square(&difference(&part.mean, &mean), self.weights[model]);
        }
        Gaussian { mean, covariance }
    }

    /// Predicts each model with its motion; `switch` has the probabilities of a change from one model to another. Also
    /// returns the bridge of the combined Gaussian, whose present value is `before`.
    #[inline]
    pub fn predicted(
        &self,
        before: &Gaussian<D>,
        motions: &[impl LinearMotion<D>; M],
        slow: &BiasTransition<D>,
        switch: &[[f64; M]; M],
    ) -> (Self, Bridge<D>) {
        let mut across = [[0.0; D]; D];
        let (after, predicted) = self.advanced(before, motions, slow, switch, Some(&mut across));
        (after, Bridge { predicted, across })
    }

    /// Like [`Self::predicted`], with the combined Gaussian. `across`, which begins with zeros, takes its covariance with
    /// the state before; few callers need it.
    pub(super) fn advanced(
        &self,
        before: &Gaussian<D>,
        motions: &[impl LinearMotion<D>; M],
        slow: &BiasTransition<D>,
        switch: &[[f64; M]; M],
        mut across: Option<&mut Rows<D, D>>,
    ) -> (Self, Gaussian<D>) {
        let mut weights = [0.0; M];
        for from in 0..M {
            add_scaled(&mut weights, &switch[from], self.weights[from]);
        }
        // Second moments about the common mean: of a mixture of them only its own mean must be subtracted.
        let mut apart = [[0.0; D]; M];
        let mut moments = [Symmetric::ZERO; M];
        for from in 0..M {
            apart[from] = difference(&self.parts[from].mean, &before.mean);
            moments[from].add(&self.parts[from].covariance, 1.0);
            moments[from].add_square(&apart[from], 1.0);
        }
        let mut after = Self { weights, parts: [Gaussian::ZERO; M] };
        let mut mixed_apart = [[0.0; D]; M];
        for to in 0..M {
            let mut mixed = Gaussian { mean: before.mean, covariance: Symmetric::ZERO };
            for from in 0..M {
                // Some changes do not occur.
                if switch[from][to] == 0.0 {
                    continue;
                }
                let share = switch[from][to] * self.weights[from] / weights[to];
                add_scaled(&mut mixed_apart[to], &apart[from], share);
                mixed.covariance.add(&moments[from], share);
            }
            mixed.covariance.add_square(&mixed_apart[to], -1.0);
            add_scaled(&mut mixed.mean, &mixed_apart[to], 1.0);
            let bridge = mixed.predicted(&motions[to], slow);
            if let Some(across) = &mut across {
                for row in 0..D {
                    add_scaled(&mut across[row], &bridge.across[row], weights[to]);
                }
            }
            after.parts[to] = bridge.predicted;
        }
        let predicted = after.combined();
        if let Some(across) = across {
            // The spread of the models' means contributes to the covariance of the states before and after.
            for to in 0..M {
                let part = difference(&after.parts[to].mean, &predicted.mean);
                for row in 0..D {
                    add_scaled(&mut across[row], &mixed_apart[to], part[row] * weights[to]);
                }
            }
        }
        (after, predicted)
    }

    /// Updates the models by an observation.
    pub(super) fn observe(&mut self, observation: &PairObservation) {
        let whitened = observation.whitened();
        let mut distances = [0.0; M];
        let mut likelihoods = [0.0; M];
        for model in 0..M {
            let (distance, determinant) = self.parts[model].observe_pair(&whitened);
            (distances[model], likelihoods[model]) = (distance, determinant.sqrt().recip());
        }
        self.update_weights(&distances, likelihoods);
    }

    /// Updates the models' weights from squared Mahalanobis distances and the densities at distance zero, in any unit.
    pub fn update_weights(&mut self, distances: &[f64; M], mut likelihoods: [f64; M]) {
        // Relative to the least distance, so that only negligible values underflow.
        let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
        for model in 0..M {
            likelihoods[model] *= (-0.5 * (distances[model] - least)).exp();
        }
        let most = likelihoods.iter().copied().fold(0.0, f64::max);
        let mut sum = 0.0;
        for model in 0..M {
            self.weights[model] = (self.weights[model] * likelihoods[model] / most).max(WEIGHT_MIN);
            sum += self.weights[model];
        }
        scale(&mut self.weights, sum.recip());
    }
}
