//! Distinguishes drones from birds by the range of a radar track.
//!
//! The range is a radar's only precise measurement. A drone flies straight on, hovers, or is faster than birds; a
//! bird's course wanders. Each is a model of the range rate: a critically damped second-order Gauss–Markov process with
//! its own standard deviation and rate of turning. A Kalman filter for each model gives the likelihood of the plots.
//! The azimuth is less useful: over seconds its bias displaces a track as far as a bird's manoeuvres do.

use nalgebra::{Matrix3, Vector3, matrix, vector};
use serde::{Deserialize, Serialize};

use crate::filter::LineOfSight;
use crate::operational::settings::RadarSettings;
use crate::operational::tuning::{
    BIRD_MOTION, DRONE_MOTIONS, MODEL_PROBABILITY_MIN, MOTION_CHANGE_S, MOTION_LOG_ODDS_MAX,
    MOTION_PLOT_LOG_ODDS_MAX, RANGE_STEP_M, RangeMotion,
};
use crate::report::Plot;
use crate::time::Time;

/// Two models of drones, one of birds.
const MOTIONS: [RangeMotion; 3] = [DRONE_MOTIONS[0], DRONE_MOTIONS[1], BIRD_MOTION];

/// Log-odds of a drone against a bird, and the filters' states.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Kinematics {
    pub(super) log_odds: f64,
    models: Option<ModelBank>,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct ModelBank {
    time: Time,
    filters: [RangeFilter; 3],
    /// Probabilities of the drone models.
    weights: [f64; 2],
}

/// State: range, its rate and its acceleration.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct RangeFilter {
    mean: Vector3<f64>,
    covariance: Matrix3<f64>,
}

impl Kinematics {
    /// Adds a plot.
    pub(super) fn add(&mut self, plot: &Plot, radar: &RadarSettings) {
        let range_m = LineOfSight::from(radar.position, plot.position).range_m;
        // Without the remaining misalignment, which does not drift.
        let errors = &radar.track_errors;
        let noise = errors.noise_range_m.powi(2) + RANGE_STEP_M * RANGE_STEP_M / 12.0;
        let Some(models) = &mut self.models else {
            self.models = Some(ModelBank {
                time: plot.time,
                filters: MOTIONS.map(|motion| RangeFilter::new(range_m, noise, &motion)),
                weights: DRONE_MOTIONS.map(|motion| motion.share),
            });
            return;
        };
        let dt = plot.time.seconds_since(models.time);
        models.time = plot.time;
        let drift = 2.0 * errors.bias_range_m.powi(2) / errors.correlation_s * dt;
        let mut logs = [0.0; 3];
        for ((filter, motion), log) in models.filters.iter_mut().zip(&MOTIONS).zip(&mut logs) {
            filter.predict(dt, motion, drift);
            *log = filter.observe(range_m, noise);
        }
        let stays = (-dt / MOTION_CHANGE_S).exp();
        let [a, b] = models.weights;
        let [a, b] = [a * stays + b * (1.0 - stays), b * stays + a * (1.0 - stays)];
        let most = logs[0].max(logs[1]);
        let (a, b) = (a * (logs[0] - most).exp(), b * (logs[1] - most).exp());
        let drone = (a + b).ln() + most;
        models.weights = [a / (a + b), b / (a + b)].map(|weight: f64| weight.max(MODEL_PROBABILITY_MIN));
        let told = (drone - logs[2]).clamp(-MOTION_PLOT_LOG_ODDS_MAX, MOTION_PLOT_LOG_ODDS_MAX);
        self.log_odds = (self.log_odds + told).clamp(-MOTION_LOG_ODDS_MAX, MOTION_LOG_ODDS_MAX);
    }
}

impl RangeFilter {
    fn new(range_m: f64, noise: f64, motion: &RangeMotion) -> Self {
        let variances =
            vector![noise, motion.rate_m_s.powi(2), (motion.rate_m_s * motion.turn_rad_s).powi(2)];
        Self { mean: vector![range_m, 0.0, 0.0], covariance: Matrix3::from_diagonal(&variances) }
    }

    fn predict(&mut self, dt: f64, motion: &RangeMotion, drift: f64) {
        // The damped process in closed form. Its noise is approximated by white jerk, which is accurate for steps much
        // shorter than a turn.
        let l = motion.turn_rad_s;
        let (x, e) = (l * dt, (-l * dt).exp());
        let (along, further) = ((2.0 - e * (2.0 + x)) / l, (1.0 - e * (1.0 + x)) / (l * l));
        let transition = matrix![
            1.0, along, further;
            0.0, e * (1.0 + x), e * dt;
            0.0, -e * l * x, e * (1.0 - x);
        ];
        let q = 4.0 * l.powi(3) * motion.rate_m_s.powi(2);
        let (t2, t3, t4, t5) = (dt * dt / 2.0, dt.powi(3), dt.powi(4) / 8.0, dt.powi(5) / 20.0);
        let noise = matrix![t5, t4, t3 / 6.0; t4, t3 / 3.0, t2; t3 / 6.0, t2, dt] * q;
        self.mean = transition * self.mean;
        self.covariance = transition * self.covariance * transition.transpose() + noise;
        self.covariance[(0, 0)] += drift;
    }

    /// Updates the state by a range; returns the log-likelihood.
    fn observe(&mut self, range_m: f64, noise: f64) -> f64 {
        let variance = self.covariance[(0, 0)] + noise;
        let innovation = range_m - self.mean[0];
        let gain = self.covariance.column(0) / variance;
        self.mean += gain * innovation;
        self.covariance -= gain * gain.transpose() * variance;
        -0.5 * (innovation * innovation / variance + variance.ln())
    }
}
