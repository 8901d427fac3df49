//! A radar whose track numbers jump: work and memory stay bounded, and other aircraft are published as without it.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use utm_fusion_engine::settings::{Radar, Receiver};
use utm_fusion_engine::time::{SECOND, Time};
use utm_fusion_engine::{
    Emission, Engine, Enu, Fix, Identity, Plot, RadarTrackKey, Report, SensorIndex, Settings,
};

const SLOT_NS: i64 = SECOND / 4;
/// Length of the flight, in slots: 40 s.
const SLOTS: i64 = 160;
const RADAR: SensorIndex = SensorIndex(0);
const RECEIVER: SensorIndex = SensorIndex(1);
/// Number of drones; the even ones have a transponder.
const DRONES: u16 = 8;

/// Which numbers jump.
#[derive(Clone, Copy)]
enum Jumping {
    /// None.
    Never,
    /// This many, with one plot each per slot, kilometres from the one before.
    Numbers(u16),
    /// One number, with this many plots per slot, all at one time.
    AtOnce(u16),
}

fn plot(number: u16, time: Time, place: Enu, uav_probability: f64) -> Report {
    let plot = Plot::new(RadarTrackKey { sensor: RADAR, number }, time, place, place.0.norm());
    Report::Plot(Plot { uav_probability: Some(uav_probability), ..plot })
}

fn reports(slot: i64, jumping: Jumping) -> Vec<Report> {
    let time = Time::from_nanos(slot * SLOT_NS);
    let mut errors = ChaCha8Rng::seed_from_u64(slot as u64);
    let mut reports = Vec::new();
    for drone in 0..DRONES {
        let angle = slot as f64 / 20.0 + f64::from(drone);
        let mut near = |sigma_m: f64| {
            let mut off = || sigma_m * errors.random_range(-1.0..1.0);
            let (east, north) = (80.0 * angle.sin(), 600.0 + 200.0 * f64::from(drone) + 80.0 * angle.cos());
            Enu::new(east + off(), north + off(), 100.0 + off())
        };
        reports.push(plot(drone, time, near(10.0), 0.9));
        if drone % 2 == 0 && (slot + i64::from(drone)) % 4 == 0 {
            let serial = format!("{drone:012}");
            let identity = Identity::new(serial.as_bytes(), None).expect("it is not blank");
            reports.push(Report::Fix(Fix::new(RECEIVER, identity, time, near(2.0))));
        }
    }
    let mut elsewhere = |number, uav_probability| {
        let mut kilometres = || errors.random_range(9_000.0..30_000.0);
        plot(number, time, Enu::new(-kilometres(), -kilometres(), 100.0), uav_probability)
    };
    match jumping {
        Jumping::Never => {}
        Jumping::Numbers(count) => reports.extend((0..count).map(|number| elsewhere(1000 + number, 0.9))),
        // A few of these plots continue a track by chance. The radar says that they are no drones.
        Jumping::AtOnce(count) => reports.extend((0..count).map(|_| elsewhere(1000, 0.1))),
    }
    reports
}

/// The slots, and the size of the state at the end.
fn fly(jumping: Jumping) -> (Vec<Emission>, usize) {
    let mut settings = Settings::default();
    settings.add_radar(Radar::default());
    settings.add_receiver(Receiver::default());
    let mut engine = Engine::new(settings).expect("the settings are right");
    let mut emissions = Vec::new();
    for slot in 0..SLOTS {
        emissions.extend(engine.advance(Time::from_nanos((slot + 1) * SLOT_NS)));
        for report in reports(slot, jumping) {
            engine.handle(report).expect("it is in time");
        }
    }
    let octets = engine.checkpoint().len();
    (emissions, octets)
}

fn discarded(emissions: &[Emission]) -> u32 {
    emissions.iter().flat_map(|emission| &emission.jumping).map(|jumping| jumping.discarded).sum()
}

/// Compares a flood with the flight without it; returns the number of discarded tracks and the octets that the state grows by.
fn flood(jumping: Jumping) -> (u32, usize) {
    let (expected, without) = fly(Jumping::Never);
    assert!(expected.last().is_some_and(|slot| slot.points.len() == usize::from(DRONES)));
    assert_eq!(discarded(&expected), 0);
    let (flooded, with) = fly(jumping);
    assert_eq!(flooded.len(), expected.len());
    for (slot, expected) in flooded.iter().zip(&expected) {
        assert!(slot.points == expected.points, "{:?}", slot.slot);
        assert!(slot.now == expected.now, "{:?}", slot.slot);
    }
    (discarded(&flooded), with - without)
}

#[test]
fn tracks_of_jumping_numbers_are_bounded_and_counted() {
    let (discarded, octets) = flood(Jumping::Numbers(200));
    // Most of the plots up to the last decided slot.
    assert!((20_000..=32_000).contains(&discarded), "{discarded}");
    let (_, more) = flood(Jumping::Numbers(400));
    // One more track for each of 200 more numbers, and the plots not yet decided.
    assert!(octets < 2_000_000 && more < 2 * octets, "{octets} {more}");
}

#[test]
fn plots_of_one_number_at_one_time_are_bounded() {
    let (discarded, octets) = flood(Jumping::AtOnce(500));
    // Radars measure distant azimuths so badly that most of these plots continue one of the tracks.
    assert!(discarded > 500, "{discarded}");
    assert!(octets < 1_000_000, "{octets}");
}
