//! A silent aircraft, and a radar track that may be this aircraft or another one.

use super::*;

const DRONE: f64 = 0.9;

/// An aircraft that a radar has detected with this class probability. Its transponder is silent from second 100 to 120
/// while it hovers; radar 0's track 2 begins at 108, at this distance and with this class.
fn silent(class: f64, off_m: f64, other_class: f64) -> Case {
    let mut case = Case::new();
    case.transponder(0, &halves(70.0, 100.0), 0.0);
    case.track((0, 1), &halves(70.0, 99.0), 0.0, class);
    case.track((0, 2), &halves(108.0, 130.0), off_m, other_class);
    case
}

/// The points of the transponder's aircraft: second, distance from it, metres, standard deviation of each axis over
/// ground, metres, and whether a radar takes part.
fn published(case: &mut Case, to_s: f64, returns: bool) -> Vec<(f64, f64, f64, bool)> {
    let published = case.publish(85.0, to_s, |case, second| {
        let heard_s = second + 6.0;
        if returns && heard_s >= 120.0 && heard_s.fract() == 0.0 {
            case.fix(0, heard_s, 0.0);
        }
    });
    let own = |(second, points): (f64, Vec<Point>)| {
        let point = points.into_iter().find(|point| point.source.transponder().is_some())?;
        let horizontal = point.estimate?.horizontal;
        let seen = matches!(point.source, crate::point::Source::Fused(..));
        Some((second, point.position.0.x.abs(), (horizontal.trace() / 2.0).sqrt(), seen))
    };
    published.into_iter().filter_map(own).collect()
}

#[test]
fn class_belongs_to_the_aircraft() {
    // An aircraft that the radar classifies as a bird is found again by that class, and a track classified as a drone
    // is not it.
    for (class, other_class, is_found) in [(0.2, 0.2, true), (0.2, DRONE, false), (DRONE, DRONE, true)] {
        let points = published(&mut silent(class, 10.0, other_class), 113.0, false);
        let seen = points.iter().any(|&(second, .., seen)| seen && second > 109.0);
        assert_eq!(seen, is_found, "{class} {other_class}");
    }
}

#[test]
fn report_elsewhere_undoes_the_reacquisition() {
    let mut case = silent(DRONE, 70.0, DRONE);
    let points = published(&mut case, 119.0, true);
    let away = |from_s: f64, to_s: f64| {
        let between = points.iter().filter(move |point| (from_s..to_s).contains(&point.0));
        between.map(|point| point.1).fold(0.0, f64::max)
    };
    // Known after two reports following the silence, 6 s ahead.
    assert!(away(109.0, 113.0) > 40.0, "taken for the track: {}", away(109.0, 113.0));
    assert!(away(117.0, 119.0) < 20.0, "and then not: {}", away(117.0, 119.0));
}

#[test]
fn reacquisition_is_published_with_doubt_until_a_report() {
    let sigma_m = |points: &[(f64, f64, f64, bool)], from_s: f64, to_s: f64| {
        let of = points.iter().filter(|point| (from_s..to_s).contains(&point.0)).map(|point| point.2);
        of.clone().sum::<f64>() / of.count() as f64
    };
    let near = published(&mut silent(DRONE, 10.0, DRONE), 125.0, true);
    let far = published(&mut silent(DRONE, 70.0, DRONE), 113.0, false);
    let is_found = |points: &[(f64, f64, f64, bool)]| points.iter().any(|point| point.3 && point.0 > 108.0);
    assert!(is_found(&near) && is_found(&far));
    let sigmas_m = [&near, &far].map(|points| sigma_m(points, 109.0, 112.0));
    assert!(sigmas_m[1] > 1.1 * sigmas_m[0], "{sigmas_m:?}");
    assert!(sigma_m(&near, 122.0, 125.0) < 5.0);
}
