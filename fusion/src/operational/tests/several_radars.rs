//! Drones without a transponder that several radars detect at the same time.

use nalgebra::Vector3;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::frames::RadarFrame;
use crate::settings::{Radar, RegistrationMode, Sensor};

/// Positions of the radars: the lines of sight of the first two cross at a right angle above [`MIDDLE`].
const RADARS: [Enu; 3] = [Enu::new(0.0, 0.0, 0.0), Enu::new(3000.0, 0.0, 0.0), Enu::new(1500.0, 3500.0, 0.0)];
const MIDDLE: Enu = Enu::new(1500.0, 1500.0, 100.0);
/// Bias of each radar in range, metres, and azimuth, radians.
const BIASES: [(f64, f64); 3] = [(4.0, 0.018), (-3.0, 0.02), (3.0, -0.015)];
/// Time after a slot whose plots are known when it is published, seconds.
const AHEAD_S: f64 = 6.0;

/// A track of a radar: its number, its start and end, and the path it follows.
struct Track<'a> {
    radar: usize,
    number: u16,
    seconds: std::ops::Range<f64>,
    place: &'a dyn Fn(f64) -> Vector3<f64>,
}

/// Published points of the slots. `order` is the seed of the order of plots between two deadlines.
fn published(tracks: &[Track], seconds: f64, order: u64) -> Vec<(f64, Vec<Point>)> {
    let radar = |place: &Enu| {
        let frame = RadarFrame::parallel(*place);
        Sensor::Radar(Radar { frame, registration: RegistrationMode::Off, ..Radar::default() })
    };
    let sensors: Vec<Sensor> = RADARS.iter().map(radar).collect();
    let mut case = Case::new();
    case.settings = OperationalSettings::new(&sensors, LATENCY, &OperationalRules::default());
    let mut noise = ChaCha8Rng::seed_from_u64(7);
    let mut plots: Vec<Plot> = Vec::new();
    for track in tracks {
        let count = ((track.seconds.end - track.seconds.start) * 4.0) as u32;
        for index in 0..count {
            // No two radars measure at the same time.
            let second = track.seconds.start + 0.25 * f64::from(index) + 0.07 * track.radar as f64;
            let (range_m, azimuth) = BIASES[track.radar];
            let place = (track.place)(second);
            let away = place - RADARS[track.radar].0;
            let across = Vector3::new(away.y, -away.x, 0.0) * azimuth;
            let mut white = |most: f64| noise.random_range(-most..most);
            let white = Vector3::new(white(2.0), white(2.0), white(4.0));
            plots.push(Plot {
                uav_probability: Some(0.95),
                ..Plot::new(
                    RadarTrackKey { sensor: SensorIndex(track.radar as u16), number: track.number },
                    at(second),
                    Enu::from(place + away.normalize() * range_m + across + white),
                    away.norm(),
                )
            });
        }
    }
    let mut order = ChaCha8Rng::seed_from_u64(order);
    case.publish(0.0, seconds, |case, second| {
        let is_known = |plot: &Plot| plot.time <= at(second + AHEAD_S);
        let mut known: Vec<Plot> = plots.extract_if(.., |plot| is_known(plot)).collect();
        known.shuffle(&mut order);
        known.into_iter().for_each(|plot| case.air.handle(Report::Plot(plot)));
    })
}

/// Eastward at 12 m/s, above the middle after 15 s.
fn flight(second: f64) -> Vector3<f64> {
    MIDDLE.0 + Vector3::new(12.0 * (second - 15.0), 0.0, 0.0)
}

/// Mean error over ground between two times, metres.
fn error_m(slots: &[(f64, Vec<Point>)], from_s: f64, to_s: f64) -> f64 {
    let errors: Vec<f64> = slots
        .iter()
        .filter(|(second, _)| (from_s..to_s).contains(second))
        .flat_map(|(second, points)| {
            points.iter().map(|point| (point.position.0 - flight(*second)).xy().norm())
        })
        .collect();
    errors.iter().sum::<f64>() / errors.len() as f64
}

/// The numbers published between two times, slot by slot, without repetition.
fn numbers(slots: &[(f64, Vec<Point>)], from_s: f64, to_s: f64) -> Vec<Vec<u32>> {
    let within = slots.iter().filter(|(second, _)| (from_s..to_s).contains(second));
    let mut numbers: Vec<Vec<u32>> =
        within.map(|(_, points)| points.iter().map(|point| point.number).collect()).collect();
    numbers.dedup();
    numbers
}

#[test]
fn two_ranges_that_cross_beat_an_azimuth() {
    let track = |radar| Track { radar, number: 5 + radar as u16, seconds: 2.0..30.0, place: &flight };
    let one = published(&[track(0)], 28.0, 0);
    let both = published(&[track(0), track(1)], 28.0, 0);
    let (one_m, both_m) = (error_m(&one, 4.0, 26.0), error_m(&both, 4.0, 26.0));
    assert!(one_m > 20.0 && both_m < 0.4 * one_m, "{one_m} m, both {both_m} m");
    assert_eq!(numbers(&both, 4.0, 26.0), [[5]]);
}

#[test]
fn radars_begin_and_end_by_themselves() {
    let track = |radar, number, seconds| Track { radar, number, seconds, place: &flight };
    let tracks = [
        track(0, 5, 2.0..14.0),
        track(1, 6, 10.0..24.0),
        track(2, 7, 16.0..20.0),
        track(0, 8, 20.0..40.0),
        track(2, 9, 26.0..40.0),
    ];
    let slots = published(&tracks, 36.0, 0);
    assert_eq!(numbers(&slots, 3.0, 34.0), [[5]]);
}

#[test]
fn lone_radar_target_is_kept_by_future_track_of_another_radar() {
    // The azimuth of the remaining radar wanders meanwhile.
    let wandering = |second: f64| {
        let off_m = 9.0 * (second - 14.0).clamp(0.0, 6.0);
        flight(second) + Vector3::new(off_m, -off_m, 0.0) * std::f64::consts::FRAC_1_SQRT_2
    };
    let track = |number, seconds| Track { radar: 1, number, seconds, place: &flight };
    let left = || Track { radar: 0, number: 5, seconds: 2.0..40.0, place: &wandering };
    let alone = published(&[left(), track(6, 2.0..14.0)], 36.0, 0);
    let again = published(&[left(), track(6, 2.0..14.0), track(7, 20.0..40.0)], 36.0, 0);
    // Tracks are used up to four seconds ahead: then two seconds of the new track are known.
    let (alone_m, again_m) = (error_m(&alone, 17.0, 20.0), error_m(&again, 17.0, 20.0));
    assert!(alone_m > 8.0 && again_m < 0.85 * alone_m, "{alone_m} m, bridged {again_m} m");
    assert_eq!(numbers(&again, 4.0, 34.0), [[5]]);
}

#[test]
fn merged_aircraft_keeps_the_older_number() {
    // The second radar's track has a large error at first.
    let astray = |second: f64| flight(second) + Vector3::new(0.0, (350.0 - 20.0 * second).max(0.0), 0.0);
    let tracks = [
        Track { radar: 0, number: 5, seconds: 2.0..40.0, place: &flight },
        Track { radar: 1, number: 6, seconds: 2.0..40.0, place: &astray },
    ];
    let slots = published(&tracks, 36.0, 0);
    assert_eq!(numbers(&slots, 4.0, 6.0), [[5, 6]]);
    assert_eq!(numbers(&slots, 30.0, 34.0), [[5]]);
}

#[test]
fn separating_tracks_are_split() {
    // Each radar detects one of two drones that fly together until they separate.
    let other = |second: f64| flight(second) + Vector3::new(0.0, (15.0 * (second - 15.0)).max(0.0), 0.0);
    let tracks = [
        Track { radar: 0, number: 5, seconds: 2.0..50.0, place: &flight },
        Track { radar: 1, number: 6, seconds: 2.0..50.0, place: &other },
    ];
    let slots = published(&tracks, 46.0, 0);
    assert_eq!(numbers(&slots, 5.0, 14.0), [[5]]);
    assert_eq!(numbers(&slots, 42.0, 45.0), [[5, 6]]);
}

/// Decisions depend on the reports received before a slot's deadline, not on their order.
#[test]
fn the_order_between_two_deadlines_plays_no_part() {
    let other = |second: f64| flight(second) + Vector3::new(5.0, 60.0 - 9.0 * second, 10.0);
    let track = |radar, number, seconds, place| Track { radar, number, seconds, place };
    let tracks: [Track; 6] = [
        track(0, 5, 2.0..14.0, &flight),
        track(1, 6, 4.0..24.0, &flight),
        track(2, 7, 3.0..30.0, &flight),
        track(0, 8, 17.0..30.0, &flight),
        track(1, 9, 2.0..30.0, &other),
        track(2, 10, 9.0..21.0, &other),
    ];
    let first = published(&tracks, 28.0, 0);
    for order in 1..6 {
        assert_eq!(published(&tracks, 28.0, order), first, "{order}");
    }
    assert!(first.iter().any(|(_, points)| points.len() > 1));
}
