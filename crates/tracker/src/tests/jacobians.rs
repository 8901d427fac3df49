//! Expected values and Jacobian rows of single quantities.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::*;

const ALL: [Quantity; 7] = [
    Quantity::Range,
    Quantity::Azimuth,
    Quantity::Elevation,
    Quantity::RangeRate,
    Quantity::East,
    Quantity::North,
    Quantity::Altitude,
];

#[test]
fn every_row_is_the_derivative_at_ten_thousand_geometries() {
    let mut rng = rng(1);
    for _ in 0..10_000 {
        let position = away(&mut rng, 1.0, 30_000.0);
        let observer = Observer {
            position: (position + away(&mut rng, 6.0, 50_000.0)).into(),
            velocity: away(&mut rng, 1.0, 100.0),
        };
        let velocity = away(&mut rng, 1.0, 300.0);
        let line = position - observer.position.0;
        let (range, ground) = (line.norm(), line.xy().norm());
        for quantity in ALL {
            let Some(expected) = quantity.expected(&observer, &position, &velocity) else {
                assert!(quantity == Quantity::Azimuth && ground < 5.0, "{quantity:?} at {line}");
                continue;
            };
            // A step within which the quantity is linear: an angle bends within its distance over ground.
            let step = match quantity {
                Quantity::Azimuth | Quantity::Elevation => 1e-4 * ground,
                _ => 1e-4 * range,
            };
            let by = |step: f64, change: &dyn Fn(Vector3<f64>) -> (Vector3<f64>, Vector3<f64>)| {
                Vector3::from_fn(|axis, _| {
                    let [after, before] = [step, -step].map(|step| {
                        let (position, velocity) = change(Vector3::ith(axis, step));
                        quantity.expected(&observer, &position, &velocity).unwrap().value
                    });
                    quantity.innovation(after, before) / (2.0 * step)
                })
            };
            if quantity == Quantity::Azimuth && ground < 5.01 {
                continue;
            }
            let by_position = by(step, &|moved| (position + moved, velocity));
            let by_velocity = by(1.0, &|moved| (position, velocity + moved));
            let off = (by_position - expected.by_position).norm();
            assert!(off <= 1e-6 * expected.by_position.norm(), "{quantity:?} at {line}: {off:e}");
            let off = (by_velocity - expected.by_velocity).norm();
            assert!(off <= 1e-6 * expected.by_velocity.norm(), "{quantity:?} at {line}: {off:e}");
        }
    }
}

#[test]
fn values_are_those_of_a_known_triangle() {
    let observer = Observer { position: Enu::new(100.0, 50.0, 20.0), velocity: Vector3::new(0.0, 10.0, 0.0) };
    let position = Vector3::new(100.0 + 300.0, 50.0 - 400.0, 20.0 + 1200.0);
    let velocity = Vector3::new(30.0, 10.0, 0.0);
    let value = |quantity: Quantity| quantity.expected(&observer, &position, &velocity).unwrap().value;
    assert!((value(Quantity::Range) - 1300.0).abs() < 1e-9);
    // South-east: clockwise from north, 90° and the angle whose tangent is 4/3.
    assert!((value(Quantity::Azimuth).to_degrees() - 143.130_102_354_155_97).abs() < 1e-9);
    assert!((value(Quantity::Elevation).to_degrees() - 67.380_135_051_959_57).abs() < 1e-9);
    // The sensor's own 10 m/s northward equals the aircraft's.
    assert!((value(Quantity::RangeRate) - 300.0 * 30.0 / 1300.0).abs() < 1e-9);
    assert_eq!([Quantity::East, Quantity::North, Quantity::Altitude].map(value), [400.0, -350.0, 1220.0]);
}

#[test]
fn an_angle_is_above_minus_pi_and_up_to_pi() {
    for (angle, expected) in [(0.0, 0.0), (PI, PI), (-PI, PI), (1.5 * PI, -FRAC_PI_2), (-3.5 * PI, FRAC_PI_2)]
    {
        assert!((wrapped(angle) - expected).abs() < 1e-12, "{angle}");
    }
    let mut rng = rng(2);
    for _ in 0..1000 {
        let (angle, turns) = (rng.random_range(-3.0..3.0), f64::from(rng.random_range(-9..9)));
        assert!((wrapped(angle + turns * TAU) - angle).abs() < 1e-12, "{angle} and {turns} turns");
    }
}

#[test]
fn an_azimuth_to_the_south_is_measured_the_short_way_round() {
    let innovation = Quantity::Azimuth.innovation(179.5_f64.to_radians(), -179.5_f64.to_radians());
    assert!((innovation.to_degrees() + 1.0).abs() < 1e-12);
    assert_eq!(Quantity::Range.innovation(7.0, 3.0), 4.0, "what is no angle is not wrapped");
}

#[test]
fn uninformative_quantity_near_the_sensor_is_omitted() {
    let observer = Observer::at_rest(Enu::new(0.0, 0.0, 0.0));
    let velocity = Vector3::new(10.0, 0.0, 0.0);
    let says = |position: Vector3<f64>| {
        ALL.map(|quantity| quantity.expected(&observer, &position, &velocity).is_some())
    };
    let (yes, no) = (true, false);
    assert_eq!(says(Vector3::new(4.0, 3.01, 0.0)), [yes; 7]);
    assert_eq!(says(Vector3::new(3.0, 3.9, 800.0)), [yes, no, yes, yes, yes, yes, yes], "overhead");
    assert_eq!(says(Vector3::new(2.0, 2.0, 4.0)), [no, no, no, no, yes, yes, yes], "at the sensor");
    let above = Vector3::new(0.0, 0.0, 800.0);
    let straight_up = Quantity::Elevation.expected(&observer, &above, &velocity).unwrap();
    assert_eq!((straight_up.value, straight_up.by_position), (FRAC_PI_2, Vector3::zeros()));
}
