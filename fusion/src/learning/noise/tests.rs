//! Noise estimated from reports, on flights with known noise.

use proptest::prelude::*;

use super::*;
use crate::frames::Enu;
use crate::report::{Identity, SensorIndex};
use crate::time::Time;

/// Configured white noise of a report: over ground, and in height, metres.
const CONFIGURED_M: [f64; 2] = [0.9, 1.5];

fn report(seconds: f64, [x, y, z]: [f64; 3]) -> Fix {
    let identity = Identity::new(b"000000000001", None).unwrap();
    Fix::new(SensorIndex(0), identity, Time::from_nanos((seconds * 1e9) as i64), Enu::new(x, y, z))
}

/// Time constant with which evidence is forgotten (to 1/e), seconds.
const MEMORY_S: f64 = 900.0;

/// Normal numbers from a counter.
struct Normal(u64);

impl Normal {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    fn next(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// Noise over ground learnt from a flight of `count` reports every `period_s`: legs of 30 s, every second one a turn.
fn learnt(seed: u64, noise_m: f64, period_s: f64, count: usize) -> WhiteNoise {
    let mut normal = Normal(seed);
    let (mut place, mut heading) = ([0.0, 0.0], 0.3_f64);
    let mut fixes = Vec::new();
    for step in 0..count {
        let seconds = step as f64 * period_s;
        for _ in 0..100 {
            let dt = period_s / 100.0;
            heading += if (seconds / 30.0) as u64 % 2 == 1 { 0.2 * dt } else { 0.0 };
            place = [place[0] + 15.0 * heading.sin() * dt, place[1] + 15.0 * heading.cos() * dt];
        }
        let noisy = [place[0] + noise_m * normal.next(), place[1] + noise_m * normal.next(), 80.0];
        fixes.push(report(seconds, noisy));
    }
    let mut noise = WhiteNoise::default();
    for three in fixes.windows(3) {
        if let Some([over_ground, _]) = likelihoods([&three[0], &three[1], &three[2]], CONFIGURED_M) {
            noise.add(&over_ground, period_s, MEMORY_S);
        }
    }
    noise
}

#[test]
fn without_evidence_it_is_as_configured() {
    assert_eq!(WhiteNoise::default().scale().0, 1.0);
}

#[test]
fn distant_reports_are_no_evidence_of_noise() {
    let fixes = [0.0, 7.0, 14.0].map(|seconds| report(seconds, [0.0; 3]));
    assert_eq!(likelihoods([&fixes[0], &fixes[1], &fixes[2]], CONFIGURED_M), None);
}

/// Flights of four minutes, half of them in turns, which look like some of the noise.
#[test]
fn the_noise_of_a_flight_is_found() {
    let mut offs = Vec::new();
    for seed in 1..=60 {
        let true_m = CONFIGURED_M[0] * (-3.5 + 5.0 * (seed as f64 / 60.0)).exp2();
        let period_s = 0.5 + 2.0 * ((seed * 7) % 60) as f64 / 60.0;
        let (scale, _) = learnt(seed, true_m, period_s, (240.0 / period_s) as usize).scale();
        offs.push((scale * CONFIGURED_M[0] / true_m).ln().abs());
    }
    offs.sort_by(f64::total_cmp);
    assert!(offs[30] < 1.3_f64.ln(), "half of them to a factor of {}", offs[30].exp());
    assert!(offs[54] < 2.0_f64.ln(), "nine of ten to a factor of {}", offs[54].exp());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// For any reports the noise stays within the weighed range.
    #[test]
    fn no_reports_lead_out_of_bounds(places in prop::collection::vec((0.01_f64..5.0, -1e6_f64..1e6), 3..60)) {
        let mut seconds = 0.0;
        let fixes: Vec<Fix> = places
            .iter()
            .map(|&(dt, place)| {
                seconds += dt;
                report(seconds, [place, -place, place / 2.0])
            })
            .collect();
        let mut noise = WhiteNoise::default();
        for three in fixes.windows(3) {
            if let Some([over_ground, _]) = likelihoods([&three[0], &three[1], &three[2]], CONFIGURED_M) {
                noise.add(&over_ground, 1.0, MEMORY_S);
            }
        }
        let (scale, factor) = noise.scale();
        prop_assert!((0.06..=16.4).contains(&scale) && factor.is_finite(), "{scale} {factor}");
    }
}

#[test]
fn transponder_starts_with_noise_of_its_type_then_learns_own() {
    let of_type = learnt(3, 0.1, 2.0, 2000);
    let mut own = WhiteNoise::of_type(&of_type);
    assert!((0.8..1.3).contains(&(own.scale().0 / of_type.scale().0)), "{own:?}");
    assert!(own.scale().1 > of_type.scale().1);
    let poor = Likelihoods::from(NOISE_SCALES.map(|scale| -(scale / 4.0_f64).log2().abs()));
    (0..15).for_each(|_| own.add(&poor, 2.0, MEMORY_S));
    assert!(own.scale().0 > 2.0, "{:?}", own.scale());
}
