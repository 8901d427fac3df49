use super::*;

fn westward(seconds: f64) -> [f64; 3] {
    [1200.0 - 9.0 * seconds, 700.0, 90.0]
}

/// Two flights that exchange their identities between these seconds; their reports are `apart_s` apart.
fn swapped((from_s, until_s): (f64, f64), period_s: f64, apart_s: f64) -> Vec<Arrival> {
    let mut reports = flight(1, period_s, (0.0, 200.0), 0.5, eastward);
    reports.extend(flight(2, period_s, (apart_s, 200.0), 0.5, westward));
    for (_, fix) in &mut reports {
        if (at(from_s)..at(until_s)).contains(&fix.time) {
            fix.identity = identity(if fix.identity == identity(1) { 2 } else { 1 });
        }
    }
    reports
}

#[test]
fn both_have_failed_as_soon_as_one_of_them_is_known() {
    for period_s in [0.5, 2.0, 4.0] {
        for apart_s in [0.1, 0.9 * period_s] {
            let fired = fired(&swapped((60.0, 300.0), period_s, apart_s), &[1, 2]);
            for number in [1, 2] {
                let first_s = first(&fired, number, Reason::Swapped, true);
                assert!(first_s.is_some_and(|first_s| (60.0..76.0).contains(&first_s)), "{fired:?}");
            }
        }
    }
}

#[test]
fn exchange_ends_when_identities_change_back() {
    let mut held_s = Vec::new();
    run(&swapped((60.0, 120.0), 2.0, 1.0), |at_s, rules| {
        if rules.finding(identity(1)).failed.contains(Reason::Swapped) {
            held_s.push(at_s);
        }
    });
    let (first_s, last_s) = (held_s[0], held_s[held_s.len() - 1]);
    assert!(first_s < 70.0 && (120.0..130.0).contains(&last_s), "{first_s} {last_s}");
}

#[test]
fn one_that_has_vanished_counts_as_well() {
    // The second transmitter is not received after the swap: its aircraft sends neither identity.
    let mut reports = swapped((60.0, 300.0), 2.0, 1.0);
    reports.retain(|(_, fix)| fix.time < at(60.0) || fix.identity != identity(1));
    let fired = fired(&reports, &[1, 2]);
    assert!(first(&fired, 2, Reason::Swapped, true).is_some_and(|first_s| first_s < 76.0), "{fired:?}");
}

#[test]
fn two_that_jump_at_once_to_other_places_are_none() {
    let off = |seconds: f64| if seconds >= 60.0 { 150.0 } else { 0.0 };
    let mut reports =
        flight(1, 2.0, (0.0, 120.0), 0.5, |seconds| [12.0 * seconds, 300.0 + off(seconds), 80.0]);
    reports.extend(flight(2, 2.0, (1.0, 120.0), 0.5, |seconds| {
        [1200.0 - 9.0 * seconds, 700.0 + off(seconds), 90.0]
    }));
    let fired = fired(&reports, &[1, 2]);
    for number in [1, 2] {
        assert_eq!(first(&fired, number, Reason::Swapped, true), None);
        assert!(first(&fired, number, Reason::Jump, false).is_some());
    }
}

#[test]
fn jump_onto_a_continuing_path_is_no_exchange() {
    let mut reports = flight(1, 2.0, (0.0, 120.0), 0.5, eastward);
    let joins = |seconds: f64| if seconds < 60.0 { westward(seconds) } else { eastward(seconds) };
    reports.extend(flight(2, 2.0, (1.0, 120.0), 0.5, joins));
    let fired = fired(&reports, &[1, 2]);
    assert!(fired.iter().all(|fired| fired.reason == Reason::Jump && fired.number == 2), "{fired:?}");
}

#[test]
fn two_that_cross_are_none() {
    for period_s in [1.0, 2.0, 4.0] {
        // At one position at second 60, at a right angle.
        let mut reports =
            flight(1, period_s, (0.0, 120.0), 0.5, |seconds| [12.0 * (seconds - 60.0), 0.0, 80.0]);
        reports
            .extend(flight(2, period_s, (0.7, 120.0), 0.5, |seconds| [0.0, 15.0 * (seconds - 60.0), 80.0]));
        assert_silent(&reports, &[1, 2]);
    }
}
