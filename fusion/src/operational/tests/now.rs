//! The picture of now, and slots that are shown early.

use jiff::SignedDuration;

use super::*;
use crate::point::{Basis, Source};

/// Output at each deadline between two times, with the reports received until then.
fn shown(
    case: &mut Case,
    latency_s: f64,
    (from_s, to_s): (f64, f64),
    mut heard: impl FnMut(&mut Case, f64),
) -> Vec<SlotOutput> {
    case.settings.latency = SignedDuration::from_secs_f64(latency_s);
    let slots = GRID.of(at(from_s)).0..GRID.of(at(to_s)).0;
    let latency_slots = (latency_s / 0.25) as i64;
    let show = |deadline: i64| {
        heard(case, deadline as f64 / 4.0);
        let slot = Slot(deadline - latency_slots);
        case.numbers.begin_slot(slot);
        let shown = case.air.emit(slot, GRID, &case.settings, &mut case.numbers);
        case.numbers.take_changes();
        shown
    };
    slots.map(show).collect()
}

/// Eastward at 10 m/s, reported each second with a delay of half a second, until it falls silent.
fn flies_until(silent_s: f64) -> impl FnMut(&mut Case, f64) {
    move |case, deadline_s| {
        let report_s = deadline_s - 0.5;
        if report_s.fract() == 0.0 && report_s < silent_s {
            case.fix(0, report_s, 10.0 * report_s);
        }
    }
}

#[test]
fn early_point_is_predicted_along_its_motion() {
    let mut case = Case::new();
    let shown = shown(&mut case, 6.25, (90.0, 130.0), flies_until(130.0));
    let mut seen = 0;
    for now in shown.iter().skip(60).map(|shown| shown.now.as_ref().unwrap()) {
        let [point] = &now.points[..] else { panic!("{now:?}") };
        let away_m = point.position.0.x - 10.0 * now.time.seconds_since(at(0.0));
        assert!(away_m.abs() < 1.0, "{away_m} m ahead of it");
        let estimate = point.estimate.unwrap();
        assert_eq!(estimate.basis, Basis::Extrapolated);
        assert!(estimate.last_measurement.is_some_and(|last| now.time.seconds_since(last) < 2.0));
        seen += 1;
    }
    assert_eq!(seen, 100);
    // The delayed slot is more accurate.
    let sigma_m = |points: &[Point]| points[0].estimate.unwrap().sigma_m();
    let last = shown.last().unwrap();
    assert!(sigma_m(&last.points) < sigma_m(&last.now.as_ref().unwrap().points));
}

#[test]
fn early_point_has_no_own_number_and_needs_a_known_position() {
    let mut case = Case::new();
    let shown = shown(&mut case, 6.25, (90.0, 130.0), |case, deadline_s| {
        // Silent from second 110 to 122.
        if !(110.5..122.5).contains(&deadline_s) {
            flies_until(200.0)(case, deadline_s);
        }
    });
    let mut of_now = Vec::new();
    let mut number = None;
    for shown in &shown {
        number = shown.points.first().map(|point| point.number).or(number);
        let now = shown.now.as_ref().unwrap();
        assert!(now.points.iter().all(|point| Some(point.number) == number), "{now:?}");
        if let [point] = &now.points[..] {
            assert!(point.estimate.unwrap().sigma_m() <= tuning::NOW_SIGMA_MAX_M);
            of_now.push(now.time.seconds_since(at(0.0)));
        }
    }
    let (first, gaps) =
        (of_now[0], of_now.windows(2).filter(|pair| pair[1] - pair[0] > 0.3).collect::<Vec<_>>());
    assert!((91.5..98.5).contains(&first), "from its second report on, at the earliest: {first}");
    let [gap] = &gaps[..] else { panic!("{gaps:?}") };
    assert!((111.0..118.0).contains(&gap[0]) && (122.0..123.5).contains(&gap[1]), "{gap:?}");
}

#[test]
fn early_slot_has_reporting_aircraft_and_decided_pairs() {
    let mut case = Case::new();
    let shown = shown(&mut case, 0.0, (60.0, 140.0), |case, deadline_s| {
        flies_until(140.0)(case, deadline_s);
        // The plots are received a little earlier than the transponder's reports.
        case.plot((0, 7), deadline_s - 0.2, 10.0 * (deadline_s - 0.2), 0.9);
    });
    for shown in shown.iter().skip(200) {
        let [point] = &shown.points[..] else { panic!("{:?}", shown.points) };
        assert!(matches!(point.source, Source::Fused(..)), "{:?}", point.source);
        assert_eq!(point.estimate.unwrap().basis, Basis::Extrapolated);
        let now = &shown.now.as_ref().unwrap().points[..];
        assert_eq!((now[0].position, &now[0].source), (point.position, &point.source));
    }
}

#[test]
fn a_drone_that_radar_alone_sees_is_left_out_sooner() {
    let mut case = Case::new();
    let shown = shown(&mut case, 6.25, (60.0, 120.0), |case, deadline_s| {
        if deadline_s < 100.0 {
            case.plot((0, 7), deadline_s - 0.2, 0.0, 0.95);
        }
    });
    let has_it = |shown: &&SlotOutput| !shown.now.as_ref().unwrap().points.is_empty();
    let latest = shown.iter().filter(has_it).map(|shown| shown.now.as_ref().unwrap().time).max().unwrap();
    // Its track counts as ended after two and a half seconds.
    assert!((99.0..103.0).contains(&latest.seconds_since(at(0.0))), "{latest:?}");
    let limit_m = |point: &Point| {
        let range_m = point.position.0.norm();
        NOW_SLACK * (tuning::NOW_RADAR_SIGMAS * range_m * 1.5_f64.to_radians() + tuning::NOW_RADAR_SIGMA_M)
    };
    for point in shown.iter().flat_map(|shown| &shown.now.as_ref().unwrap().points) {
        assert!(point.estimate.unwrap().sigma_m() <= limit_m(point));
    }
}

/// Factor on the standard deviation of a plot for the remaining misalignment of the radar.
const NOW_SLACK: f64 = 1.2;
