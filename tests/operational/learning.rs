//! Learnt errors of radars whose errors are known.

use fusion::learning::{LearntRadar, LearntValue, VelocityVerdict};
use fusion::time::{SECOND, Time};
use utm_fusion::areas::Masks;
use utm_fusion::capture::Reception;
use utm_fusion::config::{Config, Profile, SensorKind};
use utm_fusion::pipeline::Pipeline;
use utm_fusion::simulate::{Simulation, Span, simulate};

use crate::{scenario, site};

/// Some minutes of ten equipped drones, with a radar whose errors are `times` those in `crossing`.
fn flight(times: f64) -> Simulation {
    let mut scenario = scenario("crossing");
    (scenario.duration_s, scenario.drones.equipped) = (400.0, scenario.drones.multirotors);
    for radar in &mut scenario.radars {
        (radar.bias_azimuth_deg, radar.bias_range_m, radar.bias_height_m) = (0.0, 0.0, 0.0);
        radar.velocities = true;
        for error in [
            &mut radar.track_azimuth_deg,
            &mut radar.track_range_m,
            &mut radar.track_height_m,
            &mut radar.plot_azimuth_deg,
            &mut radar.plot_range_m,
            &mut radar.plot_height_m,
        ] {
            *error *= times;
        }
    }
    simulate(&scenario, 7, None).unwrap()
}

/// The learnt values, and their state as text.
fn learnt(receptions: &[Reception], config: &Config) -> (Option<LearntRadar>, String) {
    let mut pipeline = Pipeline::new(config, Masks::default());
    for reception in receptions {
        pipeline.receive(reception);
        pipeline.emissions().for_each(drop);
    }
    let (_, registered) = pipeline.engine().registered().next().unwrap();
    (registered.learnt, serde_json::to_string(&registered.learning_state()).unwrap())
}

#[test]
fn a_radar_is_learnt_to_be_as_good_or_bad_as_it_is() {
    for times in [0.3, 1.0, 2.0] {
        let simulation = flight(times);
        let config = site(&simulation, Profile::Operational);
        let receptions: Vec<Reception> = simulation.receptions().collect();
        let learnt = learnt(&receptions, &config).0.unwrap();
        // 1.25°, and 1.7 times that during turns.
        let azimuth_deg = learnt.azimuth.bias.value.to_degrees() / times;
        assert!((1.0..2.1).contains(&azimuth_deg), "{times}: {learnt:#?}");
        let noise_deg = learnt.azimuth.noise.value.to_degrees() / times;
        assert!((0.13..0.26).contains(&noise_deg), "{times}: {learnt:#?}");
        assert!(learnt.azimuth.tracks > 20.0, "{learnt:#?}");
        assert!(matches!(learnt.velocity, VelocityVerdict::Used(errors) if errors.sigma_m_s < 2.5));
    }
}

#[test]
fn learning_in_any_order_between_deadlines_agrees() {
    let simulation = flight(0.5);
    let config = site(&simulation, Profile::Operational);
    const SLOT_NS: i64 = SECOND / 4;
    let mut receptions: Vec<Reception> = simulation.receptions().collect();
    for reception in &mut receptions {
        let slot = reception.received.unwrap().nanos().div_euclid(SLOT_NS);
        reception.received = Some(Time::from_nanos(slot * SLOT_NS));
    }
    let forward = learnt(&receptions, &config);
    receptions.chunk_by_mut(|a, b| a.received == b.received).for_each(<[Reception]>::reverse);
    assert!(learnt(&receptions, &config) == forward);
}

#[test]
fn a_radar_that_is_not_to_be_learnt_is_as_it_is_configured() {
    let simulation = flight(0.5);
    let mut config = site(&simulation, Profile::Operational);
    for sensor in &mut config.sensors {
        if let SensorKind::Radar(radar) = &mut sensor.kind {
            radar.learn_accuracy = false;
        }
    }
    let receptions: Vec<Reception> = simulation.receptions().collect();
    assert_eq!(learnt(&receptions, &config).0, None);
}

#[test]
fn what_transponders_of_a_type_have_in_common_is_learnt() {
    let mut simulation = scenario("crossing");
    (simulation.duration_s, simulation.drones.equipped) = (600.0, simulation.drones.multirotors);
    simulation.transponder.stamped_late_s = Span::new(0.15, 0.15);
    simulation.transponder.gnss_white_m = 0.2;
    let simulation = simulate(&simulation, 7, None).unwrap();
    let config = site(&simulation, Profile::Operational);
    let mut pipeline = Pipeline::new(&config, Masks::default());
    for reception in simulation.receptions() {
        pipeline.receive(&reception);
        pipeline.emissions().for_each(drop);
    }
    let types = pipeline.engine().learnt_types();
    let [(kind, learnt)] = &types[..] else { panic!("{types:?}") };
    assert_eq!((kind.manufacturer, kind.model), (Some(*b"SIM"), Some(*b"UAS")));
    assert!((0.1..0.4).contains(&learnt.horizontal_m.value), "{learnt:?}");
    let LearntValue { value, deviation } = learnt.delay_s;
    assert!(deviation < 0.08 && (value - 0.15).abs() < 3.0 * deviation, "{learnt:?}");
    assert!(learnt.applied_s > 0.0 && learnt.applied_s <= value, "{learnt:?}");
}
