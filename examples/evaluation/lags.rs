//! What a shorter latency costs: error, probability of update and deviations against those at the usual one.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use fusion::slots::{Slot, SlotGrid};
use jiff::SignedDuration;
use utm_fusion::areas::Masks;
use utm_fusion::config::Profile;
use utm_fusion::evaluate::{Drone, Evaluation, Labels, Sample, Score, Scoring, evaluate, output};
use utm_fusion::simulate::{Simulation, TRANSPONDER_ID, simulate};

use crate::asked::{Asked, Bound, Case};
use crate::flights::{self, Failure};
use crate::summary::{Mean, show};

/// Where that is measured.
const SCENARIOS: [&str; 2] = ["crossing", "dense"];
/// The usual latency, seconds.
const USUAL_S: f64 = 6.25;
/// The others, seconds.
const LAGS_S: [f64; 4] = [3.25, 2.0, 1.0, 0.0];

/// Of one flight at one lag, of its equipped drones.
struct Lagged {
    /// Against the usual latency: mean error on the slots that both have, and probability of update.
    error: f64,
    update: f64,
    /// NEES over ground of each drone.
    nees: Vec<f64>,
}

/// Of a scenario, by lag, a flight each.
pub struct Measured {
    scenario: &'static str,
    by_lag: [Vec<Lagged>; LAGS_S.len()],
}

/// Flies them.
pub fn measure(seeds: RangeInclusive<u64>, threads: usize) -> Result<Vec<Measured>, Failure> {
    SCENARIOS.into_iter().map(|scenario| of_scenario(scenario, seeds.clone(), threads)).collect()
}

fn of_scenario(name: &'static str, seeds: RangeInclusive<u64>, threads: usize) -> Result<Measured, Failure> {
    let scenario = flights::scenario(name)?;
    let seeds: Vec<u64> = seeds.collect();
    let (next, flown) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                while let Some(&seed) = seeds.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let lags =
                        simulate(&scenario, seed, None).map_err(Failure::from).and_then(|s| of_flight(&s));
                    flown.lock().expect("no other flight has panicked").insert(seed, lags);
                }
            });
        }
    });
    let mut by_lag: [Vec<Lagged>; LAGS_S.len()] = Default::default();
    for lags in flown.into_inner().expect("no flight has panicked").into_values() {
        by_lag.iter_mut().zip(lags?).for_each(|(all, lagged)| all.push(lagged));
    }
    Ok(Measured { scenario: name, by_lag })
}

fn of_flight(simulation: &Simulation) -> Result<Vec<Lagged>, Failure> {
    let usual = at_lag(simulation, USUAL_S)?;
    LAGS_S.into_iter().map(|lag_s| Ok(against(&at_lag(simulation, lag_s)?, &usual))).collect()
}

/// What the service publishes at this latency, scored.
fn at_lag(simulation: &Simulation, lag_s: f64) -> Result<Evaluation, Failure> {
    let truth = simulation.truth();
    let labels = Labels::with_receivers(simulation.labels.clone(), &[TRANSPONDER_ID.to_owned()].into());
    let mut config = simulation.config.clone();
    let fusion = &mut config.fusion;
    fusion.profile = Profile::Operational;
    fusion.latency_slots = (lag_s / fusion.slot.as_secs_f64()) as u32;
    fusion.max_future = fusion.max_future.min(SignedDuration::from_secs_f64(lag_s));
    let points = output(simulation.receptions().map(Ok), &config, Masks::default())?;
    Ok(evaluate(&truth, Some(&labels), &points, None, &Scoring::of(&config)))
}

fn against(lagged: &Evaluation, usual: &Evaluation) -> Lagged {
    let (errors, usual_errors) = (errors(lagged), errors(usual));
    let common = errors.iter().filter_map(|(at, error)| Some((error, usual_errors.get(at)?)));
    let (sum, usual_sum) = common.fold((0.0, 0.0), |sums, (a, b)| (sums.0 + a, sums.1 + b));
    let update = |evaluation: &Evaluation| evaluation.fused.equipped.pu_percent.unwrap_or(0.0);
    let nees = |(score, _): (&Score, _)| Some(score.nees?.horizontal);
    Lagged {
        error: sum / usual_sum,
        update: update(lagged) / update(usual),
        nees: lagged
            .fused
            .drones
            .iter()
            .zip(&lagged.drones)
            .filter(|each| is_equipped(each.1))
            .filter_map(nees)
            .collect(),
    }
}

fn is_equipped(drone: &Drone) -> bool {
    drone.equipped == Some(true)
}

/// Least error of the points of each equipped drone in each slot, metres.
fn errors(evaluation: &Evaluation) -> BTreeMap<(usize, Slot), f64> {
    let mut errors: BTreeMap<(usize, Slot), f64> = BTreeMap::new();
    let of = |sample: &Sample| {
        let drone = sample.drone.filter(|&drone| is_equipped(&evaluation.drones[drone]))?;
        Some(((drone, SlotGrid::default().of(sample.time)), sample.error?.distance_m()))
    };
    for (at, error) in evaluation.fused.samples.iter().filter_map(of) {
        errors.entry(at).and_modify(|least| *least = least.min(error)).or_insert(error);
    }
    errors
}

/// The table of `--quick --lags`.
pub fn table(measured: &[Measured]) -> String {
    let mut text = String::new();
    for Measured { scenario, by_lag } in measured {
        for (lag_s, flights) in LAGS_S.iter().zip(by_lag) {
            let [error, update, nees] = [error, update, nees].map(|of| show(of(flights), 3));
            text += &format!("{scenario:<10} {lag_s:>5}  error {error}  PU {update}  NEES {nees}\n");
        }
    }
    text
}

fn error(flights: &[Lagged]) -> Option<Mean> {
    Mean::of(&flights.iter().map(|lagged| lagged.error).collect::<Vec<_>>())
}

fn update(flights: &[Lagged]) -> Option<Mean> {
    Mean::of(&flights.iter().map(|lagged| lagged.update).collect::<Vec<_>>())
}

fn nees(flights: &[Lagged]) -> Option<Mean> {
    Mean::of(&flights.iter().flat_map(|lagged| lagged.nees.iter().copied()).collect::<Vec<_>>())
}
