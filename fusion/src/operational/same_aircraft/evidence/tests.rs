use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::time::SECOND;

/// Standard deviation of each receiver's persistent error, each axis, metres.
const GNSS_M: f64 = 1.8;

fn at(second: u32) -> Time {
    Time::from_nanos(i64::from(second) * SECOND)
}

/// Persistent errors of two receivers: first-order Gauss–Markov processes with a correlation time of a minute.
struct Errors {
    random: ChaCha8Rng,
    sigma_m: f64,
    slow: Vector2<f64>,
}

impl Errors {
    fn new(seed: u64, sigma_m: f64) -> Self {
        let mut errors = Self { random: ChaCha8Rng::seed_from_u64(seed), sigma_m, slow: Vector2::zeros() };
        errors.slow = errors.normal() * errors.both_m();
        errors
    }

    fn both_m(&self) -> f64 {
        self.sigma_m * std::f64::consts::SQRT_2
    }

    fn normal(&mut self) -> Vector2<f64> {
        let mut normal = || (0..12).map(|_| self.random.random_range(0.0..1.0_f64)).sum::<f64>() - 6.0;
        Vector2::new(normal(), normal())
    }

    fn next(&mut self) -> Vector2<f64> {
        let kept = (-1.0 / 60.0_f64).exp();
        self.slow = self.slow * kept + self.normal() * self.both_m() * (1.0 - kept * kept).sqrt();
        self.slow + self.normal() * 0.7
    }
}

/// A look at two aircraft at 10 m/s with this distance, by receivers with errors of this standard deviation.
fn look(second: u32, apart: Vector2<f64>, sigma_m: f64) -> TransponderComparison {
    TransponderComparison {
        time: at(second),
        apart,
        slow: Matrix2::identity() * (2.0 * sigma_m * sigma_m),
        white_m2: 1.0,
        height: Some((1.0, 16.0)),
        flown_m: 10.0,
        crowd: 0.0,
        is_seen_twice: false,
    }
}

/// Number of seconds after which two are linked, for flights of this length and distance; `None`: never.
fn linked_after(seed: u64, apart: Vector2<f64>, seconds: u32, crowd: f64) -> Option<u32> {
    let mut errors = Errors::new(seed, GNSS_M);
    let mut evidence = SameAircraftEvidence::new(at(0));
    (0..seconds).find(|&second| {
        let look = look(second, apart + errors.next(), GNSS_M);
        evidence.observe(&TransponderComparison { crowd, ..look });
        evidence.is_linked()
    })
}

/// Evidence of a link after a minute of agreement.
fn linked() -> SameAircraftEvidence {
    let mut evidence = SameAircraftEvidence::new(at(0));
    (0..60).for_each(|second| evidence.observe(&look(second, Vector2::new(1.0, 1.0), GNSS_M)));
    assert!(evidence.is_linked());
    evidence
}

#[test]
fn one_aircraft_is_linked_within_a_minute() {
    let antenna = Vector2::new(1.0, 0.5);
    let linked = (0..100).filter(|&seed| linked_after(seed, antenna, 60, 0.0).is_some()).count();
    assert!(linked >= 95, "{linked} of 100");
    let later = (0..100).filter(|&seed| linked_after(seed, antenna, 120, 0.0).is_some()).count();
    assert!(later >= 98, "{later} of 100");
}

#[test]
fn link_takes_three_quarters_of_a_minute() {
    let first = (0..20).filter_map(|seed| linked_after(seed, Vector2::zeros(), 120, 0.0)).min();
    assert_eq!(first, Some(45));
}

#[test]
fn swarm_neighbours_are_never_linked() {
    // 15 m apart for five minutes, among ten others.
    let wrong: Vec<u64> =
        (0..200).filter(|&seed| linked_after(seed, Vector2::new(15.0, 0.0), 300, 10.0).is_some()).collect();
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn lone_pair_of_15_m_is_hardly_ever_linked() {
    let wrong = (0..200).filter(|&seed| linked_after(seed, Vector2::new(15.0, 0.0), 300, 0.0).is_some());
    assert!(wrong.count() <= 2);
}

#[test]
fn close_pair_with_good_receivers_is_not_linked() {
    let mut evidence = SameAircraftEvidence::new(at(0));
    for second in 0..300 {
        evidence.observe(&look(second, Vector2::new(4.0, 0.0), 0.5));
        assert!(!evidence.is_linked(), "{second}");
    }
}

#[test]
fn poor_receivers_in_a_swarm_are_not_linked() {
    let mut evidence = SameAircraftEvidence::new(at(0));
    for second in 0..600 {
        evidence.observe(&TransponderComparison { crowd: 10.0, ..look(second, Vector2::zeros(), 10.0) });
    }
    assert!(!evidence.is_linked());
}

#[test]
fn hovering_pair_is_not_linked() {
    let mut evidence = SameAircraftEvidence::new(at(0));
    (0..600).for_each(|second| {
        evidence.observe(&TransponderComparison { flown_m: 0.0, ..look(second, Vector2::zeros(), GNSS_M) });
    });
    assert!(!evidence.is_linked());
}

#[test]
fn aircraft_above_each_other_are_not_linked() {
    let mut evidence = SameAircraftEvidence::new(at(0));
    let above = |second| TransponderComparison {
        height: Some((15.0, 16.0)),
        ..look(second, Vector2::zeros(), GNSS_M)
    };
    (0..300).for_each(|second| evidence.observe(&above(second)));
    assert!(!evidence.is_linked());
}

#[test]
fn unknown_height_does_not_hinder_a_link() {
    let mut evidence = SameAircraftEvidence::new(at(0));
    (0..60).for_each(|second| {
        evidence.observe(&TransponderComparison { height: None, ..look(second, Vector2::zeros(), GNSS_M) });
    });
    assert!(evidence.is_linked());
}

#[test]
fn link_ends_three_looks_after_the_two_come_apart() {
    let mut evidence = linked();
    for (second, is_linked) in [(60, true), (61, true), (62, false)] {
        evidence.observe(&look(second, Vector2::new(20.0, 0.0), GNSS_M));
        assert_eq!(evidence.is_linked(), is_linked, "{second}");
    }
    // Earlier looks do not count again.
    (63..100).for_each(|second| evidence.observe(&look(second, Vector2::zeros(), GNSS_M)));
    assert!(!evidence.is_linked());
}

#[test]
fn single_outlier_does_not_end_a_link() {
    let mut evidence = linked();
    evidence.observe(&look(60, Vector2::new(40.0, 0.0), GNSS_M));
    evidence.observe(&look(61, Vector2::new(1.0, 1.0), GNSS_M));
    assert!(evidence.is_linked());
}

#[test]
fn offset_that_persists_ends_a_link() {
    let mut evidence = linked();
    let ends = (60..300).find(|&second| {
        evidence.observe(&look(second, Vector2::new(11.0, 0.0), GNSS_M));
        !evidence.is_linked()
    });
    assert!(ends.is_some_and(|second| second < 200), "{ends:?}");
}

#[test]
fn two_radar_tracks_for_ten_seconds_end_a_link() {
    let mut evidence = linked();
    for second in 60..70 {
        assert!(evidence.is_linked(), "{second}");
        evidence.observe(&TransponderComparison {
            is_seen_twice: true,
            ..look(second, Vector2::zeros(), GNSS_M)
        });
    }
    assert!(!evidence.is_linked());
}
