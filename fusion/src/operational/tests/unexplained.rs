//! Aircraft that only radar detects, and identities that explain them.

use super::*;

/// Whether the aircraft with that number is unexplained, by slot, for as long as it is published.
fn unexplained(published: &[(f64, Vec<Point>)], number: u32) -> Vec<(f64, bool)> {
    let of = |(second, points): &(f64, Vec<Point>)| {
        let point = points.iter().find(|point| point.number == number)?;
        Some((*second, point.is_unexplained))
    };
    published.iter().filter_map(of).collect()
}

#[test]
fn silent_transponder_explains_one_aircraft_for_120_s() {
    let mut case = Case::new();
    let published = case.publish(60.0, 240.0, |case, second| {
        let (reported_s, seen_s) = (second + 5.0, second + 6.0);
        if reported_s <= 100.0 && reported_s.fract() == 0.0 {
            case.fix(0, reported_s, 0.0);
        }
        // Too far away to be associated with the radar tracks, but within a drone's reach.
        if seen_s >= 160.0 && seen_s.fract() == 0.0 {
            case.plot((0, 7), seen_s, 600.0, 0.95);
            case.plot((0, 8), seen_s, -700.0, 0.95);
        }
    });
    let (nearer, other) = (unexplained(&published, 7), unexplained(&published, 8));
    assert!(nearer.first().is_some_and(|(second, _)| *second < 180.0), "{nearer:?}");
    assert!(nearer.last().is_some_and(|(second, _)| *second > 235.0), "{nearer:?}");
    for (second, is_unexplained) in nearer {
        assert_eq!(is_unexplained, second >= 220.0, "at {second} s, last heard at 100 s");
    }
    assert!(!other.is_empty() && other.iter().all(|(_, is_unexplained)| *is_unexplained), "{other:?}");
}

#[test]
fn confirmed_drone_remains_one_down_to_log_odds_of_1() {
    let mut case = Case::new();
    let mut log_odds = Vec::new();
    let published = case.publish(60.0, 140.0, |case, second| {
        if second > 60.0 {
            // Log-odds at the previous slot.
            let tracklet = case.air.tracklets.iter().next();
            log_odds.push(tracklet.map_or(0.0, |tracklet| tracklet.existence().log_odds()));
        }
        let seen_s = second + 6.0;
        if seen_s.fract() == 0.0 {
            // A drone at first; from then on the radar reports another class.
            case.plot((0, 7), seen_s, 0.0, if seen_s < 90.0 { 0.95 } else { 0.3 });
        }
    });
    let all = published.iter().zip(&log_odds).filter_map(|((second, points), log_odds)| {
        let point = points.first()?;
        Some((*second, point.is_unexplained, *log_odds))
    });
    let all: Vec<(f64, bool, f64)> = all.collect();
    for (second, is_unexplained, log_odds) in &all {
        assert_eq!(*is_unexplained, *log_odds >= 1.0, "{second} s: {log_odds}");
    }
    let has = |range: std::ops::Range<f64>| all.iter().any(|(_, _, log_odds)| range.contains(log_odds));
    assert!(has(3.0..f64::INFINITY) && has(1.0..1.3) && has(0.7..1.0), "{all:?}");
}
