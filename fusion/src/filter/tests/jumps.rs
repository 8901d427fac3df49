//! Reports far from the prediction: jumps of receivers, and braking aircraft.

use super::super::measurement::{By, Measurement};
use super::super::target::Dynamics;
use super::{dynamics, measurements, seconds, tracked};
use crate::frames::Enu;

/// An aircraft that brakes hard is where its transponder reports it, without doubt once the next report is received. A
/// receiver that jumps as far and flies on is in doubt.
#[test]
fn hard_braking_is_motion_and_a_step_aside_is_a_jump() {
    // 10 s at 16 m/s, then to rest within 2 s.
    let braking = |at: f64| match at {
        ..10.0 => 16.0 * at,
        10.0..12.0 => 160.0 + 16.0 * (at - 10.0) - 4.0 * (at - 10.0).powi(2),
        _ => 176.0,
    };
    let jumping = |at: f64| 16.0 * at - if at < 10.5 { 0.0 } else { 28.0 };
    for dynamics in dynamics() {
        for period_s in [1.0, 2.0, 3.0] {
            let flown = |north: &dyn Fn(f64) -> f64, until: f64| {
                let report = |index: u32| {
                    let at = 0.5 + period_s * f64::from(index);
                    let by = By::Transponder { horizontal_m: 0.4, vertical_m: 0.6 };
                    let position = Enu::new(0.0, north(at), 50.0);
                    let (velocity, climb) = (None, None);
                    Measurement { time: seconds(at), position, height_measured: true, by, velocity, climb }
                };
                let reports: Vec<_> =
                    (0..60).map(report).take_while(|report| report.time <= seconds(until)).collect();
                tracked(&reports, &dynamics)
            };
            let track = flown(&braking, 40.0);
            for at in 5..39 {
                let estimate = track.at(seconds(f64::from(at))).unwrap();
                let error_m = (estimate.position.north() - braking(f64::from(at))).abs();
                assert!(
                    error_m < 5.0 && estimate.sigma_m() < 8.0,
                    "{at} s: {error_m} ± {} m",
                    estimate.sigma_m()
                );
            }
            let doubtful = flown(&jumping, 20.0).at(seconds(20.0)).unwrap();
            assert!(period_s > 2.0 || doubtful.sigma_m() > 5.0, "{period_s} s: {} m", doubtful.sigma_m());
        }
    }
}

/// Standard deviation over ground at a time of a straight flight with a report every 2 s, displaced to the east by
/// `off`, metres.
fn sigma_with(dynamics: &Dynamics, off: impl Fn(f64) -> f64, at: f64) -> f64 {
    let measured = |index| {
        let at = 2.0 * f64::from(index);
        let by = By::Transponder { horizontal_m: 2.0, vertical_m: 2.0 };
        let position = Enu::new(off(at), 10.0 * at, 50.0);
        Measurement { time: seconds(at), position, height_measured: true, by, velocity: None, climb: None }
    };
    let measurements: Vec<_> = (0..=15).map(measured).collect();
    tracked(&measurements, dynamics).at(seconds(at)).unwrap().sigma_m()
}

/// A receiver that has jumped may be wrong by the length of the jump, for a while. Once it is back on the predicted
/// path it is right again, whatever the length and duration of the jump.
#[test]
fn a_jump_is_a_doubt_until_it_is_undone() {
    for dynamics in dynamics() {
        let sound_m = sigma_with(&dynamics, |_| 0.0, 29.0);
        for (at, least_m) in [(12.0, 150.0), (29.0, 100.0)] {
            let stayed_m = sigma_with(&dynamics, |at| if at > 9.0 { 300.0 } else { 0.0 }, at);
            assert!(stayed_m > least_m, "{stayed_m} m after {at} s, {dynamics:?}");
        }
        for (first_m, second_m) in [(300.0, 300.0), (-70_000.0, -70_000.0), (-70_000.0, 20_000.0)] {
            let off = |at: f64| match at {
                10.0 => first_m,
                12.0 => second_m,
                _ => 0.0,
            };
            let [away_m, back_m] = [10.0, 29.0].map(|at| sigma_with(&dynamics, off, at));
            assert!(away_m > 0.6 * f64::abs(first_m), "{first_m} m: {away_m} m, {dynamics:?}");
            assert!(back_m < 4.0 * sound_m, "{first_m}, {second_m} m: {back_m} m, {sound_m} m, {dynamics:?}");
        }
    }
}

/// One report that is kilometres too high is followed, with doubt, and changes neither the climb nor the position over
/// ground. The next one cancels it.
#[test]
fn a_jump_in_height_is_in_doubt_until_the_jump_back() {
    for dynamics in dynamics() {
        let mut reports = measurements(&[(2.0, 0.0, 0.0, 0); 12]);
        reports[6].position.0.z += 2_000.0;
        let known = |reports: &[Measurement]| {
            let last = reports.last().unwrap().time;
            let estimate = tracked(reports, &dynamics).at(last).unwrap();
            (estimate.position.up(), estimate.vertical.sqrt(), estimate.velocity.z, estimate.sigma_m())
        };
        let (height_m, vertical_m, climb, sigma_m) = known(&reports[..7]);
        assert!(height_m > 1_000.0 && vertical_m > 1_000.0, "{height_m} ± {vertical_m} m, {dynamics:?}");
        assert!(climb.abs() < 5.0 && sigma_m < 10.0, "{climb} m/s, {sigma_m} m, {dynamics:?}");
        let (height_m, vertical_m, climb, _) = known(&reports[..8]);
        assert!(
            (height_m - 50.0).abs() < 10.0 && vertical_m < 30.0,
            "{height_m} ± {vertical_m} m, {dynamics:?}"
        );
        assert!(climb.abs() < 5.0, "{climb} m/s, {dynamics:?}");
    }
}

/// A radar that measures the height that the transponder now reports limits the doubt to its own errors. A radar that
/// measures the earlier height, and one that measures none, do not.
#[test]
fn a_plot_settles_a_jump_in_height() {
    for dynamics in dynamics() {
        let vertical_m = |plots_higher_m: Option<f64>| {
            let mut all = measurements(&[(1.0, 0.0, 0.0, 0), (1.0, 0.0, 0.0, 1)].repeat(6));
            let last = all.len() - 1;
            for measurement in &mut all[last - 3..] {
                measurement.position.0.z += 2_000.0;
            }
            let plots = all.iter_mut().skip(last - 3).filter(|of| matches!(of.by, By::Radar { .. }));
            for plot in plots {
                plot.height_measured = plots_higher_m.is_some();
                plot.position.0.z += plots_higher_m.unwrap_or_default() - 2_000.0;
            }
            tracked(&all, &dynamics).at(all[last].time).unwrap().vertical.sqrt()
        };
        let (with_it_m, against_it_m, without_m) =
            (vertical_m(Some(2_000.0)), vertical_m(Some(0.0)), vertical_m(None));
        assert!(with_it_m < 60.0, "{with_it_m} m, {dynamics:?}");
        assert!(against_it_m > 500.0 && without_m > 500.0, "{against_it_m}, {without_m} m, {dynamics:?}");
    }
}

/// A radar that detects the aircraft where the transponder has jumped to limits the doubt to its own errors. If it
/// detects it at the earlier position, the doubt stays, as it does without a radar.
#[test]
fn plot_reduces_the_doubt_about_a_jump() {
    for dynamics in dynamics() {
        let sigma_m = |plots_north: Option<f64>| {
            let report = |index: u32| (2.0, 0.0, if index < 5 { 0.0 } else { 300.0 }, 0);
            let mut rows: Vec<_> = (0..7).map(report).collect();
            for _ in 0..4 {
                rows.extend(plots_north.map(|north| (1.0, 0.0, north, 1)));
                rows.push((if plots_north.is_some() { 1.0 } else { 2.0 }, 0.0, 300.0, 0));
            }
            let last = 2.0 * rows.iter().filter(|row| row.3 == 0).count() as f64;
            tracked(&measurements(&rows), &dynamics).at(seconds(last)).unwrap().sigma_m()
        };
        let (alone_m, with_it_m, against_it_m) = (sigma_m(None), sigma_m(Some(300.0)), sigma_m(Some(0.0)));
        assert!(with_it_m < 60.0, "{with_it_m} m, {dynamics:?}");
        assert!(alone_m > 130.0 && against_it_m > 130.0, "{alone_m}, {against_it_m} m, {dynamics:?}");
    }
}
