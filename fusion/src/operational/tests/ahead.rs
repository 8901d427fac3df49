use crate::operational::tests::two_drones::{START, TRACKS, identity, place, reports, settings};
use crate::operational::tuning::COAST_MAX_S;
use crate::point::{Basis, Estimate};
use crate::report::{Identity, Report};
use crate::time::{SECOND, Time};
use crate::{Emission, Engine, Point};

/// Flies the reports of the flight that `keep` accepts, by the second of their reception.
fn fly(keep: impl Fn(i64, &Report) -> bool) -> Vec<Emission> {
    let mut engine = Engine::new(settings(true)).unwrap();
    let mut emissions = Vec::new();
    for (received, report) in reports(60) {
        emissions.extend(engine.advance(received));
        if keep(received.nanos() / SECOND - START, &report) {
            engine.handle(report).unwrap();
        }
    }
    emissions.extend(engine.finish());
    emissions
}

/// Time since the start of the flight, seconds.
fn second(time: Time) -> f64 {
    time.seconds_since(Time::from_nanos(START * SECOND))
}

/// The slots between these seconds of the flight.
fn between(emissions: &[Emission], from: f64, until: f64) -> impl Iterator<Item = &Emission> {
    emissions.iter().filter(move |emission| (from..until).contains(&second(emission.time)))
}

fn estimate(point: &Point) -> &Estimate {
    point.estimate.as_ref().unwrap()
}

fn of(report: &Report, which: usize) -> bool {
    match report {
        Report::Plot(plot) => plot.track.number == TRACKS[which],
        Report::Fix(fix) => fix.identity == identity(which),
        Report::Bearing(_) => false,
    }
}

const fn is_plot(report: &Report) -> bool {
    matches!(report, Report::Plot(_))
}

fn transponder(point: &Point) -> Option<Identity> {
    point.source.transponder().map(|part| part.identity)
}

#[test]
fn radar_only_drone_is_published_from_before_its_first_plot() {
    let emissions = fly(|second, report| of(report, 0) && is_plot(report) && second >= 20);
    let points: Vec<(&Emission, &Point)> = emissions
        .iter()
        .flat_map(|emission| emission.points.iter().map(move |point| (emission, point)))
        .collect();
    let first = second(points[0].0.time);
    assert!((20.0 - COAST_MAX_S..20.5 - COAST_MAX_S).contains(&first), "{first}");
    let early = points.iter().take_while(|(emission, _)| second(emission.time) < 19.75);
    assert!(early.clone().count() >= 6);
    let mut before = f64::INFINITY;
    for (emission, point) in early {
        let known = estimate(point);
        assert_eq!((known.basis, known.last_measurement), (Basis::Extrapolated, None));
        assert_eq!(point.source.radar().map(|part| part.track.number), Some(TRACKS[0]));
        let off_m = (point.position.0 - place(0, emission.time).0).xy().norm();
        assert!(off_m < 4.0 * known.horizontal.trace().sqrt(), "{off_m} {known:?}");
        // The nearer to the plots, the more certain.
        assert!(known.horizontal.trace() < before, "{known:?}");
        before = known.horizontal.trace();
    }
    assert!(points.iter().all(|(_, point)| point.number == points[0].1.number));
}

#[test]
fn one_plot_is_no_aircraft() {
    let alone = Time::from_nanos((START + 20) * SECOND);
    let emissions =
        fly(|_, report| matches!(report, Report::Plot(plot) if of(report, 0) && plot.time == alone));
    assert!(emissions.iter().all(|emission| emission.points.is_empty()));
}

#[test]
fn a_silent_drone_is_where_its_radar_track_will_begin() {
    // The transponder is received up to 20 s, the radar track begins at 25 s.
    let emissions =
        fly(|second, report| of(report, 0) && if is_plot(report) { second >= 25 } else { second <= 20 });
    let number = emissions.iter().find_map(|emission| emission.points.first()).unwrap().number;
    let mut interpolated = 0;
    for emission in between(&emissions, 5.0, 30.0) {
        let [point] = &emission.points[..] else { panic!("{emission:?}") };
        assert_eq!((point.number, transponder(point)), (number, Some(identity(0))));
        if (21.0..24.75).contains(&second(emission.time)) {
            let known = estimate(point);
            interpolated += usize::from(known.basis == Basis::Interpolated);
            let off_m = (point.position.0 - place(0, emission.time).0).xy().norm();
            assert!(off_m < 4.0 * known.horizontal.trace().sqrt(), "{off_m} {known:?}");
        }
    }
    assert!(interpolated >= 14, "{interpolated} slots");
}

#[test]
fn future_track_at_a_reporting_drone_is_no_other_aircraft() {
    // The first drone's transponder is received up to 20 s, without plots. The second's is always received, with plots
    // from 23 s on.
    let emissions = fly(|second, report| match (of(report, 0), is_plot(report)) {
        (true, is_plot) => !is_plot && second <= 20,
        (false, true) => second >= 23,
        (false, false) => true,
    });
    for emission in between(&emissions, 5.0, 50.0) {
        for point in &emission.points {
            let track = point.source.radar().map(|part| part.track.number);
            assert!(transponder(point).is_some(), "{point:?}");
            assert!(track.is_none() || transponder(point) == Some(identity(1)), "{point:?}");
        }
        let of_second = emission.points.iter().filter(|point| transponder(point) == Some(identity(1)));
        assert_eq!(of_second.count(), 1);
    }
    // Once the track has begun it belongs to the second drone.
    let fused = |emission: &Emission| emission.points.iter().any(|point| point.source.radar().is_some());
    assert!(between(&emissions, 30.0, 50.0).all(fused));
}

#[test]
fn future_track_over_a_reporting_drone_waits_for_its_plots() {
    const LOW_M: f64 = 60.0;
    let mut engine = Engine::new(settings(true)).unwrap();
    let mut emissions = Vec::new();
    for (received, mut report) in reports(60) {
        emissions.extend(engine.advance(received));
        let second = received.nanos() / SECOND - START;
        if let Report::Plot(plot) = &mut report {
            plot.position.0.z -= LOW_M;
        }
        if of(&report, 0) && (!is_plot(&report) || second >= 20) {
            engine.handle(report).unwrap();
        }
    }
    assert!(between(&emissions, 5.0, 20.0).count() > 50);
    for emission in between(&emissions, 5.0, 20.0) {
        let [point] = &emission.points[..] else { panic!("{emission:?}") };
        assert_eq!((transponder(point), point.source.radar()), (Some(identity(0)), None));
    }
}
