//! A host sends forged CAT129 reports, rotated about the radar, to falsify its registration.

use asterix::cat129::{Altitude, Position};
use asterix::{DataSource, Record, TimeOfDay, blocks, cat048, cat129, encode_block};
use fusion::Enu;
use fusion::integrity::State;
use fusion::time::{SECOND, Time};
use jiff::SignedDuration;
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Reception, ReceptionKind};
use utm_fusion::config::Profile;
use utm_fusion::normalise::Normaliser;
use utm_fusion::pipeline::Pipeline;
use utm_fusion::simulate::{Pattern, Simulation, simulate};

use crate::{scenario, site};

/// Growth of the rotation, in degrees per second.
const GROWTH_DEG_S: f64 = 0.02;

/// Ten drones without a transponder that an aligned radar sees all the time.
fn flight(seed: u64) -> Simulation {
    let mut scenario = scenario("crossing");
    (scenario.duration_s, scenario.birds.count) = (120.0, 0);
    (scenario.drones.multirotors, scenario.drones.fixed_wings, scenario.drones.equipped) = (10, 0, 0);
    scenario.drones.pattern = Pattern::Free;
    for radar in &mut scenario.radars {
        (radar.bias_azimuth_deg, radar.bias_range_m, radar.bias_height_m) = (0.0, 0.0, 0.0);
        (radar.seen_s, radar.unseen_s, radar.seduction_every_s) = (1e9, 0.0, 0.0);
        (radar.detection, radar.swap_share) = (1.0, 0.0);
    }
    simulate(&scenario, seed, None).unwrap()
}

/// The flight with one forged report per second for each radar track: at its latest plot, rotated by a growing angle.
fn forged(simulation: &Simulation, start: Time) -> Vec<Reception> {
    let config = site(simulation, Profile::Operational);
    let normaliser = Normaliser::new(&config, Masks::default());
    let mut receptions: Vec<Reception> = simulation.receptions().collect();
    let mut latest = std::collections::BTreeMap::<u16, Time>::new();
    let mut forged = Vec::new();
    for reception in &receptions {
        let received = reception.received.unwrap();
        let blocks = blocks(&reception.payload).map(Result::unwrap);
        for block in blocks.filter(|block| block.category == cat048::Record::CATEGORY) {
            for record in block.records::<cat048::Record>().map(|located| located.unwrap().record) {
                let Ok(plot) = normaliser.plot(&record, received) else { continue };
                let number = plot.track.number;
                if latest.get(&number).is_some_and(|last| plot.time.seconds_since(*last) < 1.0) {
                    continue;
                }
                latest.insert(number, plot.time);
                let angle = (GROWTH_DEG_S * plot.time.seconds_since(start)).to_radians();
                let (sin, cos) = (plot.position.0.x.atan2(plot.position.0.y) + angle).sin_cos();
                let ground_m = plot.position.0.xy().norm();
                let place = Enu::new(ground_m * sin, ground_m * cos, plot.position.0.z);
                let place = normaliser.frame().to_geodetic(place);
                let stamp = TimeOfDay::from_seconds(plot.time.since_midnight() as f64 / SECOND as f64);
                let position = Position::new(place.latitude_deg(), place.longitude_deg());
                let mut serial = *b"FAKE00000000";
                serial[7..].copy_from_slice(format!("{number:05}").as_bytes());
                let record = cat129::Record::builder(DataSource { sac: 0, sic: 0 }, *b"GB", stamp, position)
                    .serial_number(serial)
                    .altitude_amsl(Altitude::from_metres(place.height_m - normaliser.undulation_m()))
                    .build()
                    .unwrap();
                let mut payload = Vec::new();
                encode_block(&[record], &mut payload).unwrap();
                forged.push(Reception {
                    received: Some(received + SignedDuration::from_millis(20)),
                    input: 0,
                    from: Some(([127, 0, 0, 66], 4_129).into()),
                    kind: ReceptionKind::Datagram,
                    origin: 0,
                    payload,
                });
            }
        }
    }
    receptions.append(&mut forged);
    receptions.sort_by_key(|reception| reception.received);
    receptions
}

#[test]
fn forged_reports_that_turn_do_not_turn_the_registration() {
    for seed in 201..=202 {
        let simulation = flight(seed);
        let start = simulation.flights[0].samples[0].time;
        let mut pipeline = Pipeline::new(&site(&simulation, Profile::Operational), Masks::default());
        let (mut alarm_s, mut most_deg) = (None, 0.0_f64);
        for reception in forged(&simulation, start) {
            pipeline.receive(&reception);
            pipeline.emissions().for_each(drop);
            let Some((_, registered)) = pipeline.engine().registered().next() else { continue };
            let bearing = registered.estimate.bearing;
            if bearing.observable {
                most_deg = most_deg.max(bearing.value.to_degrees().abs());
            }
            if let (None, Some(creep)) = (alarm_s, registered.creep()) {
                assert_eq!(creep.host.unwrap().to_string(), "127.0.0.66");
                alarm_s = Some(reception.received.unwrap().seconds_since(start));
            }
        }
        // In the first seconds a rotation cannot be distinguished from noise, and the bearing correction is applied.
        assert!(most_deg <= 0.35, "{seed}: {most_deg}");
        assert!(alarm_s.is_some_and(|alarm_s| alarm_s <= 60.0), "{seed}: {alarm_s:?}");
        let verified =
            pipeline.engine().assessments().filter(|known| known.integrity.state == State::Verified);
        assert_eq!(verified.count(), 0, "{seed}");
    }
}
