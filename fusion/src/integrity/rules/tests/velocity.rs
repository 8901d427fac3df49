use super::*;

fn straight(period_s: f64, noise_m: f64, states: impl Fn(f64) -> [f64; 2]) -> Vec<Arrival> {
    stating(flight(1, period_s, (0.0, 200.0), noise_m, eastward), states)
}

#[test]
fn motion_against_stated_velocity_is_suspect() {
    // 12 m/s eastward; the report adds 6 m/s to the north and a small variation.
    for period_s in [0.5, 1.0, 2.0] {
        let reports = straight(period_s, 0.5, |seconds| [12.0, 6.0 + 0.3 * (seconds * 0.3).sin()]);
        assert_fires(&reports, 1, Reason::Velocity, false, (14.0, 25.0));
    }
}

#[test]
fn a_drift_that_it_does_not_state_shows() {
    let drifts = |seconds: f64| [12.0 * seconds, 300.0 + 5.0 * (seconds - 60.0).max(0.0), 80.0];
    let reports = flight(1, 1.0, (0.0, 200.0), 0.5, drifts);
    let reports = stating(reports, |seconds| [12.0, 0.1 * (seconds * 0.3).sin()]);
    assert_fires(&reports, 1, Reason::Velocity, false, (70.0, 85.0));
}

#[test]
fn zero_constant_and_absent_velocities_are_no_evidence() {
    assert_silent(&straight(1.0, 0.5, |_| [0.0, 0.0]), &[1]);
    assert_silent(&straight(1.0, 0.5, |_| [-7.0, 3.0]), &[1]);
    assert_silent(&flight(1, 1.0, (0.0, 200.0), 0.5, eastward), &[1]);
}

#[test]
fn velocities_cut_off_to_whole_m_s_and_a_second_old_are_honest() {
    // From 1.7 m/s to 15.9 m/s, in circles and back and forth.
    let omega = 0.15;
    let circle = |seconds: f64| [106.0 * (omega * seconds).sin(), 106.0 * (omega * seconds).cos(), 80.0];
    let states = |seconds: f64| {
        let old = omega * (seconds - 1.0);
        [(106.0 * omega * old.cos()).trunc(), (-106.0 * omega * old.sin()).trunc()]
    };
    for (period_s, noise_m) in [(0.2, 0.5), (1.0, 0.5), (1.0, 5.0), (3.0, 0.5), (4.0, 2.0)] {
        let reports = stating(flight(1, period_s, (0.0, 300.0), noise_m, circle), states);
        assert_silent(&reports, &[1]);
        let slow = stating(
            flight(1, period_s, (0.0, 300.0), noise_m, |seconds| [1.9 * seconds, 0.0, 80.0]),
            |seconds| [1.0 + f64::from(seconds as i32 % 40 == 7), 0.0],
        );
        assert_silent(&slow, &[1]);
    }
}

#[test]
fn a_jump_is_no_other_velocity() {
    let jumps = |seconds: f64| [12.0 * seconds, if seconds >= 60.0 { 400.0 } else { 300.0 }, 80.0];
    let reports =
        stating(flight(1, 1.0, (0.0, 120.0), 0.5, jumps), |seconds| [12.0, 0.1 * (seconds * 0.3).sin()]);
    assert_eq!(first(&fired(&reports, &[1]), 1, Reason::Velocity, false), None);
}

#[test]
fn gaps_are_no_evidence() {
    let mut reports = straight(1.0, 0.5, |seconds| [12.0, 0.1 * (seconds * 0.3).sin()]);
    // The position jumps within each gap of 8 s.
    for (_, fix) in &mut reports {
        let seconds = fix.time.seconds_since(at(0.0));
        fix.position.0.x += 5000.0 * (seconds / 20.0).floor();
    }
    reports.retain(|(_, fix)| fix.time.seconds_since(at(0.0)) % 20.0 < 12.0);
    assert_eq!(first(&fired(&reports, &[1]), 1, Reason::Velocity, false), None);
}
