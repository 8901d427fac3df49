//! After a handover the receiving engine agrees with the other one.

use super::two_drones::{START, TRACKS, identity, reports, settings};
use crate::report::Report;
use crate::time::{SECOND, Time};
use crate::{Emission, Engine, Enu, Point};

/// Second from which the second engine receives reports; the first receives all.
const HEARS_FROM: i64 = 40;
/// Second of the handover.
const TOLD_AT: i64 = 50;

fn second(second: i64) -> Time {
    Time::from_nanos((START + second) * SECOND)
}

/// Two drones. The second has no transponder, and the radar classifies it as a drone only at the beginning.
fn flight() -> impl Iterator<Item = (Time, Report)> {
    reports(90).into_iter().filter_map(|(received, mut report)| {
        match &mut report {
            Report::Fix(fix) if fix.identity == identity(1) => return None,
            Report::Plot(plot) if plot.track.number == TRACKS[1] && plot.time > second(20) => {
                plot.uav_probability = Some(0.5);
            }
            _ => {}
        }
        Some((received, report))
    })
}

/// Emissions of both engines from the handover on; `tells` hands over the state of the first engine to the second.
fn both(tells: impl Fn(&Engine, &mut Engine)) -> [Vec<Emission>; 2] {
    let mut engines = [(); 2].map(|()| {
        let mut engine = Engine::new(settings(true)).unwrap();
        engine.share_values();
        engine
    });
    let mut said = [Vec::new(), Vec::new()];
    let mut is_told = false;
    for (received, report) in flight() {
        let hears = [true, received >= second(HEARS_FROM)];
        for index in (0..2).filter(|&index| hears[index]) {
            said[index].extend(engines[index].advance(received));
        }
        let [first, other] = &mut engines;
        if !is_told && said[1].last().is_some_and(|last: &Emission| last.time >= second(TOLD_AT)) {
            tells(first, other);
            is_told = true;
            said = [Vec::new(), Vec::new()];
        }
        for index in (0..2).filter(|&index| hears[index]) {
            engines[index].handle(report).unwrap();
        }
    }
    said
}

/// A point without the numbers that each engine assigns itself.
fn nameless(point: &Point) -> impl PartialEq + std::fmt::Debug {
    let radar = point.source.radar().map(|part| (part.track, part.time));
    let identity = point.source.transponder().map(|part| part.identity);
    (point.position, point.estimate, radar, identity)
}

fn are_alike([one, other]: &[Vec<Emission>; 2]) -> bool {
    assert!(one.len() > 100 && one.len() == other.len());
    one.iter().zip(other).all(|(one, other)| {
        let [one, other] = [one, other].map(|emission| emission.points.iter().map(nameless));
        one.eq(other)
    })
}

#[test]
fn handed_over_engine_publishes_identical_points() {
    let all = |first: &Engine, other: &mut Engine| {
        let names = first.names();
        assert_eq!(names.len(), 2);
        names.iter().for_each(|&(name, _)| other.receive_handover(first.handover(name, |_| true).unwrap()));
    };
    let told = both(all);
    assert!(told[0].iter().all(|emission| emission.points.len() == 2));
    assert!(are_alike(&told));
    // For an engine that has observed it only briefly, the one without a transponder is no drone.
    let untold = both(|_, _| {});
    assert!(!are_alike(&untold));
    assert!(untold[1].iter().all(|emission| emission.points.len() == 1));
}

#[test]
fn repeated_or_late_handover_has_the_same_result() {
    let twice = |first: &Engine, other: &mut Engine| {
        let told = first.names().into_iter().chain(first.names());
        told.for_each(|(name, _)| other.receive_handover(first.handover(name, |_| true).unwrap()));
    };
    assert!(are_alike(&both(twice)));
    // A checkpoint keeps waiting handovers.
    let restored = |first: &Engine, other: &mut Engine| {
        let told = first.names().into_iter();
        told.for_each(|(name, _)| other.receive_handover(first.handover(name, |_| true).unwrap()));
        *other = Engine::restored(settings(true), &other.checkpoint()).unwrap();
    };
    assert!(are_alike(&both(restored)));
}

#[test]
fn names_are_where_their_aircraft_are() {
    let places = |first: &Engine, _: &mut Engine| {
        let is_known = |name, around: fn(Enu) -> bool| first.handover(name, around).is_some();
        for (index, (name, place)) in first.names().into_iter().enumerate() {
            let expected = super::two_drones::place(index, second(TOLD_AT)).0;
            assert!((place.0 - expected).norm() < 60.0, "{place:?} {expected:?}");
            assert!(is_known(name, |_| false));
        }
    };
    both(places);
}
