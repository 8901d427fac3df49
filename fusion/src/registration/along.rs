//! Generalised least squares along one radar track of one target.
//!
//! In each of azimuth, range and height the offset of a plot is aᵀp + bias + the reference's error + white error, where
//! p is the misalignment of the radar. A Kalman filter follows the two errors that last, and with them how its mean would
//! change with p: its innovations are then white, and each tells of p what is new in it. The sum of that is the exact solution
//! with the dense covariance of all plots; information about a bias grows as 1 + D / 2T with the track's duration D and the
//! errors' correlation time T, however many plots there are.

use nalgebra::{Matrix4, Matrix4x6, Matrix6, RowVector4, RowVector6, Vector3, Vector4, Vector6};
use serde::{Deserialize, Serialize};

use super::creep::Turned;
use super::parameters::{AXES, AZIMUTH, BEARING, HEIGHT, OWN, PRIOR, RANGE, TILT_EAST, TILT_NORTH, TIME};
use crate::filter::RadarErrors;
use crate::frames::{AtRadar, Enu};
use crate::time::Time;

/// A plot against where its target was at that time, both as seen from the radar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// When, as the radar says.
    pub time: Time,
    /// Where the radar saw it, without any registration applied.
    pub plot: Enu<AtRadar>,
    /// Where its transponder says it was at `time`.
    pub target: Enu<AtRadar>,
    /// The target's velocity in the radar's axes, m/s.
    pub velocity: Vector3<f64>,
    /// Whether the radar measured the height; if not, the plot's is an assumed one, and tells nothing.
    pub height_measured: bool,
    /// Standard deviation of `target`, each axis, metres.
    pub sigma_m: f64,
}

impl Residual {
    /// The offset in azimuth, of a radar track that began then; `None` where azimuth means little, or where it is no number.
    pub(crate) fn turned(&self, begun: Time) -> Option<Turned> {
        let Self { time, plot, target, velocity, .. } = self;
        let (plot, target) = (&plot.0, &target.0);
        let ground_m = target.xy().norm();
        let is_far = ground_m.min(plot.xy().norm()) >= NEAR_M && target.z.abs() <= STEEP * ground_m;
        let offset = wrapped(plot.x.atan2(plot.y) - target.x.atan2(target.y));
        let rate = (velocity.x * target.y - velocity.y * target.x) / (ground_m * ground_m);
        (is_far && offset.is_finite() && rate.is_finite()).then_some(Turned {
            time: *time,
            begun,
            offset,
            rate,
        })
    }
}

/// What is known of p: inverse covariance, and that times the mean.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Information {
    pub(super) matrix: Matrix6<f64>,
    pub(super) vector: Vector6<f64>,
}

/// The mean offset of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Offset {
    pub(super) mean: f64,
    pub(super) variance: f64,
    /// How it changes with p.
    pub(super) row: Vector6<f64>,
}

/// What a piece of a radar track tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When the radar track began: tells tracks apart.
    pub(super) begun: Time,
    /// When the piece ended.
    pub(super) time: Time,
    pub(super) axes: [Information; AXES],
}

/// One radar track of one target.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TrackComparison {
    correlation_s: f64,
    axes: [Axis; AXES],
    /// First and newest plot; first plot since the last take.
    begun: Option<Time>,
    newest: Time,
    since: Option<Time>,
}

/// A satellite receiver's error is forgotten to 1/e in this time, seconds: it lasts for a minute. So all of `sigma_m` counts
/// as an error that lasts, which is on the safe side where part of it is new with each report.
const REFERENCE_S: f64 = 60.0;
/// An innovation beyond so many deviations is given less weight (Huber).
const FAR: f64 = 3.0;
/// Nearer, azimuth means little, metres over ground.
const NEAR_M: f64 = 100.0;
/// Steeper, likewise: height over distance over ground.
const STEEP: f64 = 2.0;

/// An axis: its errors that last (the radar's in the axis' unit; the reference's east, north, up, as shares of its deviation,
/// because a target that passes by turns them from one axis into another), and how their mean changes with p.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Axis {
    own: usize,
    bias_sigma: f64,
    noise_sigma: f64,
    mean: Vector4<f64>,
    sensitivity: Matrix4x6<f64>,
    covariance: Matrix4<f64>,
    /// What is known of the axis' offset as a whole, for finding outliers: inverse variance, and that times the mean.
    offset: Option<(f64, f64)>,
    information: Information,
}

impl Information {
    pub(super) fn none() -> Self {
        Self { matrix: Matrix6::zeros(), vector: Vector6::zeros() }
    }

    pub(super) fn add(&mut self, other: &Self, weight: f64) {
        self.matrix += other.matrix * weight;
        self.vector += other.vector * weight;
    }

    /// The mean offset of axis `axis`; `None`: nothing was measured.
    pub(super) fn offset(&self, axis: usize) -> Option<Offset> {
        let own = OWN[axis];
        let information = self.matrix[(own, own)];
        (information > 0.0).then(|| Offset {
            mean: self.vector[own] / information,
            variance: 1.0 / information,
            row: self.matrix.column(own) / information,
        })
    }
}

impl Sample {
    /// When the track began.
    pub fn begun(&self) -> Time {
        self.begun
    }

    /// Counts this much, 0 to 1.
    pub(crate) fn weaken(&mut self, weight: f64) {
        for axis in &mut self.axes {
            axis.matrix *= weight;
            axis.vector *= weight;
        }
    }

    /// When the piece ended.
    pub fn time(&self) -> Time {
        self.time
    }

    /// The mean offset in azimuth of the piece, plot minus target, and its standard deviation; radians.
    pub fn azimuth(&self) -> Option<(f64, f64)> {
        self.axes[AZIMUTH].offset(AZIMUTH).map(|offset| (offset.mean, offset.variance.sqrt()))
    }
}

impl TrackComparison {
    /// A radar track of which nothing is known yet, of a radar that errs so when it is aligned.
    pub fn new(errors: &RadarErrors) -> Self {
        let slow = [errors.bias_azimuth, errors.bias_range_m, errors.bias_height_m];
        let fast = [errors.noise_azimuth, errors.noise_range_m, errors.noise_height_m];
        Self {
            correlation_s: errors.correlation_s,
            axes: std::array::from_fn(|axis| Axis::new(OWN[axis], slow[axis], fast[axis])),
            begun: None,
            newest: Time::default(),
            since: None,
        }
    }

    /// One plot more. One that is no later than the newest, too near, too steep, or no number, is left out.
    pub fn add(&mut self, residual: &Residual) {
        let Residual { time, plot, target, velocity, height_measured, sigma_m } = residual;
        let (plot, target) = (&plot.0, &target.0);
        let (ground_m, range_m) = (target.xy().norm(), target.norm());
        let numbers = [plot, target, velocity].iter().all(|vector| vector.iter().all(|x| x.is_finite()));
        if !numbers
            || !sigma_m.is_finite()
            || (self.begun.is_some() && *time <= self.newest)
            || ground_m.min(plot.xy().norm()) < NEAR_M
            || target.z.abs() > STEEP * ground_m
        {
            return;
        }
        if self.begun.is_some() {
            let dt = time.seconds_since(self.newest);
            for axis in &mut self.axes {
                axis.predict((-dt / self.correlation_s).exp(), (-dt / REFERENCE_S).exp());
            }
        }
        self.begun.get_or_insert(*time);
        self.since.get_or_insert(*time);
        self.newest = *time;

        let turned = wrapped(plot.x.atan2(plot.y) - target.x.atan2(target.y));
        let [azimuth, range, height] = rows(target, velocity, turned);
        let [azimuths, ranges, heights] = &mut self.axes;
        let clockwise = Vector3::new(target.y, -target.x, 0.0) / (ground_m * ground_m);
        azimuths.measure(turned, &azimuth, &(clockwise * *sigma_m));
        ranges.measure(plot.norm() - range_m, &range, &(target / range_m * *sigma_m));
        if *height_measured {
            heights.measure(plot.z - target.z, &height, &(Vector3::z() * *sigma_m));
        }
    }

    /// What was gathered since the last take; `None`: nothing. The pieces of a track add up to what the whole would have told.
    pub fn take(&mut self) -> Option<Sample> {
        self.since.take()?;
        let axes =
            self.axes.each_mut().map(|axis| std::mem::replace(&mut axis.information, Information::none()));
        Some(Sample { begun: self.begun?, time: self.newest, axes })
    }

    /// When it began.
    pub(crate) fn begun(&self) -> Option<Time> {
        self.begun
    }

    /// From the first plot to the newest since the last take, seconds.
    pub fn gathered_s(&self) -> f64 {
        self.since.map_or(0.0, |since| self.newest.seconds_since(since))
    }
}

impl Axis {
    fn new(own: usize, bias_sigma: f64, noise_sigma: f64) -> Self {
        Self {
            own,
            bias_sigma,
            noise_sigma,
            mean: Vector4::zeros(),
            sensitivity: Matrix4x6::zeros(),
            covariance: stationary(bias_sigma),
            offset: None,
            information: Information::none(),
        }
    }

    /// Of the bias and of the reference's, these shares are kept.
    fn predict(&mut self, slow: f64, reference: f64) {
        let kept = Vector4::new(slow, reference, reference, reference);
        let both = Matrix4::from_diagonal(&kept);
        self.mean = both * self.mean;
        self.sensitivity = both * self.sensitivity;
        self.covariance = both * self.covariance * both;
        self.covariance += stationary(self.bias_sigma) * (Matrix4::identity() - both * both);
    }

    /// An offset, how it changes with p, and with the reference's errors (in their deviations).
    fn measure(&mut self, offset: f64, row: &Vector6<f64>, reference: &Vector3<f64>) {
        let seen = RowVector4::new(1.0, reference.x, reference.y, reference.z);
        let innovation = offset - (seen * self.mean)[0];
        let row_new: RowVector6<f64> = row.transpose() - seen * self.sensitivity;
        let across = self.covariance * seen.transpose();
        let mut variance = (seen * across)[0] + self.noise_sigma * self.noise_sigma;

        // An outlier is one that the track as a whole cannot explain, however the radar is set up.
        let (known, sum) = self.offset.unwrap_or_else(|| {
            let spread: f64 = row.iter().zip(PRIOR).map(|(x, prior)| (x * prior) * (x * prior)).sum();
            (1.0 / spread, 0.0)
        });
        let own = row_new[self.own];
        let distance = (innovation - own * sum / known).abs() / (variance + own * own / known).sqrt();
        if distance > FAR {
            variance *= distance / FAR;
        }
        self.offset = Some((known + own * own / variance, sum + own * innovation / variance));

        let row_column = row_new.transpose();
        self.information.matrix += row_column * row_new / variance;
        self.information.vector += row_column * (innovation / variance);
        let gain = across / variance;
        self.mean += gain * innovation;
        self.sensitivity += gain * row_new;
        self.covariance -= gain * across.transpose();
    }
}

/// Variances of the errors that last, when nothing is known of them.
fn stationary(bias_sigma: f64) -> Matrix4<f64> {
    Matrix4::from_diagonal(&Vector4::new(bias_sigma * bias_sigma, 1.0, 1.0, 1.0))
}

/// How azimuth, range and height of a target at this place change with p, where the radar sees it turned by so much.
pub(super) fn rows(target: &Vector3<f64>, velocity: &Vector3<f64>, turned: f64) -> [Vector6<f64>; AXES] {
    let ground_m = target.xy().norm().max(1.0);
    let azimuth = target.x.atan2(target.y);
    let clockwise = Vector3::new(azimuth.cos(), -azimuth.sin(), 0.0);
    // Halfway between the two directions a difference of places is linear in the rotation, but for its third power.
    let (sin, cos) = (azimuth + turned / 2.0).sin_cos();
    let steep = target.z / ground_m;
    let mut rows = [Vector6::zeros(); AXES];
    rows[0][BEARING] = 1.0;
    rows[0][TILT_EAST] = steep * sin;
    rows[0][TILT_NORTH] = steep * cos;
    rows[0][TIME] = velocity.dot(&clockwise) / ground_m;
    rows[1][RANGE] = 1.0;
    rows[1][TIME] = velocity.dot(target) / target.norm().max(1.0);
    rows[2][TILT_EAST] = ground_m * cos;
    rows[2][TILT_NORTH] = -ground_m * sin;
    rows[2][HEIGHT] = 1.0;
    rows[2][TIME] = velocity.z;
    rows
}

/// An angle between -π and π.
pub(super) fn wrapped(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}
