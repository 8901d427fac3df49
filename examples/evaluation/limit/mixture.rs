//! Interacting multiple models: Gaussian states under motion modes that form a Markov chain.
//!
//! Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and Navigation*, 2001, section
//! 11.6.6.

use super::gaussian::{GaussianState, MeasurementRow, ScalarMeasurement};

/// Maximum time between two mixing steps, seconds.
const STEP_S: f64 = 0.5;

/// Motion of a state in each of its modes.
pub trait MotionModel<const N: usize, const M: usize> {
    /// Mean duration of each mode, seconds.
    fn durations_s(&self) -> [f64; M];
    /// Probability of each mode after the end of another one.
    fn successors(&self) -> [[f64; M]; M];
    /// Adjusts the state of a mode that begins. It was merged from the previous states, one per mode, with these
    /// shares.
    fn enter(
        &self,
        state: &mut GaussianState<N>,
        to: usize,
        before: &[GaussianState<N>; M],
        shares: &[f64; M],
    );
    /// Predicts the state within a mode.
    fn predict(&self, state: &mut GaussianState<N>, mode: usize, elapsed_s: f64);
}

/// State given each mode, and probabilities of the modes.
#[derive(Clone, Copy, Debug)]
pub struct MotionMixture<const N: usize, const M: usize> {
    pub weights: [f64; M],
    pub parts: [GaussianState<N>; M],
}

impl<const N: usize, const M: usize> MotionMixture<N, M> {
    /// Mixture with the same state in every mode.
    pub fn new(weights: [f64; M], state: GaussianState<N>) -> Self {
        Self { weights, parts: [state; M] }
    }

    /// Predicts over a time, in steps.
    pub fn predict(&mut self, motion: &impl MotionModel<N, M>, elapsed_s: f64) {
        let steps = (elapsed_s / STEP_S).ceil();
        for _ in 0..steps as usize {
            self.exchange(motion, elapsed_s / steps);
            for (mode, part) in self.parts.iter_mut().enumerate() {
                motion.predict(part, mode, elapsed_s / steps);
            }
        }
    }

    /// Mixes the modes according to their transitions within a step.
    fn exchange(&mut self, motion: &impl MotionModel<N, M>, elapsed_s: f64) {
        if M == 1 {
            return;
        }
        let (durations_s, successors, before) = (motion.durations_s(), motion.successors(), *self);
        let stays = durations_s.map(|duration_s| (-elapsed_s / duration_s).exp());
        let change = |from: usize, to: usize| match from == to {
            true => stays[from],
            false => (1.0 - stays[from]) * successors[from][to],
        };
        for to in 0..M {
            let mut shares = before.weights;
            shares.iter_mut().enumerate().for_each(|(from, share)| *share *= change(from, to));
            let sum: f64 = shares.iter().sum();
            self.weights[to] = sum;
            if sum > 0.0 {
                shares.iter_mut().for_each(|share| *share /= sum);
                let part = &mut self.parts[to];
                *part = GaussianState::merged(shares.iter().copied().zip(&before.parts));
                motion.enter(part, to, &before.parts, &shares);
            }
        }
    }

    /// Updates with a measurement, which is linearised for each mode's state.
    pub fn update(&mut self, measured: impl Fn(&GaussianState<N>) -> ScalarMeasurement<N>) {
        let mut logs = [0.0; M];
        for (log, part) in logs.iter_mut().zip(&mut self.parts) {
            let scalar = measured(part);
            *log = part.update(&scalar);
        }
        let best = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut sum = 0.0;
        for (weight, log) in self.weights.iter_mut().zip(logs) {
            *weight *= (log - best).exp();
            sum += *weight;
        }
        self.weights.iter_mut().for_each(|weight| *weight /= sum);
    }

    /// Transforms the state in every mode.
    pub fn transform(&mut self, rows: &[MeasurementRow]) {
        self.parts.iter_mut().for_each(|part| part.transform(rows));
    }

    /// Sets an entry to this mean and standard deviation in every mode.
    pub fn renew(&mut self, entry: usize, mean: f64, deviation: f64) {
        self.parts.iter_mut().for_each(|part| part.renew(entry, mean, deviation));
    }

    /// Mean of one entry.
    pub fn mean(&self, entry: usize) -> f64 {
        self.weights.iter().zip(&self.parts).map(|(weight, part)| weight * part.mean[entry]).sum()
    }

    /// Mean and covariance of the mixture.
    pub fn whole(&self) -> GaussianState<N> {
        GaussianState::merged(self.weights.iter().copied().zip(&self.parts))
    }
}
