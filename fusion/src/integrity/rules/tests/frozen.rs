use super::*;

/// A flight whose position is constant from second 60 to `until_s`, and then continues as if it had flown on.
fn freezes(number: u32, period_s: f64, until_s: f64, place: impl Fn(f64) -> [f64; 3]) -> Vec<Arrival> {
    let mut reports = flight(number, period_s, (0.0, 160.0), 0.4, place);
    let is_frozen = |seconds: f64| (60.0..until_s).contains(&seconds);
    let last = reports.iter().rfind(|(_, fix)| fix.time < at(60.0)).unwrap().1;
    for (_, fix) in &mut reports {
        if is_frozen(fix.time.seconds_since(at(0.0))) {
            (fix.position, fix.velocity) = (last.position, last.velocity);
        }
    }
    reports
}

fn hover(_: f64) -> [f64; 3] {
    [200.0, 300.0, 80.0]
}

#[test]
fn five_places_to_the_octet_over_12_s_are_suspect() {
    for (period_s, by_s) in [(0.2, 72.5), (1.0, 72.5), (2.0, 72.6), (4.0, 76.6)] {
        // The run begins with the last honest report.
        assert_fires(&freezes(1, period_s, 160.0, hover), 1, Reason::Frozen, false, (70.0, by_s + 0.5));
    }
}

#[test]
fn without_any_hover_before_it_takes_20_s() {
    assert_fires(&freezes(1, 2.0, 160.0, eastward), 1, Reason::Frozen, false, (78.0, 80.0));
}

#[test]
fn frozen_with_stated_motion_has_failed() {
    let honest = |seconds: f64| [12.0 + (seconds * 0.7).sin(), 0.3];
    let reports = flight(1, 2.0, (0.0, 160.0), 0.4, eastward);
    let mut reports = stating(reports, honest);
    let last = reports[29].1;
    for (_, fix) in &mut reports[30..] {
        (fix.position, fix.velocity) = (last.position, last.velocity);
    }
    assert_fires(&reports, 1, Reason::Frozen, true, (70.0, 72.0));
    // Not if it always reports the same velocity.
    let constant = stating(freezes(1, 2.0, 160.0, hover), |_| [12.0, 0.3]);
    let fired = fired(&constant, &[1]);
    assert_eq!(first(&fired, 1, Reason::Frozen, true), None, "{fired:?}");
    assert!(first(&fired, 1, Reason::Frozen, false).is_some());
}

#[test]
fn frozen_ends_with_another_position_or_silence() {
    let mut held_s = Vec::new();
    run(&freezes(1, 2.0, 100.0, hover), |at_s, rules| {
        if rules.finding(identity(1)).suspect.contains(Reason::Frozen) {
            assert_eq!(rules.finding(identity(1)).still_since, Some(at(58.0)));
            held_s.push(at_s);
        }
    });
    assert_eq!(held_s[held_s.len() - 1], 100.25);
    let silenced: Vec<Arrival> = freezes(1, 2.0, 160.0, hover)
        .into_iter()
        .filter(|(_, fix)| fix.time <= at(80.0) || fix.time > at(157.0))
        .collect();
    let mut last_s = 0.0;
    run(&silenced, |at_s, rules| {
        if at_s < 150.0 && rules.finding(identity(1)).still_since.is_some() {
            last_s = at_s;
        }
    });
    assert_eq!(last_s, 90.0);
}

#[test]
fn transponder_that_never_moved_is_not_frozen() {
    let standing = flight(1, 1.0, (0.0, 300.0), 0.0, hover);
    assert_silent(&standing, &[1]);
    assert_eq!(run(&standing, |_, _| ()).finding(identity(1)).still_since, None);
}

#[test]
fn a_receiver_that_rests_where_it_hovers_is_left_alone() {
    // Positions on a grid of 1.1 m: real receivers repeat one for up to 6 s in hover.
    let coarse = |seconds: f64| {
        let [east, north, up] = [3.0 * (0.05 * seconds).sin(), 3.0 * (0.041 * seconds).cos(), 80.0];
        [(east / 1.1).round() * 1.1, (north / 1.1).round() * 1.1, up]
    };
    for period_s in [0.5, 1.0, 2.0, 3.0] {
        assert_silent(&flight(1, period_s, (0.0, 900.0), 0.0, coarse), &[1]);
    }
}

#[test]
fn how_long_it_rested_before_counts() {
    // A constant position for 10 s in each hover of 20 s: 24 s of it are not unusual, 40 s are.
    let resting = |until_s: f64| {
        let mut reports = flight(1, 1.0, (0.0, 200.0), 0.2, hover);
        for (_, fix) in &mut reports {
            let seconds = fix.time.seconds_since(at(0.0));
            if seconds < 100.0 && seconds % 20.0 >= 10.0 || (110.0..until_s).contains(&seconds) {
                fix.position = Enu::new(200.0, 300.0, 80.0);
            }
        }
        reports
    };
    assert_silent(&resting(134.0), &[1]);
    assert_fires(&resting(160.0), 1, Reason::Frozen, false, (136.0, 142.0));
}

#[test]
fn a_late_report_of_another_place_begins_it_anew() {
    let mut reports = freezes(1, 2.0, 160.0, hover);
    // Stamped in the middle of the run, received 3 s later.
    reports.push((66.0, fix(1, 63.0, [201.0, 300.0, 80.0])));
    assert_fires(&reports, 1, Reason::Frozen, false, (76.0, 77.0));
}
