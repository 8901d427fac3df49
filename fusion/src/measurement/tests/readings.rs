//! What a reading is, and where it says that an aircraft is.

use nalgebra::{Matrix2, matrix};

use super::*;
use crate::frames::{Geodetic, TangentPlane};

#[test]
fn what_is_no_measurement_is_no_reading() {
    let taken = at_origin(0.0, 0);
    assert!(RADAR.reading(taken, [100.0, 0.1, 0.1], Some(3.0)).is_some());
    assert!(RADAR.reading(taken, [f64::NAN, 0.1, 0.1], None).is_none());
    assert!(RADAR.reading(taken, [100.0, 0.1, 0.1], Some(f64::INFINITY)).is_none());
    for sigma in [0.0, f64::NAN, f64::INFINITY] {
        assert!(Camera { azimuth: sigma, ..CAMERA }.reading(taken, [0.1, 0.1]).is_none(), "{sigma}");
    }
    let one = Measured { quantity: Quantity::Range, value: 1.0, sigma: 1.0 };
    assert!(Reading::independent(taken, &[]).is_none());
    assert!(Reading::independent(taken, &[one; 4]).is_some());
    assert!(Reading::independent(taken, &[one; 5]).is_none());
    let nowhere = super::taken(0.0, 0, Observer::at_rest(Enu::new(f64::NAN, 0.0, 0.0)));
    assert!(Reading::independent(nowhere, &[one]).is_none());
    let no_covariance = matrix![1.0, 2.0; 2.0, 1.0];
    assert!(Reading::place_reported(taken, [0.0, 0.0], &no_covariance, None).is_none());
}

/// A place from range and angles, with the covariance by central differences of the way there.
#[test]
fn a_radar_says_where_an_aircraft_is_and_how_well() {
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
fn an_interrogator_takes_the_altitude_and_a_camera_says_no_place() {
    let interrogator = Interrogator { range_m: 150.0, azimuth: 0.05, altitude_m: 30.0 };
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

/// A position that an aircraft reports, with its accuracy along parallel and meridian, in the axes of a site far away.
#[test]
fn what_an_aircraft_reports_is_turned_with_the_convergence() {
    let site = TangentPlane::at_site(Geodetic::from_degrees(58.0, 10.0, 50.0));
    let aircraft = Geodetic::from_degrees(58.4, 11.5, 900.0);
    let (along_parallel, along_meridian) = (30.0, 6.0);
    let covariance = over_ground(&site, aircraft, along_parallel, along_meridian);
    // Central differences of the way from latitude and longitude.
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
    // The convergence is 1.27°, and the errors have that in common.
    let convergence = 1.5_f64.to_radians() * 58.4_f64.to_radians().sin();
    let common = convergence.sin() * convergence.cos() * (900.0 - 36.0);
    assert!((covariance[(0, 1)] / common - 1.0).abs() < 0.02, "{covariance} {common}");
    let same = over_ground(&site, aircraft, 10.0, 10.0);
    assert!((same - Matrix2::identity() * 100.0).norm() < 0.1, "equal in both directions it stays a circle");
}

/// Two cameras, against many draws of their noise.
#[test]
fn two_lines_of_sight_say_where_an_aircraft_is_and_how_well() {
    let position = Vector3::new(400.0, 1500.0, 250.0);
    let observers = [Enu::new(0.0, 0.0, 10.0), Enu::new(900.0, 200.0, 30.0)].map(Observer::at_rest);
    let exact = observers.map(|observer| seen_by_camera(taken(0.0, 1, observer), &position));
    let (place, covariance) = exact[0].crossing(&exact[1]).unwrap();
    assert!((place.0 - position).norm() < 1e-6);
    assert_eq!(Estimate::crossed([&exact[0], &exact[1]], 20.0).unwrap().position, place);
    let mut rng = rng(8);
    let mut sum = Matrix3::zeros();
    let draws = 20_000;
    for _ in 0..draws {
        let [one, other] = [0, 1].map(|camera| {
            let angles = [0, 1].map(|angle| {
                let sigma = [CAMERA.azimuth, CAMERA.elevation][angle];
                // Uniform, of that deviation.
                exact[camera].values()[angle].1 + sigma * 3.0_f64.sqrt() * rng.random_range(-1.0..1.0)
            });
            CAMERA.reading(*exact[camera].taken(), angles).unwrap()
        });
        let off = one.crossing(&other).unwrap().0.0 - position;
        sum += off * off.transpose() / f64::from(draws);
    }
    // Over ground both lines decide; upward the nearest way between them is about the best there is.
    let over_ground = |matrix: &Matrix3<f64>| matrix.fixed_view::<2, 2>(0, 0).into_owned();
    assert!((over_ground(&sum) - over_ground(&covariance)).norm() < 0.1 * over_ground(&covariance).norm());
    assert!((0.9..1.3).contains(&(sum[(2, 2)] / covariance[(2, 2)])), "{sum} {covariance}");
}

#[test]
fn lines_of_sight_that_hardly_cross_say_no_place() {
    let position = Vector3::new(0.0, 2000.0, 100.0);
    let seen_from = |east: f64, north: f64, target: &Vector3<f64>| {
        let observer = Observer::at_rest(Enu::new(east, north, 0.0));
        seen_by_camera(taken(0.0, 1, observer), target)
    };
    let one = seen_from(0.0, 0.0, &position);
    // 2000 m away, 170 m to the side are 4.9 degrees and 180 m are 5.1.
    assert!(one.crossing(&seen_from(170.0, 0.0, &position)).is_none());
    assert!(one.crossing(&seen_from(180.0, 0.0, &position)).is_some());
    assert!(one.crossing(&seen_from(0.0, 100.0, &position)).is_none(), "along one line");
    let apart = seen_from(900.0, 0.0, &Vector3::new(2000.0, 1500.0, 100.0));
    assert!(one.crossing(&apart).is_none(), "they meet behind the sensors");
    let radar = seen_by_radar(at_origin(0.0, 0), &position, &Vector3::zeros());
    assert!(one.crossing(&radar).is_none(), "a radar's reading is no line of sight");
}
