//! Smoother for one drone: for each requested time it uses only the data that arrived by that time's deadline.
//!
//! A filter processes the measurements in order of time, up to the first one that has not arrived or is later than the
//! requested time. A copy of its state continues from there: at the requested time it copies the position into separate
//! entries, which later measurements correct through the covariances (fixed-point smoothing).

use nalgebra::{Matrix2, Vector2};

use super::gaussian::{GaussianState, MeasurementRow};
use super::mixture::MotionMixture;
use super::model::{
    self, ASKED, AZIMUTH, DELAY, HEIGHT, HORIZONTAL, HorizontalModel, MODES, MotionLevels, P, RANGE,
    SensorErrors, VerticalModel, Z, Z_ASKED, Z_TRACK,
};

/// Time before the first measurement at which the filter begins, seconds: the time from a slot to its deadline.
const BEFORE_S: f64 = 7.0;
/// Standard deviations of a drone before any measurement, per axis: position, height, speed and climb rate.
const PLACE_M: f64 = 400.0;
const HEIGHT_M: f64 = 40.0;
const SPEED_M_S: f64 = 12.0;
const CLIMB_M_S: f64 = 1.5;

/// A measurement of the drone. Times are seconds from the beginning of the flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitMeasurement {
    pub time_s: f64,
    pub arrives_s: f64,
    /// Height above mean sea level, metres.
    pub height_m: Option<f64>,
    pub kind: MeasurementKind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeasurementKind {
    /// A report of a transponder.
    Report {
        /// Position east and north, metres.
        place_m: [f64; 2],
        /// True mean velocity over the delay, m/s.
        velocity_m_s: [f64; 2],
    },
    /// A plot of a radar, without registration bias.
    Plot {
        /// Measured position east and north, metres.
        place_m: [f64; 2],
        azimuth: LinearMeasurement,
        range: LinearMeasurement,
        /// Factor of the track's slow error in azimuth.
        turning: f64,
        /// Index of the radar's track; each track has its own slow errors.
        track: u32,
    },
}

/// A measurement that is linear in the position: the value is the factors times east and north, plus errors. Azimuth
/// and range are linearised at the drone's true position, so that a wrong estimate cannot make the filter
/// overconfident.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearMeasurement {
    pub factors: [f64; 2],
    pub value: f64,
}

/// Prior of a transponder's delay: mean and standard deviation, seconds.
#[derive(Clone, Copy, Debug)]
pub struct DelayPrior {
    pub mean_s: f64,
    pub sigma_s: f64,
}

/// A requested time, and the deadline by which measurements must have arrived.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RequestedTime {
    pub time_s: f64,
    pub deadline_s: f64,
}

/// Estimate of the drone's position.
#[derive(Clone, Copy, Debug)]
pub struct SmoothedEstimate {
    /// Position: east, north and height above mean sea level, metres.
    pub place_m: [f64; 3],
    /// Covariance over ground, m². `height_m2` is the variance of the height.
    pub ground_m2: Matrix2<f64>,
    pub height_m2: f64,
    /// Delay and its standard deviation, seconds.
    pub delay_s: [f64; 2],
}

impl SmoothedEstimate {
    /// Normalised squares of these errors: over ground, divided by two degrees of freedom, and in height.
    pub fn normalised(&self, error_m: [f64; 3]) -> Option<[f64; 2]> {
        let error = Vector2::new(error_m[0], error_m[1]);
        let weighed = self.ground_m2.try_inverse()? * error;
        Some([error.dot(&weighed) / 2.0, error_m[2] * error_m[2] / self.height_m2])
    }
}

/// The models, and the antenna's height above mean sea level.
#[derive(Clone, Copy, Debug)]
pub struct Smoother {
    sensors: SensorErrors,
    horizontal: HorizontalModel,
    vertical: VerticalModel,
    antenna_m: f64,
}

#[derive(Clone, Copy)]
struct SmootherState {
    time_s: f64,
    ground: MotionMixture<HORIZONTAL, MODES>,
    height: MotionMixture<HEIGHT, 2>,
    track: Option<u32>,
}

impl Smoother {
    pub fn new(sensors: SensorErrors, levels: MotionLevels, antenna_m: f64) -> Self {
        let (horizontal, vertical) = (HorizontalModel { sensors, levels }, VerticalModel { sensors, levels });
        Self { sensors, horizontal, vertical, antenna_m }
    }

    /// Estimates for requested times, which increase, from measurements in order of time. `None` before the first
    /// measurement has arrived.
    pub fn estimates(
        &self,
        measured: &[LimitMeasurement],
        delay: DelayPrior,
        requested: &[RequestedTime],
    ) -> Vec<Option<SmoothedEstimate>> {
        let Some(first) = measured.first() else { return vec![None; requested.len()] };
        let mut base = self.begin(first, delay);
        let mut next = 0;
        let estimate = |requested: &RequestedTime| {
            while let Some(one) = measured.get(next)
                && one.time_s <= requested.time_s
                && one.arrives_s <= requested.deadline_s
            {
                self.take(&mut base, one);
                next += 1;
            }
            if first.arrives_s > requested.deadline_s || requested.time_s < base.time_s {
                return None;
            }
            let later = measured[next..].iter();
            let later = later.take_while(|one| one.time_s <= requested.deadline_s);
            self.look_back(base, later.filter(|one| one.arrives_s <= requested.deadline_s), requested.time_s)
        };
        requested.iter().map(estimate).collect()
    }

    fn begin(&self, first: &LimitMeasurement, delay: DelayPrior) -> SmootherState {
        let SensorErrors { gnss, gnss_height, track_azimuth, track_range, track_height, .. } = self.sensors;
        let (MeasurementKind::Report { place_m: [east, north], .. }
        | MeasurementKind::Plot { place_m: [east, north], .. }) = first.kind;
        let (place, speed, gnss_m) = (PLACE_M, SPEED_M_S, gnss.sigma);
        let mut mean = [0.0; HORIZONTAL];
        (mean[P], mean[P + 1], mean[DELAY]) = (east, north, delay.mean_s);
        let slow = [track_azimuth.sigma, track_range.sigma];
        let deviations =
            [place, place, speed, speed, 0.0, 0.0, gnss_m, gnss_m, slow[0], slow[1], delay.sigma_s, 0.0, 0.0];
        let ground = GaussianState::independent(mean, deviations);
        let height_m = first.height_m.unwrap_or(self.antenna_m + 75.0);
        let height = GaussianState::independent(
            [height_m, 0.0, 0.0, 0.0, 0.0],
            [HEIGHT_M, CLIMB_M_S, gnss_height.sigma, track_height.sigma, 0.0],
        );
        SmootherState {
            time_s: first.time_s - BEFORE_S,
            ground: MotionMixture::new([0.8, 0.1, 0.1], ground),
            height: MotionMixture::new([0.5, 0.5], height),
            track: None,
        }
    }

    /// Estimate at a requested time, from an earlier state and the measurements after it.
    fn look_back<'a>(
        &self,
        mut state: SmootherState,
        measured: impl Iterator<Item = &'a LimitMeasurement>,
        time_s: f64,
    ) -> Option<SmoothedEstimate> {
        let mut is_kept = false;
        for one in measured {
            if !is_kept && one.time_s > time_s {
                self.keep(&mut state, time_s);
                is_kept = true;
            }
            self.take(&mut state, one);
        }
        if !is_kept {
            self.keep(&mut state, time_s);
        }
        let (ground, height) = (state.ground.whole(), state.height.whole());
        let covariance = |row: usize, column: usize| ground.covariance[ASKED + row][ASKED + column];
        Some(SmoothedEstimate {
            place_m: [ground.mean[ASKED], ground.mean[ASKED + 1], height.mean[Z_ASKED]],
            ground_m2: Matrix2::from_fn(covariance),
            height_m2: height.covariance[Z_ASKED][Z_ASKED],
            delay_s: [ground.mean[DELAY], ground.covariance[DELAY][DELAY].max(0.0).sqrt()],
        })
    }

    /// Copies position and height at a time into separate entries.
    fn keep(&self, state: &mut SmootherState, time_s: f64) {
        self.predict(state, time_s);
        state.ground.transform(&[MeasurementRow::copy(ASKED, P), MeasurementRow::copy(ASKED + 1, P + 1)]);
        state.height.transform(&[MeasurementRow::copy(Z_ASKED, Z)]);
    }

    fn predict(&self, state: &mut SmootherState, time_s: f64) {
        state.ground.predict(&self.horizontal, time_s - state.time_s);
        state.height.predict(&self.vertical, time_s - state.time_s);
        state.time_s = time_s;
    }

    fn take(&self, state: &mut SmootherState, one: &LimitMeasurement) {
        self.predict(state, one.time_s);
        let sensors = self.sensors;
        match one.kind {
            MeasurementKind::Report { place_m, velocity_m_s } => {
                for axis in 0..2 {
                    let (place_m, velocity_m_s) = (place_m[axis], velocity_m_s[axis]);
                    state.ground.update(|part| {
                        model::report_axis(part, axis, place_m, velocity_m_s, sensors.white_m)
                    });
                }
                let delay_s = state.ground.mean(DELAY);
                if let Some(height_m) = one.height_m {
                    (state.height)
                        .update(|part| model::report_height(part, height_m, delay_s, sensors.white_m));
                }
            }
            MeasurementKind::Plot { azimuth, range, turning, track, .. } => {
                if state.track != Some(track) {
                    state.track = Some(track);
                    state.ground.renew(AZIMUTH, 0.0, sensors.track_azimuth.sigma);
                    state.ground.renew(RANGE, 0.0, sensors.track_range.sigma);
                    state.height.renew(Z_TRACK, 0.0, sensors.track_height.sigma);
                }
                if let Some(height_m) = one.height_m {
                    (state.height).update(|part| model::plot_height(part, height_m, sensors.plot_height_m));
                }
                let (white, white_m) = (sensors.plot_azimuth, sensors.plot_range_m);
                state.ground.update(|part| model::plot(part, azimuth, (AZIMUTH, turning), white));
                state.ground.update(|part| model::plot(part, range, (RANGE, 1.0), white_m));
            }
        }
    }
}
