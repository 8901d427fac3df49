//! Updates by readings, compared with dense matrices.

use nalgebra::{DMatrix, DVector, Matrix2, SMatrix, Vector6};

use super::*;
use crate::flight::FlightMotion;
use crate::reading::MOST;
use crate::update::{ReadingFit, apply_reading, usable};
use fusion::filter::{BiasTransition, Mixture};

/// Textbook update by all values at once, linearised at the mean, with the noise of the reading.
fn textbook(
    state: &Gaussian<6>,
    reading: &Reading,
    noise: &DMatrix<f64>,
) -> (Vector6<f64>, Matrix6<f64>, ReadingFit) {
    let (position, velocity) =
        (Vector3::from_row_slice(&state.mean[..3]), Vector3::from_row_slice(&state.mean[3..]));
    let count = reading.values().len();
    let mut rows = DMatrix::zeros(count, 6);
    let mut innovation = DVector::zeros(count);
    for (row, (quantity, value)) in reading.values().iter().enumerate() {
        let expected = quantity.expected(&reading.origin().observer, &position, &velocity).unwrap();
        rows.view_mut((row, 0), (1, 3)).copy_from(&expected.by_position.transpose());
        rows.view_mut((row, 3), (1, 3)).copy_from(&expected.by_velocity.transpose());
        innovation[row] = quantity.innovation(*value, expected.value);
    }
    let prior = dense(&state.covariance);
    let spread = &rows * prior * rows.transpose() + noise;
    let inverse = spread.clone().try_inverse().unwrap();
    let gain: SMatrix<f64, 6, 4> = {
        let gain = prior * rows.transpose() * &inverse;
        SMatrix::from_fn(|row, column| if column < count { gain[(row, column)] } else { 0.0 })
    };
    let padded = nalgebra::Vector4::from_fn(|row, _| if row < count { innovation[row] } else { 0.0 });
    let rows =
        SMatrix::<f64, 4, 6>::from_fn(|row, column| if row < count { rows[(row, column)] } else { 0.0 });
    let fit = ReadingFit {
        distance: (innovation.transpose() * &inverse * &innovation)[0],
        determinant: spread.determinant() / noise.determinant(),
    };
    (Vector6::from(state.mean) + gain * padded, (Matrix6::identity() - gain * rows) * prior, fit)
}

fn whole(state: &mut Gaussian<6>, reading: &Reading) -> ReadingFit {
    apply_reading(state, reading, &reading.whitening([true; MOST]).unwrap()).unwrap()
}

fn agrees(state: &Gaussian<6>, reading: &Reading, noise: &DMatrix<f64>) {
    let (mean, covariance, expected) = textbook(state, reading, noise);
    let mut taken = *state;
    let fit = whole(&mut taken, reading);
    let off = (Vector6::from(taken.mean) - mean).component_div(&covariance.diagonal().map(f64::sqrt));
    assert!(off.norm() < 1e-6, "{off}");
    assert!((dense(&taken.covariance) - covariance).norm() < 1e-6 * covariance.norm());
    assert!((fit.distance / expected.distance - 1.0).abs() < 1e-6, "{fit:?} {expected:?}");
    assert!((fit.determinant / expected.determinant - 1.0).abs() < 1e-6, "{fit:?} {expected:?}");
}

#[test]
fn one_number_after_another_is_all_at_once() {
    let mut rng = rng(4);
    for _ in 0..300 {
        let line = away(&mut rng, 3000.0, 30_000.0);
        let velocity = away(&mut rng, 1.0, 200.0);
        let state = gaussian(
            [line.x, line.y, line.z, velocity.x, velocity.y, velocity.z],
            &covariance(&mut rng, 40.0, 10.0),
        );
        let off = away(&mut rng, 1.0, 40.0);
        let radar = seen_by_radar(at_origin(0.0, 0), &(line + off), &velocity);
        let noise = [20.0, 0.01, 0.02, 1.5].map(|sigma: f64| sigma * sigma);
        agrees(&state, &radar, &DMatrix::from_diagonal(&noise.to_vec().into()));
        // A position whose errors to the east and to the north are correlated.
        let common = Matrix2::new(400.0, 150.0, 150.0, 90.0);
        let place = [line.x + off.x, line.y + off.y];
        let reported =
            Reading::place_reported(at_origin(0.0, 0), place, &common, Some((line.z + off.z, 12.0)));
        let mut noise = DMatrix::zeros(3, 3);
        noise.view_mut((0, 0), (2, 2)).copy_from(&common);
        noise[(2, 2)] = 144.0;
        agrees(&state, &reported.unwrap(), &noise);
    }
}

#[test]
fn south_of_the_sensor_the_state_is_not_thrown_round_it() {
    let prior = Matrix6::from_diagonal(&[900.0, 900.0, 900.0, 9.0, 9.0, 9.0].into());
    // Expected just east of south, measured just west of it.
    let mut state = gaussian([10.0, -3000.0, 100.0, 0.0, 0.0, 0.0], &prior);
    let fit = whole(
        &mut state,
        &seen_by_radar(at_origin(0.0, 0), &Vector3::new(-10.0, -3000.0, 100.0), &Vector3::zeros()),
    );
    assert!(fit.distance < 1.0, "{fit:?}");
    assert!(
        (-10.0..10.0).contains(&state.mean[0]) && (state.mean[1] + 3000.0).abs() < 1.0,
        "{:?}",
        state.mean
    );
}

#[test]
fn overhead_the_azimuth_is_left_out_and_the_rest_counts() {
    let prior = Matrix6::from_diagonal(&[900.0, 900.0, 900.0, 9.0, 9.0, 9.0].into());
    let state = gaussian([1.0, 2.0, 800.0, 0.0, 0.0, 0.0], &prior);
    let reading = RADAR.reading(at_origin(0.0, 0), [805.0, 2.0, 1.5], Some(0.0)).unwrap();
    let used = usable(&reading, [&state.mean]);
    assert_eq!(used, [true, false, true, true]);
    let mut after = state;
    assert!(apply_reading(&mut after, &reading, &reading.whitening(used).unwrap()).is_some());
    assert!(
        (after.mean[2] - 803.0).abs() < 1.0 && is_covariance(&dense(&after.covariance)),
        "{:?}",
        after.mean
    );
    // With all values there is no update.
    assert!(apply_reading(&mut state.clone(), &reading, &reading.whitening([true; MOST]).unwrap()).is_none());
    // At the position of a camera none of its values is usable, and nothing changes.
    let mut there = gaussian([1.0, 2.0, 3.0, 0.0, 0.0, 0.0], &prior);
    let camera = CAMERA.reading(at_origin(0.0, 0), [1.0, 0.2]).unwrap();
    let used = usable(&camera, [&there.mean]);
    assert_eq!(used[..2], [false, false]);
    let before = there;
    assert!(apply_reading(&mut there, &camera, &camera.whitening(used).unwrap()).is_none());
    assert_eq!(there, before);
}

#[test]
fn rows_that_depend_on_each_other_leave_a_covariance() {
    let east = |sigma| MeasuredValue { quantity: Quantity::East, value: 5.0, sigma };
    for sigma in [1.0, 1e-3, 1e-6] {
        let mut state = gaussian([0.0, 0.0, 100.0, 0.0, 0.0, 0.0], &covariance(&mut rng(5), 1000.0, 30.0));
        let twice = Reading::independent(at_origin(0.0, 0), &[east(sigma); 2]).unwrap();
        for _ in 0..100 {
            whole(&mut state, &twice);
            assert!(is_covariance(&dense(&state.covariance)), "{sigma}");
        }
        assert!((state.mean[0] - 5.0).abs() < 3.0 * sigma);
    }
}

#[test]
fn a_million_updates_leave_a_covariance() {
    let flight = Turning { rates: Vec::new(), noise: 1.0, stays: 1.0 }.models::<1>().unwrap();
    let mut rng = rng(6);
    let mut state = gaussian([2000.0, 1500.0, 300.0, 0.0, 0.0, 0.0], &covariance(&mut rng, 1e4, 300.0));
    let readings: Vec<Reading> = (0..64)
        .map(|number| {
            let fine = 10.0_f64.powi(-(number % 5));
            let position = Vector3::new(2000.0, 1500.0, 300.0) + away(&mut rng, 0.1, 50.0);
            let observer = Observer::at_rest(away(&mut rng, 1.0, 1000.0).into());
            let line = position - observer.position.0;
            let angles = [line.x.atan2(line.y), (line.z / line.norm()).asin()];
            let taken = taken(0.0, 0, observer);
            if number % 2 == 0 {
                CameraModel { azimuth: 1e-3 * fine, elevation: 1e-2 * fine }.reading(taken, angles)
            } else {
                let fine =
                    RadarModel { range_m: fine, azimuth: 1e-2, elevation: 1e-2, range_rate: Some(fine) };
                fine.reading(taken, [line.norm(), angles[0], angles[1]], Some(0.0))
            }
            .unwrap()
        })
        .collect();
    for number in 0..1_000_000_usize {
        whole(&mut state, &readings[number % readings.len()]);
        // The first readings are all of one time; then the aircraft flies on.
        if number > 10_000 && number % 3 == 0 {
            let moved = Mixture { weights: [1.0], parts: [state] };
            let motions = FlightMotion::<6, 1>::motions(&flight, 0.1);
            state = moved.predicted(&state, &motions, &BiasTransition::NONE, &[[1.0]]).1.predicted;
        }
        if number % 1000 == 0 {
            assert!(is_covariance(&dense(&state.covariance)), "after {number}");
        }
    }
    assert!(is_covariance(&dense(&state.covariance)));
}

/// A state with a large error across the line of sight, and an accurate azimuth: the second linearisation follows the
/// arc.
#[test]
fn a_wide_estimate_is_linearised_twice() {
    let prior = Matrix6::from_diagonal(&[4e6, 4e6, 1e4, 25.0, 25.0, 25.0].into());
    let state = gaussian([0.0, 1000.0, 0.0, 0.0, 0.0, 0.0], &prior);
    let truth = Vector3::new(1000.0 * 0.7_f64.sin(), 1000.0 * 0.7_f64.cos(), 0.0);
    let reading = seen_by_radar(at_origin(0.0, 0), &truth, &Vector3::zeros());
    let noise = [20.0, 0.01, 0.02, 1.5].map(|sigma: f64| sigma * sigma);
    let (once, _, expected) = textbook(&state, &reading, &DMatrix::from_diagonal(&noise.to_vec().into()));
    let mut twice = state;
    let fit = whole(&mut twice, &reading);
    let off = |mean: &[f64]| (Vector3::from_row_slice(&mean[..3]) - truth).norm();
    assert!(off(&twice.mean) < 0.5 * off(once.as_slice()), "{} {}", off(&twice.mean), off(once.as_slice()));
    // The agreement refers to the prior.
    assert!((fit.distance / expected.distance - 1.0).abs() < 1e-6);
}
