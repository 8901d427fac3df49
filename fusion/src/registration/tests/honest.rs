//! Consistency of the deviations: normalised squared errors over many radars with random misalignments.

use nalgebra::Vector3;

use super::{ERRORS, NAMES, REFERENCE_M, Registration, Residual, TrackComparison, World, seconds, values};

const RUNS: u64 = 400;
/// The 95 % band of a mean of 400 squares of normal numbers is 0.86 to 1.14. With 40 tracks the variance factor has an error of a
/// fifth, which increases the mean by some hundredths.
const BAND: std::ops::Range<f64> = 0.8..1.25;

/// For each value: mean normalised squared error, root mean square error, and number of runs in which it was observable.
fn errors(tracks: usize, scale: f64, heights: bool) -> [(f64, f64, usize); 6] {
    let mut found = [(0.0, 0.0, 0); 6];
    for seed in 0..RUNS {
        let mut world = World::wrong(1000 * tracks as u64 + seed);
        (world.scale, world.heights) = (scale, heights);
        let estimate = world.estimate(tracks);
        for (index, value) in values(&estimate).iter().enumerate() {
            let error = value.value - world.bias[index];
            found[index].0 += (error / value.deviation).powi(2) / RUNS as f64;
            found[index].1 += error * error / RUNS as f64;
            found[index].2 += usize::from(value.observable);
        }
    }
    for (name, (nees, square, observable)) in NAMES.iter().zip(&found) {
        let error = square.sqrt();
        println!("{tracks} tracks, {scale}, {name}: {nees:.2}, error {error:.4}, observable {observable}");
    }
    found
}

fn check(tracks: usize, scale: f64, heights: bool, band: std::ops::Range<f64>) {
    for (name, (nees, ..)) in NAMES.iter().zip(errors(tracks, scale, heights)) {
        assert!(band.contains(&nees), "{name}: {nees}");
    }
}

#[test]
fn deviations_are_honest_with_heights() {
    check(40, 1.0, true, BAND);
}

#[test]
fn deviations_are_honest_without_heights() {
    check(40, 1.0, false, BAND);
}

#[test]
fn deviations_are_honest_with_few_tracks() {
    check(4, 1.0, true, BAND);
}

/// The true errors are larger or smaller than stated by three tenths, which the tracks' scatter shows.
#[test]
fn deviations_adapt_to_errors_given_wrongly() {
    check(60, 1.3, true, 0.8..1.35);
    check(60, 0.7, true, 0.65..1.25);
}

#[test]
fn tilts_and_height_need_heights_and_more_than_one_place() {
    let observable = |world: &mut World| values(&world.estimate(80)).map(|value| value.observable);
    assert_eq!(observable(&mut World::new(1)), [true; 6]);
    let mut world = World::new(1);
    world.heights = false;
    assert_eq!(observable(&mut world), [true, false, false, true, false, true]);
    // Measured heights, but all in one corner, hovering.
    let mut registration = Registration::default();
    for track in 0..80 {
        let mut along = TrackComparison::new(&ERRORS);
        let place = Vector3::new(2000.0, 2000.0, 60.0);
        for plot in 0..30 {
            along.add(&Residual {
                time: seconds(f64::from(100 * track + 2 * plot)),
                plot: place.into(),
                target: place.into(),
                velocity: Vector3::zeros(),
                height_measured: true,
                lasting_m: REFERENCE_M,
                curve_m: 0.0,
                spacing_s: 0.0,
            });
        }
        registration.add(&along.take_sample().unwrap());
    }
    let estimate = registration.estimate();
    assert_eq!(values(&estimate).map(|value| value.observable), [true, false, false, true, false, false]);
}

/// The remaining misalignment includes values that are not corrected, and the uncertainty of those that are.
#[test]
fn residual_is_the_uncorrected_part() {
    for tracks in [1, 2, 40] {
        let estimate = World::wrong(5).estimate(tracks);
        for (index, value) in values(&estimate).iter().enumerate() {
            let kept = if value.observable { 0.0 } else { value.value };
            let left = value.deviation.hypot(kept);
            let tilt = index == 1 || index == 2;
            let expected = if tilt { value.deviation } else { left };
            assert!((estimate.left[(index, index)].sqrt() / expected - 1.0).abs() < 1e-9, "{tracks} {index}");
        }
        assert_eq!(values(&estimate).iter().all(|value| value.observable), tracks == 40);
    }
}
