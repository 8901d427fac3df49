use super::*;

/// Two transmitters: the second is 500 m to the north and reports between the reports of the first.
fn doubled(period_s: f64, sensor: u16) -> Vec<Arrival> {
    let mut reports = flight(1, period_s, (0.0, 120.0), 0.5, eastward);
    let north = |seconds: f64| [12.0 * seconds, 800.0, 80.0];
    let second = flight(2, period_s, (60.0 + period_s / 2.0, 120.0), 0.5, north).into_iter();
    reports.extend(second.map(|(arrives_s, fix)| {
        (arrives_s, Fix { identity: identity(1), sensor: SensorIndex(sensor), ..fix })
    }));
    reports
}

#[test]
fn two_transmitters_show_with_the_third_change() {
    for (period_s, by_s) in [(0.5, 62.0), (2.0, 64.0), (4.0, 67.5)] {
        assert_fires(&doubled(period_s, 1), 1, Reason::Duplicate, true, (60.0, by_s + LATE_S));
    }
}

#[test]
fn duplicate_is_found_across_two_receivers() {
    assert_fires(&doubled(2.0, 2), 1, Reason::Duplicate, true, (60.0, 70.0));
}

#[test]
fn one_jump_there_and_back_is_none() {
    let there_and_back =
        |seconds: f64| [12.0 * seconds, if (60.0..66.0).contains(&seconds) { 800.0 } else { 300.0 }, 80.0];
    for period_s in [1.0, 2.0, 3.0] {
        let fired = fired(&flight(1, period_s, (0.0, 120.0), 0.5, there_and_back), &[1]);
        assert_eq!(first(&fired, 1, Reason::Duplicate, true), None);
    }
}

#[test]
fn two_receivers_that_stamp_differently_are_none() {
    // 30 m/s, with stamps 1.9 s later at the second receiver: the positions are always 57 m apart.
    let fast = |seconds: f64| [30.0 * seconds, 0.0, 80.0];
    let mut reports = flight(1, 1.0, (0.0, 120.0), 0.5, fast);
    let late = |&(arrives_s, fix): &Arrival| {
        let time = fix.time + SignedDuration::from_millis(1900);
        (arrives_s + 1.9, Fix { time, sensor: SensorIndex(2), ..fix })
    };
    let second: Vec<Arrival> = reports.iter().map(late).collect();
    reports.extend(second);
    assert_silent(&reports, &[1]);
}

#[test]
fn an_aircraft_faster_than_any_drone_is_none() {
    let jet = |seconds: f64| [200.0 * seconds, 0.0, 3000.0];
    for period_s in [0.5, 1.0, 4.0] {
        assert_silent(&flight(1, period_s, (0.0, 120.0), 2.0, jet), &[1]);
    }
}

#[test]
fn reflections_at_a_fast_receiver_are_none() {
    let reflected = |seconds: f64| {
        let off_m = if (seconds * 5.0) as i64 % 2 == 0 { 15.0 } else { -15.0 };
        [12.0 * seconds, off_m, 80.0]
    };
    let fired = fired(&flight(1, 0.2, (0.0, 60.0), 0.5, reflected), &[1]);
    assert_eq!(first(&fired, 1, Reason::Duplicate, true), None);
}
