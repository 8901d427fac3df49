//! The geometry of one pair, compared with random draws and with figures of Fasano et al.

use nalgebra::{Matrix2, Vector2};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;

/// A head-on approach from `range_m` at `closing` m/s, with errors only in the rates of azimuth and elevation, degrees
/// a second. Returns the standard deviation of the miss, across and in height, metres.
fn radial_m(range_m: f64, closing: f64, azimuth_rate: f64, elevation_rate: f64) -> f64 {
    let rate = |degrees: f64| range_m * degrees.to_radians();
    let mut covariance = Matrix4::identity() * 1e-9;
    covariance[(2, 2)] = rate(azimuth_rate).powi(2);
    let relative = Relative {
        position: Vector2::new(0.0, range_m),
        velocity: Vector2::new(0.0, -closing),
        covariance,
        vertical: Some(Vertical {
            height_m: 0.0,
            climb: 0.0,
            covariance: [1e-9, 0.0, rate(elevation_rate).powi(2)],
        }),
    };
    let approach = relative.approach(&ahead(1e4, 0.0));
    assert!((approach.t_cpa_s - range_m / closing).abs() < 1e-9);
    (approach.across_m2() + approach.vertical.unwrap().1).sqrt()
}

/// Fasano et al., equations 5 to 7 with the errors of Table 2: radar alone, then radar and camera.
#[test]
fn angular_rate_errors_give_the_miss_of_the_paper() {
    for (rates, expected_m) in [([0.29, 0.26], 362.6), ([0.099, 0.092], 125.8)] {
        let miss_m = radial_m(2000.0, 75.0, rates[0], rates[1]);
        assert!((miss_m / expected_m - 1.0).abs() < 1e-3, "{miss_m} m instead of {expected_m} m");
    }
}

/// Probability of entering a cylinder within the horizon.
fn probability(relative: &Relative, ahead: &Extrapolation, horizontal_m: f64, vertical_m: f64) -> f64 {
    relative.passage(&cylinder(horizontal_m, vertical_m), ahead, 0.0).probability
}

proptest! {
    /// Linear in the inverse of the range rate, quadratic in range (equation 7).
    #[test]
    fn the_miss_grows_with_the_square_of_the_range(
        range_m in 100.0..5000.0_f64, closing in 5.0..150.0_f64, rate in 0.01..0.5_f64, factor in 0.2..5.0_f64,
    ) {
        let miss_m = radial_m(range_m, closing, rate, rate);
        let further_m = radial_m(factor * range_m, closing, rate, rate);
        prop_assert!((further_m / miss_m / (factor * factor) - 1.0).abs() < 1e-4);
        let faster_m = radial_m(range_m, factor * closing, rate, rate);
        prop_assert!((faster_m * factor / miss_m - 1.0).abs() < 1e-4);
    }

    #[test]
    fn conflict_is_symmetric_in_its_aircraft(
        place in prop::array::uniform3(-500.0..500.0_f64), velocity in prop::array::uniform3(-20.0..20.0_f64),
        other in prop::array::uniform3(-20.0..20.0_f64),
    ) {
        let (one, other) = (aircraft(1, [0.0; 3], velocity), aircraft(2, place, other));
        let approach = |a: &ConflictAircraft, b: &ConflictAircraft| Relative::of(a, b).approach(&ahead(60.0, 1.0));
        let (there, back) = (approach(&one, &other), approach(&other, &one));
        prop_assert!((there.miss + back.miss).norm() < 1e-6);
        let chance = |a: &ConflictAircraft, b: &ConflictAircraft| {
            Relative::of(a, b).passage(&drones(), &ahead(60.0, 1.0), 0.0)
        };
        let (forth, reverse) = (chance(&one, &other), chance(&other, &one));
        prop_assert!((forth.probability - reverse.probability).abs() < 1e-9);
        prop_assert!((forth.entry_s - reverse.entry_s).abs() < 1e-9);
        prop_assert!((0.0..=1.0).contains(&forth.probability));
        // At no step of the straight path are they nearer.
        let relative = Relative::of(&one, &other);
        for step in 0..=600 {
            let apart = relative.position + relative.velocity * (f64::from(step) / 10.0);
            prop_assert!(apart.norm() >= there.horizontal_m() - 0.1 * 0.05, "{step}");
        }
    }
}

#[test]
fn a_volume_all_around_is_certain_and_one_far_away_impossible() {
    let relative = Relative::of(&aircraft(1, [0.0; 3], [0.0; 3]), &aircraft(2, [30.0, 0.0, 2.0], [0.0; 3]));
    assert!(relative.approach(&ahead(60.0, 1.0)).t_cpa_s == 0.0);
    assert!(probability(&relative, &ahead(60.0, 1.0), 500.0, 500.0) > 0.999_999);
    assert!(probability(&relative, &ahead(2.0, 0.0), 1.0, 15.0) < 1e-3);
    // With exact positions the probability is 0 or 1.
    let mut exact = aircraft(1, [0.0; 3], [0.0; 3]);
    exact.covariance = Matrix4::identity() * 1e-12;
    exact.vertical = None;
    let other = ConflictAircraft { position: Enu::new(30.0, 0.0, 0.0), ..exact.clone() };
    let relative = Relative::of(&exact, &other);
    assert!(probability(&relative, &ahead(60.0, 1.0), 30.1, 1.0) > 1.0 - 1e-6);
    assert!(probability(&relative, &ahead(60.0, 1.0), 29.9, 1.0) < 1e-6);
}

/// Reference for the disc: a quadrature in other coordinates.
#[test]
fn the_density_over_a_disc_is_that_of_rings_and_angles() {
    let covariance: Matrix2<f64> = Matrix2::new(900.0, 300.0, 300.0, 250.0);
    let inverse = covariance.try_inverse().unwrap();
    let scale = std::f64::consts::TAU * covariance.determinant().sqrt();
    for mean in [Vector2::zeros(), Vector2::new(40.0, -25.0), Vector2::new(0.0, 90.0)] {
        let rings = 400;
        let (mut sum, step) = (0.0, 50.0 / f64::from(rings));
        for ring in 0..rings {
            let radius = (f64::from(ring) + 0.5) * step;
            for part in 0..360 {
                let angle = f64::from(part) * std::f64::consts::TAU / 360.0;
                let away = Vector2::new(radius * angle.cos(), radius * angle.sin()) - mean;
                let density = (-0.5 * (away.transpose() * inverse * away).x).exp() / scale;
                sum += density * radius * step * std::f64::consts::TAU / 360.0;
            }
        }
        // Both at rest: the closest point is now.
        let mut still = aircraft(1, [0.0; 3], [0.0; 3]);
        still.covariance = Matrix4::identity() * 1e-9;
        still.vertical = None;
        let mut other = still.clone();
        other.position = Enu::new(mean.x, mean.y, 0.0);
        other.covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&covariance);
        let probability = probability(&Relative::of(&still, &other), &ahead(60.0, 1.0), 50.0, 1.0);
        assert!((probability - sum).abs() < 1e-3, "{probability} and {sum} about {mean}");
    }
}

/// Geometries of one kind, each compared with straight flights drawn from the same covariance.
fn compared(seed: u64, climbs: f64, speeds: std::ops::Range<f64>, volume: &Volume) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut errors = Vec::new();
    for _ in 0..200 {
        let mut span = |from: f64, to: f64| random.random_range(from..to);
        let (bearing, aside): (f64, f64) = (span(0.0, std::f64::consts::TAU), span(-0.4, 0.4));
        let speed = span(speeds.start, speeds.end);
        let range_m = span(0.2, 1.0) * (60.0 * speed + 2.0 * volume.horizontal_m);
        let position = Vector2::new(bearing.sin(), bearing.cos()) * range_m;
        let velocity = -Vector2::new((bearing + aside).sin(), (bearing + aside).cos()) * speed;
        let (place, rate) = (span(1.0, 20.0), span(0.05, 0.8));
        let across = span(-0.6, 0.6) * place * rate;
        let mut covariance =
            Matrix4::from_diagonal(&[place * place, 0.7 * place * place, rate * rate, rate * rate].into());
        for (row, column) in [(0, 2), (2, 0)] {
            covariance[(row, column)] = across;
        }
        let (height, climb) = (span(1.0, 8.0), span(0.02, 0.4));
        let vertical = Vertical {
            height_m: span(-60.0, 60.0),
            climb: span(-climbs, climbs),
            covariance: [height * height, span(-0.8, 0.8) * height * climb, climb * climb],
        };
        let relative = Relative { position, velocity, covariance, vertical: Some(vertical) };
        let straight = Extrapolation { straight_s: 1e9, ..ahead(60.0, 0.0) };
        let stated = relative.passage(volume, &straight, 0.0).probability;
        let root = covariance.cholesky().unwrap().l();
        let [hh, hc, cc] = vertical.covariance;
        let upright = Matrix2::new(hh, hc, hc, cc).cholesky().unwrap().l();
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let draws = 4_000;
        let inside = (0..draws).filter(|_| {
            let drawn = root * nalgebra::Vector4::from_fn(|_, _| normal());
            let above = upright * Vector2::from_fn(|_, _| normal());
            let drawn = Relative {
                position: position + drawn.xy(),
                velocity: velocity + Vector2::new(drawn.z, drawn.w),
                vertical: Some(Vertical {
                    height_m: vertical.height_m + above.x,
                    climb: vertical.climb + above.y,
                    ..vertical
                }),
                ..relative
            };
            volume.interval(&drawn, 60.0).is_some()
        });
        let share = inside.count() as f64 / f64::from(draws);
        if stated > 0.02 || share > 0.02 {
            errors.push((stated - share).abs());
        }
    }
    errors.sort_by(f64::total_cmp);
    errors
}

/// Level flight, climbs and descents, slow relative motion, and modified tau.
#[test]
fn probability_is_the_share_of_draws_inside_at_any_time() {
    let enroute = Preset::Do365Enroute.volume();
    for (name, climbs, speeds, volume, largest_mean, largest_most) in [
        ("level", 0.05, 3.0..30.0, drones(), 0.02, 0.08),
        ("climbing", 4.0, 3.0..30.0, drones(), 0.03, 0.1),
        ("wide", 4.0, 30.0..90.0, Preset::F3442.volume(), 0.03, 0.1),
        ("slow", 2.0, 0.0..1.0, drones(), 0.08, 0.3),
        ("tau", 4.0, 30.0..90.0, enroute, 0.03, 0.12),
    ] {
        let errors = compared(4_000, climbs, speeds, &volume);
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let (most, largest) = (errors[errors.len() * 95 / 100], errors[errors.len() - 1]);
        let summary = format!("{name}, of {}: mean {mean}, 95 % {most}, largest {largest}", errors.len());
        println!("{summary}");
        assert!(errors.len() > 25 && mean < largest_mean && most < largest_most, "{summary}");
    }
}
