//! Radar tracks and transponders with given likelihoods.

use super::*;

/// Reports of a transponder that is not received now, nor searched for, so that only the given likelihoods count.
const LONG_AGO: [f64; 2] = [50.0, 51.0];
/// One plot gives no evidence of class or motion.
const LASTING: [f64; 1] = [100.0];
const SILENT: f64 = 0.57;

fn tracks<const N: usize>(case: &mut Case, keys: [(u16, u16); N]) -> [TrackletId; N] {
    keys.map(|key| case.track(key, &LASTING, 0.0, SILENT))
}

#[test]
fn transponder_has_at_most_one_track_of_each_radar() {
    let mut case = Case::new();
    let [worse, better, other] = tracks(&mut case, [(0, 1), (0, 2), (2, 1)]);
    let target = case.transponder(0, &LONG_AGO, 0.0);
    for (track, llr) in [(worse, 9.0), (better, 11.0), (other, 7.0)] {
        case.pair(track, target, llr);
    }
    case.associate();
    assert_eq!([worse, better, other].map(|track| case.target(track)), [None, Some(target), Some(target)]);
    // The sum counts, not the single best pair.
    let second = case.transponder(1, &LONG_AGO, 0.0);
    case.pair(better, second, 8.0);
    case.associate();
    assert_eq!([worse, better].map(|track| case.target(track)), [Some(target), Some(second)]);
}

#[test]
fn a_pair_begins_at_one_threshold_and_ends_at_another() {
    let mut case = Case::new();
    let [track] = tracks(&mut case, [(0, 1)]);
    let target = case.transponder(0, &LONG_AGO, 0.0);
    for (llr, is_one) in [(5.9, false), (6.1, true), (-3.9, true), (-4.1, false), (5.9, false)] {
        case.pair(track, target, llr);
        case.associate();
        assert_eq!(case.target(track), is_one.then_some(target), "{llr}");
    }
}

#[test]
fn a_pair_stays_until_another_is_better_by_the_margin() {
    let mut case = Case::new();
    let [first, second] = tracks(&mut case, [(0, 1), (0, 2)]);
    let target = case.transponder(0, &LONG_AGO, 0.0);
    for (of_second, holder) in [(-12.0, first), (10.9, first), (11.1, second), (3.1, second), (2.9, first)] {
        case.pair(first, target, 7.0);
        case.pair(second, target, of_second);
        case.associate();
        assert_eq!(
            [first, second].map(|track| case.target(track) == Some(target)),
            [first == holder, second == holder]
        );
    }
}

#[test]
fn a_radar_that_is_certain_of_a_bird_has_a_veto() {
    let mut case = Case::new();
    let target = case.transponder(0, &LONG_AGO, 0.0);
    let bird = case.track((0, 1), &halves(95.0, 101.0), 0.0, 0.0);
    let brief = case.track((2, 1), &halves(100.0, 101.0), 0.0, 0.0);
    case.pair(bird, target, 40.0);
    case.pair(brief, target, 40.0);
    case.associate();
    assert_eq!([bird, brief].map(|track| case.target(track)), [None, Some(target)]);
}

#[test]
fn an_operators_decision_outweighs_all_likelihood() {
    let mut case = Case::new();
    let [one, other] = tracks(&mut case, [(0, 1), (0, 2)]);
    let target = case.transponder(0, &LONG_AGO, 0.0);
    case.pair(one, target, 12.0);
    case.decide(one, 0, Verdict::Decorrelated);
    case.associate();
    assert_eq!(case.target(one), None);
    case.decide(other, 0, Verdict::Correlated);
    case.decide(one, 0, Verdict::Automatic);
    case.associate();
    assert_eq!([one, other].map(|track| case.target(track)), [None, Some(target)]);
}

/// A target that no sensor detects now, a track that has begun at its expected position, and one that begins there in
/// two seconds.
fn unseen(begun_at_m: f64) -> (Case, TargetId, TrackletId, TrackletId) {
    let mut case = Case::new();
    let target = case.transponder(0, &halves(80.0, 97.0), 0.0);
    let begun = case.track((0, 1), &halves(99.5, 104.0), begun_at_m, 0.9);
    let ahead = case.track((0, 2), &halves(102.0, 104.0), 0.0, 0.9);
    case.run(|air, _, cycle| air.targets.filter_all(&air.tracklets, &air.cameras, cycle));
    (case, target, begun, ahead)
}

#[test]
fn future_track_reacquires_a_target_without_a_current_track() {
    let (mut case, target, begun, ahead) = unseen(0.0);
    case.associate();
    assert_eq!([begun, ahead].map(|track| case.target(track)), [Some(target), None], "begun first");
    let (mut case, target, begun, ahead) = unseen(700.0);
    case.associate();
    assert_eq!([begun, ahead].map(|track| case.target(track)), [None, Some(target)]);
}

#[test]
fn reacquired_target_is_missing_only_to_other_radars() {
    let (mut case, target, _, ahead) = unseen(700.0);
    let [same, other] = [(0, 7), (2, 1)].map(|key| case.track(key, &halves(101.0, 104.0), 20.0, 0.9));
    case.associate();
    assert_eq!([ahead, same, other].map(|track| case.target(track)), [Some(target), None, Some(target)]);
}

#[test]
fn a_target_that_is_seen_is_not_reacquired() {
    let (mut case, target, ..) = unseen(700.0);
    case.transponder(0, &[98.0, 100.0, 102.0], 0.0);
    let tracks = [(2, 1), (2, 2)].map(|key| case.track(key, &halves(101.0, 104.0), 0.0, 0.9));
    case.associate();
    assert!(tracks.iter().all(|&track| case.target(track) != Some(target)));
}
