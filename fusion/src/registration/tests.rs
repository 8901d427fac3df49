//! A misaligned radar with drones around it, and its registration.

mod along;
mod correction;
mod delay;
mod heights;
mod honest;
mod mutual;
mod place;
mod qmethod;
mod state;
mod step;

use nalgebra::{Rotation3, Vector3, Vector6};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::along::Sample;
use super::parameters::PRIOR;
use super::qmethod::rotation_vector;
use super::{BiasValue, Misalignment, Registration, Residual, TrackComparison};
use crate::filter::RadarErrors;
use crate::time::Time;

const ERRORS: RadarErrors = RadarErrors {
    bias_range_m: 5.0,
    bias_azimuth: 1.0_f64.to_radians(),
    bias_height_m: 8.0,
    noise_range_m: 2.0,
    noise_azimuth: 0.2_f64.to_radians(),
    noise_height_m: 3.0,
    correlation_s: 20.0,
};
/// Error of the transponders' positions, metres.
const REFERENCE_M: f64 = 1.5;
/// Time between two reports of a transponder, seconds.
const REPORTS_S: f64 = 3.0;
/// Height that is assumed without a measurement, metres.
const ASSUMED_M: f64 = 60.0;

fn seconds(at: f64) -> Time {
    Time::from_nanos((at * 1e9).round() as i64)
}

/// A radar and its surroundings.
pub(crate) struct World {
    random: ChaCha8Rng,
    /// True misalignment: bearing, tilts, range, height, time.
    pub(crate) bias: Vector6<f64>,
    /// Where the radar stands, relative to the position of which the comparison knows.
    displaced: Vector3<f64>,
    /// Ratio of the true biases to [`ERRORS`].
    scale: f64,
    heights: bool,
    /// Maximum error of the reports' time stamps in either direction, seconds; reports come every 3 s.
    jitter_s: f64,
    /// Beginning of the next track, seconds.
    now_s: f64,
}

/// A first-order Gauss–Markov process.
struct Lasting {
    value: f64,
    deviation: f64,
    correlation_s: f64,
}

impl Lasting {
    fn new(world: &mut World, deviation: f64, correlation_s: f64) -> Self {
        Self { value: deviation * world.normal(), deviation, correlation_s }
    }

    fn after(&mut self, world: &mut World, dt: f64) -> f64 {
        let kept = (-dt / self.correlation_s).exp();
        self.value = kept * self.value + (1.0 - kept * kept).sqrt() * self.deviation * world.normal();
        self.value
    }
}

impl World {
    /// An aligned radar.
    fn new(seed: u64) -> Self {
        let random = ChaCha8Rng::seed_from_u64(seed);
        Self {
            random,
            bias: Vector6::zeros(),
            displaced: Vector3::zeros(),
            scale: 1.0,
            heights: true,
            jitter_s: 0.0,
            now_s: 1000.0,
        }
    }

    /// A radar with a random misalignment according to the prior.
    pub(crate) fn wrong(seed: u64) -> Self {
        let mut world = Self::new(seed);
        world.bias = Vector6::from(PRIOR).map(|deviation| deviation * world.normal());
        world
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.random.random::<f64>()
    }

    /// The radar's plot of a position, with these errors of azimuth, range and height.
    fn plot(&self, place: Vector3<f64>, errors: [f64; 3]) -> Vector3<f64> {
        let turned = Rotation3::new(rotation_vector(&self.bias)) * (place - self.displaced);
        let range_m = turned.norm() + self.bias[3] + errors[1];
        let up = if self.heights { turned.z + self.bias[4] + errors[2] } else { ASSUMED_M };
        let ground_m = (range_m * range_m - up * up).max(0.0).sqrt();
        let (sin, cos) = (turned.x.atan2(turned.y) + errors[0]).sin_cos();
        Vector3::new(ground_m * sin, ground_m * cos, up)
    }

    /// Plots of one track of a drone that turns at random.
    fn plots(&mut self, duration_s: f64, dt: f64) -> Vec<Residual> {
        let (azimuth, range_m) = (self.between(0.0, std::f64::consts::TAU), self.between(400.0, 4000.0));
        let mut place =
            Vector3::new(range_m * azimuth.sin(), range_m * azimuth.cos(), self.between(20.0, 140.0));
        let (speed, climb) = (self.between(2.0, 20.0), self.between(-1.0, 1.0));
        let (mut course, mut turning) = (self.between(0.0, std::f64::consts::TAU), 0.0);
        let slow = |deviation: f64, world: &mut Self| {
            Lasting::new(world, world.scale * deviation, ERRORS.correlation_s)
        };
        let mut errors =
            [ERRORS.bias_azimuth, ERRORS.bias_range_m, ERRORS.bias_height_m].map(|d| slow(d, self));
        let fast = [ERRORS.noise_azimuth, ERRORS.noise_range_m, ERRORS.noise_height_m];
        let mut reference = [REFERENCE_M; 3].map(|deviation| Lasting::new(self, deviation, 60.0));
        let begun_s = self.now_s;
        self.now_s += 5.0;
        let mut plots = Vec::new();
        let stamps: Vec<f64> = (0..=(duration_s / REPORTS_S) as usize + 1)
            .map(|_| if self.jitter_s > 0.0 { self.between(-self.jitter_s, self.jitter_s) } else { 0.0 })
            .collect();
        let mut at = 0.0;
        while at <= duration_s {
            let velocity = Vector3::new(speed * f64::sin(course), speed * f64::cos(course), climb);
            let wrong = std::array::from_fn(|i| errors[i].value + fast[i] * self.normal());
            let plot = self.plot(place + velocity * self.bias[5], wrong);
            let (report, share) = ((at / REPORTS_S) as usize, (at / REPORTS_S).fract());
            let late_s = stamps[report] * (1.0 - share) + stamps[report + 1] * share;
            let said =
                place - velocity * late_s + Vector3::from(reference.each_ref().map(|error| error.value));
            plots.push(Residual {
                time: seconds(begun_s + at),
                plot: plot.into(),
                target: said.into(),
                velocity,
                height_measured: self.heights,
                lasting_m: REFERENCE_M,
                // Variance of a uniform distribution after interpolation.
                curve_m: velocity.norm() * self.jitter_s * f64::sqrt(2.0 / 9.0),
                spacing_s: REPORTS_S,
            });
            if self.random.random::<f64>() < dt / 15.0 {
                turning = self.between(-0.2, 0.2);
            }
            course += turning * dt;
            place += velocity * dt;
            at += dt;
            for lasting in errors.iter_mut().chain(&mut reference) {
                lasting.after(self, dt);
            }
        }
        plots
    }

    pub(crate) fn sample(&mut self, duration_s: f64, dt: f64) -> Sample {
        let plots = self.plots(duration_s, dt);
        sample_of(&plots)
    }

    /// The samples of one track, one for each `every_s`.
    fn segments(&mut self, duration_s: f64, every_s: f64) -> Vec<Sample> {
        let mut along = TrackComparison::new(&ERRORS);
        let mut samples = Vec::new();
        for plot in self.plots(duration_s, 2.0) {
            along.add(&plot);
            if along.gathered_s() >= every_s {
                samples.extend(along.take_sample());
            }
        }
        samples
    }

    /// Estimate from this number of tracks of a minute each.
    fn estimate(&mut self, tracks: usize) -> Misalignment {
        let mut registration = Registration::default();
        for _ in 0..tracks {
            registration.add(&self.sample(60.0, 2.0));
        }
        registration.estimate()
    }
}

fn sample_of(plots: &[Residual]) -> Sample {
    let mut along = TrackComparison::new(&ERRORS);
    for plot in plots {
        along.add(plot);
    }
    along.take_sample().unwrap()
}

fn values(estimate: &Misalignment) -> [BiasValue; 6] {
    let Misalignment { bearing, tilt_east, tilt_north, range_m, height_m, time_s, .. } = *estimate;
    [bearing, tilt_east, tilt_north, range_m, height_m, time_s]
}

const NAMES: [&str; 6] = ["bearing", "tilt east", "tilt north", "range", "height", "time"];
