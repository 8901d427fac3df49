//! The rules of the `operational` profile on simulated flights.

#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

mod checkpoint;
mod creep;
mod crewed;
mod flood;
#[path = "../shared/invented.rs"]
mod invented;
mod learning;
mod liars;
mod now;
mod worlds;

use fusion::time::Time;
use utm_fusion::areas::Masks;
use utm_fusion::capture::Reception;
use utm_fusion::config::{Config, Motion, Profile};
use utm_fusion::evaluate::{
    ErrorStatistics, Evaluation, InputsAlone, Labels, OutputPoint, Scoring, evaluate, output,
};
use utm_fusion::simulate::{Scenario, Simulation, TRANSPONDER_ID, simulate};

pub(crate) fn scenario(name: &str) -> Scenario {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("config/scenarios/{name}.toml"));
    Scenario::load(&path).unwrap()
}

fn flight(name: &str, seed: u64) -> Simulation {
    simulate(&scenario(name), seed, None).unwrap()
}

pub(crate) fn site(simulation: &Simulation, profile: Profile) -> Config {
    let mut config = simulation.config.clone();
    config.fusion.profile = profile;
    config
}

fn points(receptions: impl Iterator<Item = Reception>, config: &Config) -> Vec<OutputPoint> {
    output(receptions.map(Ok), config, Masks::default()).unwrap()
}

fn scored(simulation: &Simulation, profile: Profile) -> Evaluation {
    scored_as(simulation, &site(simulation, profile))
}

fn scored_as(simulation: &Simulation, config: &Config) -> Evaluation {
    let labels = Labels::with_receivers(simulation.labels.clone(), &[TRANSPONDER_ID.to_owned()].into());
    let alone = InputsAlone::of(simulation.receptions().map(Ok), config, Masks::default()).unwrap();
    let points = points(simulation.receptions(), config);
    evaluate(&simulation.truth(), Some(&labels), &points, Some(&alone), &Scoring::of(config))
}

/// The mean of a figure over several flights.
fn mean(flights: &[Evaluation], figure: impl Fn(&Evaluation) -> Option<f64>) -> f64 {
    let values: Vec<f64> = flights.iter().filter_map(figure).collect();
    values.iter().sum::<f64>() / values.len() as f64
}

fn metres(error: Option<ErrorStatistics>) -> Option<f64> {
    error.map(|error| error.mean_m)
}

fn covered(flight: &Evaluation) -> Option<f64> {
    metres(flight.fused.equipped.epos_covered)
}

fn gap(flight: &Evaluation) -> Option<f64> {
    metres(flight.fused.equipped.epos_gap)
}

#[test]
fn it_removes_the_weaknesses_of_the_reference_profile() {
    let seeds = 1..=4;
    let simulations: Vec<Simulation> = seeds.map(|seed| flight("crossing", seed)).collect();
    let of = |profile| simulations.iter().map(|flight| scored(flight, profile)).collect::<Vec<_>>();
    let (before, now) = (of(Profile::Reference), of(Profile::Operational));

    let alone = |e: &Evaluation| metres(e.transponder.as_ref()?.equipped.epos_covered);
    assert!(mean(&now, |e| Some(covered(e)? / alone(e)?)) <= 1.0, "worse than the transponder");
    assert!(mean(&now, covered) <= 0.78 * mean(&before, covered));
    let radar = |e: &Evaluation| metres(e.radar.as_ref()?.equipped.epos_gap);
    assert!(mean(&now, |e| Some(gap(e)? / radar(e)?)) <= 0.45, "in gaps");
    assert!(mean(&now, |e| e.fused.equipped.pu_percent) >= 90.0, "equipped drones");
    assert!(mean(&now, |e| e.fused.unequipped.pu_percent) >= 36.0, "drones without a transponder");
    assert!(mean(&now, |e| e.fused.all.precision) >= 0.99, "radar tracks of others");
    assert!(mean(&now, |e| e.fused.equipped.id_changes) <= 0.1, "names");
    assert!(mean(&now, |e| e.fused.all.false_track_s) <= 5.0, "birds");
    assert!(mean(&now, |e| e.fused.all.gospa_m) <= 0.68 * mean(&before, |e| e.fused.all.gospa_m));
}

#[test]
fn velocities_make_it_better() {
    // The same flights with and without reported velocities.
    let told = |velocities| {
        let mut scenario = scenario("gaps");
        scenario.transponder.velocities = velocities;
        scenario.radars.iter_mut().for_each(|radar| radar.velocities = velocities);
        let flown = |seed| scored(&simulate(&scenario, seed, None).unwrap(), Profile::Operational);
        (1..=7).map(flown).collect::<Vec<_>>()
    };
    let (without, with) = (told(false), told(true));
    // The median flight: in one flight a wrong radar track may be followed through a gap, which outweighs all others.
    let ratio = |figure: fn(&Evaluation) -> Option<f64>| {
        let ratio = |(with, without)| figure(with).unwrap() / figure(without).unwrap();
        let mut ratios: Vec<f64> = with.iter().zip(&without).map(ratio).collect();
        ratios.sort_by(f64::total_cmp);
        ratios[ratios.len() / 2]
    };
    let (covered, gap) = (ratio(covered), ratio(gap));
    assert!(covered <= 0.97, "covered: {covered} of the error without velocities");
    assert!(gap <= 0.9, "in gaps: {gap}");
    let seen = ratio(|flight| flight.fused.equipped.pu_percent);
    assert!(seen >= 1.01, "PU: {seen} times that without");
}

#[test]
fn the_singer_model_is_another_way_to_move() {
    let flights = [1, 2].map(|seed| flight("crossing", seed));
    let moving = |simulation: &Simulation, profile, motion| {
        let mut config = site(simulation, profile);
        config.fusion.motion = motion;
        config
    };
    let now = flights
        .each_ref()
        .map(|flight| scored_as(flight, &moving(flight, Profile::Operational, Motion::Singer)));
    let alone = |e: &Evaluation| metres(e.transponder.as_ref()?.equipped.epos_covered);
    assert!(mean(&now, |e| Some(covered(e)? / alone(e)?)) <= 1.1, "worse than the transponder");
    let radar = |e: &Evaluation| metres(e.radar.as_ref()?.equipped.epos_gap);
    assert!(mean(&now, |e| Some(gap(e)? / radar(e)?)) <= 0.6, "in gaps");
    assert!(mean(&now, |e| e.fused.equipped.pu_percent) >= 90.0, "equipped drones");

    let put_out = |profile, motion| {
        let config = moving(&flights[0], profile, motion);
        points(flights[0].receptions(), &config)
    };
    let [imm, singer] = [Motion::Imm, Motion::Singer].map(|motion| put_out(Profile::Operational, motion));
    assert_ne!(imm, singer);
    // The rules of `reference` do not use the motion model.
    let [imm, singer] = [Motion::Imm, Motion::Singer].map(|motion| put_out(Profile::Reference, motion));
    assert_eq!(imm, singer);
}

#[test]
fn points_of_input_in_any_order_between_deadlines_agree() {
    let simulation = flight("crossing", 5);
    let config = site(&simulation, Profile::Operational);
    let receptions: Vec<Reception> = simulation.receptions().collect();
    let expected = points(receptions.iter().cloned(), &config);
    assert!(expected.len() > 5000);
    assert_eq!(points(receptions.iter().cloned(), &config), expected, "again");

    // Bursts: two seconds of data at once, in order and in reverse order.
    const BURST_NS: i64 = 2_000_000_000;
    let burst = |reception: &Reception| reception.received.unwrap().nanos().div_euclid(BURST_NS);
    let mut bursts = receptions;
    for reception in &mut bursts {
        reception.received = Some(Time::from_nanos((burst(reception) + 1) * BURST_NS));
    }
    let forward = points(bursts.iter().cloned(), &config);
    assert!(forward.len() > 5000);
    bursts.chunk_by_mut(|a, b| a.received == b.received).for_each(<[Reception]>::reverse);
    assert_eq!(points(bursts.into_iter(), &config), forward);
}

#[test]
fn aircraft_has_one_number_at_a_time_and_alone() {
    let simulation = flight("crossing", 6);
    let points = points(simulation.receptions(), &site(&simulation, Profile::Operational));
    for slot in points.chunk_by(|a, b| a.time == b.time) {
        let mut numbers: Vec<u32> = slot.iter().map(|point| point.number).collect();
        let mut transponders: Vec<u32> = slot.iter().filter_map(|point| point.transponder).collect();
        for list in [&mut numbers, &mut transponders] {
            let count = list.len();
            list.sort_unstable();
            list.dedup();
            assert_eq!(list.len(), count, "{slot:?}");
        }
    }
}

#[test]
fn drones_with_radars_of_any_quality_keep_transponders() {
    // Three equipped drones, and a radar with a multiple of its configured errors.
    let trio = |by: f64| {
        let mut scenario = scenario("single");
        scenario.name = "three".to_owned();
        (scenario.drones.multirotors, scenario.drones.fixed_wings, scenario.drones.equipped) = (2, 1, 3);
        scenario.birds.count = 0;
        for radar in &mut scenario.radars {
            (radar.bias_azimuth_deg, radar.bias_range_m, radar.bias_height_m) = (0.0, 0.0, 0.0);
            let slow = [&mut radar.track_azimuth_deg, &mut radar.track_range_m, &mut radar.track_height_m];
            let white = [&mut radar.plot_azimuth_deg, &mut radar.plot_range_m, &mut radar.plot_height_m];
            slow.into_iter().chain(white).for_each(|error| *error *= by);
        }
        scenario
    };
    for by in [0.1, 0.5, 2.0] {
        let scenario = trio(by);
        let flown = |seed| scored(&simulate(&scenario, seed, None).unwrap(), Profile::Operational);
        let flights: Vec<Evaluation> = (201..=205).map(flown).collect();
        let recall = mean(&flights, |flight| flight.fused.all.recall);
        assert!(recall >= 0.95, "{by} × the data sheet: recall {recall}");
        let alone = |flight: &Evaluation| metres(flight.transponder.as_ref()?.equipped.epos_covered);
        let error = mean(&flights, |flight| Some(covered(flight)? / alone(flight)?));
        assert!(error <= 1.0, "{by} × the data sheet: {error} of the transponder's error");
    }
}
