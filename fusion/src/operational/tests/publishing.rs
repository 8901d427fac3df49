//! Published points and their numbers.

use super::*;
use crate::operational::tuning::UNSEEN_SIGMA_MAX_M;
use crate::point::{AssociationEvidence, Basis, Competitor, Source};

/// Radar track 7 with plots between two times, published from second 90 on.
fn radar_only(from_s: f64, to_s: f64) -> Vec<(f64, Vec<Point>)> {
    let mut case = Case::new();
    case.track((0, 7), &halves(from_s, to_s), 0.0, 0.95);
    case.publish(90.0, 110.0, |_, _| ())
}

#[test]
fn coasting_ends_after_two_seconds() {
    let published: Vec<(f64, Point)> = radar_only(95.0, 100.0)
        .into_iter()
        .filter_map(|(second, mut points)| Some((second, points.pop()?)))
        .collect();
    let seconds: Vec<f64> = published.iter().map(|(second, _)| *second).collect();
    assert_eq!((seconds[0], *seconds.last().unwrap()), (93.125, 101.875));
    for (second, point) in &published {
        let estimate = point.estimate.unwrap();
        let expected = match second {
            ..94.75 => Basis::Extrapolated,
            ..100.25 => Basis::Measured,
            _ => Basis::Extrapolated,
        };
        assert!(estimate.basis == expected || estimate.basis == Basis::Interpolated, "{second} {estimate:?}");
        assert_eq!(point.number, 7);
    }
}

#[test]
fn a_radars_number_that_is_still_in_use_is_not_given_again() {
    let mut case = Case::new();
    // One number for two distant drones.
    case.track((0, 7), &halves(95.0, 105.0), 0.0, 0.95);
    case.track((2, 7), &halves(95.0, 105.0), 5000.0, 0.95);
    let published = case.publish(97.0, 98.0, |_, _| ());
    for (_, points) in published {
        assert_eq!(points.iter().map(|point| point.number).collect::<Vec<_>>(), [7, 4096]);
    }
}

#[test]
fn an_aircraft_that_comes_back_has_its_number_again() {
    let mut case = Case::new();
    let mut numbers = Vec::new();
    let published = case.publish(100.0, 180.0, |case, second| {
        // Two aircraft at first; the first is silent for 40 s, after which none of its reports are left.
        if second.fract() == 0.0 {
            if !(110.0..150.0).contains(&second) {
                case.fix(0, second + 5.0, 0.0);
            }
            case.fix(1, second + 5.0, 3000.0);
        }
    });
    for (second, points) in &published {
        if (108.0..114.0).contains(second) || (165.0..).contains(second) {
            numbers.push(points.iter().map(|point| point.number).collect::<Vec<_>>());
        }
    }
    assert!(published.iter().any(|(_, points)| points.len() == 1));
    assert!(numbers.len() > 60 && numbers.iter().all(|numbers| *numbers == [10_000, 20_000]), "{numbers:?}");
}

#[test]
fn associated_radar_track_passes_its_number_to_transponder() {
    let mut case = Case::new();
    let track = case.track((0, 7), &halves(90.0, 101.0), 0.0, 0.95);
    let before = case.publish(98.0, 100.0, |_, _| ());
    assert!(before.iter().all(|(_, points)| points[0].number == 7));
    let target = case.transponder(0, &halves(98.0, 101.0), 0.0);
    case.pair(track, target, 12.0);
    case.associate();
    case.run(|air, numbers, cycle| {
        air.targets.filter_all(&air.tracklets, &air.cameras, cycle);
        let points = output::publish(
            &mut air.targets,
            &air.tracklets,
            &air.cameras,
            &air.correlations,
            numbers,
            GRID,
            cycle,
        );
        let [Point { number: 7, source: Source::Fused(_, _, pair), .. }] = &points[..] else {
            panic!("{points:?}");
        };
        assert_eq!(pair.because, AssociationEvidence::Likelihood { score: 12.0 });
    });
}

#[test]
fn rivals_are_ordered_by_likelihood_three_of_a_kind_at_most() {
    let mut case = Case::new();
    let track = case.track((0, 7), &halves(95.0, 105.0), 0.0, 0.95);
    let targets =
        [0, 1, 2, 3, 4, 5].map(|which| case.transponder(which, &halves(97.0, 103.0), 10.0 * which as f64));
    for (target, llr) in targets.into_iter().zip([12.0, 3.0, 5.0, -2.0, 4.0, -12.0]) {
        case.pair(track, target, llr);
    }
    case.decide(track, 2, Verdict::Decorrelated);
    case.associate();
    assert_eq!(case.target(track), Some(targets[0]));
    case.run(|air, _, cycle| {
        let told = competitors::competitors(&air.tracklets, &air.targets, &air.correlations, cycle);
        let of = |target: TargetId| told.get(&target).map_or(&[][..], Vec::as_slice);
        let own: Vec<_> = of(targets[0]).iter().map(|told| (told.score, told.decorrelated)).collect();
        assert_eq!(own, [(5.0, true), (4.0, false), (3.0, false)]);
        assert!(matches!(of(targets[1])[..], [Competitor { who: Rival::Radar(key), score: 3.0, .. }] if key.number == 7));
        assert!(of(targets[5]).is_empty(), "the plots say all that they can against it");
    });
}

#[test]
fn silent_transponder_is_published_up_to_250_m_accuracy() {
    let mut case = Case::new();
    case.transponder(0, &halves(80.0, 100.0), 0.0);
    let published = case.publish(95.0, 125.0, |_, _| ());
    let (_, last) = published.iter().rfind(|(_, points)| !points.is_empty()).unwrap();
    // The transponder's bias is published with it, but does not count for the limit.
    let sigma_m = (last[0].estimate.unwrap().horizontal.trace() / 2.0 - 0.91 * 4.5).sqrt();
    assert!((0.9..=1.0).contains(&(sigma_m / UNSEEN_SIGMA_MAX_M)), "{sigma_m} m");
}

#[test]
fn radar_point_is_published_at_any_accuracy() {
    let mut case = Case::new();
    case.settings.radars[0].as_mut().unwrap().errors.bias_azimuth = 0.5;
    let track = case.track((0, 1), &halves(90.0, 110.0), 0.0, 0.9);
    let published = case.publish(95.0, 105.0, |_, _| ());
    assert!(case.target(track).is_some());
    assert!(published.iter().skip(2).all(|(_, points)| points.len() == 1));
    let poor = |points: &Vec<Point>| {
        points[0].estimate.unwrap().horizontal.trace() > 2.0 * UNSEEN_SIGMA_MAX_M.powi(2)
    };
    assert!(published.iter().skip(2).all(|(_, points)| poor(points)), "{published:?}");
}
