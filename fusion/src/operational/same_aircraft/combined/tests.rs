use nalgebra::Vector3;

use super::*;

/// A position at this distance east, with this standard deviation of each axis and this time between reports.
fn part(east_m: f64, sigma_m: f64, gap_s: f64) -> TransponderShare {
    let variance = sigma_m * sigma_m;
    TransponderShare {
        position: Enu::new(east_m, 0.0, 100.0),
        estimate: Estimate {
            velocity: Vector3::new(east_m, 0.0, 0.0),
            horizontal: Matrix2::identity() * variance,
            vertical_m2: variance,
            velocity_covariance: Matrix2::identity(),
            position_velocity: Matrix2::zeros(),
            height_climb: 0.0,
            climb_m2s2: 1.0,
            lie_m2: 0.0,
            basis: Basis::Interpolated,
            last_measurement: None,
        },
        gap_s,
    }
}

#[test]
fn equal_positions_are_averaged_and_keep_their_variance() {
    let (position, estimate) = combined(&[part(0.0, 2.0, 1.0), part(3.0, 2.0, 1.0)]).unwrap();
    assert!((position.east() - 1.5).abs() < 1e-9 && (position.up() - 100.0).abs() < 1e-9);
    assert!((estimate.velocity.x - 1.5).abs() < 1e-9);
    assert!((estimate.sigma_m() - 2.0).abs() < 1e-9 && (estimate.climb_m2s2 - 1.0).abs() < 1e-9);
}

#[test]
fn far_poorer_position_hardly_counts() {
    let (position, _) = combined(&[part(0.0, 2.0, 1.0), part(30.0, 20.0, 1.0)]).unwrap();
    assert!(position.east() < 0.01, "{}", position.east());
}

#[test]
fn position_in_a_gap_hardly_counts() {
    let (position, _) = combined(&[part(0.0, 2.0, 1.0), part(10.0, 2.0, 10.0)]).unwrap();
    assert!(position.east() < 0.05, "{}", position.east());
    // In a gap of both their weights are equal.
    let (position, _) = combined(&[part(0.0, 2.0, f64::INFINITY), part(10.0, 2.0, f64::INFINITY)]).unwrap();
    assert!((position.east() - 5.0).abs() < 1e-9);
}

#[test]
fn single_position_is_left_as_it_is() {
    let one = part(3.0, 2.0, 1.0);
    assert_eq!(combined(&[one]), Some((one.position, one.estimate)));
    assert_eq!(combined(&[]), None);
}
