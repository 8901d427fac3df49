use super::*;

/// The reports of `from_s` to `until_s` again, `lag_s` later.
fn again(reports: &[Arrival], (from_s, until_s): (f64, f64), lag_s: f64) -> Vec<Arrival> {
    let lag = SignedDuration::from_secs_f64(lag_s);
    let heard = reports.iter().filter(|(_, fix)| (at(from_s)..at(until_s)).contains(&fix.time));
    heard.map(|&(arrives_s, fix)| (arrives_s + lag_s, Fix { time: fix.time + lag, ..fix })).collect()
}

#[test]
fn the_last_minute_again_is_a_replay_with_its_fifth_report() {
    for period_s in [0.5, 2.0, 4.0] {
        let mut reports = flight(1, period_s, (0.0, 60.0), 0.5, eastward);
        reports.extend(again(&reports, (0.0, 60.0), 60.0));
        reports.extend(again(&reports, (60.0, 120.0), 60.0));
        let fifth_s = 60.0 + 4.0 * period_s;
        assert_fires(&reports, 1, Reason::Replay, true, (fifth_s, fifth_s + 1.0));
    }
}

#[test]
fn replay_is_found_under_another_identity_and_in_hover() {
    let mut reports = flight(1, 2.0, (0.0, 200.0), 0.5, |_| [100.0, 50.0, 60.0]);
    let stolen = again(&reports, (20.0, 80.0), 70.0).into_iter();
    reports.extend(stolen.map(|(arrives_s, fix)| (arrives_s, Fix { identity: identity(2), ..fix })));
    let fired = fired(&reports, &[1, 2]);
    assert!(first(&fired, 2, Reason::Replay, true).is_some_and(|at_s| at_s < 100.0), "{fired:?}");
    assert_eq!(first(&fired, 1, Reason::Replay, true), None);
}

#[test]
fn a_fifth_of_the_earlier_reports_may_have_been_lost() {
    let mut reports = flight(1, 2.0, (0.0, 60.0), 0.5, eastward);
    let replayed = again(&reports, (0.0, 60.0), 60.0);
    let lost: Vec<Time> = reports.iter().skip(3).step_by(6).map(|(_, fix)| fix.time).collect();
    reports.retain(|(_, fix)| !lost.contains(&fix.time));
    reports.extend(replayed);
    assert_fires(&reports, 1, Reason::Replay, true, (68.0, 80.0));
}

#[test]
fn the_same_way_at_other_times_is_none() {
    // Exactly the same positions, but each round takes longer than the one before.
    let mut reports = flight(1, 2.0, (0.0, 60.0), 0.0, eastward);
    let slower: Vec<Arrival> = (0..30)
        .map(|report| {
            let seconds = 60.0 + 3.0 * f64::from(report);
            (seconds + LATE_S, Fix { time: at(seconds), ..reports[report as usize].1 })
        })
        .collect();
    reports.extend(slower);
    assert_eq!(first(&fired(&reports, &[1]), 1, Reason::Replay, true), None);
}

#[test]
fn repetition_within_5_s_at_other_receivers_is_no_replay() {
    for (lag_s, sensor) in [(4.9, 1), (4.9, 2), (7.0, 2)] {
        let mut reports = flight(1, 1.0, (0.0, 60.0), 0.5, |seconds| [2.0 * seconds, 0.0, 80.0]);
        let second = again(&reports, (0.0, 60.0), lag_s).into_iter();
        reports
            .extend(second.map(|(arrives_s, fix)| (arrives_s, Fix { sensor: SensorIndex(sensor), ..fix })));
        assert_eq!(first(&fired(&reports, &[1]), 1, Reason::Replay, true), None, "{lag_s} {sensor}");
    }
}

#[test]
fn hovering_on_a_coarse_grid_is_none() {
    for (number, cell_m) in [(1, 1.1), (2, 0.3), (3, 11.0)] {
        for period_s in [0.5, 1.0, 2.0] {
            let mut reports = flight(number, period_s, (0.0, 1800.0), 0.6, |_| [0.4, 0.3, 80.0]);
            for (_, fix) in &mut reports {
                fix.position.0 = fix.position.0.map(|axis| (axis / cell_m).round() * cell_m);
            }
            assert_eq!(
                first(&fired(&reports, &[number]), number, Reason::Replay, true),
                None,
                "{cell_m} {period_s}"
            );
        }
    }
}

#[test]
fn a_frozen_or_standing_one_is_none() {
    assert_silent(&flight(1, 0.5, (0.0, 600.0), 0.0, |_| [1.0, 2.0, 3.0]), &[1]);
}

#[test]
fn wander_of_centimetres_back_and_forth_is_no_replay() {
    // Repeated exactly every 10 s.
    let wanders = |seconds: f64| {
        let step = f64::from((seconds * 5.0).round() as i32 % 50);
        [0.02 * step.min(50.0 - step), 0.01 * (step % 7.0), 80.0]
    };
    assert_eq!(
        first(
            &fired(&flight(1, 0.2, (0.0, 60.0), 0.0, |s| wanders(s).map(|m| m * 0.4)), &[1]),
            1,
            Reason::Replay,
            true
        ),
        None
    );
}
