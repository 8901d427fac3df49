//! Scores of two drones flying head on, with predictions made by hand.

use super::*;
use crate::evaluate::labels::Label;
use crate::evaluate::place::GeodeticPlace;
use crate::evaluate::types::{PointFlags, PointSource};

const START_NS: i64 = 1_773_478_800 * SECOND;
const STEP_NS: i64 = SECOND / 4;
/// Time at which the drones meet, seconds.
const MEET_S: f64 = 60.0;
/// Duration of the flight, seconds.
const FLOWN_S: i64 = 130;
const IDS: [&str; 2] = ["A", "B"];

fn at(seconds: f64) -> Time {
    Time::from_nanos(START_NS + (seconds * SECOND as f64) as i64)
}

/// Place on the equator, where a degree of longitude is 111,319.49 m.
fn east(metres: f64) -> GeodeticPlace {
    GeodeticPlace { latitude_deg: 0.0, longitude_deg: metres / 111_319.49, altitude_amsl_m: Some(100.0) }
}

/// Each drone flies at 10 m/s towards the other.
fn place(drone: usize, time_s: f64) -> GeodeticPlace {
    let side = if drone == 0 { 1.0 } else { -1.0 };
    east(side * 10.0 * (time_s - MEET_S))
}

fn times() -> impl Iterator<Item = f64> {
    (0..FLOWN_S * SECOND / STEP_NS).map(|step| step as f64 / 4.0)
}

fn point(drone: usize, time_s: f64) -> OutputPoint {
    OutputPoint {
        time: at(time_s),
        place: place(drone, time_s),
        source: PointSource::Transponder,
        number: 10_000 * (drone as u32 + 1),
        radar_track: None,
        sensor: None,
        transponder: Some(drone as u32 + 1),
        identity: None,
        covariance: None,
        flags: PointFlags::default(),
    }
}

fn label(drone: usize, time_s: f64) -> Label {
    Label {
        time: at(time_s),
        sensor: "receiver".to_owned(),
        number: drone as u32 + 1,
        id: Some(IDS[drone].to_owned()),
        seduced: false,
        identity: None,
    }
}

/// A prediction for each second: an advisory, then a warning from `warned_s` on.
fn foreseen(warned_s: f64, numbers: [u32; 2]) -> Vec<ConflictPrediction> {
    let each = |second: i64| {
        let time_s = second as f64;
        ConflictPrediction {
            time: at(time_s),
            is_seen: true,
            id: Some(1),
            numbers,
            level: Some(if time_s >= warned_s { Level::Warning } else { Level::Advisory }),
            t_cpa_s: MEET_S - time_s,
            t_entry_s: (MEET_S - time_s - 2.5).max(0.0),
            probability: 0.95,
            across: (0.0, 100.0),
            relative: [[20.0 * (MEET_S - time_s), 0.0], [-20.0, 0.0]],
        }
    };
    (0..MEET_S as i64).map(each).collect()
}

/// Truth, labels and output of the flight.
fn flown() -> (Truth, Labels, Vec<OutputPoint>) {
    let truth = Truth::new([0, 1].map(|drone| {
        let samples = times().map(|time_s| (at(time_s), place(drone, time_s)));
        (IDS[drone].to_owned(), samples.collect())
    }));
    let both = || times().flat_map(|time_s| [0, 1].map(|drone| (drone, time_s)));
    let labels = both().map(|(drone, time_s)| label(drone, time_s)).collect();
    let labels = Labels::with_receivers(labels, &["receiver".to_owned()].into());
    (truth, labels, both().map(|(drone, time_s)| point(drone, time_s)).collect())
}

fn scored(foreseen: &[ConflictPrediction]) -> ConflictScore {
    let (truth, labels, output) = flown();
    score_conflicts(&ConflictFlight {
        truth: &truth,
        labels: &labels,
        output: &output,
        foreseen,
        volume: (50.0, 15.0),
        settings: &Scoring::default(),
    })
}

fn met(foreseen: &[ConflictPrediction]) -> Option<Encounter> {
    let (truth, labels, output) = flown();
    encounter(&truth, &labels, &output, foreseen.iter(), &Scoring::default())
}

#[test]
fn timely_warning_counts_and_predictions_are_scored() {
    let score = scored(&foreseen(45.0, [10_000, 20_000]));
    // The drones are within 50 m from 57.5 s on. The warning was active 10 s before, at 47.5 s.
    assert_eq!((score.violations, score.warned, score.foreseeable), (1, 1, 1));
    assert_eq!((score.warnings, score.false_warnings), (1, 0));
    assert_eq!((score.bins[9].stated, score.bins[9].happened), (60, 60));
    // From 30 s to 50 s, the closest point was 30 to 10 s ahead.
    assert_eq!((score.judged, score.within), (21, 21));
    assert!(score.t_cpa_rms_s().unwrap() < 0.01);
    assert_eq!((score.encounters, score.changes), (1, 1));
    assert!((score.drone_h - 2.0 * 129.75 / 3600.0).abs() < 1e-6);
    assert!((score.unreliability(50).unwrap() - 0.05).abs() < 1e-9);
}

#[test]
fn late_warning_does_not_count() {
    let score = scored(&foreseen(48.0, [10_000, 20_000]));
    assert_eq!((score.violations, score.warned, score.foreseeable), (1, 0, 1));
    // A warning still counts while an aircraft is missing, but adds no prediction.
    let mut unseen = foreseen(40.0, [10_000, 20_000]);
    unseen.iter_mut().skip(42).for_each(|one| one.is_seen = false);
    let score = scored(&unseen);
    assert_eq!((score.warned, score.bins[9].stated, score.judged), (1, 42, 12));
}

#[test]
fn warning_without_a_near_pair_of_drones_is_false() {
    let score = scored(&foreseen(45.0, [10_000, 77]));
    assert_eq!((score.warned, score.warnings, score.false_warnings, score.judged), (0, 1, 1, 0));
    assert!((score.false_per_h().unwrap() - 3600.0 / (2.0 * 129.75)).abs() < 1e-6);
    // After they have met, the drones fly apart.
    let mut late = foreseen(0.0, [10_000, 20_000]);
    late.iter_mut().for_each(|one| one.time = Time::from_nanos(one.time.nanos() + 66 * SECOND));
    late.truncate(3);
    let score = scored(&late);
    assert_eq!((score.warnings, score.false_warnings), (1, 1));
}

#[test]
fn encounter_has_predicted_and_true_closest_approaches() {
    let mut foreseen = foreseen(45.0, [10_000, 20_000]);
    foreseen[40].is_seen = false;
    foreseen[41].numbers = [10_000, 30_000];
    let met = met(&foreseen).unwrap();
    assert_eq!((met.ids.each_ref().map(String::as_str), met.time), (IDS, at(MEET_S)));
    assert!(met.distance_m < 0.01 && met.ground_m < 0.01);
    // From 30 s before to 5 s after, four steps per second.
    assert_eq!(met.truth.len(), 141);
    for approach in &met.truth {
        let left_s = at(MEET_S).seconds_since(approach.time);
        assert!((approach.t_cpa_s - left_s.max(0.0)).abs() < 0.01, "{approach:?}");
        assert!((approach.d_cpa_m - (-20.0 * left_s).max(0.0)).abs() < 0.1, "{approach:?}");
    }
    // Every second from 30 s on, except the one with a missing aircraft and the one of another pair.
    let stated: Vec<f64> = met.foreseen.iter().map(|stated| stated.approach.t_cpa_s).collect();
    let expected =
        (30..60).filter(|second| ![40, 41].contains(second)).map(|second| MEET_S - f64::from(second));
    assert_eq!(stated, expected.collect::<Vec<_>>());
    assert!(met.foreseen.iter().all(|stated| stated.approach.d_cpa_m == 0.0 && stated.sigma_m == 10.0));
}

#[test]
fn encounter_without_predictions_has_truth_only() {
    let alone = met(&[]).unwrap();
    assert!(alone.foreseen.is_empty() && alone.truth.len() == 141);
    let (truth, _, output) = flown();
    let labels = (0..FLOWN_S).map(|second| label(0, second as f64)).collect();
    let labels = Labels::with_receivers(labels, &["receiver".to_owned()].into());
    assert_eq!(encounter(&truth, &labels, &output, [].iter(), &Scoring::default()), None);
}
