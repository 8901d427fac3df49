//! Statistics that determined the defaults, pooled over seeds: update rates and errors of radar and transponder.

use std::collections::BTreeSet;

use fusion::time::Time;
use fusion::{Emission, Source};
use utm_fusion::areas::Masks;
use utm_fusion::config::Profile;
use utm_fusion::pipeline::{Event, Output, Pipeline};
use utm_fusion::simulate::Scenario;

use crate::common::{Flown, between, fly, kept};

/// Number of slots, number of slots with data of the drone, and the 3-D error of each datum.
#[derive(Default)]
struct Pool {
    slots: usize,
    updated: usize,
    errors_m: Vec<f64>,
}

impl Pool {
    fn update_percent(&self) -> f64 {
        100.0 * self.updated as f64 / self.slots as f64
    }

    fn mean_m(&self) -> f64 {
        self.errors_m.iter().sum::<f64>() / self.errors_m.len() as f64
    }
}

fn slot(flown: &Flown, time: Time) -> i64 {
    (flown.seconds(time) * 4.0).floor() as i64
}

fn radar(scenario: &Scenario, seeds: u64) -> Pool {
    let mut pool = Pool::default();
    for seed in 1..=seeds {
        let flown = fly(scenario, seed);
        let slots: BTreeSet<(usize, i64)> =
            flown.plots.iter().filter_map(|plot| Some((plot.drone?, slot(&flown, plot.time)))).collect();
        pool.slots += flown.simulation.flights.len() * (scenario.duration_s * 4.0) as usize;
        pool.updated += slots.len();
        pool.errors_m.extend(flown.plots.iter().filter_map(|plot| {
            let truth = flown.truth(plot.drone?, flown.seconds(plot.time));
            Some((plot.position - truth.position).norm())
        }));
    }
    pool
}

/// Runs transponders alone through the engine: every point is an interpolated position, with a latency of 6.25 s.
fn transponders(scenario: &Scenario, seeds: u64) -> Pool {
    let mut pool = Pool::default();
    for seed in 1..=seeds {
        let flown = fly(scenario, seed);
        // Interpolate the transponders like the paper.
        let mut config = flown.simulation.config.clone();
        config.fusion.profile = Profile::Reference;
        let mut pipeline = Pipeline::new(&config, Masks::default());
        let mut emissions: Vec<Emission> = Vec::new();
        for reception in flown.receptions(129) {
            pipeline.receive(&reception);
            while let Some(output) = pipeline.poll() {
                match output {
                    Output::Emission(emission) => emissions.push(emission),
                    // If a single transponder is silent for longer than the window, the engine starts afresh.
                    Output::Event(event) => {
                        assert!(!event.is_warning() || matches!(event, Event::Restarted), "{event:?}");
                    }
                }
            }
        }
        pipeline.finish();
        emissions.extend(pipeline.emissions());
        let equipped = flown.simulation.flights.iter().filter(|flight| flight.equipped).count();
        pool.slots += equipped * (scenario.duration_s * 4.0) as usize;
        for emission in emissions {
            for point in emission.points {
                assert!(matches!(point.source, Source::Transponder(_)), "{point:?}");
                let truth = flown.truth(point.number as usize - 1, flown.seconds(emission.time));
                pool.errors_m.push((point.position.0 - truth.position).norm());
                pool.updated += 1;
            }
        }
    }
    pool
}

#[test]
fn a_radar_sees_a_drone_in_two_fifths_of_the_slots_36_m_off() {
    let mut all = Pool::default();
    for (name, seeds) in [("single", 20), ("crossing", 20), ("dense", 3)] {
        let pool = radar(&kept(name), seeds);
        println!("{name}: radar PU {:.2} %, {:.2} m", pool.update_percent(), pool.mean_m());
        all.slots += pool.slots;
        all.updated += pool.updated;
        all.errors_m.extend(pool.errors_m);
    }
    between("radar PU, percent", 38.0, all.update_percent(), 41.0);
    between("radar mean 3-D error, m", 33.0, all.mean_m(), 39.0);
}

#[test]
fn two_degrees_of_bias_make_58_m() {
    let pool = radar(&kept("bias"), 30);
    between("radar PU, percent", 37.0, pool.update_percent(), 42.0);
    between("radar mean 3-D error at 2 degrees of bias, m", 55.0, pool.mean_m(), 61.0);
}

#[test]
fn interpolated_transponder_covers_five_sixths_of_slots() {
    let mut all = Pool::default();
    for (name, seeds) in [("single", 20), ("crossing", 12), ("dense", 2)] {
        let pool = transponders(&kept(name), seeds);
        println!("{name}: transponder PU {:.2} %, {:.2} m", pool.update_percent(), pool.mean_m());
        all.slots += pool.slots;
        all.updated += pool.updated;
        all.errors_m.extend(pool.errors_m);
    }
    between("interpolated transponder PU, percent", 81.0, all.update_percent(), 88.0);
    between("interpolated transponder mean 3-D error, m", 4.5, all.mean_m(), 6.0);
}
