//! Cost of a shorter latency: error, probability of update and consistency, compared with the default latency.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use fusion::slots::{Slot, SlotGrid};
use jiff::SignedDuration;
use utm_fusion::areas::Masks;
use utm_fusion::config::{PictureKind, Profile};
use utm_fusion::evaluate::{
    ErrorSample, Evaluation, Labels, Scoring, StreamMetrics, TrueDrone, evaluate, output_at,
};
use utm_fusion::simulate::{Simulation, TRANSPONDER_ID, simulate};

use crate::flights::{self, EvaluationFailure};
use crate::results::{ResultCase, ResultRow};
use crate::summary::{MeanValue, show};

/// Scenarios for latencies.
const SCENARIOS: [&str; 2] = ["crossing", "dense"];
/// Default latency, seconds.
const USUAL_S: f64 = 6.25;

/// A picture with a shorter latency.
struct ShorterLatency {
    name: &'static str,
    latency_s: f64,
    picture: PictureKind,
}

const EARLY: [ShorterLatency; 5] = [
    early("3.25 s", 3.25),
    early("2 s", 2.0),
    early("1 s", 1.0),
    early("0", 0.0),
    ShorterLatency {
        name: "\"now\" beside the usual picture",
        latency_s: USUAL_S,
        picture: PictureKind::Now,
    },
];

const fn early(name: &'static str, latency_s: f64) -> ShorterLatency {
    ShorterLatency { name, latency_s, picture: PictureKind::Lagged }
}

/// Score of one early picture of one flight, over equipped drones.
struct LatencyScores {
    /// Ratio to the default picture of the mean error, on slots that both have. `update` is the ratio of the
    /// probability of update.
    error: f64,
    update: f64,
    /// NEES over ground of each drone.
    nees: Vec<f64>,
}

/// Scores of a scenario, by early picture and flight.
pub struct LatencyResults {
    scenario: &'static str,
    early: [Vec<LatencyScores>; EARLY.len()],
}

/// Flies the scenarios.
pub fn measure(seeds: RangeInclusive<u64>, threads: usize) -> Result<Vec<LatencyResults>, EvaluationFailure> {
    SCENARIOS.into_iter().map(|scenario| of_scenario(scenario, seeds.clone(), threads)).collect()
}

fn of_scenario(
    name: &'static str,
    seeds: RangeInclusive<u64>,
    threads: usize,
) -> Result<LatencyResults, EvaluationFailure> {
    let scenario = flights::scenario(name)?;
    let seeds: Vec<u64> = seeds.collect();
    let (next, flown) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                while let Some(&seed) = seeds.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let simulated = simulate(&scenario, seed, None).map_err(EvaluationFailure::from);
                    let scored = simulated.and_then(|simulation| of_flight(&simulation));
                    flown.lock().expect("no other flight has panicked").insert(seed, scored);
                }
            });
        }
    });
    let mut early: [Vec<LatencyScores>; EARLY.len()] = Default::default();
    for scored in flown.into_inner().expect("no flight has panicked").into_values() {
        early.iter_mut().zip(scored?).for_each(|(all, scored)| all.push(scored));
    }
    Ok(LatencyResults { scenario: name, early })
}

fn of_flight(simulation: &Simulation) -> Result<Vec<LatencyScores>, EvaluationFailure> {
    let usual = evaluated(simulation, USUAL_S, PictureKind::Lagged)?;
    let against = |early: &ShorterLatency| {
        let early = evaluated(simulation, early.latency_s, early.picture)?;
        Ok(against(&early, &usual))
    };
    EARLY.iter().map(against).collect()
}

/// Evaluation of the output at this latency.
fn evaluated(
    simulation: &Simulation,
    latency_s: f64,
    picture: PictureKind,
) -> Result<Evaluation, EvaluationFailure> {
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

fn against(early: &Evaluation, usual: &Evaluation) -> LatencyScores {
    let (errors, usual_errors) = (errors(early), errors(usual));
    let common = errors.iter().filter_map(|(at, error)| Some((error, usual_errors.get(at)?)));
    let (sum, usual_sum) = common.fold((0.0, 0.0), |sums, (a, b)| (sums.0 + a, sums.1 + b));
    let update = |evaluation: &Evaluation| evaluation.fused.equipped.pu_percent.unwrap_or(0.0);
    let nees = |(score, drone): (&StreamMetrics, &TrueDrone)| {
        Some(score.nees.filter(|_| is_equipped(drone))?.horizontal)
    };
    LatencyScores {
        error: sum / usual_sum,
        update: update(early) / update(usual),
        nees: early.fused.drones.iter().zip(&early.drones).filter_map(nees).collect(),
    }
}

fn is_equipped(drone: &TrueDrone) -> bool {
    drone.equipped == Some(true)
}

/// Smallest error of each equipped drone's points in each slot, metres.
fn errors(evaluation: &Evaluation) -> BTreeMap<(usize, Slot), f64> {
    let mut errors: BTreeMap<(usize, Slot), f64> = BTreeMap::new();
    let of = |sample: &ErrorSample| {
        let drone = sample.drone.filter(|&drone| is_equipped(&evaluation.drones[drone]))?;
        Some(((drone, SlotGrid::default().of(sample.time)), sample.error?.distance_m()))
    };
    for (at, error) in evaluation.fused.samples.iter().filter_map(of) {
        errors.entry(at).and_modify(|least| *least = least.min(error)).or_insert(error);
    }
    errors
}

fn error(flights: &[LatencyScores]) -> Option<MeanValue> {
    MeanValue::of(&flights.iter().map(|scored| scored.error).collect::<Vec<_>>())
}

fn update(flights: &[LatencyScores]) -> Option<MeanValue> {
    MeanValue::of(&flights.iter().map(|scored| scored.update).collect::<Vec<_>>())
}

fn nees(flights: &[LatencyScores]) -> Option<MeanValue> {
    MeanValue::of(&flights.iter().flat_map(|scored| scored.nees.iter().copied()).collect::<Vec<_>>())
}

/// Table of `--quick --lags`.
pub fn table(measured: &[LatencyResults]) -> String {
    let mut text = String::new();
    for LatencyResults { scenario, early } in measured {
        for (early, flights) in EARLY.iter().zip(early) {
            let [error, update, nees] = [error, update, nees].map(|of| show(of(flights), 3));
            text += &format!("{scenario:<9} {:<30}  error {error}  PU {update}  NEES {nees}\n", early.name);
        }
    }
    text
}

/// Rows of the document.
pub fn rows(measured: &[LatencyResults]) -> Vec<ResultRow> {
    let cases = |index: usize, figure: fn(&[LatencyScores]) -> Option<MeanValue>| {
        let case = |measured: &LatencyResults| ResultCase {
            at: measured.scenario,
            result: figure(&measured.early[index]),
            reference: None,
        };
        measured.iter().map(case).collect::<Vec<_>>()
    };
    let each = || EARLY.iter().enumerate();
    let mut rows = Vec::new();
    for (index, early) in each() {
        let name = early.name;
        let measure =
            format!("equipped drones, latency {name}: error / that at 6.25 s, on the slots of both");
        let row = ResultRow::new(measure, cases(index, error));
        rows.push(match index {
            0 => row.limitation(
                "a report after the slot determines its position; at 3.25 s, the next report of a transponder has \
                 often not arrived.",
            ),
            _ => row,
        });
    }
    for (index, early) in each() {
        let measure = format!("equipped drones, latency {}: PU / that at 6.25 s", early.name);
        rows.push(ResultRow::new(measure, cases(index, update)).decimals(3).lowest());
    }
    for (index, early) in
        each().filter(|(_, early)| early.latency_s == 0.0 || early.picture == PictureKind::Now)
    {
        let measure = format!("equipped drones, latency {}: NEES over ground", early.name);
        rows.push(ResultRow::new(measure, cases(index, nees)).farthest_from_one());
    }
    rows
}
