//! The limit compared with closed forms, and on simulated flights.

use utm_fusion::simulate::simulate;

use super::gaussian::{GaussianState, MeasurementRow};
use super::inputs::LimitInputs;
use super::mixture::MotionMixture;
use super::model::{self, HEIGHT, MotionLevels, SensorErrors, SlowError, VerticalModel, Z, Z_ASKED};
use super::smoother::{
    DelayPrior, LimitMeasurement, LinearMeasurement, MeasurementKind, RequestedTime, SmoothedEstimate,
    Smoother,
};
use super::{COVERED, LIMITS, NEES, NEES_HEIGHT, PRODUCT, UNKNOWN, WAYS};
use crate::flights;

const ANTENNA_M: f64 = 59.0;

/// Sensors with these white errors and no slow errors.
fn white(report_m: f64, plot_m: f64) -> SensorErrors {
    let none = SlowError { sigma: 0.0, time_s: 20.0 };
    SensorErrors {
        gnss: none,
        gnss_height: none,
        white_m: report_m,
        track_azimuth: none,
        track_range: none,
        track_height: none,
        plot_azimuth: 0.003,
        plot_range_m: plot_m,
        plot_height_m: plot_m,
    }
}

/// Motion without manoeuvres, with this spectral density of the acceleration.
fn calm(density: f64) -> MotionLevels {
    MotionLevels {
        steady: density,
        climb: [density; 2],
        durations_s: [f64::INFINITY; 3],
        ..MotionLevels::default()
    }
}

/// A report without latency, of a drone that flies east.
fn report(time_s: f64, delay_s: f64, speed_m_s: f64) -> LimitMeasurement {
    let place_m = [speed_m_s * (time_s - delay_s), 1000.0];
    LimitMeasurement {
        time_s,
        arrives_s: time_s,
        height_m: Some(100.0),
        kind: MeasurementKind::Report { place_m, velocity_m_s: [speed_m_s, 0.0] },
    }
}

/// A plot of the same drone.
fn plot(time_s: f64, speed_m_s: f64) -> LimitMeasurement {
    let place_m: [f64; 2] = [speed_m_s * time_s, 1000.0];
    let range_m = place_m[0].hypot(place_m[1]);
    let along = [place_m[0] / range_m, place_m[1] / range_m];
    let across = [along[1] / range_m, -along[0] / range_m];
    let range = LinearMeasurement { factors: along, value: range_m };
    let azimuth = LinearMeasurement { factors: across, value: 0.0 };
    let kind = MeasurementKind::Plot { place_m, azimuth, range, turning: 1.0, track: 1 };
    LimitMeasurement { time_s, arrives_s: time_s, height_m: Some(100.0), kind }
}

fn at_once(mut measured: Vec<LimitMeasurement>) -> Vec<LimitMeasurement> {
    measured.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    measured
}

fn every(step_s: f64, until_s: f64) -> impl Iterator<Item = f64> {
    (0..=(until_s / step_s) as usize).map(move |step| step as f64 * step_s)
}

fn estimate(
    sensors: SensorErrors,
    levels: MotionLevels,
    measured: &[LimitMeasurement],
    delay: DelayPrior,
    requested: (f64, f64),
) -> SmoothedEstimate {
    let requested = RequestedTime { time_s: requested.0, deadline_s: requested.1 };
    let smoother = Smoother::new(sensors, levels, ANTENNA_M);
    smoother.estimates(measured, delay, &[requested])[0].expect("something has arrived")
}

const KNOWN: DelayPrior = DelayPrior { mean_s: 0.0, sigma_s: 0.0 };

fn near(value: f64, expected: f64, share: f64) {
    assert!((value / expected - 1.0).abs() < share, "{value} instead of {expected}");
}

/// White acceleration of density q, and positions with white noise of density r, in continuous time. The filter's
/// variance is sqrt(2) (q r³)^(1/4); the smoother's, far from both ends, is a quarter of it.
#[test]
fn steady_variances_are_those_of_the_closed_form() {
    let (density, step_s, sigma_m) = (0.2, 0.002, 3.0);
    let vertical = VerticalModel { sensors: white(sigma_m, 1.0), levels: calm(density) };
    let mut state =
        MotionMixture::new([0.5; 2], GaussianState::independent([0.0; HEIGHT], [40.0, 2.0, 0.0, 0.0, 0.0]));
    let run = |state: &mut MotionMixture<HEIGHT, 2>| {
        for _ in 0..20_000 {
            state.predict(&vertical, step_s);
            state.update(|part| model::report_height(part, 0.0, 0.0, sigma_m));
        }
    };
    run(&mut state);
    let expected = 2.0_f64.sqrt() * (density * (sigma_m * sigma_m * step_s).powi(3)).powf(0.25);
    near(state.whole().covariance[Z][Z], expected, 0.01);
    state.transform(&[MeasurementRow::copy(Z_ASKED, Z)]);
    run(&mut state);
    near(state.whole().covariance[Z_ASKED][Z_ASKED], expected / 4.0, 0.02);
}

/// Mixing two equal modes gives the same result as one mode.
#[test]
fn equal_modes_are_one_kalman_filter() {
    let levels = MotionLevels { climb_durations_s: [2.0, 3.0], ..calm(0.2) };
    let vertical = VerticalModel { sensors: white(3.0, 1.0), levels };
    let begin = GaussianState::independent([0.0; HEIGHT], [40.0, 2.0, 0.0, 0.0, 0.0]);
    let mut mixed = MotionMixture::new([0.9, 0.1], begin);
    let mut single = MotionMixture::new([1.0, 0.0], begin);
    for measured_m in [3.0, -1.0, 4.0, 6.0] {
        for state in [&mut mixed, &mut single] {
            state.predict(&vertical, 1.0);
            state.update(|part| model::report_height(part, measured_m, 0.1, 3.0));
        }
    }
    near(mixed.mean(Z), single.mean(Z), 1e-9);
    near(mixed.whole().covariance[Z][Z], single.whole().covariance[Z][Z], 1e-9);
}

#[test]
fn constant_error_of_reports_is_not_seen_without_a_radar() {
    let sensors = SensorErrors { gnss: SlowError { sigma: 1.8, time_s: 1e9 }, ..white(0.5, 2.0) };
    let reports: Vec<LimitMeasurement> = every(1.0, 400.0).map(|time_s| report(time_s, 0.0, 5.0)).collect();
    let alone = estimate(sensors, calm(1e-6), &reports, KNOWN, (390.0, 396.0));
    near(alone.ground_m2[(0, 0)], 1.8 * 1.8, 0.01);
    let plots = every(1.0, 400.0).map(|time_s| plot(time_s + 0.5, 5.0));
    let both = at_once(reports.iter().copied().chain(plots).collect());
    let both = estimate(sensors, calm(1e-6), &both, KNOWN, (390.0, 396.0));
    assert!(both.ground_m2[(0, 0)] < 0.1 * 1.8 * 1.8, "{}", both.ground_m2);
}

#[test]
fn delay_is_learnt_from_a_radar_and_not_from_reports() {
    let (delay_s, speed_m_s) = (0.2, 20.0);
    let unknown = DelayPrior { mean_s: 0.0, sigma_s: 0.1 };
    let reports: Vec<LimitMeasurement> =
        every(2.0, 60.0).map(|time_s| report(time_s, delay_s, speed_m_s)).collect();
    let alone = estimate(white(0.5, 2.0), calm(1e-6), &reports, unknown, (50.0, 56.0));
    near(alone.delay_s[1], 0.1, 0.01);
    assert!(alone.delay_s[0].abs() < 1e-3, "{:?}", alone.delay_s);
    let plots = every(0.5, 60.0).map(|time_s| plot(time_s, speed_m_s));
    let both = at_once(reports.iter().copied().chain(plots).collect());
    let both = estimate(white(0.5, 2.0), calm(1e-6), &both, unknown, (50.0, 56.0));
    let [mean_s, sigma_s] = both.delay_s;
    assert!(sigma_s < 0.03 && (mean_s - delay_s).abs() < 3.0 * sigma_s, "{:?}", both.delay_s);
}

#[test]
fn report_after_the_deadline_changes_nothing() {
    let mut reports: Vec<LimitMeasurement> =
        every(2.0, 20.0).map(|time_s| report(time_s, 0.0, 10.0)).collect();
    let of = |reports: &[LimitMeasurement], deadline_s| {
        estimate(white(0.5, 2.0), MotionLevels::default(), reports, KNOWN, (11.0, deadline_s)).ground_m2
    };
    let all = of(&reports, 17.0);
    let without: Vec<LimitMeasurement> = reports.iter().copied().filter(|one| one.time_s != 12.0).collect();
    let without = of(&without, 17.0);
    assert!(without[(0, 0)] > 1.02 * all[(0, 0)], "the report at 12 s counts");
    reports[6].arrives_s = 17.5;
    assert_eq!(of(&reports, 17.0), without);
    near(of(&reports, 17.6)[(0, 0)], all[(0, 0)], 1e-9);
}

#[test]
fn slow_errors_of_a_new_radar_track_are_its_own() {
    let slow = SlowError { sigma: 4.0, time_s: 1e9 };
    let sensors = SensorErrors { track_range: slow, track_height: slow, ..white(0.5, 1.0) };
    let two = |second: u32| {
        let of = |time_s: f64| {
            let mut one = plot(time_s, 0.0);
            if let (MeasurementKind::Plot { track, .. }, true) = (&mut one.kind, time_s > 20.0) {
                *track = second;
            }
            one
        };
        let plots: Vec<LimitMeasurement> = every(0.5, 40.0).map(of).collect();
        estimate(sensors, calm(1e-9), &plots, KNOWN, (39.0, 40.0))
    };
    // Range is north here: two independent errors halve its variance.
    let (same, other) = (two(1), two(2));
    near(same.ground_m2[(1, 1)], 16.0, 0.05);
    near(other.ground_m2[(1, 1)], 8.0, 0.05);
    near(other.height_m2 / same.height_m2, 0.5, 0.05);
}

/// Mean normalised square of all equipped drones, over ground and in height; and mean error relative to that of reports
/// interpolated with the next two known. The seeds were not used to fit the levels.
#[test]
fn limit_is_consistent_and_no_worse_than_interpolation() {
    let scenario = flights::scenario("crossing").unwrap();
    let radar = &scenario.radars[0];
    let (mut nees, mut errors_m, mut count) = ([0.0; 2], [0.0; 2], 0.0);
    for seed in 101..=112 {
        let simulation = simulate(&scenario, seed, None).unwrap();
        let inputs = LimitInputs::of(&scenario, radar, seed, &simulation).unwrap();
        let smoother =
            Smoother::new(SensorErrors::of(&scenario, radar), MotionLevels::default(), inputs.antenna_m);
        for (number, drone) in inputs.drones.iter().enumerate() {
            let Some(delay_s) = drone.delay_s else { continue };
            let requested = every(5.0, 270.0).map(|step_s| 12.0 + step_s);
            let requested: Vec<RequestedTime> =
                requested.map(|time_s| RequestedTime { time_s, deadline_s: time_s + 6.125 }).collect();
            let delay = DelayPrior { mean_s: delay_s, sigma_s: 0.0 };
            for (requested, found) in
                requested.iter().zip(smoother.estimates(&drone.measured, delay, &requested))
            {
                let reports = drone.measured.iter().filter_map(|one| match one.kind {
                    MeasurementKind::Report { place_m, .. } if one.arrives_s <= requested.deadline_s => {
                        Some((one.time_s - delay_s, place_m))
                    }
                    _ => None,
                });
                let before = reports.clone().rfind(|(time_s, _)| *time_s <= requested.time_s);
                let after = reports.clone().find(|(time_s, _)| *time_s > requested.time_s);
                let (Some(found), Some(before), Some(after)) = (found, before, after) else { continue };
                let share = (requested.time_s - before.0) / (after.0 - before.0);
                let truth_m = inputs.truth_m(number, requested.time_s);
                let line =
                    |axis: usize| before.1[axis] * (1.0 - share) + after.1[axis] * share - truth_m[axis];
                let error_m = std::array::from_fn(|axis| found.place_m[axis] - truth_m[axis]);
                let normalised = found.normalised(error_m).unwrap();
                (0..2).for_each(|part| nees[part] += normalised[part]);
                errors_m[0] += error_m[0].hypot(error_m[1]);
                errors_m[1] += line(0).hypot(line(1));
                count += 1.0;
            }
        }
    }
    let nees = nees.map(|sum| sum / count);
    // 96 drones with errors that last for a minute: at least as many independent samples.
    assert!((0.8..1.25).contains(&nees[0]) && (0.75..1.3).contains(&nees[1]), "{nees:?}");
    assert!(errors_m[0] < 0.95 * errors_m[1], "{errors_m:?}");
}

#[test]
fn limit_is_below_the_product_on_crossing() {
    let measured = super::measure(&["crossing"], &(101..=102), 2).unwrap();
    let figure = |figure, way| measured[0].figure(figure, way).unwrap().mean;
    for (limit, way) in WAYS.iter().enumerate().skip(UNKNOWN) {
        // The product learns delays by type, but the limit learns each one separately.
        let at_most = if limit == UNKNOWN { 1.1 } else { 1.0 };
        assert!(figure(COVERED, limit) < at_most * figure(COVERED, PRODUCT), "{way}");
        assert!(
            (0.6..1.6).contains(&figure(NEES, limit)) && (0.5..1.7).contains(&figure(NEES_HEIGHT, limit))
        );
    }
    // A known delay reduces the error.
    assert!(figure(COVERED, LIMITS) < figure(COVERED, UNKNOWN));
    assert_eq!(measured[0].unknown(), 0);
}
