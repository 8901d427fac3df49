//! The output is identical, to the last digit, for any number of threads that share the work of a slot.

use std::num::NonZeroUsize;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use utm_fusion_engine::frames::RadarFrame;
use utm_fusion_engine::settings::{OperationalRules, Radar, Receiver};
use utm_fusion_engine::time::{SECOND, Time};
use utm_fusion_engine::{
    Emission, Engine, Enu, Fix, Identity, Plot, Profile, RadarTrackKey, Report, SensorIndex, Settings,
};

/// Number of drones, sufficient for eight threads to have a part each.
const DRONES: u16 = 850;
/// Two of three drones have a transponder.
const EQUIPPED: u16 = 3;
const SLOT_NS: i64 = SECOND / 4;
/// Length of the flight, in slots: 14 s.
const SLOTS: i64 = 56;

/// Drones that circle side by side, detected by radar 0, and the western half also by radar 2.
fn reports(slot: i64, errors: &mut ChaCha8Rng) -> Vec<Report> {
    let time = Time::from_nanos(slot * SLOT_NS);
    let mut reports = Vec::new();
    for drone in 0..DRONES {
        let (east, north) = (f64::from(drone % 30) * 150.0 - 2250.0, f64::from(drone / 30) * 150.0 + 500.0);
        let angle = slot as f64 / 20.0 + f64::from(drone);
        let mut near = |sigma_m: f64| {
            let mut off = || sigma_m * errors.random_range(-1.0..1.0);
            Enu::new(east + 80.0 * angle.sin() + off(), north + 80.0 * angle.cos() + off(), 100.0 + off())
        };
        for radar in [0, 2] {
            if radar == 0 || east < 0.0 {
                let track = RadarTrackKey { sensor: SensorIndex(radar), number: drone };
                let place = near(15.0);
                let plot = Plot::new(track, time, place, place.0.norm());
                reports.push(Report::Plot(Plot { uav_probability: Some(0.9), ..plot }));
            }
        }
        if drone % EQUIPPED != 0 && (slot + i64::from(drone)) % 8 == 0 {
            let serial: [u8; 12] = format!("{drone:012}").into_bytes().try_into().expect("twelve digits");
            let identity = Identity::new(&serial, None).expect("it is not blank");
            reports.push(Report::Fix(Fix::new(SensorIndex(1), identity, time, near(3.0))));
        }
    }
    reports
}

fn fly(threads: usize) -> Vec<Emission> {
    let threads = NonZeroUsize::new(threads).expect("one at least");
    let profile = Profile::Operational(OperationalRules { threads, ..OperationalRules::default() });
    let mut settings = Settings { profile, ..Settings::default() };
    settings.add_radar(Radar::default());
    settings.add_receiver(Receiver { max_new_per_s: 1000, ..Receiver::default() });
    settings
        .add_radar(Radar { frame: RadarFrame::parallel(Enu::new(-3000.0, 4000.0, 0.0)), ..Radar::default() });
    let mut engine = Engine::new(settings).expect("the settings are right");
    let mut errors = ChaCha8Rng::seed_from_u64(1);
    let mut emissions = Vec::new();
    for slot in 0..SLOTS {
        emissions.extend(engine.advance(Time::from_nanos((slot + 1) * SLOT_NS)));
        for report in reports(slot, &mut errors) {
            engine.handle(report).expect("it is in time");
        }
    }
    emissions
}

#[test]
fn one_thread_publishes_the_same_as_eight() {
    let alone = fly(1);
    let points: usize = alone.iter().map(|emission| emission.points.len()).sum();
    assert!(points > 10_000, "{points}");
    for threads in [2, 8] {
        let shared = fly(threads);
        assert_eq!(shared.len(), alone.len());
        for (slot, expected) in shared.iter().zip(&alone) {
            assert!(slot == expected, "{threads} threads, {:?}", slot.slot);
        }
    }
}
