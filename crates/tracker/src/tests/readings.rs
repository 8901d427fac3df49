//! Readings, and the positions that follow from them.

use nalgebra::{Matrix2, matrix};

use super::*;
use fusion::frames::{Geodetic, TangentPlane};

#[test]
fn invalid_measurement_gives_no_reading() {
    let taken = at_origin(0.0, 0);
    assert!(RADAR.reading(taken, [100.0, 0.1, 0.1], Some(3.0)).is_some());
    assert!(RADAR.reading(taken, [f64::NAN, 0.1, 0.1], None).is_none());
    assert!(RADAR.reading(taken, [100.0, 0.1, 0.1], Some(f64::INFINITY)).is_none());
    for sigma in [0.0, f64::NAN, f64::INFINITY] {
        assert!(CameraModel { azimuth: sigma, ..CAMERA }.reading(taken, [0.1, 0.1]).is_none(), "{sigma}");
    }
    let one = MeasuredValue { quantity: Quantity::Range, value: 1.0, sigma: 1.0 };
    assert!(Reading::independent(taken, &[]).is_none());
    assert!(Reading::independent(taken, &[one; 4]).is_some());
    assert!(Reading::independent(taken, &[one; 5]).is_none());
    let nowhere = super::taken(0.0, 0, Observer::at_rest(Enu::new(f64::NAN, 0.0, 0.0)));
    assert!(Reading::independent(nowhere, &[one]).is_none());
    let no_covariance = matrix![1.0, 2.0; 2.0, 1.0];
    assert!(Reading::place_reported(taken, [0.0, 0.0], &no_covariance, None).is_none());
}

/// A position from range and angles; the covariance is compared with central differences.
#[test]
fn radar_reading_gives_position_and_covariance() {
    let mut rng = rng(3);
    for _ in 0..200 {
        let observer = Observer::at_rest(away(&mut rng, 1.0, 5000.0).into());
        let line = away(&mut rng, 100.0, 20_000.0);
        let polar = Vector3::new(line.norm(), line.x.atan2(line.y), (line.z / line.norm()).asin());
        let reading = RADAR.reading(taken(0.0, 0, observer), polar.into(), None).unwrap();
        let (place, covariance) = reading.place().unwrap();
        assert!((place.0 - observer.position.0 - line).norm() < 1e-6);
        let there = |polar: Vector3<f64>| {
            let (along, up) = (polar.x * polar.z.cos(), polar.x * polar.z.sin());
            Vector3::new(along * polar.y.sin(), along * polar.y.cos(), up)
        };
        let steps = Vector3::new(1e-2, 1e-5, 1e-5);
        let ways = Matrix3::from_columns(&[0, 1, 2].map(|axis| {
            let step = Vector3::ith(axis, steps[axis]);
            (there(polar + step) - there(polar - step)) / (2.0 * steps[axis])
        }));
        let noise = Matrix3::from_diagonal(&Vector3::new(20.0, 0.01, 0.02).map(|sigma: f64| sigma * sigma));
        assert!(close(&covariance, &(ways * noise * ways.transpose()), 1e-6));
    }
}

#[test]
fn interrogator_uses_altitude_and_camera_gives_no_position() {
    let interrogator = InterrogatorModel { range_m: 150.0, azimuth: 0.05, altitude_m: 30.0 };
    let observer = Observer::at_rest(Enu::new(10.0, 20.0, 100.0));
    let range = f64::hypot(3000.0, 400.0);
    let reading = interrogator.reading(taken(0.0, 0, observer), [range, -0.5], Some(500.0)).unwrap();
    let (place, covariance) = reading.place().unwrap();
    let expected = Vector3::new(10.0 - 3000.0 * 0.5_f64.sin(), 20.0 + 3000.0 * 0.5_f64.cos(), 500.0);
    assert!((place.0 - expected).norm() < 1e-9);
    assert!((covariance[(2, 2)] - 900.0).abs() < 1e-6, "the height is the altitude's");
    assert!(interrogator.reading(taken(0.0, 0, observer), [range, 0.5], None).unwrap().place().is_none());
    assert!(CAMERA.reading(taken(0.0, 0, observer), [0.5, 0.1]).unwrap().place().is_none());
}

/// A position reported by an aircraft, with its accuracy along parallel and meridian, in the axes of a distant site.
#[test]
fn reported_velocity_is_rotated_by_the_convergence() {
    let site = TangentPlane::at_site(Geodetic::from_degrees(58.0, 10.0, 50.0));
    let aircraft = Geodetic::from_degrees(58.4, 11.5, 900.0);
    let (along_parallel, along_meridian) = (30.0, 6.0);
    let covariance = over_ground(&site, aircraft, along_parallel, along_meridian);
    // Central differences of the conversion from latitude and longitude.
    let (meridian, parallel) = aircraft.curvature_m();
    let way = |latitude: f64, longitude: f64| {
        let at = |sign: f64| {
            let latitude = aircraft.latitude + sign * latitude;
            site.from_geodetic(Geodetic {
                latitude,
                longitude: aircraft.longitude + sign * longitude,
                ..aircraft
            })
            .0
        };
        (at(1.0) - at(-1.0)).xy() / 2.0
    };
    let height = aircraft.height_m;
    let east = way(0.0, 1.0 / ((parallel + height) * aircraft.latitude.cos())) * along_parallel;
    let north = way(1.0 / (meridian + height), 0.0) * along_meridian;
    let expected = east * east.transpose() + north * north.transpose();
    assert!((covariance - expected).norm() < 1e-5 * expected.norm());
    // The convergence is 1.27°, which correlates the errors.
    let convergence = 1.5_f64.to_radians() * 58.4_f64.to_radians().sin();
    let common = convergence.sin() * convergence.cos() * (900.0 - 36.0);
    assert!((covariance[(0, 1)] / common - 1.0).abs() < 0.02, "{covariance} {common}");
    let same = over_ground(&site, aircraft, 10.0, 10.0);
    assert!((same - Matrix2::identity() * 100.0).norm() < 0.1, "equal in both directions it stays a circle");
}

/// Two cameras, compared with many draws of their noise.
#[test]
fn two_bearings_give_position_and_covariance() {
    let position = Vector3::new(400.0, 1500.0, 250.0);
    let observers = [Enu::new(0.0, 0.0, 10.0), Enu::new(900.0, 200.0, 30.0)].map(Observer::at_rest);
    let exact = observers.map(|observer| seen_by_camera(taken(0.0, 1, observer), &position));
    let (place, covariance) = exact[0].crossing(&exact[1]).unwrap();
    assert!((place.0 - position).norm() < 1e-6);
    assert_eq!(TrackerEstimate::crossed([&exact[0], &exact[1]], 20.0).unwrap().position, place);
    let mut rng = rng(8);
    let mut sum = Matrix3::zeros();
    let draws = 20_000;
    for _ in 0..draws {
        let [one, other] = [0, 1].map(|camera| {
            let angles = [0, 1].map(|angle| {
                let sigma = [CAMERA.azimuth, CAMERA.elevation][angle];
                // Uniformly distributed with that deviation.
                exact[camera].values()[angle].1 + sigma * 3.0_f64.sqrt() * rng.random_range(-1.0..1.0)
            });
            CAMERA.reading(*exact[camera].origin(), angles).unwrap()
        });
        let off = one.crossing(&other).unwrap().0.0 - position;
        sum += off * off.transpose() / f64::from(draws);
    }
    // Over ground both lines determine the position; upward the middle between them is nearly optimal.
    let over_ground = |matrix: &Matrix3<f64>| matrix.fixed_view::<2, 2>(0, 0).into_owned();
    assert!((over_ground(&sum) - over_ground(&covariance)).norm() < 0.1 * over_ground(&covariance).norm());
    assert!((0.9..1.3).contains(&(sum[(2, 2)] / covariance[(2, 2)])), "{sum} {covariance}");
}

#[test]
fn nearly_parallel_bearings_give_no_position() {
    let position = Vector3::new(0.0, 2000.0, 100.0);
    let seen_from = |east: f64, north: f64, target: &Vector3<f64>| {
        let observer = Observer::at_rest(Enu::new(east, north, 0.0));
        seen_by_camera(taken(0.0, 1, observer), target)
    };
    let one = seen_from(0.0, 0.0, &position);
    // At 2000 m, 170 m to the side are 4.9 degrees and 180 m are 5.1.
    assert!(one.crossing(&seen_from(170.0, 0.0, &position)).is_none());
    assert!(one.crossing(&seen_from(180.0, 0.0, &position)).is_some());
    assert!(one.crossing(&seen_from(0.0, 100.0, &position)).is_none(), "along one line");
    let apart = seen_from(900.0, 0.0, &Vector3::new(2000.0, 1500.0, 100.0));
    assert!(one.crossing(&apart).is_none(), "they meet behind the sensors");
    let radar = seen_by_radar(at_origin(0.0, 0), &position, &Vector3::zeros());
    assert!(one.crossing(&radar).is_none(), "a radar's reading is no line of sight");
}
