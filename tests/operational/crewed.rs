//! Crewed aircraft and vehicles together with drones.

use std::collections::BTreeMap;

use utm_fusion::areas::Masks;
use utm_fusion::config::Profile;
use utm_fusion::conflicts::ConflictWatch;
use utm_fusion::evaluate::OutputPoint;
use utm_fusion::picture::{PictureMaker, TrackClass};
use utm_fusion::pipeline::Pipeline;
use utm_fusion::simulate::simulate;

use crate::{flight, points, scenario, site};

#[test]
fn vehicles_take_no_part_in_conflicts() {
    let mut scenario = scenario("crossing-crewed");
    (scenario.duration_s, scenario.crewed.vehicles) = (120.0, 4);
    let simulation = simulate(&scenario, 3, None).unwrap();
    let config = site(&simulation, Profile::Operational);
    let mut pipeline = Pipeline::new(&config, Masks::default());
    let maker = PictureMaker::new(&config, pipeline.normaliser());
    let mut watch = ConflictWatch::new(&config);
    let (mut vehicles, mut most) = (0, 0);
    let mut recent = BTreeMap::new();
    for reception in simulation.receptions() {
        pipeline.receive(&reception);
        for picture in pipeline.emissions().map(|emission| maker.picture(emission)) {
            let Some(outlook) = watch.look(&picture, &maker) else { continue };
            let mut flying = 0;
            // Only tracks accurate enough to take part are compared.
            for track in picture.tracks.iter().filter(|track| track.is_within(config.output.max_accuracy_m)) {
                match maker.class(track) {
                    TrackClass::Vehicle => vehicles += 1,
                    TrackClass::Other => {}
                    TrackClass::Drone | TrackClass::Unknown | TrackClass::Crewed => {
                        flying += 1;
                        recent.insert((track.point.number, track.point.first_seen), picture.time);
                    }
                }
            }
            // An aircraft that is missing takes part for up to 20 s.
            recent.retain(|_, seen| picture.time.seconds_since(*seen) <= 21.0);
            assert!((flying..=recent.len()).contains(&outlook.aircraft) && outlook.left_out == 0);
            most = most.max(flying);
        }
    }
    assert!(vehicles > 100 && most > 10, "{vehicles}, {most}");
}

#[test]
fn adsb_beside_a_scenario_changes_nothing_of_its_drones() {
    for seed in [3, 4] {
        let [alone, beside] = ["crossing", "crossing-crewed"].map(|name| {
            let simulation = flight(name, seed);
            points(simulation.receptions(), &site(&simulation, Profile::Operational))
        });
        // With the aeroplanes the input ends later, and so do the slots.
        let last = alone.last().unwrap().time;
        // ICAO addresses have six digits.
        let is_crewed = |point: &OutputPoint| point.identity.as_ref().is_some_and(|name| name.len() == 6);
        let (crewed, mut drones): (Vec<_>, Vec<_>) = beside.into_iter().partition(is_crewed);
        drones.retain(|point| point.time <= last);
        assert!(crewed.len() > 1000, "{}", crewed.len());
        assert!(drones == alone, "{} points of drones, {} without aeroplanes", drones.len(), alone.len());
    }
}
