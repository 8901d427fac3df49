//! What a shorter latency costs: error, probability of update and deviations against those at the usual one.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use fusion::slots::{Slot, SlotGrid};
use jiff::SignedDuration;
use utm_fusion::areas::Masks;
use utm_fusion::config::{PictureKind, Profile};
use utm_fusion::evaluate::{Drone, Evaluation, Labels, Sample, Score, Scoring, evaluate, output_at};
use utm_fusion::simulate::{Simulation, TRANSPONDER_ID, simulate};

use crate::asked::{Asked, Bound, Case};
use crate::flights::{self, Failure};
use crate::summary::{Mean, show};

/// Where that is measured.
const SCENARIOS: [&str; 2] = ["crossing", "dense"];
/// The usual latency, seconds.
const USUAL_S: f64 = 6.25;

/// A picture that is earlier than the usual one, and what was asked of it: most error, least probability of update, each
/// required and as an ambition.
struct Early {
    name: &'static str,
    latency_s: f64,
    picture: PictureKind,
    error: [f64; 2],
    update: [f64; 2],
}

const EARLY: [Early; 5] = [
    early("3.25 s", 3.25, [1.12, 1.05], [0.97, 0.99]),
    early("2 s", 2.0, [1.45, 1.25], [0.95, 0.98]),
    early("1 s", 1.0, [2.0, 1.6], [0.94, 0.97]),
    early("0", 0.0, [2.8, 2.1], [0.92, 0.97]),
    Early {
        name: "\"now\" beside the usual picture",
        picture: PictureKind::Now,
        ..early("", USUAL_S, [2.8, 2.1], [f64::NEG_INFINITY; 2])
    },
];

const fn early(name: &'static str, latency_s: f64, error: [f64; 2], update: [f64; 2]) -> Early {
    Early { name, latency_s, picture: PictureKind::Lagged, error, update }
}

/// Of one early picture of one flight, of its equipped drones.
struct Scored {
    /// Against the usual picture: mean error on the slots that both have, and probability of update.
    error: f64,
    update: f64,
    /// NEES over ground of each drone.
    nees: Vec<f64>,
}

/// Of a scenario, by early picture, a flight each.
pub struct Measured {
    scenario: &'static str,
    early: [Vec<Scored>; EARLY.len()],
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
                    let simulated = simulate(&scenario, seed, None).map_err(Failure::from);
                    let scored = simulated.and_then(|simulation| of_flight(&simulation));
                    flown.lock().expect("no other flight has panicked").insert(seed, scored);
                }
            });
        }
    });
    let mut early: [Vec<Scored>; EARLY.len()] = Default::default();
    for scored in flown.into_inner().expect("no flight has panicked").into_values() {
        early.iter_mut().zip(scored?).for_each(|(all, scored)| all.push(scored));
    }
    Ok(Measured { scenario: name, early })
}

fn of_flight(simulation: &Simulation) -> Result<Vec<Scored>, Failure> {
    let usual = evaluated(simulation, USUAL_S, PictureKind::Lagged)?;
    let against = |early: &Early| {
        let early = evaluated(simulation, early.latency_s, early.picture)?;
        Ok(against(&early, &usual))
    };
    EARLY.iter().map(against).collect()
}

/// What the service publishes at this latency.
fn evaluated(simulation: &Simulation, latency_s: f64, picture: PictureKind) -> Result<Evaluation, Failure> {
    let truth = simulation.truth();
    let labels = Labels::with_receivers(simulation.labels.clone(), &[TRANSPONDER_ID.to_owned()].into());
    let mut config = simulation.config.clone();
    let fusion = &mut config.fusion;
    fusion.profile = Profile::Operational;
    fusion.latency_slots = (latency_s / fusion.slot.as_secs_f64()) as u32;
    fusion.max_future = fusion.max_future.min(SignedDuration::from_secs_f64(latency_s));
    let points = output_at(picture, simulation.receptions().map(Ok), &config, Masks::default())?;
    Ok(evaluate(&truth, Some(&labels), &points, None, &Scoring::of(&config)))
}

fn against(early: &Evaluation, usual: &Evaluation) -> Scored {
    let (errors, usual_errors) = (errors(early), errors(usual));
    let common = errors.iter().filter_map(|(at, error)| Some((error, usual_errors.get(at)?)));
    let (sum, usual_sum) = common.fold((0.0, 0.0), |sums, (a, b)| (sums.0 + a, sums.1 + b));
    let update = |evaluation: &Evaluation| evaluation.fused.equipped.pu_percent.unwrap_or(0.0);
    let nees = |(score, drone): (&Score, &Drone)| Some(score.nees.filter(|_| is_equipped(drone))?.horizontal);
    Scored {
        error: sum / usual_sum,
        update: update(early) / update(usual),
        nees: early.fused.drones.iter().zip(&early.drones).filter_map(nees).collect(),
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

fn error(flights: &[Scored]) -> Option<Mean> {
    Mean::of(&flights.iter().map(|scored| scored.error).collect::<Vec<_>>())
}

fn update(flights: &[Scored]) -> Option<Mean> {
    Mean::of(&flights.iter().map(|scored| scored.update).collect::<Vec<_>>())
}

fn nees(flights: &[Scored]) -> Option<Mean> {
    Mean::of(&flights.iter().flat_map(|scored| scored.nees.iter().copied()).collect::<Vec<_>>())
}

/// The table of `--quick --lags`.
pub fn table(measured: &[Measured]) -> String {
    let mut text = String::new();
    for Measured { scenario, early } in measured {
        for (early, flights) in EARLY.iter().zip(early) {
            let [error, update, nees] = [error, update, nees].map(|of| show(of(flights), 3));
            text += &format!("{scenario:<9} {:<30}  error {error}  PU {update}  NEES {nees}\n", early.name);
        }
    }
    text
}

/// The rows of the document.
pub fn asked(measured: &[Measured]) -> Vec<Asked> {
    let cases = |index: usize, figure: fn(&[Scored]) -> Option<Mean>| {
        let case = |measured: &Measured| Case {
            at: measured.scenario,
            reached: figure(&measured.early[index]),
            reference: None,
        };
        measured.iter().map(case).collect::<Vec<_>>()
    };
    let why = "a report that comes after a slot pins its place down, and at 3.25 s the next one of a transponder is often \
               still to come; what is left out is what a 95 % radius of 100 m does not hold, no more.";
    let mut rows = Vec::new();
    for (index, early) in EARLY.iter().enumerate() {
        let name = early.name;
        let figure = format!("equipped drones, latency {name}: error / that at 6.25 s, on the slots of both");
        rows.push(
            Asked::new(figure, cases(index, error))
                .required(Bound::AtMost(early.error[0]))
                .ambition(Bound::AtMost(early.error[1]))
                .why(why),
        );
    }
    for (index, early) in EARLY.iter().enumerate() {
        let figure = format!("equipped drones, latency {}: PU / that at 6.25 s", early.name);
        let asked = Asked::new(figure, cases(index, update)).decimals(3);
        rows.push(match early.update {
            [least, best] if least.is_finite() => {
                asked.required(Bound::AtLeast(least)).ambition(Bound::AtLeast(best))
            }
            _ => asked,
        });
    }
    for (index, early) in EARLY
        .iter()
        .enumerate()
        .filter(|(_, early)| early.latency_s == 0.0 || early.picture == PictureKind::Now)
    {
        let figure = format!("equipped drones, latency {}: NEES over ground", early.name);
        rows.push(
            Asked::new(figure, cases(index, nees))
                .required(Bound::Between(0.5, 3.0))
                .ambition(Bound::Between(0.8, 1.5)),
        );
    }
    rows
}
