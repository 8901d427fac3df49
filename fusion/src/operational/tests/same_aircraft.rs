//! A drone with two transponders, from the first report on.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::integrity::{Reason, State, Trust};

/// Position of the drone: on a circle of 200 m, at 10 m/s.
fn place(second: f64) -> (f64, f64) {
    let turned = 0.05 * second;
    (200.0 * turned.sin(), 1500.0 + 200.0 * turned.cos())
}

/// A flight with two identities, and its output.
struct Flight {
    case: Case,
    random: ChaCha8Rng,
    slots: Vec<(f64, SlotOutput)>,
}

impl Flight {
    fn new() -> Self {
        Self { case: Case::new(), random: ChaCha8Rng::seed_from_u64(1), slots: Vec::new() }
    }

    /// A report of an identity at this distance east of the drone's position, with half a metre of noise.
    fn report(&mut self, which: usize, second: f64, east_m: f64) {
        let (east, north) = place(second);
        let mut noise = || self.random.random_range(-0.5..0.5);
        let position = Enu::new(east + east_m + noise(), north + noise(), 100.0 + noise());
        self.case.air.handle(Report::Fix(Fix::new(SensorIndex(1), identity(which), at(second), position)));
    }

    /// Publishes the slots up to that second; `apart` is the offset east of the drone that each identity reports at a
    /// time, metres.
    fn fly(&mut self, until_s: f64, apart: impl Fn(usize, f64) -> Option<f64>) -> &mut Self {
        let first = self.slots.last().map_or(GRID.of(at(100.0)).0, |(time, _)| GRID.of(at(*time)).0 + 1);
        for slot in first..GRID.of(at(until_s)).0 {
            let second = slot as f64 / 4.0;
            // Each identity reports once a second, in a phase of its own.
            for which in (0..3).filter(|&which| slot.rem_euclid(4) == [0, 2, 1][which]) {
                if let Some(east_m) = apart(which, second + 5.0) {
                    self.report(which, second + 5.0, east_m);
                }
            }
            let Case { air, settings, numbers, .. } = &mut self.case;
            numbers.begin_slot(Slot(slot));
            let made = air.emit(Slot(slot), GRID, settings, numbers);
            numbers.take_changes();
            self.slots.push((GRID.centre(Slot(slot)).seconds_since(at(0.0)), made));
        }
        self
    }

    fn points(&self, from_s: f64, to_s: f64) -> impl Iterator<Item = (f64, &[Point])> {
        let slots = self.slots.iter().filter(move |(time, _)| (from_s..to_s).contains(time));
        slots.map(|(time, made)| (*time, made.points.as_slice()))
    }
}

/// Distance of a point to the position `east_m` east of the drone at that time, metres.
fn away_m(point: &Point, time: f64, east_m: f64) -> f64 {
    let (east, north) = place(time);
    let there: Enu = Enu::new(east + east_m, north, 100.0);
    (point.position.0 - there.0).norm()
}

fn numbers(points: &[Point]) -> Vec<u32> {
    points.iter().map(|point| point.number).collect()
}

fn both(which: usize, _: f64) -> Option<f64> {
    [Some(0.0), Some(1.5), None][which]
}

#[test]
fn two_transponders_become_one_aircraft_in_a_minute() {
    let mut flight = Flight::new();
    flight.fly(220.0, both);
    for (time, points) in flight.points(110.0, 140.0) {
        assert_eq!(numbers(points), [10_000, 20_000], "{time}");
    }
    for (time, points) in flight.points(165.0, 220.0) {
        let [point] = points else { panic!("{time}: {points:?}") };
        assert_eq!(point.number, 10_000);
        let identities = [point.source.transponder().unwrap(), &point.also[0]].map(|part| part.identity);
        assert_eq!((identities, point.also.len()), ([identity(0), identity(1)], 1));
        // The position lies between the two.
        assert!(away_m(point, time, 0.75) < 1.2, "{time}: {point:?}");
    }
    // The picture of now has one aircraft as well, under the same number.
    for (time, made) in flight.slots.iter().filter(|(time, _)| *time > 180.0) {
        assert_eq!(numbers(&made.now.as_ref().unwrap().points), [10_000], "{time}");
    }
}

#[test]
fn three_transponders_become_one_aircraft() {
    let mut flight = Flight::new();
    flight.fly(200.0, |which, _| Some([0.0, 1.5, -1.0][which]));
    for (time, points) in flight.points(165.0, 200.0) {
        assert_eq!((numbers(points), points[0].also.len()), (vec![10_000], 2), "{time}");
    }
}

#[test]
fn number_is_kept_when_the_leader_falls_silent_for_good() {
    let mut flight = Flight::new();
    flight.fly(180.0, both).fly(300.0, |which, second| both(which, second).filter(|_| which == 1));
    for (time, points) in flight.points(170.0, 290.0) {
        let [point] = points else { panic!("{time}: {points:?}") };
        assert_eq!(point.number, 10_000, "{time}");
        assert!(away_m(point, time, 1.0) < 4.0, "{time}");
    }
    let (_, last) = flight.points(280.0, 290.0).last().unwrap();
    assert_eq!(last[0].source.transponder().unwrap().identity, identity(1));
    // The first identity returns to its aircraft, which keeps the number.
    flight.fly(400.0, both);
    for (time, points) in flight.points(370.0, 390.0) {
        assert_eq!(numbers(points), [10_000], "{time}");
    }
}

#[test]
fn identities_that_come_apart_have_their_numbers_again() {
    let mut flight = Flight::new();
    let apart =
        |which, second| both(which, second).map(|east_m| east_m + which as f64 * 8.0 * (second - 180.0));
    flight.fly(175.0, both).fly(230.0, apart);
    assert!(flight.points(170.0, 179.0).all(|(_, points)| numbers(points) == [10_000]));
    for (time, points) in flight.points(190.0, 230.0) {
        assert_eq!(numbers(points), [10_000, 20_000], "{time}");
        assert!(points.iter().all(|point| point.also.is_empty()));
    }
}

#[test]
fn distrusted_identity_is_not_linked() {
    let mut flight = Flight::new();
    flight.fly(180.0, both);
    assert!(flight.points(170.0, 180.0).all(|(_, points)| numbers(points) == [10_000]));
    flight.case.air.set_trust(TrustOverride { identity: identity(1), trust: Trust::Distrusted }, Slot(720));
    flight.fly(260.0, both);
    for (time, points) in flight.points(182.0, 260.0) {
        assert_eq!(numbers(points), [10_000, 20_000], "{time}");
    }
}

#[test]
fn second_transmitter_of_a_linked_identity_is_found() {
    let mut flight = Flight::new();
    flight.fly(180.0, both);
    let before = flight.slots.len();
    // Between its own reports the first identity is also reported 500 m away.
    for second in (180..230).map(f64::from) {
        flight.fly(second, both);
        flight.report(0, second + 5.25, 500.0);
    }
    let found = flight.slots[before..].iter().any(|(_, made)| {
        made.concerns.iter().any(|concern| match concern {
            Concern::Integrity { identity: who, state, reasons, .. } => {
                *who == identity(0) && *state == State::Failed && reasons.contains(Reason::Duplicate)
            }
            _ => false,
        })
    });
    assert!(found);
    // The other identity keeps its true position.
    let (time, last) = flight.points(220.0, 229.0).last().unwrap();
    let own = last.iter().find(|point| point.source.transponder().unwrap().identity == identity(1)).unwrap();
    assert!(away_m(own, time, 1.5) < 4.0);
    assert!(own.also.is_empty());
}

#[test]
fn neighbours_of_15_m_stay_apart() {
    let mut flight = Flight::new();
    flight.fly(300.0, |which, _| Some(15.0 * which as f64));
    for (time, points) in flight.points(110.0, 300.0) {
        assert_eq!(numbers(points), [10_000, 20_000, 30_000], "{time}");
    }
}

#[test]
fn radar_track_of_a_linked_pair_is_the_leaders() {
    let mut flight = Flight::new();
    for second in (100..240).map(f64::from) {
        flight.fly(second, both);
        for half in [0.0, 0.5] {
            let (east, north) = place(second + 5.0 + half);
            flight.case.air.handle(Report::Plot(Plot {
                uav_probability: Some(0.95),
                ..Plot::new(
                    RadarTrackKey { sensor: SensorIndex(0), number: 7 },
                    at(second + 5.0 + half),
                    Enu::new(east + 3.0, north - 3.0, 100.0),
                    1500.0,
                )
            }));
        }
    }
    for (time, points) in flight.points(170.0, 230.0) {
        let [Point { source: crate::point::Source::Fused(radar, own, _), also, .. }] = points else {
            panic!("{time}: {points:?}");
        };
        assert_eq!((radar.track.number, own.identity, also.len()), (7, identity(0), 1));
    }
}
