//! Trackers over whole flights.

use super::*;
use crate::flight::{FlightMotion, WITH_ACCELERATION};
use fusion::filter::Models;
use fusion::settings::Singer;

const SPEED: f64 = 60.0;

/// Straight to the north for 20 s, then left at 3°/s: position and velocity.
fn flown(at: f64) -> (Vector3<f64>, Vector3<f64>) {
    const RATE: f64 = 3.0_f64.to_radians();
    const TURN_S: f64 = 20.0;
    let start = Vector3::new(1500.0, -2000.0, 400.0);
    let (straight, turning) = (at.min(TURN_S), (at - TURN_S).max(0.0) * RATE);
    let radius = SPEED / RATE;
    let position = start
        + Vector3::new(-radius * (1.0 - turning.cos()), SPEED * straight + radius * turning.sin(), 2.0 * at);
    (position, Vector3::new(-SPEED * turning.sin(), SPEED * turning.cos(), 2.0))
}

/// A radar every 2 s, and a camera at another position every 0.3 s.
fn readings() -> Vec<Reading> {
    let camera = Observer::at_rest(Enu::new(3000.0, 200.0, 10.0));
    let mut all: Vec<Reading> = (0..25)
        .map(|scan| f64::from(scan) * 2.0)
        .map(|at| seen_by_radar(at_origin(at, 0), &flown(at).0, &flown(at).1))
        .chain(
            (1..160)
                .map(|frame| f64::from(frame) * 0.3)
                .map(|at| seen_by_camera(taken(at, 1, camera), &flown(at).0)),
        )
        .collect();
    all.sort_by_key(|reading| (reading.origin().time, reading.origin().sensor));
    all
}

fn flights() -> [Flight; 4] {
    [
        Flight::Singer(Singer { lasts_s: 5.0, horizontal: 2.0, vertical: 2.0 }),
        Flight::Drone(Models::default()),
        Flight::Turning(Turning::any(1.0, 0.95)),
        Flight::Turning(Turning { rates: Vec::new(), noise: 1.0, stays: 0.95 }),
    ]
}

fn tracked(flight: &Flight, readings: &[Reading]) -> Tracker {
    let first = TrackerEstimate::first(&readings[0], 100.0).unwrap();
    let mut tracker = Tracker::begin(flight, &first).unwrap();
    for reading in &readings[1..] {
        tracker.update(reading.clone()).unwrap();
    }
    tracker
}

/// Seed 000, section 3.1: exact re-filtering of late data.
#[test]
fn refiltered_late_reading_gives_the_state_of_a_timely_one() {
    let in_time = readings();
    for flight in flights() {
        let expected = tracked(&flight, &in_time);
        let mut rng = rng(7);
        for _ in 0..5 {
            // All except the first, which starts the track, in random order.
            let mut late = in_time.clone();
            for place in (2..late.len()).rev() {
                late.swap(place, rng.random_range(1..=place));
            }
            let shuffled = tracked(&flight, &late);
            for at in [0.0, 7.1, 25.0, 48.0, 50.0] {
                assert_eq!(shuffled.at(seconds(at)), expected.at(seconds(at)), "{flight:?} at {at} s");
                let probabilities = |tracker: &Tracker| tracker.probabilities(seconds(at));
                assert_eq!(probabilities(&shuffled), probabilities(&expected), "{flight:?} at {at} s");
            }
        }
    }
}

#[test]
fn prediction_uses_earlier_readings_only() {
    let all = readings();
    let flight = Flight::Turning(Turning::any(1.0, 0.95));
    let cut = all.iter().position(|reading| reading.origin().time > seconds(25.0)).unwrap();
    let (early, whole) = (tracked(&flight, &all[..cut]), tracked(&flight, &all));
    assert_eq!(early.at(seconds(25.0)), whole.at(seconds(25.0)));
    assert_ne!(early.at(seconds(30.0)), whole.at(seconds(30.0)));
    assert_eq!(whole.at(seconds(-0.1)), None);
}

#[test]
fn reading_older_than_the_history_is_refused() {
    let all = readings();
    let mut tracker = tracked(&flights()[0], &all);
    let before = tracker.at(seconds(49.0));
    tracker.forget_before(seconds(40.0));
    assert_eq!(tracker.at(seconds(49.0)), before);
    let of = |at: f64| seen_by_camera(at_origin(at, 5), &flown(at).0);
    assert_eq!(tracker.update(of(30.0)), Err(TooOld));
    assert_eq!(tracker.at(seconds(49.0)), before);
    assert_eq!(tracker.update(of(45.0)), Ok(()));
    assert_ne!(tracker.at(seconds(49.0)), before);
}

#[test]
fn every_flight_follows_the_aircraft() {
    for flight in flights() {
        let tracker = tracked(&flight, &readings());
        for at in [15.0, 46.0] {
            let TrackerEstimate { position, velocity, covariance, .. } = tracker.at(seconds(at)).unwrap();
            let (there, moving) = flown(at);
            let (off, wrong) = ((position.0 - there).norm(), (velocity - moving).norm());
            assert!(off < 15.0 && wrong < 8.0, "{flight:?} at {at} s: {off} m, {wrong} m/s");
            assert!(is_covariance(&covariance));
        }
    }
}

#[test]
fn left_turn_is_recognised() {
    let tracker = tracked(&Flight::Turning(Turning::any(1.0, 0.95)), &readings());
    let [straight, left] = [15.0, 40.0].map(|at| {
        let likely = tracker.probabilities(seconds(at)).unwrap();
        assert!((likely.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        // Probabilities of straight flight, and of left turns.
        (likely[0], likely[1] + likely[3] + likely[5])
    });
    assert!(straight.0 > 0.5 && left.1 > 0.8, "{straight:?} {left:?}");
}

#[test]
fn gate_width_follows_the_covariance() {
    let tracker = tracked(&flights()[2], &readings());
    let (there, moving) = flown(47.9);
    let expected = seen_by_radar(at_origin(47.9, 0), &there, &moving);
    let (distance, count) = tracker.distance(&expected).unwrap();
    assert!(distance < 1.0 && count == 4, "{distance}");
    let elsewhere = seen_by_radar(at_origin(47.9, 0), &(there + Vector3::new(0.0, 0.0, 600.0)), &moving);
    assert!(tracker.distance(&elsewhere).unwrap().0 > 25.0);
    assert_eq!(tracker.distance(&seen_by_camera(at_origin(-1.0, 1), &there)), None, "before the beginning");
}

#[test]
fn reading_too_close_in_time_is_counted() {
    let all = readings();
    let mut tracker = tracked(&flights()[0], &all);
    assert_eq!(tracker.unused(), 0);
    let there = tracker.at(seconds(48.0)).unwrap().position;
    let below = Observer::at_rest((there.0 - Vector3::new(1.0, 1.0, 80.0)).into());
    tracker.update(CAMERA.reading(taken(48.0, 2, below), [1.0, 1.5]).unwrap()).unwrap();
    assert_eq!(tracker.unused(), 1, "the azimuth from below");
    let inside = Observer::at_rest((there.0 + Vector3::new(1.0, 1.0, 1.0)).into());
    tracker.update(CAMERA.reading(taken(48.0, 3, inside), [1.0, 1.5]).unwrap()).unwrap();
    assert_eq!(tracker.unused(), 3);
}

#[test]
fn there_are_at_most_seven_models() {
    let first = TrackerEstimate::first(&readings()[0], 100.0).unwrap();
    let of = |count: usize| Flight::Turning(Turning { rates: vec![0.1; count], noise: 1.0, stays: 0.9 });
    assert!((0..=6).all(|turns| Tracker::begin(&of(turns), &first).is_some()));
    assert!(Tracker::begin(&of(7), &first).is_none());
}

/// Seed 001, eq. 5 with its first row corrected (left positive, as there): the circle is closed.
#[test]
fn a_turn_is_seed_001_equation_5_put_right() {
    let (omega, dt) = (3.0_f64.to_radians(), 1.7);
    let (sin, cos) = (omega * dt).sin_cos();
    let models = Turning { rates: vec![-omega], noise: 4.0, stays: 0.95 }.models::<2>().unwrap();
    let [_, turn] = FlightMotion::<6, 2>::motions(&models, dt);
    let transition = transition_of(&turn);
    #[rustfmt::skip]
    let put_right = Matrix6::new(
        1.0, 0.0, 0.0, sin / omega,         -(1.0 - cos) / omega, 0.0,
        0.0, 1.0, 0.0, (1.0 - cos) / omega, sin / omega,          0.0,
        0.0, 0.0, 1.0, 0.0,                 0.0,                  dt,
        0.0, 0.0, 0.0, cos,                 -sin,                 0.0,
        0.0, 0.0, 0.0, sin,                 cos,                  0.0,
        0.0, 0.0, 0.0, 0.0,                 0.0,                  1.0,
    );
    assert!((transition - put_right).norm() < 1e-12);
    // Eq. 4: the noise of each model, on each axis.
    let noise = noise_of(&turn);
    let (place, across, rate) = (4.0 * dt.powi(3) / 3.0, 4.0 * dt * dt / 2.0, 4.0 * dt);
    let expected = Matrix6::from_fn(|row, column| match (row / 3, column / 3) {
        _ if row % 3 != column % 3 => 0.0,
        (0, 0) => place,
        (1, 1) => rate,
        _ => across,
    });
    assert!((noise - expected).norm() < 1e-12);
    // Probabilities of changes between models.
    let switch = FlightMotion::<6, 2>::switch(&models, 2.0);
    assert!((switch[0][0] - 0.95 * 0.95).abs() < 1e-12 && (switch[0][0] + switch[0][1] - 1.0).abs() < 1e-12);
}

/// Seed 000, eq. 1: the acceleration of each axis decays by exp(-μT) and moves only that axis.
#[test]
fn singer_carries_each_axis_by_itself() {
    let singer = Singer { lasts_s: 5.0, horizontal: 2.0, vertical: 1.0 };
    let [motion] = FlightMotion::<WITH_ACCELERATION, 1>::motions(&singer, 0.1);
    let transition = transition_of::<WITH_ACCELERATION>(&motion);
    let noise = noise_of::<WITH_ACCELERATION>(&motion);
    let kept = (-0.02_f64).exp();
    for axis in 0..3 {
        let [place, rate, acceleration] = [axis, axis + 3, axis + 6];
        assert!((transition[(acceleration, acceleration)] - kept).abs() < 1e-15);
        assert!((transition[(place, rate)] - 0.1).abs() < 1e-15);
        assert!((transition[(rate, acceleration)] - 0.1).abs() < 0.002);
        let sigma: f64 = if axis < 2 { 2.0 } else { 1.0 };
        let added = sigma * sigma * (1.0 - kept * kept);
        assert!((noise[(acceleration, acceleration)] - added).abs() < 1e-12);
        let of_others = (0..9).filter(|column| column % 3 != axis);
        assert!(of_others.map(|column| transition[(place, column)].abs()).sum::<f64>() == 0.0);
    }
}
