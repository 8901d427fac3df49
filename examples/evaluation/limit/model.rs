//! Models of motion and of sensors for the limit: horizontal state and height.

use utm_fusion::simulate::{Radar, Scenario};

use super::gaussian::{GaussianState, MeasurementRow, ScalarMeasurement};
use super::mixture::MotionModel;
use super::smoother::LinearMeasurement;

/// Entries of the horizontal state: position, velocity, acceleration; slow GNSS error; slow errors of the radar's track
/// in azimuth (radians) and range; delay of the transponder (seconds); position at the requested time.
pub const HORIZONTAL: usize = 13;
pub const P: usize = 0;
pub const V: usize = 2;
const A: usize = 4;
const GNSS: usize = 6;
pub const AZIMUTH: usize = 8;
pub const RANGE: usize = 9;
pub const DELAY: usize = 10;
pub const ASKED: usize = 11;

/// Entries of the vertical state: height and climb rate; slow errors of GNSS and of the radar's track; height at the
/// requested time.
pub const HEIGHT: usize = 5;
pub const Z: usize = 0;
const CLIMB: usize = 1;
const Z_GNSS: usize = 2;
pub const Z_TRACK: usize = 3;
pub const Z_ASKED: usize = 4;

/// Modes of the horizontal motion: constant velocity, a decaying acceleration, a turn at constant rate.
pub const MODES: usize = 3;
const STEADY: usize = 0;
const SURGE: usize = 1;

/// Standard deviation of a value rounded to multiples of a step, in steps.
const ROUNDED: f64 = 0.288_675_134_594_812_9;
/// Resolution of CAT048: range (1/256 NM) and height (25 ft), metres.
const RANGE_STEP_M: f64 = 1852.0 / 256.0;
const HEIGHT_STEP_M: f64 = 25.0 * 0.3048;
/// Minimum speed at which a rate of turn is defined, m/s.
const TURNS_FROM_M_S: f64 = 2.0;

/// A first-order Gauss-Markov error.
#[derive(Clone, Copy, Debug)]
pub struct SlowError {
    pub sigma: f64,
    pub time_s: f64,
}

impl SlowError {
    /// Share of the error that remains after `elapsed_s`.
    fn kept(self, elapsed_s: f64) -> f64 {
        (-elapsed_s / self.time_s).exp()
    }

    /// Adds the variance of the new part of the error after `elapsed_s`.
    fn grow<const N: usize>(self, state: &mut GaussianState<N>, entry: usize, elapsed_s: f64) {
        let kept = self.kept(elapsed_s);
        state.add(entry, entry, self.sigma * self.sigma * (1.0 - kept * kept));
    }
}

/// Errors of the sensors: the true values of the simulation.
#[derive(Clone, Copy, Debug)]
pub struct SensorErrors {
    pub gnss: SlowError,
    pub gnss_height: SlowError,
    /// White error of a report, metres per axis.
    pub white_m: f64,
    pub track_azimuth: SlowError,
    pub track_range: SlowError,
    pub track_height: SlowError,
    /// White errors of a plot including the rounding of CAT048, radians and metres.
    pub plot_azimuth: f64,
    pub plot_range_m: f64,
    pub plot_height_m: f64,
}

impl SensorErrors {
    pub fn of(scenario: &Scenario, radar: &Radar) -> Self {
        let transponder = &scenario.transponder;
        let gnss = |sigma| SlowError { sigma, time_s: transponder.gnss_time_s };
        let track = |sigma| SlowError { sigma, time_s: radar.track_time_s };
        Self {
            gnss: gnss(transponder.gnss_horizontal_m),
            gnss_height: gnss(transponder.gnss_vertical_m),
            white_m: transponder.gnss_white_m,
            track_azimuth: track(radar.track_azimuth_deg.to_radians()),
            track_range: track(radar.track_range_m),
            track_height: track(radar.track_height_m),
            plot_azimuth: radar.plot_azimuth_deg.to_radians(),
            plot_range_m: radar.plot_range_m.hypot(ROUNDED * RANGE_STEP_M),
            plot_height_m: radar.plot_height_m.hypot(ROUNDED * HEIGHT_STEP_M),
        }
    }
}

/// Levels and durations of manoeuvres, chosen on seeds below 1001: likelihoods close to the maximum, and consistent
/// deviations in gaps. Errors on covered slots hardly depend on them.
#[derive(Clone, Copy, Debug)]
pub struct MotionLevels {
    /// Spectral density of the acceleration in steady flight, m²/s³.
    pub steady: f64,
    /// Standard deviation of an acceleration at its beginning, m/s² per axis. `surge_fades_s` is its time constant, s.
    pub surge_m_s2: f64,
    pub surge_fades_s: f64,
    /// Standard deviation of the lateral acceleration at the beginning of a turn, m/s². `turn_jerk` is the spectral
    /// density of the jerk in it, m²/s⁵.
    pub turn_m_s2: f64,
    pub turn_jerk: f64,
    pub durations_s: [f64; MODES],
    pub successors: [[f64; MODES]; MODES],
    /// Spectral densities of the vertical acceleration, level and climbing, m²/s³. `climb_durations_s` are the
    /// durations.
    pub climb: [f64; 2],
    pub climb_durations_s: [f64; 2],
}

impl Default for MotionLevels {
    fn default() -> Self {
        Self {
            steady: 0.0001,
            surge_m_s2: 2.5,
            surge_fades_s: 100.0,
            turn_m_s2: 1.3,
            turn_jerk: 0.9,
            durations_s: [60.0, 8.0, 15.0],
            successors: [[0.0, 0.5, 0.5], [0.8, 0.0, 0.2], [0.8, 0.2, 0.0]],
            climb: [0.0002, 0.3],
            climb_durations_s: [60.0, 8.0],
        }
    }
}

/// Horizontal motion and slow errors.
#[derive(Clone, Copy, Debug)]
pub struct HorizontalModel {
    pub sensors: SensorErrors,
    pub levels: MotionLevels,
}

impl MotionModel<HORIZONTAL, MODES> for HorizontalModel {
    fn durations_s(&self) -> [f64; MODES] {
        self.levels.durations_s
    }

    fn successors(&self) -> [[f64; MODES]; MODES] {
        self.levels.successors
    }

    fn enter(
        &self,
        state: &mut GaussianState<HORIZONTAL>,
        to: usize,
        before: &[GaussianState<HORIZONTAL>; MODES],
        shares: &[f64; MODES],
    ) {
        let share = shares[STEADY];
        match to {
            STEADY => {
                state.renew(A, 0.0, 0.0);
                state.renew(A + 1, 0.0, 0.0);
            }
            SURGE => {
                let variance = share * self.levels.surge_m_s2.powi(2);
                state.add(A, A, variance);
                state.add(A + 1, A + 1, variance);
            }
            _ => {
                let [east, north] = [0, 1].map(|axis| before[STEADY].mean[V + axis]);
                let speed = east.hypot(north).max(TURNS_FROM_M_S);
                let across = (-north / speed, east / speed);
                let variance = share * self.levels.turn_m_s2.powi(2);
                state.add(A, A, variance * across.0 * across.0);
                state.add(A + 1, A + 1, variance * across.1 * across.1);
                state.add(A, A + 1, variance * across.0 * across.1);
            }
        }
    }

    fn predict(&self, state: &mut GaussianState<HORIZONTAL>, mode: usize, elapsed_s: f64) {
        let dt = elapsed_s;
        let transition = match mode {
            STEADY => Transition::fading(dt, 0.0),
            SURGE => Transition::fading(dt, self.levels.surge_fades_s),
            _ => Transition::turning(dt, turn_rate(state)),
        };
        let SensorErrors { gnss, track_azimuth, track_range, .. } = self.sensors;
        let slow = [(GNSS, gnss), (GNSS + 1, gnss), (AZIMUTH, track_azimuth), (RANGE, track_range)];
        transition.apply(state, slow.map(|(_, error)| error.kept(dt)));
        for (entry, error) in slow {
            error.grow(state, entry, dt);
        }
        for axis in 0..2 {
            let (p, v, a) = (P + axis, V + axis, A + axis);
            match mode {
                STEADY => accelerate(state, p, v, self.levels.steady, dt),
                SURGE => {
                    let MotionLevels { surge_m_s2, surge_fades_s, .. } = self.levels;
                    jerk(state, [p, v, a], 2.0 * surge_m_s2.powi(2) / surge_fades_s, dt);
                }
                _ => jerk(state, [p, v, a], self.levels.turn_jerk, dt),
            }
        }
    }
}

/// Adds white acceleration of this spectral density.
fn accelerate<const N: usize>(state: &mut GaussianState<N>, p: usize, v: usize, density: f64, dt: f64) {
    state.add(p, p, density * dt.powi(3) / 3.0);
    state.add(p, v, density * dt.powi(2) / 2.0);
    state.add(v, v, density * dt);
}

/// Adds white jerk of this spectral density.
fn jerk(state: &mut GaussianState<HORIZONTAL>, [p, v, a]: [usize; 3], density: f64, dt: f64) {
    state.add(p, p, density * dt.powi(5) / 20.0);
    state.add(p, v, density * dt.powi(4) / 8.0);
    state.add(p, a, density * dt.powi(3) / 6.0);
    state.add(v, v, density * dt.powi(3) / 3.0);
    state.add(v, a, density * dt.powi(2) / 2.0);
    state.add(a, a, density * dt);
}

/// Factors of velocity and acceleration in the state after `dt`.
struct Transition {
    dt: f64,
    /// Factors of the acceleration in the position: along and across the acceleration.
    place: [f64; 2],
    speed: [f64; 2],
    own: [f64; 2],
}

impl Transition {
    /// Transition for an acceleration that decays exponentially, or immediately if the time is zero.
    fn fading(dt: f64, time_s: f64) -> Self {
        let kept = if time_s > 0.0 { (-dt / time_s).exp() } else { 0.0 };
        let place = time_s * (dt - time_s * (1.0 - kept));
        Self { dt, place: [place, 0.0], speed: [time_s * (1.0 - kept), 0.0], own: [kept, 0.0] }
    }

    /// Transition for an acceleration that turns at this rate, radians per second counterclockwise.
    fn turning(dt: f64, rate: f64) -> Self {
        if rate.abs() < 1e-3 {
            return Self { dt, place: [dt * dt / 2.0, 0.0], speed: [dt, 0.0], own: [1.0, 0.0] };
        }
        let (sin, cos) = (rate * dt).sin_cos();
        let squared = rate * rate;
        Self {
            dt,
            place: [(1.0 - cos) / squared, (rate * dt - sin) / squared],
            speed: [sin / rate, (1.0 - cos) / rate],
            own: [cos, sin],
        }
    }

    /// Predicts position, velocity and acceleration, and keeps these shares of the slow errors.
    fn apply(&self, state: &mut GaussianState<HORIZONTAL>, kept: [f64; 4]) {
        let covariance = &mut state.covariance;
        let mut column = 0;
        while column < HORIZONTAL {
            let moved = self.moved([
                covariance[0][column],
                covariance[1][column],
                covariance[2][column],
                covariance[3][column],
                covariance[4][column],
                covariance[5][column],
            ]);
            let mut row = 0;
            while row < GNSS {
                covariance[row][column] = moved[row];
                row += 1;
            }
            while row < DELAY {
                covariance[row][column] *= kept[row - GNSS];
                row += 1;
            }
            column += 1;
        }
        let mut row = 0;
        while row < HORIZONTAL {
            self.line(&mut covariance[row], kept);
            row += 1;
        }
        self.line(&mut state.mean, kept);
    }

    fn line(&self, line: &mut [f64; HORIZONTAL], kept: [f64; 4]) {
        let moved = self.moved([line[0], line[1], line[2], line[3], line[4], line[5]]);
        let mut entry = 0;
        while entry < GNSS {
            line[entry] = moved[entry];
            entry += 1;
        }
        while entry < DELAY {
            line[entry] *= kept[entry - GNSS];
            entry += 1;
        }
    }

    #[inline]
    fn moved(&self, [p0, p1, v0, v1, a0, a1]: [f64; 6]) -> [f64; 6] {
        let Self { dt, place, speed, own } = self;
        [
            p0 + dt * v0 + place[0] * a0 - place[1] * a1,
            p1 + dt * v1 + place[1] * a0 + place[0] * a1,
            v0 + speed[0] * a0 - speed[1] * a1,
            v1 + speed[1] * a0 + speed[0] * a1,
            own[0] * a0 - own[1] * a1,
            own[1] * a0 + own[0] * a1,
        ]
    }
}

/// Rate of turn, radians per second counterclockwise.
fn turn_rate(state: &GaussianState<HORIZONTAL>) -> f64 {
    let [v, a] = [V, A].map(|entry| (state.mean[entry], state.mean[entry + 1]));
    let squared = v.0 * v.0 + v.1 * v.1;
    if squared < TURNS_FROM_M_S.powi(2) {
        return 0.0;
    }
    ((v.0 * a.1 - v.1 * a.0) / squared).clamp(-1.0, 1.0)
}

/// Vertical motion and slow errors.
#[derive(Clone, Copy, Debug)]
pub struct VerticalModel {
    pub sensors: SensorErrors,
    pub levels: MotionLevels,
}

impl MotionModel<HEIGHT, 2> for VerticalModel {
    fn durations_s(&self) -> [f64; 2] {
        self.levels.climb_durations_s
    }

    fn successors(&self) -> [[f64; 2]; 2] {
        [[0.0, 1.0], [1.0, 0.0]]
    }

    fn enter(&self, _: &mut GaussianState<HEIGHT>, _: usize, _: &[GaussianState<HEIGHT>; 2], _: &[f64; 2]) {}

    fn predict(&self, state: &mut GaussianState<HEIGHT>, mode: usize, elapsed_s: f64) {
        let SensorErrors { gnss_height, track_height, .. } = self.sensors;
        let gnss = MeasurementRow::scaled(Z_GNSS, gnss_height.kept(elapsed_s));
        let track = MeasurementRow::scaled(Z_TRACK, track_height.kept(elapsed_s));
        let climb = MeasurementRow::plus(Z, [(CLIMB, elapsed_s), (0, 0.0), (0, 0.0)]);
        state.transform(&[climb, gnss, track]);
        accelerate(state, Z, CLIMB, self.levels.climb[mode], elapsed_s);
        gnss_height.grow(state, Z_GNSS, elapsed_s);
        track_height.grow(state, Z_TRACK, elapsed_s);
    }
}

/// East or north of a report. `velocity` is the true mean velocity over the delay, which is the factor of the delay.
pub fn report_axis(
    state: &GaussianState<HORIZONTAL>,
    axis: usize,
    measured_m: f64,
    velocity_m_s: f64,
    white_m: f64,
) -> ScalarMeasurement<HORIZONTAL> {
    let mut factors = [0.0; HORIZONTAL];
    (factors[P + axis], factors[GNSS + axis], factors[DELAY]) = (1.0, 1.0, -velocity_m_s);
    let expected = state.mean[P + axis] + state.mean[GNSS + axis] - velocity_m_s * state.mean[DELAY];
    ScalarMeasurement { factors, residual: measured_m - expected, variance: white_m * white_m }
}

/// Azimuth or range of a plot; `slow` is the entry of the track's slow error and its factor.
pub fn plot(
    state: &GaussianState<HORIZONTAL>,
    line: LinearMeasurement,
    (slow, factor): (usize, f64),
    white: f64,
) -> ScalarMeasurement<HORIZONTAL> {
    let mut factors = [0.0; HORIZONTAL];
    (factors[P], factors[P + 1], factors[slow]) = (line.factors[0], line.factors[1], factor);
    let expected =
        line.factors[0] * state.mean[P] + line.factors[1] * state.mean[P + 1] + factor * state.mean[slow];
    ScalarMeasurement { factors, residual: line.value - expected, variance: white * white }
}

/// Height of a report; `delay_s` is the estimate of its delay.
pub fn report_height(
    state: &GaussianState<HEIGHT>,
    measured_m: f64,
    delay_s: f64,
    white_m: f64,
) -> ScalarMeasurement<HEIGHT> {
    let mut factors = [0.0; HEIGHT];
    (factors[Z], factors[CLIMB], factors[Z_GNSS]) = (1.0, -delay_s, 1.0);
    let expected = state.mean[Z] - delay_s * state.mean[CLIMB] + state.mean[Z_GNSS];
    ScalarMeasurement { factors, residual: measured_m - expected, variance: white_m * white_m }
}

/// Height of a plot, without the registration bias.
pub fn plot_height(
    state: &GaussianState<HEIGHT>,
    measured_m: f64,
    white_m: f64,
) -> ScalarMeasurement<HEIGHT> {
    let mut factors = [0.0; HEIGHT];
    (factors[Z], factors[Z_TRACK]) = (1.0, 1.0);
    let residual = measured_m - state.mean[Z] - state.mean[Z_TRACK];
    ScalarMeasurement { factors, residual, variance: white_m * white_m }
}
