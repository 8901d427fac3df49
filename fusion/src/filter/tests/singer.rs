//! The filter on aircraft that follow the Singer model: its stated errors hold.

use nalgebra::{Matrix2, Vector2, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;

/// Time between two samples of a flight, seconds.
const STEP_S: f64 = 0.01;

/// Position and velocity at an instant.
type Sample = (Vector3<f64>, Vector3<f64>);

/// Simulates a flight of `samples` samples: the acceleration by eq. 1 of Fasano et al., integrated in small steps.
fn flown(singer: &Singer, first_speed: Vector3<f64>, samples: usize, chance: &mut ChaCha8Rng) -> Vec<Sample> {
    let normal = |chance: &mut ChaCha8Rng| Vector3::from_fn(|_, _| StandardNormal.sample(chance));
    let deviation = Vector3::new(singer.horizontal, singer.horizontal, singer.vertical);
    let kept = (-STEP_S / singer.lasts_s).exp();
    let mut acceleration: Vector3<f64> = normal(chance).component_mul(&deviation);
    let mut velocity: Vector3<f64> = normal(chance).component_mul(&first_speed);
    let mut place = Vector3::new(400.0, 900.0, 60.0);
    let mut flight = Vec::with_capacity(samples);
    for _ in 0..samples {
        flight.push((place, velocity));
        let new = normal(chance).component_mul(&deviation) * (1.0 - kept * kept).sqrt();
        let next = acceleration * kept + new;
        let rate = (acceleration + next) / 2.0;
        place += velocity * STEP_S + rate * (STEP_S * STEP_S / 2.0);
        velocity += rate * STEP_S;
        acceleration = next;
    }
    flight
}

/// Reports of a transponder about every two seconds; every third has velocity and climb.
fn reports(flight: &[Sample], chance: &mut ChaCha8Rng) -> Vec<Measurement> {
    const HORIZONTAL_M: f64 = 1.0;
    const VERTICAL_M: f64 = 1.5;
    const VELOCITY: f64 = 0.3;
    let mut normal = |deviation: f64| -> f64 {
        let value: f64 = StandardNormal.sample(chance);
        value * deviation
    };
    let report = |number: usize| {
        let sample = number * 200 + [0, 33, 71][number % 3];
        let &(place, velocity) = flight.get(sample)?;
        let wrong = Vector3::new(normal(HORIZONTAL_M), normal(HORIZONTAL_M), normal(VERTICAL_M));
        let told = velocity + Vector3::from_fn(|_, _| normal(VELOCITY));
        let tells = number % 3 == 2;
        Some(Measurement {
            time: seconds(sample as f64 * STEP_S),
            position: Enu::from(place + wrong),
            height_measured: true,
            velocity: tells.then_some((told.xy(), VELOCITY)),
            climb: tells.then_some((told.z, VELOCITY)),
            by: By::Transponder { horizontal_m: HORIZONTAL_M, vertical_m: VERTICAL_M },
        })
    };
    (0..).map_while(report).collect()
}

/// Sums over many estimates.
#[derive(Default)]
struct Errors {
    count: f64,
    /// Normalised squared errors over their dimensions: of the position over ground, the height, the velocity over
    /// ground.
    nees: [f64; 3],
    squared_m2: f64,
    told_m2: f64,
}

impl Errors {
    fn take(&mut self, track: &TargetFilter, sample: usize, flight: &[Sample]) {
        let estimate = track.at(seconds(sample as f64 * STEP_S)).unwrap();
        let (place, velocity) = flight[sample];
        let normalised = |apart: Vector2<f64>, spread: &Matrix2<f64>| {
            apart.dot(&(spread.try_inverse().unwrap() * apart)) / 2.0
        };
        let apart = estimate.position.0 - place;
        self.count += 1.0;
        self.nees[0] += normalised(apart.xy(), &estimate.horizontal);
        self.nees[1] += apart.z * apart.z / estimate.vertical;
        self.nees[2] += normalised((estimate.velocity - velocity).xy(), &estimate.velocity_covariance);
        self.squared_m2 += apart.xy().norm_squared();
        self.told_m2 += estimate.horizontal.trace();
    }
}

#[test]
fn singer_errors_are_consistent_and_shrink_with_later_plots() {
    const SAMPLES: usize = 2000;
    let singer = Singer { lasts_s: 2.5, horizontal: 1.8, vertical: 0.9 };
    let mut chance = ChaCha8Rng::seed_from_u64(1970);
    let (mut filtered, mut smoothed) = (Errors::default(), Errors::default());
    for _ in 0..300 {
        // Initial speeds as the filter assumes them.
        let flight = flown(&singer, Vector3::new(12.0, 12.0, 2.0), SAMPLES, &mut chance);
        let reports = reports(&flight, &mut chance);
        let dynamics = Dynamics::Singer(singer);
        let all = tracked(&reports, &dynamics);
        for sample in [250, 730, 1210, 1640] {
            let known = reports.partition_point(|report| report.time <= seconds(sample as f64 * STEP_S));
            filtered.take(&tracked(&reports[..known], &dynamics), sample, &flight);
            smoothed.take(&all, sample, &flight);
        }
    }
    for (errors, which) in [(&filtered, "filter"), (&smoothed, "smoother")] {
        // 1200 estimates, of which those of one flight are correlated: four deviations and more.
        let nees = errors.nees.map(|sum| sum / errors.count);
        assert!(nees.iter().all(|nees| (0.85..1.15).contains(nees)), "{which}: {nees:?}");
    }
    assert!(
        smoothed.squared_m2 < 0.5 * filtered.squared_m2,
        "{} {}",
        smoothed.squared_m2,
        filtered.squared_m2
    );
    assert!(smoothed.told_m2 < 0.5 * filtered.told_m2);
}
