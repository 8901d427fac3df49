//! Radar tracks that become targets, and those that do not.

use super::*;
use crate::settings::Sensor;

/// Whether the track becomes a target.
fn is_initiated(case: &mut Case, track: TrackletId) -> bool {
    case.run(|air, _, cycle| {
        let decided = air.correlations.decided(&air.tracklets, &air.targets);
        let measured = MeasuredPositions::of(&air.targets);
        initiation::initiate(
            &mut air.tracklets,
            &mut air.targets,
            &measured,
            &decided,
            &Default::default(),
            cycle,
        );
    });
    case.target(track).is_some()
}

/// Whether a track of these plots, with no other object near, becomes a target.
fn alone(seconds: &[f64], uav_probability: f64) -> bool {
    let mut case = Case::new();
    let track = case.track((0, 1), seconds, 0.0, uav_probability);
    is_initiated(&mut case, track)
}

#[test]
fn unassociated_track_becomes_a_target_once_confirmed() {
    assert!(alone(&halves(98.0, 101.0), 0.9));
    assert!(!alone(&halves(98.0, 101.0), 0.57), "as likely a bird");
    assert!(!alone(&halves(98.0, 101.0), 0.1), "a bird");
    assert!(!alone(&halves(96.0, 100.0), 0.9), "it has ended");
}

#[test]
fn one_plot_is_no_track_however_sure_the_radar_is() {
    let mut sensors = two_drones::settings(true).sensors;
    let Sensor::Radar(radar) = &mut sensors[0] else { unreachable!("sensor 0 is a radar") };
    radar.period_s = 1.0;
    let settings = OperationalSettings::new(&sensors, LATENCY, &OperationalRules::default());
    for (seconds, is_track) in [(&[100.5][..], false), (&[99.5, 100.5], true)] {
        let mut case = Case { settings: settings.clone(), ..Case::new() };
        let track = case.track((0, 1), seconds, 0.0, 1.0);
        assert_eq!(is_initiated(&mut case, track), is_track);
    }
}

#[test]
fn a_track_becomes_a_target_shortly_before_its_first_plot() {
    assert!(alone(&halves(102.0, 106.0), 0.9));
    assert!(!alone(&halves(102.5, 106.0), 0.9));
}

#[test]
fn a_target_is_known_from_its_tracks_first_plot_on() {
    let mut case = Case::new();
    let track = case.track((0, 1), &halves(96.0, 101.0), 0.0, 0.9);
    assert!(is_initiated(&mut case, track));
    case.run(|air, _, cycle| air.targets.filter_all(&air.tracklets, &air.cameras, cycle));
    let target = case.air.targets.get(case.target(track).unwrap()).unwrap();
    assert_eq!(target.estimate(at(96.0)).unwrap().since_s, Some(0.0));
}

#[test]
fn likely_associated_track_waits_before_becoming_a_target() {
    let mut case = Case::new();
    let target = case.transponder(0, &[50.0, 51.0], 0.0);
    let track = case.track((0, 1), &halves(95.0, 101.0), 0.0, 0.9);
    let mut is_initiated_with = |llr, last_likely: Option<f64>, verdict| {
        let pair = PairLikelihood::with_llr(llr, last_likely.map(at));
        case.air.tracklets.get_mut(track).unwrap().set_pair(target, pair);
        case.decide(track, 0, verdict);
        let is_initiated = is_initiated(&mut case, track);
        case.air.targets.assign_track(&mut case.air.tracklets, track, None);
        is_initiated
    };
    assert!(!is_initiated_with(0.5, None, Verdict::Automatic), "it could be that one");
    assert!(!is_initiated_with(-7.5, None, Verdict::Automatic), "it would be a ghost if it were");
    assert!(is_initiated_with(-8.5, None, Verdict::Automatic));
    assert!(!is_initiated_with(-8.5, Some(90.5), Verdict::Automatic), "it has walked off");
    assert!(is_initiated_with(-8.5, Some(90.0), Verdict::Automatic));
    assert!(is_initiated_with(12.0, Some(100.0), Verdict::Decorrelated), "an operator says it is not");
}

#[test]
fn a_track_ahead_that_could_be_a_known_target_waits() {
    let mut case = Case::new();
    case.transponder(0, &halves(80.0, 99.0), 0.0);
    let [there, elsewhere] = [(1, 0.0), (2, 900.0)]
        .map(|(number, east_m)| case.track((0, number), &halves(101.0, 104.0), east_m, 0.9));
    case.run(|air, _, cycle| air.targets.filter_all(&air.tracklets, &air.cameras, cycle));
    assert!(!is_initiated(&mut case, there));
    assert!(case.target(elsewhere).is_some());
}
