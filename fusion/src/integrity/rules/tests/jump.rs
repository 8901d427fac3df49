use super::*;

/// From second 60 on displaced by this distance in this direction, radians.
fn jumps(heading: f64, distance_m: f64) -> impl Fn(f64) -> [f64; 3] {
    move |seconds| {
        let [east, north, up] = eastward(seconds);
        let off_m = if seconds >= 60.0 { distance_m } else { 0.0 };
        [east + off_m * heading.sin(), north + off_m * heading.cos(), up]
    }
}

#[test]
fn jump_of_100_m_is_found_at_the_third_report_after_it() {
    for period_s in [0.2, 0.5, 1.0, 2.0, 3.0, 4.0, 4.4] {
        for heading in [0.0, 1.5, 3.1, 4.7] {
            let reports = flight(1, period_s, (0.0, 120.0), 0.5, jumps(heading, 100.0));
            let third_s = 60.0 + 3.0 * period_s + LATE_S + SLOT_S;
            assert_fires(&reports, 1, Reason::Jump, false, (60.0, third_s.min(75.0)));
        }
    }
}

#[test]
fn jump_suspicion_lasts_half_a_minute() {
    let reports = flight(1, 1.0, (0.0, 120.0), 0.5, jumps(0.0, 100.0));
    let mut held_s = Vec::new();
    run(&reports, |at_s, rules| {
        let finding = rules.finding(identity(1));
        assert!(finding.failed.is_empty());
        if finding.suspect.contains(Reason::Jump) {
            held_s.push(at_s);
        }
    });
    let (first_s, last_s) = (held_s[0], held_s[held_s.len() - 1]);
    assert!(first_s < 64.0 && last_s == 90.0, "{first_s} {last_s}");
}

#[test]
fn reflections_of_15_m_are_none() {
    for period_s in [0.2, 1.0, 2.0, 4.0] {
        let reflected = |seconds: f64| {
            let [east, north, up] = eastward(seconds);
            [east, north + if (seconds / 7.0) as i64 % 2 == 0 { 15.0 } else { 0.0 }, up]
        };
        assert_silent(&flight(1, period_s, (0.0, 300.0), 0.5, reflected), &[1]);
    }
}

#[test]
fn a_receiver_much_noisier_than_usual_does_not_jump() {
    for (number, noise_m) in [(1, 3.0), (2, 6.0), (3, 10.0)] {
        for period_s in [0.2, 1.0, 3.0] {
            assert_silent(&flight(number, period_s, (0.0, 900.0), noise_m, eastward), &[number]);
        }
    }
}

#[test]
fn a_single_report_that_is_off_is_none() {
    let mut reports = flight(1, 1.0, (0.0, 120.0), 0.5, eastward);
    reports[60].1.position.0.y += 400.0;
    assert_silent(&reports, &[1]);
}

#[test]
fn hard_turns_and_stops_are_none() {
    // 17 m/s in a bank of 35°; there and back with 4 m/s²; 12 m/s, braked with 4 m/s² to a hover of 9 s and on.
    let circle = |seconds: f64| [42.1 * (0.404 * seconds).sin(), 42.1 * (0.404 * seconds).cos(), 80.0];
    let shuttle = |seconds: f64| [60.0 * (0.26 * seconds).sin(), 0.0, 80.0];
    let stops = |seconds: f64| {
        let (legs, phase) = ((seconds / 30.0).floor(), seconds % 30.0);
        let (braking, starting) = ((phase - 15.0).clamp(0.0, 3.0), (phase - 27.0).max(0.0));
        let on_m = 12.0 * phase.min(18.0) - 2.0 * braking * braking + 2.0 * starting * starting;
        [216.0 * legs + on_m, 0.0, 80.0]
    };
    for period_s in [0.2, 1.0, 2.0, 3.1, 4.0, 4.4] {
        assert_silent(&flight(1, period_s, (0.0, 300.0), 0.5, circle), &[1]);
        assert_silent(&flight(1, period_s, (0.0, 300.0), 0.5, shuttle), &[1]);
        assert_silent(&flight(1, period_s, (0.0, 300.0), 0.5, stops), &[1]);
    }
}

#[test]
fn a_gap_and_reports_out_of_order_are_no_evidence() {
    let mut reports = flight(1, 2.0, (0.0, 60.0), 0.5, eastward);
    // Silent for 20 s, during which it flies to the north.
    reports
        .extend(flight(1, 2.0, (80.0, 140.0), 0.5, |seconds| [720.0, 300.0 + 12.0 * (seconds - 60.0), 80.0]));
    for (index, (arrives_s, _)) in reports.iter_mut().enumerate() {
        *arrives_s += if index % 7 == 3 { 5.0 } else { 0.0 };
    }
    let doubled: Vec<Arrival> =
        reports.iter().step_by(3).map(|&(arrives_s, fix)| (arrives_s + 0.7, fix)).collect();
    reports.extend(doubled);
    assert_silent(&reports, &[1]);
}

#[test]
fn two_receivers_with_different_delays_are_no_jump() {
    let mut reports = flight(1, 1.0, (0.0, 200.0), 0.5, eastward);
    let late = |&(arrives_s, mut fix): &Arrival| {
        (fix.time, fix.sensor) = (fix.time + SignedDuration::from_millis(1700), SensorIndex(2));
        (arrives_s + 1.7, fix)
    };
    let second: Vec<Arrival> = reports.iter().map(late).collect();
    reports.extend(second);
    assert_silent(&reports, &[1]);
}
