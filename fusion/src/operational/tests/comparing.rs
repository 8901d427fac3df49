//! Pairs that begin and end.

use super::*;
use crate::operational::tuning::PAIR_LLR_MAX;

/// Whether a pair with that sum, of a track and a transponder at this distance east of it, is kept after the slot.
fn lasts(case: &mut Case, east_m: f64, llr: f64, likely_s: Option<f64>, is_own: bool) -> bool {
    let track = case.track((0, 1), &halves(98.0, 101.0), 0.0, 0.9);
    let target = case.transponder(0, &halves(97.0, 103.0), east_m);
    let pair = PairLikelihood::with_llr(llr, likely_s.map(at));
    case.air.tracklets.get_mut(track).unwrap().set_pair(target, pair);
    if is_own {
        case.air.targets.assign_track(&mut case.air.tracklets, track, Some(target));
    }
    case.run(|air, _, cycle| pair_likelihoods::compare(&mut air.tracklets, &air.targets, cycle));
    case.air.tracklets.get(track).unwrap().pair(target).is_some()
}

#[test]
fn distant_pair_ends_when_all_evidence_opposes_it() {
    let lasts = |east_m, llr, likely_s, is_own| lasts(&mut Case::new(), east_m, llr, likely_s, is_own);
    assert!(!lasts(2000.0, -PAIR_LLR_MAX, None, false));
    assert!(!lasts(2000.0, -PAIR_LLR_MAX, Some(NOW_S - 10.0), false));
    assert!(lasts(2000.0, -PAIR_LLR_MAX, Some(NOW_S - 5.0), false), "it may have walked off");
    assert!(lasts(2000.0, -PAIR_LLR_MAX, None, true), "it is that target");
    assert!(lasts(600.0, PAIR_LLR_MAX, None, false), "not everything");
    assert!(lasts(50.0, -PAIR_LLR_MAX, None, false), "near");
}

#[test]
fn approaching_transponder_is_compared_with_all_plots() {
    let mut case = Case::new();
    let track = case.track((0, 1), &halves(98.0, 101.0), 0.0, 0.9);
    let target = case.transponder(0, &halves(97.0, 103.0), 20.0);
    case.run(|air, _, cycle| pair_likelihoods::compare(&mut air.tracklets, &air.targets, cycle));
    let all = case.air.tracklets.get(track).unwrap().pair_llr(target).unwrap();
    let mut expected = PairLikelihood::default();
    let plots = case.air.tracklets.get(track).unwrap().between(EARLIEST, at(NOW_S));
    let transponder = case.air.targets.get(target).unwrap().transponder().unwrap();
    let radar = case.settings.radar(SensorIndex(0)).unwrap();
    expected.add_plots(plots, transponder, radar, &case.settings);
    assert_eq!(Some(all), expected.total());
}
