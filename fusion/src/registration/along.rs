//! Generalised least squares along one radar track of one target.
//!
//! In each of azimuth, range and height the offset of a plot is aᵀp + bias + the reference's error + white error, where
//! p is the misalignment of the radar. A Kalman filter follows the two errors that last, and with them how its mean would
//! change with p: its innovations are then white, and each adds what is new about p. The sum of that is the exact solution
//! with the dense covariance of all plots; information about a bias grows as 1 + D / 2T with the track's duration D and the
//! errors' correlation time T, however many plots there are.

use nalgebra::{
    Matrix4, Matrix4x2, Matrix4x6, Matrix6, RowVector2, RowVector4, RowVector6, Vector2, Vector3, Vector4,
    Vector6,
};
use serde::{Deserialize, Serialize};

use super::creep::AzimuthOffset;
use super::displaced::{AXES_OVER_GROUND, PlaceInformation};
use super::parameters::{AXES, AZIMUTH, BEARING, HEIGHT, OWN, PRIOR, RANGE, TILT_EAST, TILT_NORTH, TIME};
use crate::filter::RadarErrors;
use crate::frames::{AtRadar, Enu};
use crate::time::Time;

/// A plot and the position of its target at that time, both relative to the radar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Time of the plot, according to the radar.
    pub time: Time,
    /// Position of the plot, without any registration applied.
    pub plot: Enu<AtRadar>,
    /// Position according to the transponder at `time`.
    pub target: Enu<AtRadar>,
    /// The target's velocity in the radar's axes, m/s.
    pub velocity: Vector3<f64>,
    /// Whether the radar measured the height; if not, the plot's height is assumed, and is ignored.
    pub height_measured: bool,
    /// Standard deviation of the persistent error of `target`, each axis, metres.
    pub lasting_m: f64,
    /// Standard deviation of the error of `target` that changes with each report, interpolation included, each axis, metres.
    pub curve_m: f64,
    /// Time between the transponder's reports before and after `time`, seconds.
    pub spacing_s: f64,
}

impl Residual {
    /// Offset in azimuth, for a radar track that began at `begun`; `None` near the radar, at steep elevations, or if it is not a
    /// number.
    pub(crate) fn turned(&self, begun: Time) -> Option<AzimuthOffset> {
        let Self { time, plot, target, velocity, .. } = self;
        let (plot, target) = (&plot.0, &target.0);
        let ground_m = target.xy().norm();
        let is_far = ground_m.min(plot.xy().norm()) >= NEAR_M && target.z.abs() <= STEEP * ground_m;
        let offset = wrapped(plot.x.atan2(plot.y) - target.x.atan2(target.y));
        let rate = (velocity.x * target.y - velocity.y * target.x) / (ground_m * ground_m);
        (is_far && offset.is_finite() && rate.is_finite()).then_some(AzimuthOffset {
            time: *time,
            begun,
            offset,
            rate,
        })
    }
}

/// Information about p: inverse covariance, and inverse covariance times mean.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Information {
    pub(super) matrix: Matrix6<f64>,
    pub(super) vector: Vector6<f64>,
}

/// Mean offset on an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MeanOffset {
    pub(super) mean: f64,
    pub(super) variance: f64,
    /// Derivative of the offset with respect to p.
    pub(super) row: Vector6<f64>,
}

/// Information from a segment of a radar track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Beginning of the radar track; distinguishes tracks.
    pub(super) begun: Time,
    /// End of the segment.
    pub(super) time: Time,
    pub(super) axes: [Information; AXES],
    /// Information about the radar's position, from azimuth and range.
    pub(super) places: [PlaceInformation; AXES_OVER_GROUND],
    /// Time from its first to its last plot, seconds.
    pub(super) lasted_s: f64,
}

/// Comparison of one radar track with its target.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TrackComparison {
    correlation_s: f64,
    axes: [ResidualAxis; AXES],
    /// First and newest plot; first plot since the last [`Self::take_sample`].
    begun: Option<Time>,
    newest: Time,
    since: Option<Time>,
}

/// Time in which the persistent error of a GNSS receiver decays to 1/e, seconds.
const REFERENCE_S: f64 = 60.0;
/// Number of deviations beyond which an innovation has less weight (Huber).
const FAR: f64 = 3.0;
/// Minimum ground distance at which azimuth is compared, metres.
const NEAR_M: f64 = 100.0;
/// Maximum ratio of height to ground distance at which azimuth is compared.
const STEEP: f64 = 2.0;

/// One axis. Its state holds the persistent errors and the change of their mean with p: the radar's bias in the unit of the axis,
/// and the reference's error east, north and up in deviations. The reference's error is kept in these directions because a
/// passing target rotates it from one axis into another.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct ResidualAxis {
    own: usize,
    bias_sigma: f64,
    noise_sigma: f64,
    mean: Vector4<f64>,
    sensitivity: Matrix4x6<f64>,
    covariance: Matrix4<f64>,
    /// Estimate of the total offset, for the detection of outliers: inverse variance, and inverse variance times mean.
    offset: Option<(f64, f64)>,
    information: Information,
    /// Change of the mean with the radar's position, and what is known of that.
    place_sensitivity: Matrix4x2<f64>,
    place: PlaceInformation,
}

impl Information {
    pub(super) fn none() -> Self {
        Self { matrix: Matrix6::zeros(), vector: Vector6::zeros() }
    }

    pub(super) fn add(&mut self, other: &Self, weight: f64) {
        self.matrix += other.matrix * weight;
        self.vector += other.vector * weight;
    }

    /// Mean offset on axis `axis`; `None` without a measurement.
    pub(super) fn offset(&self, axis: usize) -> Option<MeanOffset> {
        let own = OWN[axis];
        let information = self.matrix[(own, own)];
        (information > 0.0).then(|| MeanOffset {
            mean: self.vector[own] / information,
            variance: 1.0 / information,
            row: self.matrix.column(own) / information,
        })
    }
}

impl Sample {
    /// Beginning of the radar track.
    pub fn begun(&self) -> Time {
        self.begun
    }

    /// Scales the information by a weight of 0 to 1.
    pub(crate) fn weaken(&mut self, weight: f64) {
        for axis in &mut self.axes {
            axis.matrix *= weight;
            axis.vector *= weight;
        }
        for place in &mut self.places {
            place.cross *= weight;
            place.matrix *= weight;
            place.vector *= weight;
        }
    }

    /// End of the segment.
    pub fn time(&self) -> Time {
        self.time
    }

    /// Mean offset in azimuth of the segment, plot minus target, and its standard deviation; radians.
    pub fn azimuth(&self) -> Option<(f64, f64)> {
        self.axes[AZIMUTH].offset(AZIMUTH).map(|offset| (offset.mean, offset.variance.sqrt()))
    }
}

impl TrackComparison {
    /// An empty comparison. `errors`: errors of the radar when aligned.
    pub fn new(errors: &RadarErrors) -> Self {
        let slow = [errors.bias_azimuth, errors.bias_range_m, errors.bias_height_m];
        let fast = [errors.noise_azimuth, errors.noise_range_m, errors.noise_height_m];
        Self {
            correlation_s: errors.correlation_s,
            axes: std::array::from_fn(|axis| ResidualAxis::new(OWN[axis], slow[axis], fast[axis])),
            begun: None,
            newest: Time::default(),
            since: None,
        }
    }

    /// Adds a plot. It is ignored if it is not newer than the last one, too near, too steep, or not a number.
    pub fn add(&mut self, residual: &Residual) {
        let Residual { time, plot, target, velocity, height_measured, lasting_m, curve_m, spacing_s } =
            residual;
        let (plot, target) = (&plot.0, &target.0);
        let (ground_m, range_m) = (target.xy().norm(), target.norm());
        let numbers = [plot, target, velocity].iter().all(|vector| vector.iter().all(|x| x.is_finite()));
        if !numbers
            || !(lasting_m + curve_m + spacing_s).is_finite()
            || (self.begun.is_some() && *time <= self.newest)
            || ground_m.min(plot.xy().norm()) < NEAR_M
            || target.z.abs() > STEEP * ground_m
        {
            return;
        }
        // Number of plots between the same two reports, which share the interpolation error.
        let mut sharing = 1.0;
        if self.begun.is_some() {
            let dt = time.seconds_since(self.newest);
            sharing = (spacing_s / dt).max(1.0);
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
        // In azimuth and height the plot's own errors are far larger, so the whole error of the reference may count as
        // persistent.
        let reference_m = lasting_m.hypot(*curve_m);
        azimuths.measure(turned, &azimuth, &-clockwise.xy(), &(clockwise * reference_m), 0.0, 1.0);
        let along = target / range_m;
        let length = plot.norm() - range_m;
        ranges.measure(length, &range, &-along.xy(), &(along * *lasting_m), curve_m * curve_m, sharing);
        if *height_measured {
            let above = Vector3::z() * reference_m;
            heights.measure(plot.z - target.z, &height, &Vector2::zeros(), &above, 0.0, 1.0);
        }
    }

    /// Information since the last call; `None` without a plot. The segments of a track add up to the information of the whole
    /// track.
    pub fn take_sample(&mut self) -> Option<Sample> {
        let since = self.since.take()?;
        let axes =
            self.axes.each_mut().map(|axis| std::mem::replace(&mut axis.information, Information::none()));
        let places = std::array::from_fn(|axis| {
            std::mem::replace(&mut self.axes[axis].place, PlaceInformation::none())
        });
        let lasted_s = self.newest.seconds_since(since);
        Some(Sample { begun: self.begun?, time: self.newest, axes, places, lasted_s })
    }

    /// Beginning of the radar track.
    pub(crate) fn begun(&self) -> Option<Time> {
        self.begun
    }

    /// Time from the first to the newest plot since the last [`Self::take_sample`], seconds.
    pub fn gathered_s(&self) -> f64 {
        self.since.map_or(0.0, |since| self.newest.seconds_since(since))
    }
}

impl ResidualAxis {
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
            place_sensitivity: Matrix4x2::zeros(),
            place: PlaceInformation::none(),
        }
    }

    /// Propagates the state; these shares of the radar's bias and of the reference's error remain.
    fn predict(&mut self, slow: f64, reference: f64) {
        let kept = Vector4::new(slow, reference, reference, reference);
        let both = Matrix4::from_diagonal(&kept);
        self.mean = both * self.mean;
        self.sensitivity = both * self.sensitivity;
        self.place_sensitivity = both * self.place_sensitivity;
        self.covariance = both * self.covariance * both;
        self.covariance += stationary(self.bias_sigma) * (Matrix4::identity() - both * both);
    }

    /// Adds an offset. `row`, `place` and `reference`: derivatives by p, by the radar's position and by the reference's persistent
    /// errors (in deviations). `curve`: variance of the reference's other errors, one of which is common to `sharing` plots.
    fn measure(
        &mut self,
        offset: f64,
        row: &Vector6<f64>,
        place: &Vector2<f64>,
        reference: &Vector3<f64>,
        curve: f64,
        sharing: f64,
    ) {
        let seen = RowVector4::new(1.0, reference.x, reference.y, reference.z);
        let innovation = offset - (seen * self.mean)[0];
        let row_new: RowVector6<f64> = row.transpose() - seen * self.sensitivity;
        let across = self.covariance * seen.transpose();
        let mut variance = (seen * across)[0] + self.noise_sigma * self.noise_sigma + curve;

        // An outlier cannot be explained by the track as a whole, for any alignment of the radar.
        let (known, sum) = self.offset.unwrap_or_else(|| {
            let spread: f64 = row.iter().zip(PRIOR).map(|(x, prior)| (x * prior) * (x * prior)).sum();
            (1.0 / spread, 0.0)
        });
        let own = row_new[self.own];
        let distance = (innovation - own * sum / known).abs() / (variance + own * own / known).sqrt();
        // White noise with the same spectral density as the shared errors.
        variance += curve * (sharing - 1.0);
        if distance > FAR {
            variance *= distance / FAR;
        }
        self.offset = Some((known + own * own / variance, sum + own * innovation / variance));

        let row_column = row_new.transpose();
        self.information.matrix += row_column * row_new / variance;
        self.information.vector += row_column * (innovation / variance);
        let place_new: RowVector2<f64> = place.transpose() - seen * self.place_sensitivity;
        self.place.cross += row_column * place_new / variance;
        self.place.matrix += place_new.transpose() * place_new / variance;
        self.place.vector += place_new.transpose() * (innovation / variance);
        let gain = across / variance;
        self.mean += gain * innovation;
        self.sensitivity += gain * row_new;
        self.place_sensitivity += gain * place_new;
        self.covariance -= gain * across.transpose();
    }
}

/// Initial covariance of the persistent errors.
fn stationary(bias_sigma: f64) -> Matrix4<f64> {
    Matrix4::from_diagonal(&Vector4::new(bias_sigma * bias_sigma, 1.0, 1.0, 1.0))
}

/// Derivatives with respect to p of azimuth, range and height of a target that the radar sees rotated by `turned`.
pub(super) fn rows(target: &Vector3<f64>, velocity: &Vector3<f64>, turned: f64) -> [Vector6<f64>; AXES] {
    let ground_m = target.xy().norm().max(1.0);
    let azimuth = target.x.atan2(target.y);
    let clockwise = Vector3::new(azimuth.cos(), -azimuth.sin(), 0.0);
    // Halfway between the two directions a difference of positions is linear in the rotation, except for terms of third order.
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

/// The angle between -π and π.
pub(super) fn wrapped(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}
