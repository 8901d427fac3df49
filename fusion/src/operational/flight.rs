//! Whether a radar track flies like a drone or like a bird: what its range shows.
//!
//! A radar's range is its one exact measure. A drone flies straight on, hovers, or is faster than birds are; a bird's
//! course wanders. Each is a model of the rate at which the range changes, a critically damped second-order Gauss–Markov
//! process of its own deviation and rate of turning; a Kalman filter each tells how well it explains the plots. What the
//! azimuth shows is less: over seconds its slow error moves a track as far as a wing does.

use nalgebra::{Matrix3, Vector3, matrix, vector};

use super::settings::Radar;
use crate::filter::LineOfSight;
use crate::report::Plot;
use crate::time::Time;

/// How the rate of the range changes: its deviation, metres a second, how fast it turns over, radians a second, and how
/// many of the drones fly so; the last is that of birds.
struct Manner {
    rate_m_s: f64,
    turns: f64,
    share: f64,
}

const BIRD: usize = 2;
const MANNERS: [Manner; 3] = [
    // Straight on, or in hover.
    Manner { rate_m_s: 12.0, turns: 0.01, share: 0.75 },
    // Faster than birds, and turning.
    Manner { rate_m_s: 16.0, turns: 0.2, share: 0.25 },
    Manner { rate_m_s: 8.0, turns: 0.15, share: 1.0 },
];
/// Drones change between their two manners once in so many seconds.
const CHANGE_S: f64 = 15.0;
/// I048/040 tells the range in steps of so many metres.
const STEP_M: f64 = 1852.0 / 256.0;
/// One plot says no more than this, and all of them together
const CLIP: f64 = 1.0;
/// no more than this.
const MOST: f64 = 3.0;

/// The sum, and what is expected of the next plot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flight {
    /// Logarithm of how much likelier a drone flies so than a bird.
    pub(super) score: f64,
    state: Option<State>,
}

#[derive(Clone, Copy, Debug)]
struct State {
    time: Time,
    filters: [Filter; 3],
    /// How likely each of the drones' manners is.
    weights: [f64; 2],
}

/// Range, its rate and its acceleration.
#[derive(Clone, Copy, Debug)]
struct Filter {
    mean: Vector3<f64>,
    covariance: Matrix3<f64>,
}

impl Flight {
    pub(super) const NEW: Self = Self { score: 0.0, state: None };

    /// With these plots as well, in the order of their time.
    pub(super) fn with<'a>(mut self, plots: impl Iterator<Item = &'a Plot>, radar: &Radar) -> Self {
        plots.for_each(|plot| self.add(plot, radar));
        self
    }

    fn add(&mut self, plot: &Plot, radar: &Radar) {
        let range_m = LineOfSight::from(radar.position, plot.position).range_m;
        // Not what is left of a wrong set-up: that does not drift.
        let errors = &radar.track_errors;
        let noise = errors.noise_range_m.powi(2) + STEP_M * STEP_M / 12.0;
        let Some(state) = &mut self.state else {
            let first = |manner: &Manner| Filter {
                mean: vector![range_m, 0.0, 0.0],
                covariance: Matrix3::from_diagonal(&vector![
                    noise,
                    manner.rate_m_s.powi(2),
                    (manner.rate_m_s * manner.turns).powi(2)
                ]),
            };
            self.state = Some(State {
                time: plot.time,
                filters: [first(&MANNERS[0]), first(&MANNERS[1]), first(&MANNERS[2])],
                weights: [MANNERS[0].share, MANNERS[1].share],
            });
            return;
        };
        let dt = plot.time.seconds_since(state.time);
        state.time = plot.time;
        let drift = 2.0 * errors.bias_range_m.powi(2) / errors.correlation_s * dt;
        let mut logs = [0.0; 3];
        for ((filter, manner), log) in state.filters.iter_mut().zip(&MANNERS).zip(&mut logs) {
            filter.predict(dt, manner, drift);
            *log = filter.observe(range_m, noise);
        }
        let stays = (-dt / CHANGE_S).exp();
        let [a, b] = state.weights;
        let [a, b] = [a * stays + b * (1.0 - stays), b * stays + a * (1.0 - stays)];
        let most = logs[0].max(logs[1]);
        let (a, b) = (a * (logs[0] - most).exp(), b * (logs[1] - most).exp());
        let drone = (a + b).ln() + most;
        state.weights = [a / (a + b), b / (a + b)].map(|w: f64| w.max(1e-3));
        self.score = (self.score + (drone - logs[BIRD]).clamp(-CLIP, CLIP)).clamp(-MOST, MOST);
    }
}

impl Filter {
    fn predict(&mut self, dt: f64, manner: &Manner, drift: f64) {
        // The damped process in closed form; its noise as white jerk, which it is over steps much shorter than a turn.
        let l = manner.turns;
        let (x, e) = (l * dt, (-l * dt).exp());
        let (along, further) = ((2.0 - e * (2.0 + x)) / l, (1.0 - e * (1.0 + x)) / (l * l));
        let transition = matrix![
            1.0, along, further;
            0.0, e * (1.0 + x), e * dt;
            0.0, -e * l * x, e * (1.0 - x);
        ];
        let q = 4.0 * l.powi(3) * manner.rate_m_s.powi(2);
        let (t2, t3, t4, t5) = (dt * dt / 2.0, dt.powi(3), dt.powi(4) / 8.0, dt.powi(5) / 20.0);
        let noise = matrix![t5, t4, t3 / 6.0; t4, t3 / 3.0, t2; t3 / 6.0, t2, dt] * q;
        self.mean = transition * self.mean;
        self.covariance = transition * self.covariance * transition.transpose() + noise;
        self.covariance[(0, 0)] += drift;
    }

    /// Logarithm of the likelihood.
    fn observe(&mut self, range_m: f64, noise: f64) -> f64 {
        let spread = self.covariance[(0, 0)] + noise;
        let innovation = range_m - self.mean[0];
        let gain = self.covariance.column(0) / spread;
        self.mean += gain * innovation;
        self.covariance -= gain * gain.transpose() * spread;
        -0.5 * (innovation * innovation / spread + spread.ln())
    }
}
