//! Several sources of one aircraft: which of them counts, and which values one takes from the other.
#![expect(clippy::unwrap_used, reason = "a test that panics has failed")]

use utm_fusion_engine::point::Basis;
use utm_fusion_engine::report::{Aircraft, AircraftKind};
use utm_fusion_engine::settings::{Profile, Radar, RadarErrors, Receiver, RegistrationMode};
use utm_fusion_engine::time::{SECOND, Time};
use utm_fusion_engine::{
    Emission, Engine, Enu, Fix, Identity, Plot, Point, RadarTrackKey, Report, SensorIndex, Settings,
};

/// Sensors of [`settings`].
const RADAR: SensorIndex = SensorIndex(0);
const GOOD: SensorIndex = SensorIndex(1);
const POOR: SensorIndex = SensorIndex(2);
const GOOD_M: f64 = 3.0;

/// A radar, a receiver with position errors of 3 m, and one with position errors of `poor_m`.
fn settings(poor_m: f64) -> Settings {
    let mut settings = Settings { profile: Profile::Operational(Default::default()), ..Settings::default() };
    settings.add_radar(Radar {
        errors: RadarErrors::of_data_sheet(5.0, 0.5, 8.0),
        registration: RegistrationMode::Off,
        period_s: 0.5,
        ..Radar::default()
    });
    for horizontal_m in [GOOD_M, poor_m] {
        settings.add_receiver(Receiver {
            horizontal_m,
            delay_s: Some(0.0),
            period_s: 1.0,
            ..Receiver::default()
        });
    }
    settings
}

fn at(seconds: f64) -> Time {
    Time::from_nanos(1_700_000_000 * SECOND + (seconds * SECOND as f64) as i64)
}

/// Time since the start, seconds.
fn seconds(emission: &Emission) -> f64 {
    emission.time.seconds_since(at(0.0))
}

fn drone() -> Identity {
    Identity::new(b"DRONE", None).unwrap()
}

/// Northward at 12 m/s, 100 m up, displaced to the east.
fn place(seconds: f64, east_m: f64) -> Enu {
    Enu::new(east_m, 1000.0 + 12.0 * seconds, 100.0)
}

/// A report on that line by one of the receivers; that of [`POOR`] is displaced to the east.
fn fix(sensor: SensorIndex, seconds: f64, off_m: f64) -> Report {
    let east_m = if sensor == POOR { off_m } else { 0.0 };
    Report::Fix(Fix::new(sensor, drone(), at(seconds), place(seconds, east_m)))
}

/// Each report is received 0.2 s after its time.
fn fly(settings: Settings, mut reports: Vec<Report>) -> Vec<Emission> {
    reports.sort_by_key(Report::time);
    let mut engine = Engine::new(settings).unwrap();
    let mut emissions = Vec::new();
    for report in reports {
        emissions.extend(engine.advance(Time::from_nanos(report.time().nanos() + SECOND / 5)));
        engine.handle(report).unwrap();
    }
    emissions.extend(engine.finish());
    emissions
}

/// Times and points between two seconds; each slot has one point.
fn points(emissions: &[Emission], from_s: f64, to_s: f64) -> Vec<(f64, Point)> {
    let within = emissions.iter().filter(|emission| (from_s..to_s).contains(&seconds(emission)));
    let one = |emission: &Emission| {
        assert_eq!(emission.points.len(), 1, "{} s: {:?}", seconds(emission), emission.points);
        (seconds(emission), emission.points[0].clone())
    };
    let points: Vec<_> = within.map(one).collect();
    assert_eq!(points.len(), ((to_s - from_s) * 4.0) as usize, "in each slot");
    points
}

/// Both receivers report each second, half a second apart, except for the good one from second 40 to 60.
fn both(off_m: f64) -> Vec<Report> {
    let good = (0..100).map(f64::from).filter(|second| !(40.0..60.0).contains(second));
    let poor = (0..100).map(|second| f64::from(second) + 0.5);
    good.map(|second| fix(GOOD, second, off_m)).chain(poor.map(|second| fix(POOR, second, off_m))).collect()
}

fn receiver(point: &Point) -> SensorIndex {
    point.source.transponder().unwrap().sensor
}

#[test]
fn the_far_better_source_counts_alone_while_it_speaks() {
    const OFF_M: f64 = 40.0;
    let emissions = fly(settings(10.0), both(OFF_M));
    for (second, point) in points(&emissions, 5.0, 38.0) {
        assert_eq!(receiver(&point), GOOD, "{second} s");
        assert!(point.position.east().abs() < 0.1, "{second} s: {} m", point.position.east());
    }
    // Once the good receiver is silent for longer than 5 s (from second 39 on), the other one counts.
    for (second, point) in points(&emissions, 46.0, 59.0) {
        assert_eq!(receiver(&point), POOR, "{second} s");
        assert!((point.position.east() - OFF_M).abs() < 10.0, "{second} s: {} m", point.position.east());
    }
    // When it reports again, the good receiver counts at once.
    for (second, point) in points(&emissions, 66.0, 98.0) {
        assert_eq!(receiver(&point), GOOD, "{second} s");
        assert!(point.position.east().abs() < 1.0, "{second} s: {} m", point.position.east());
    }
    // The aircraft keeps one number all the time.
    let all = points(&emissions, 5.0, 98.0);
    assert!(all.iter().all(|(_, point)| point.number == all[0].1.number));
}

#[test]
fn of_two_sources_that_are_about_as_good_both_count() {
    // Twice as poor is not far poorer.
    let emissions = fly(settings(2.0 * GOOD_M), both(4.0));
    let of_poor =
        |points: &[(f64, Point)]| points.iter().filter(|(_, point)| receiver(point) == POOR).count();
    let shared = points(&emissions, 5.0, 38.0);
    assert!((50..82).contains(&of_poor(&shared)), "{} of {}", of_poor(&shared), shared.len());
    let farther = fly(settings(2.1 * GOOD_M), both(4.0));
    assert_eq!(of_poor(&points(&farther, 5.0, 38.0)), 0);
}

#[test]
fn a_poor_source_alone_is_a_source() {
    let reports = (0..40).map(|second| fix(POOR, f64::from(second), 40.0)).collect();
    for (_, point) in points(&fly(settings(200.0), reports), 5.0, 38.0) {
        assert!((point.position.east() - 40.0).abs() < 0.1 && receiver(&point) == POOR);
    }
}

/// Flight of a transponder at 100 m that reports no height, or this one, beside a radar that measures heights, or none.
fn beside_a_radar(stated_m: Option<f64>, is_measured_by_radar: bool) -> Vec<Emission> {
    let mut reports = Vec::new();
    for half in 0..240 {
        let second = f64::from(half) / 2.0;
        let track = RadarTrackKey { sensor: RADAR, number: 7 };
        let seen = place(second, 0.0);
        let mut plot = Plot::new(track, at(second), seen, seen.0.norm());
        plot.uav_probability = Some(0.95);
        if !is_measured_by_radar {
            plot.height_measured = false;
            plot.position = Enu::new(seen.east(), seen.north(), 300.0);
        }
        reports.push(Report::Plot(plot));
        if half % 2 == 0 {
            let (up_m, height_measured) = stated_m.map_or((0.0, false), |height_m| (height_m, true));
            let position = Enu::new(seen.east(), seen.north(), up_m);
            let fix = Fix::new(GOOD, drone(), at(second), position);
            reports.push(Report::Fix(Fix { height_measured, ..fix }));
        }
    }
    fly(settings(10.0), reports)
}

#[test]
fn transponder_without_height_uses_the_radars() {
    let sigma_m = |point: &Point| point.estimate.unwrap().vertical_m2.sqrt();
    let fused = points(&beside_a_radar(None, true), 30.0, 115.0);
    for (second, point) in &fused {
        assert!(!point.source.height_measured(), "its transponder states none");
        let (up_m, sigma_m) = (point.position.up(), sigma_m(point));
        assert!((up_m - 100.0).abs() < 2.0 && sigma_m < 15.0, "{second} s: {up_m} m, {sigma_m} m");
    }
    assert!(fused.iter().any(|(_, point)| point.source.radar().is_some()), "it is fused");

    // A radar that measures no height cannot provide one.
    for (second, point) in points(&beside_a_radar(None, false), 30.0, 115.0) {
        assert!(sigma_m(&point) > 50.0, "{second} s: {} m", sigma_m(&point));
    }
    // A reported height is used alone, without the radar's.
    for (second, point) in points(&beside_a_radar(Some(112.0), true), 30.0, 115.0) {
        assert!((point.position.up() - 112.0).abs() < 1e-6, "{second} s: {} m", point.position.up());
    }
}

/// An aircraft of this kind at this speed, reported each second.
fn fast(kind: AircraftKind, speed_m_s: f64) -> Vec<Emission> {
    let report = |second: i32| {
        let second = f64::from(second);
        let identity = Identity::of_address(0x48_4A_F0);
        let position = Enu::new(speed_m_s * second - 9000.0, 2000.0, 900.0);
        let aircraft = Aircraft { kind, ..Aircraft::default() };
        Report::Fix(Fix { aircraft, ..Fix::new(GOOD, identity, at(second), position) })
    };
    fly(settings(10.0), (0..40).map(report).collect())
}

#[test]
fn an_airliner_is_admitted_and_a_drone_as_fast_is_not() {
    let shown = |kind, speed_m_s| !fast(kind, speed_m_s).iter().all(|emission| emission.points.is_empty());
    assert!(shown(AircraftKind::Crewed, 300.0));
    assert!(shown(AircraftKind::Unmanned, 90.0));
    assert!(!shown(AircraftKind::Unmanned, 300.0));
    assert!(!shown(AircraftKind::Crewed, 460.0), "350 m/s and the 100 m of their errors");
}

/// A drone whose reports state this radius, metres, up to second 60.
fn stating(accuracy_m: Option<f64>) -> Vec<Emission> {
    let report = |second: i32| {
        let second = f64::from(second);
        Report::Fix(Fix { accuracy_m, ..Fix::new(GOOD, drone(), at(second), place(second, 0.0)) })
    };
    // Another drone reports for longer, so that slots continue.
    let other = |second: i32| {
        let identity = Identity::new(b"OTHER", None).unwrap();
        Report::Fix(Fix::new(GOOD, identity, at(f64::from(second)), Enu::new(5000.0, 0.0, 100.0)))
    };
    fly(settings(10.0), (0..60).map(report).chain((0..120).map(other)).collect())
}

/// Times and standard deviations over ground of the drone in the pictures of now.
fn now(emissions: &[Emission]) -> Vec<(f64, f64)> {
    let pictures = emissions.iter().filter_map(|emission| emission.now.as_ref());
    let of_drone = pictures.filter_map(|now| {
        let is_it = |point: &&Point| point.source.transponder().unwrap().identity == drone();
        let point = now.points.iter().find(is_it)?;
        let estimate = point.estimate.unwrap();
        assert_eq!(estimate.basis, Basis::Extrapolated);
        Some((now.time.seconds_since(at(0.0)), estimate.sigma_m()))
    });
    of_drone.collect()
}

#[test]
fn poor_stated_accuracy_is_kept_in_the_current_picture() {
    // NACp 5: a radius of half a nautical mile contains 95 %, of 445 m half.
    let poor = now(&stating(Some(445.4)));
    let flying: Vec<_> = poor.iter().filter(|(second, _)| (20.0..59.0).contains(second)).collect();
    assert_eq!(flying.len(), 156, "in each of its slots");
    for (second, sigma_m) in flying {
        // 445.4 m / 1.1774 is a standard deviation; a tenth of it is independent between reports.
        assert!((350.0..380.0).contains(sigma_m), "{second} s: {sigma_m} m");
    }
    // The aircraft is not shown forever.
    let last_s = poor.last().unwrap().0;
    assert!((60.0..85.0).contains(&last_s), "{last_s} s");

    let good = now(&stating(None));
    assert!(good.iter().all(|(_, sigma_m)| *sigma_m <= 25.0));
    assert!((60.0..70.0).contains(&good.last().unwrap().0) && good.last().unwrap().0 < last_s);
}
