//! Correction of plots.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::{PRIOR, World, values};
use crate::frames::Enu;
use crate::registration::{BiasValue, Correction, Misalignment, Registration};

/// A misalignment that is accurately known.
fn known(bias: &Vector6<f64>) -> Misalignment {
    let value = |index: usize| BiasValue { value: bias[index], deviation: 0.0, observable: true };
    Misalignment {
        bearing: value(0),
        tilt_east: value(1),
        tilt_north: value(2),
        range_m: value(3),
        height_m: value(4),
        time_s: value(5),
        samples: 1.0,
        residual: None,
        left: Matrix6::zeros(),
    }
}

#[test]
fn known_correction_is_applied_in_full() {
    let mut world = World::wrong(1);
    for _ in 0..50 {
        let place =
            Vector3::new(world.between(-4e3, 4e3), world.between(300.0, 4e3), world.between(-20.0, 200.0));
        world.bias = Vector6::from(PRIOR).map(|deviation| deviation * world.normal());
        let correction = Correction::of(&known(&world.bias));
        world.heights = true;
        let corrected = correction.apply(world.plot(place, [0.0; 3]).into()).0;
        assert!((corrected - place).norm() < 1e-8, "{corrected} {place}");
        // An assumed height is kept. Azimuth and range are corrected, except for the effect of the tilts at another height.
        world.heights = false;
        (world.bias[1], world.bias[2]) = (0.0, 0.0);
        let correction = Correction::of(&known(&world.bias));
        let plot = world.plot(place, [0.0; 3]);
        let corrected = correction.apply_without_height(plot.into()).0;
        assert_eq!(corrected.z, plot.z);
        assert!((corrected.norm() - place.norm()).abs() < 1e-8);
        assert!((corrected.x.atan2(corrected.y) - place.x.atan2(place.y)).abs() < 1e-12);
    }
}

#[test]
fn nothing_is_nothing() {
    let plot = Vector3::new(0.1, 1234.567, 8.9);
    let none = Correction::of(&Registration::default().estimate());
    assert_eq!((none.apply(plot.into()).0, none.apply_without_height(plot.into()).0), (plot, plot));
    let remaining = none.remaining(Enu::new(0.0, 3000.0, 0.0));
    assert!(
        (remaining.range_m - 20.0).abs() < 1e-9 && (remaining.azimuth - 5_f64.to_radians()).abs() < 1e-12
    );
    assert!((remaining.height_m - (3000.0 * 1_f64.to_radians()).hypot(15.0)).abs() < 1e-9);
    // Values that are not observable are not corrected.
    let mut estimate = known(&Vector6::repeat(0.01));
    for value in [&mut estimate.bearing, &mut estimate.tilt_east, &mut estimate.tilt_north] {
        value.observable = false;
    }
    for value in [&mut estimate.range_m, &mut estimate.height_m, &mut estimate.time_s] {
        value.observable = false;
    }
    assert_eq!(Correction::of(&estimate).apply(plot.into()).0, plot);
}

/// A plot at the radar itself, and one nearer than the range bias.
#[test]
fn no_place_is_without_an_answer() {
    let correction = Correction::of(&known(&Vector6::from(PRIOR)));
    for plot in [Vector3::zeros(), Vector3::new(0.0, 0.0, 500.0), Vector3::new(1.0, 2.0, 3.0)] {
        assert!(correction.apply(plot.into()).0.iter().all(|x| x.is_finite()));
        assert!(correction.apply_without_height(plot.into()).0.iter().all(|x| x.is_finite()));
    }
}

/// Signs of the parameters, as shown to an operator.
#[test]
fn signs_are_as_said() {
    let seen = |parameter: usize, by: f64, place: [f64; 3]| {
        let mut world = World::new(0);
        world.bias[parameter] = by;
        world.plot(place.into(), [0.0; 3])
    };
    let (north, east) = ([0.0, 1000.0, 0.0], [1000.0, 0.0, 0.0]);
    assert!(seen(0, 0.01, north).x > 9.9, "a bearing too large: north is seen to the east");
    assert!(seen(1, 0.01, north).z > 9.9, "turned about east: north is seen too high");
    assert!(seen(2, 0.01, east).z < -9.9, "turned about north: east is seen too low");
    assert!((seen(3, 10.0, north).y - 1010.0).abs() < 1e-9);
    assert!((seen(4, 10.0, north).z - 10.0).abs() < 1e-9);
    // The estimate has the same sign: plots of moving tracks lie ahead.
    let mut world = World::new(1);
    world.bias = Vector6::new(0.05, 0.01, -0.01, 15.0, 10.0, 0.5);
    let estimate = world.estimate(60);
    for (value, bias) in values(&estimate).iter().zip(&world.bias) {
        assert!(value.value * bias > 0.0 && value.observable, "{value:?} {bias}");
    }
}

/// The remaining misalignment has the stated size, over many radars and positions.
#[test]
fn remaining_error_matches_its_covariance() {
    let (mut squares, mut count) = ([0.0; 3], 0.0);
    for seed in 0..120 {
        let mut world = World::wrong(seed);
        world.bias[5] = 0.0;
        world.heights = true;
        let tracks = if seed % 2 == 0 { 6 } else { 40 };
        let correction = Correction::of(&world.estimate(tracks));
        for _ in 0..20 {
            let (azimuth, range_m) =
                (world.between(0.0, std::f64::consts::TAU), world.between(400.0, 4000.0));
            let place = Vector3::new(range_m * azimuth.sin(), range_m * azimuth.cos(), 60.0);
            let corrected = correction.apply(world.plot(place, [0.0; 3]).into());
            let remaining = correction.remaining(corrected);
            let turned = super::super::along::wrapped(corrected.0.x.atan2(corrected.0.y) - azimuth);
            squares[0] += (turned / remaining.azimuth).powi(2);
            squares[1] += ((corrected.0.norm() - place.norm()) / remaining.range_m).powi(2);
            squares[2] += ((corrected.0.z - place.z) / remaining.height_m).powi(2);
            count += 1.0;
        }
    }
    let found = squares.map(|square| square / count);
    println!("azimuth, range, height: {found:.2?}");
    assert!(found.iter().all(|square| (0.7..1.35).contains(square)), "{found:?}");
}
