//! How long it takes to find the conflicts of a second, and how that grows with the traffic at constant density.

#![allow(missing_docs, reason = "criterion's macro makes public items")]

use std::time::{Duration, Instant};

use conflict::{ConflictAircraft, Conflicts, TrafficKind};
use criterion::{Criterion, criterion_group};
use fusion::{Enu, Time};
use nalgebra::{Matrix4, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use utm_fusion::config;

/// Aircraft in a square kilometre: 4,000 in 20 x 20 km.
const DENSITY: f64 = 10.0;
/// Evaluations that are measured, a second of flight apart.
const EVALUATIONS: i64 = 200;

/// Side of the square in which this number of aircraft fly, metres.
fn side_m(count: u32) -> f64 {
    1000.0 * (f64::from(count) / DENSITY).sqrt()
}

fn traffic(count: u32) -> Vec<ConflictAircraft> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let side_m = side_m(count);
    let one = |number: u32| {
        let mut span = |most: f64| random.random_range(0.0..most);
        let (course, speed) = (span(std::f64::consts::TAU), 5.0 + span(20.0));
        ConflictAircraft {
            key: (number, Time::default()),
            position: Enu::new(span(side_m), span(side_m), 30.0 + span(90.0)),
            velocity: Vector3::new(speed * course.sin(), speed * course.cos(), 0.0),
            covariance: Matrix4::from_diagonal(&[25.0, 25.0, 1.0, 1.0].into()),
            vertical: Some([16.0, 0.0, 0.1]),
            kind: TrafficKind::Drone,
            disputed: Vec::new(),
            has_transponder: true,
            is_shown: true,
        }
    };
    (0..count).map(one).collect()
}

/// Moves the aircraft by a second. An aircraft that leaves the square turns round, so that the density stays.
fn fly_on(traffic: &mut [ConflictAircraft], side_m: f64) {
    for one in traffic {
        one.position = Enu::from(one.position.0 + one.velocity);
        for axis in [0, 1] {
            let beyond = one.position.0[axis] < 0.0 || one.position.0[axis] > side_m;
            let outward = (one.position.0[axis] > 0.0) == (one.velocity[axis] > 0.0);
            if beyond && outward {
                one.velocity[axis] = -one.velocity[axis];
            }
        }
    }
}

fn growth(criterion: &mut Criterion) {
    let mut measured = Vec::new();
    for count in [500, 1_000, 2_000, 4_000] {
        let mut conflicts = Conflicts::new(config::Conflicts::default().rules());
        let mut aircraft = traffic(count);
        let (mut times, mut tested, mut found) = (Vec::new(), 0, 0);
        for second in 0..EVALUATIONS {
            let given = aircraft.clone();
            let began = now();
            let evaluation = conflicts.evaluate(Time::from_nanos(second * 1_000_000_000), given);
            times.push(began.elapsed());
            (tested, found) = (evaluation.tested, evaluation.conflicts.len());
            fly_on(&mut aircraft, side_m(count));
        }
        times.sort_unstable();
        let at = |share: f64| 1e3 * times[(share * times.len() as f64) as usize].as_secs_f64();
        println!(
            "{count} aircraft: median {:.2} ms, p99 {:.2} ms; {tested} pairs looked at, {found} worth a line",
            at(0.5),
            at(0.99)
        );
        measured.push((f64::from(count), times[times.len() / 2]));
        criterion.bench_function(&format!("conflicts of a second, {count} aircraft"), |bencher| {
            bencher.iter(|| {
                Conflicts::new(config::Conflicts::default().rules())
                    .evaluate(Time::default(), aircraft.clone())
            });
        });
    }
    let [(few, least), .., (many, most)] = measured[..] else { return };
    let growth = (most.div_duration_f64(least)).ln() / (many / few).ln();
    println!("an evaluation grows with the number of aircraft to the power of {growth:.2}");
}

#[expect(clippy::disallowed_methods, reason = "a benchmark looks at the clock")]
fn now() -> Instant {
    Instant::now()
}

fn quick() -> Criterion {
    Criterion::default().sample_size(20).measurement_time(Duration::from_secs(3))
}

criterion_group!(name = benches; config = quick(); targets = growth);
criterion::criterion_main!(benches);
