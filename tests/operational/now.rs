//! Short latencies, and the picture of now.

use std::collections::BTreeMap;

use fusion::Emission;
use fusion::point::Basis;
use fusion::slots::Slot;
use jiff::SignedDuration;
use utm_fusion::capture::Reception;
use utm_fusion::config::{Config, PictureKind, Profile};
use utm_fusion::evaluate::{Evaluation, Labels, Scoring, evaluate, output_at};
use utm_fusion::pipeline::Pipeline;
use utm_fusion::simulate::{Simulation, TRANSPONDER_ID};

use crate::{Masks, Time, flight, mean, points, site};

/// The configuration with this latency, in seconds.
fn at_latency(simulation: &Simulation, latency_s: f64) -> Config {
    let mut config = site(simulation, Profile::Operational);
    config.fusion.latency_slots = (latency_s / 0.25) as u32;
    config.fusion.max_future = config.fusion.max_future.min(SignedDuration::from_secs_f64(latency_s));
    config
}

fn emissions(receptions: impl Iterator<Item = Reception>, config: &Config) -> Vec<Emission> {
    let mut pipeline = Pipeline::new(config, Masks::default());
    let mut emissions = Vec::new();
    for reception in receptions {
        pipeline.receive(&reception);
        emissions.extend(pipeline.emissions());
    }
    pipeline.finish();
    emissions.extend(pipeline.emissions());
    emissions
}

#[test]
fn now_is_the_slot_that_opens_and_changes_nothing_else() {
    let simulation = flight("crossing", 5);
    for latency_s in [6.25, 3.25, 1.0, 0.0] {
        let mut config = at_latency(&simulation, latency_s);
        let with = emissions(simulation.receptions(), &config);
        config.fusion.now = false;
        let without = emissions(simulation.receptions(), &config);
        let mut points = 0;
        for emission in &with {
            let now = emission.now.as_ref().unwrap();
            assert_eq!(now.slot, Slot(emission.slot.0 + (latency_s / 0.25) as i64));
            points += now.points.len();
        }
        assert!(points > 5000, "{latency_s} s: {points} points of now");
        let lagged: Vec<Emission> =
            with.into_iter().map(|emission| Emission { now: None, ..emission }).collect();
        assert!(lagged == without, "{latency_s} s");
    }
}

#[test]
fn point_of_now_is_predicted_numbered_and_accurate() {
    let simulation = flight("crossing", 6);
    // The latest published aircraft of each number.
    let mut published = BTreeMap::new();
    for emission in emissions(simulation.receptions(), &at_latency(&simulation, 6.25)) {
        for point in emission.points {
            published.insert(point.number, point);
        }
        for point in emission.now.unwrap().points {
            let last = &published[&point.number];
            let estimate = point.estimate.unwrap();
            assert_eq!((estimate.basis, point.first_seen), (Basis::Extrapolated, last.first_seen));
            let transponder = point.source.transponder().map(|part| part.identity);
            assert_eq!(transponder, last.source.transponder().map(|part| part.identity), "another aircraft");
            if transponder.is_some() {
                assert!(estimate.sigma_m() <= 25.0, "{point:?}");
            }
        }
    }
    assert!(published.len() > 3);
}

#[test]
fn at_a_latency_of_nothing_both_pictures_are_of_one_time() {
    let simulation = flight("crossing", 7);
    let (mut both, mut lagged_alone) = (0, 0);
    for emission in emissions(simulation.receptions(), &at_latency(&simulation, 0.0)) {
        let now = emission.now.unwrap();
        assert_eq!((now.slot, now.time), (emission.slot, emission.time));
        let places: BTreeMap<_, _> = now.points.iter().map(|point| (point.number, point.position)).collect();
        for point in &emission.points {
            match places.get(&point.number) {
                Some(place) => {
                    assert_eq!(*place, point.position);
                    both += 1;
                }
                // The picture of now leaves out less accurate tracks.
                None => lagged_alone += 1,
            }
        }
        assert!(places.len() <= emission.points.len());
    }
    assert!(both > 5000 && lagged_alone < both / 5, "{both}, {lagged_alone}");
}

#[test]
fn short_latencies_and_now_in_any_order_agree() {
    let simulation = flight("crossing", 5);
    const BURST_NS: i64 = 2_000_000_000;
    let mut bursts: Vec<Reception> = simulation.receptions().collect();
    for reception in &mut bursts {
        let burst = reception.received.unwrap().nanos().div_euclid(BURST_NS);
        reception.received = Some(Time::from_nanos((burst + 1) * BURST_NS));
    }
    let mut backward = bursts.clone();
    backward.chunk_by_mut(|a, b| a.received == b.received).for_each(<[Reception]>::reverse);
    for latency_s in [6.25, 1.0, 0.0] {
        let config = at_latency(&simulation, latency_s);
        let forward = emissions(bursts.iter().cloned(), &config);
        assert!(
            forward.iter().map(|emission| emission.now.as_ref().unwrap().points.len()).sum::<usize>() > 3000
        );
        assert!(forward == emissions(backward.iter().cloned(), &config), "{latency_s} s");
    }
}

#[test]
fn nobody_is_shown_for_longer_than_what_is_received_lasts() {
    // From some time on nothing is received while the clock goes on.
    let simulation = flight("single", 3);
    let receptions: Vec<Reception> = simulation.receptions().collect();
    let (first, last) = (receptions[0].received.unwrap(), receptions[receptions.len() / 2].received.unwrap());
    for latency_s in [6.25, 3.25, 0.0] {
        let mut pipeline = Pipeline::new(&at_latency(&simulation, latency_s), Masks::default());
        let mut shown = Vec::new();
        for reception in &receptions[..receptions.len() / 2] {
            pipeline.receive(reception);
            shown.extend(pipeline.emissions());
        }
        for quarter in 1..80 {
            pipeline.tick(last + SignedDuration::from_millis(250 * quarter));
            shown.extend(pipeline.emissions());
        }
        let latest = |has: fn(&Emission) -> bool| {
            let shown = shown.iter().filter(|emission| has(emission)).map(|emission| emission.time);
            shown.max().unwrap() + SignedDuration::from_secs_f64(latency_s)
        };
        for shown in [
            latest(|emission| !emission.points.is_empty()),
            latest(|emission| emission.now.as_ref().is_some_and(|now| !now.points.is_empty())),
        ] {
            let after_s = shown.seconds_since(last);
            assert!(shown > first && after_s <= 6.5, "{latency_s} s: {after_s} s after the last reception");
        }
    }
}

/// The evaluation of both pictures at this latency.
fn scored(simulation: &Simulation, latency_s: f64) -> [Evaluation; 2] {
    let labels = Labels::with_receivers(simulation.labels.clone(), &[TRANSPONDER_ID.to_owned()].into());
    let config = at_latency(simulation, latency_s);
    [PictureKind::Lagged, PictureKind::Now].map(|picture| {
        let receptions = simulation.receptions().map(Ok);
        let points = output_at(picture, receptions, &config, Masks::default()).unwrap();
        evaluate(&simulation.truth(), Some(&labels), &points, None, &Scoring::of(&config))
    })
}

#[test]
fn a_shorter_latency_costs_what_it_may_and_says_so() {
    let flights: Vec<Simulation> = (1..=4).map(|seed| flight("crossing", seed)).collect();
    let at = |latency_s| flights.iter().map(|flight| scored(flight, latency_s)).collect::<Vec<_>>();
    let figures = |scored: &[[Evaluation; 2]], picture: usize| {
        let scored: Vec<Evaluation> = scored.iter().map(|pictures| pictures[picture].clone()).collect();
        let error = mean(&scored, |e| Some(e.fused.equipped.epos?.mean_m));
        let seen = mean(&scored, |e| e.fused.equipped.pu_percent);
        let nees = mean(&scored, |e| Some(e.fused.equipped.nees?.horizontal));
        (error, seen, nees)
    };
    let usual = at(6.25);
    let (usual_error, usual_seen, _) = figures(&usual, 0);
    for (latency_s, error_most, seen_least) in
        [(3.25, 1.3, 0.97), (2.0, 1.6, 0.95), (1.0, 2.0, 0.94), (0.0, 2.8, 0.92)]
    {
        let (error, seen, nees) = figures(&at(latency_s), 0);
        assert!(error <= error_most * usual_error, "{latency_s} s: {error} m of {usual_error} m");
        assert!(seen >= seen_least * usual_seen, "{latency_s} s: PU {seen} of {usual_seen}");
        assert!((0.5..=3.0).contains(&nees), "{latency_s} s: NEES {nees}");
    }
    let (error, seen, nees) = figures(&usual, 1);
    assert!(error <= 2.8 * usual_error, "now: {error} m of {usual_error} m");
    // The picture of now lacks the first 6.25 s of the five minutes, and tracks less accurate than 25 m.
    assert!(seen >= 0.87 * usual_seen, "now: PU {seen} of {usual_seen}");
    assert!((0.5..=3.0).contains(&nees), "now: NEES {nees}");
}

#[test]
fn a_latency_that_is_shorter_shows_the_same_aircraft() {
    // By number and transponder: association does not depend on the latency of the picture.
    let simulation = flight("crossing", 8);
    let pairs = |latency_s| {
        let points = points(simulation.receptions(), &at_latency(&simulation, latency_s));
        let mut pairs: Vec<_> =
            points.iter().filter_map(|point| Some((point.transponder?, point.number))).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs.iter().map(|pair| pair.0).collect::<Vec<_>>()
    };
    let usual = pairs(6.25);
    assert!(usual.len() > 3);
    for latency_s in [3.25, 0.0] {
        assert_eq!(pairs(latency_s), usual, "one number for each transponder at {latency_s} s");
    }
}
