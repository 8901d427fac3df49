//! Compares the product's error with that of a clairvoyant smoother. The smoother knows the drone of each plot and
//! report, the radar's misalignment, and the size of every random error. It uses only data that had arrived when the
//! product published.
//!
//! The smoother shares no code with the engine's filters. The difference between the two is the cost of association,
//! registration, learnt accuracies and motion models.

mod drone;
mod gaussian;
mod inputs;
mod mixture;
mod model;
mod parts;
mod smoother;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use utm_fusion::areas::Masks;
use utm_fusion::config::Profile;
use utm_fusion::evaluate::{ErrorSample, Evaluation, InputsAlone, Labels, Scoring, evaluate, output};
use utm_fusion::simulate::{TRANSPONDER_ID, simulate};

use crate::flights::{self, EvaluationFailure, EvaluationFlight, FlightSource};
use crate::parallel;
use crate::results::{ResultCase, ResultRow};
use crate::summary::{MeanValue, show};
use crate::variants::{BIAS_EQUIPPED, SPARSE, VARIANTS};

use inputs::{LimitInputs, drone_of};
use model::{MotionLevels, SensorErrors};
use smoother::{DelayPrior, RequestedTime, SmoothedEstimate, Smoother};

pub use parts::parts;

/// Scenarios and variants for the limit: one radar, no attacks on transponders.
pub const SCENARIOS: [&str; 6] = ["single", "crossing", "dense", "bias", "gaps", "flock"];
const CHANGED: [&str; 3] = [BIAS_EQUIPPED, AZIMUTH, SPARSE];
const AZIMUTH: &str = "azimuth-bias-minus-3";

/// Estimators: the product, and the limit with each prior of the delay.
pub const WAYS: [&str; 4] =
    ["product", "limit, delay 0 ± 0.1 s", "limit, distribution of delays known", "limit, delay known"];
const PRODUCT: usize = 0;
const UNKNOWN: usize = 1;
const LIMITS: usize = 3;
/// Standard deviation of an unknown delay, seconds.
const DELAY_S: f64 = 0.1;

/// Only slots whose number is a multiple of this are compared, because errors of successive slots are nearly the same.
const EVERY: i64 = 4;

/// A point of the product, with the limit's errors at the same time.
pub struct LimitPoint {
    pub time_s: f64,
    pub is_equipped: bool,
    /// Error of the interpolated transponder in the slot, if it interpolates, metres.
    pub transponder_m: Option<f64>,
    /// Whether the drone has a plot within one second.
    pub has_plots: bool,
    pub is_turning: bool,
    /// True velocity east and north, m/s.
    pub velocity_m_s: [f64; 2],
    /// Errors east, north and up, in the order of [`WAYS`], metres.
    pub errors_m: [[f64; 3]; WAYS.len()],
    /// Errors of the estimated delays, in the order of [`WAYS`], seconds; unknown for the product.
    pub delays_off_s: [f64; WAYS.len()],
    /// Normalised squares of the limit's errors, over ground and in height.
    nees: [[f64; 2]; LIMITS],
}

/// Comparison of a flight.
pub struct LimitFlight {
    pub points: Vec<LimitPoint>,
    pub duration_s: f64,
    /// Number of the product's points for which the limit had received nothing yet.
    unknown: usize,
}

/// Comparisons of all flights of a scenario.
pub struct LimitResults {
    pub name: &'static str,
    pub flights: Vec<LimitFlight>,
}

/// Flies the named scenarios and variants, or all if none is named.
pub fn measure(
    names: &[&str],
    seeds: &RangeInclusive<u64>,
    threads: usize,
) -> Result<Vec<LimitResults>, EvaluationFailure> {
    if let Some(name) = names.iter().find(|name| !SCENARIOS.contains(name) && !CHANGED.contains(name)) {
        let known = [&SCENARIOS[..], &CHANGED[..]].concat().join(", ");
        return Err(format!("the limit is not measured on {name}; it is on {known}").into());
    }
    let is_wanted = |name: &str| names.is_empty() || names.contains(&name);
    let mut rows: Vec<(&'static str, Vec<EvaluationFlight>)> = Vec::new();
    for name in SCENARIOS.into_iter().filter(|name| is_wanted(name)) {
        rows.push((name, flights::simulated(name, seeds.clone())?));
    }
    for variant in
        VARIANTS.iter().filter(|variant| CHANGED.contains(&variant.name) && is_wanted(variant.name))
    {
        rows.push((variant.name, variant.flights(seeds.clone())?));
    }
    let of_row = |(name, flights): (&'static str, Vec<EvaluationFlight>)| {
        let flown = parallel::each(&flights, threads, |_, flight| {
            eprintln!("limit: {}", flight.name());
            of_flight(flight)
        });
        Ok(LimitResults { name, flights: flown.into_iter().collect::<Result<_, _>>()? })
    };
    rows.into_iter().map(of_row).collect()
}

fn of_flight(flight: &EvaluationFlight) -> Result<LimitFlight, EvaluationFailure> {
    let FlightSource::Simulated { scenario, seed, .. } = &flight.source else {
        return Err("the limit is of simulated flights".into());
    };
    let [radar] = scenario.radars.as_slice() else { return Err("the limit takes one radar".into()) };
    let simulation = simulate(scenario, *seed, None)?;
    let truth = simulation.truth();
    let labels = Labels::with_receivers(simulation.labels.clone(), &[TRANSPONDER_ID.to_owned()].into());
    let mut config = simulation.config.clone();
    (flight.configure)(&mut config);
    config.fusion.profile = Profile::Operational;
    let receptions = || simulation.receptions().map(Ok);
    let alone = InputsAlone::of(receptions(), &config, Masks::default())?;
    let points = output(receptions(), &config, Masks::default())?;
    let scoring = Scoring::of(&config);
    let evaluation = evaluate(&truth, Some(&labels), &points, Some(&alone), &scoring);
    let inputs = LimitInputs::of(scenario, radar, *seed, &simulation)?;
    let smoother =
        Smoother::new(SensorErrors::of(scenario, radar), MotionLevels::default(), inputs.antenna_m);
    let late = scenario.transponder.stamped_late_s;
    let uniform = DelayPrior {
        mean_s: (late.low + late.high) / 2.0,
        sigma_s: (late.high - late.low) / 12.0_f64.sqrt(),
    };
    Ok(compared(&evaluation, &inputs, &smoother, uniform, &scoring, scenario.duration_s))
}

/// The product's points with the limit's errors.
fn compared(
    evaluation: &Evaluation,
    inputs: &LimitInputs,
    smoother: &Smoother,
    uniform: DelayPrior,
    scoring: &Scoring,
    duration_s: f64,
) -> LimitFlight {
    let grid = scoring.grid;
    let number = |drone: usize| drone_of(&evaluation.drones[drone].id);
    let mut transponder_m = BTreeMap::new();
    for sample in evaluation.transponder.iter().flat_map(|scored| &scored.samples) {
        if let (Some(drone), Some(error)) = (sample.drone, sample.error) {
            transponder_m.insert((drone, grid.of(sample.time)), error.distance_m());
        }
    }
    let mut samples: BTreeMap<usize, Vec<&ErrorSample>> = BTreeMap::new();
    for sample in &evaluation.fused.samples {
        if let Some(drone) = sample.drone
            && grid.of(sample.time).0 % EVERY == 0
        {
            samples.entry(drone).or_default().push(sample);
        }
    }
    let mut flown = LimitFlight { points: Vec::new(), duration_s, unknown: 0 };
    for (drone, mut samples) in samples {
        let Some((own, known)) = number(drone).and_then(|number| Some((number, inputs.drones.get(number)?)))
        else {
            continue;
        };
        samples.sort_by_key(|sample| sample.time);
        let requested: Vec<RequestedTime> = (samples.iter())
            .map(|sample| RequestedTime {
                time_s: inputs.seconds(sample.time),
                deadline_s: inputs.seconds(grid.open(grid.of(sample.time)) + scoring.latency),
            })
            .collect();
        let true_s = known.delay_s.unwrap_or(0.0);
        let delays = [
            DelayPrior { mean_s: 0.0, sigma_s: DELAY_S },
            uniform,
            DelayPrior { mean_s: true_s, sigma_s: 0.0 },
        ];
        let limits = delays.map(|delay| smoother.estimates(&known.measured, delay, &requested));
        for (place, sample) in samples.iter().enumerate() {
            let [Some(one), Some(two), Some(three)] = limits.each_ref().map(|limit| limit[place]) else {
                flown.unknown += 1;
                continue;
            };
            let Some(error) = sample.error else { continue };
            let time_s = requested[place].time_s;
            let truth_m = inputs.truth_m(own, time_s);
            let product_m = [error.east_m, error.north_m, error.up_m.unwrap_or(0.0)];
            let off =
                |limit: &SmoothedEstimate| std::array::from_fn(|axis| limit.place_m[axis] - truth_m[axis]);
            let delay = |limit: &SmoothedEstimate| (limit.delay_s[0] - true_s).abs();
            let limits = [one, two, three];
            let [one_m, two_m, three_m]: [[f64; 3]; 3] = limits.each_ref().map(off);
            let nees = |limit: usize, error_m| limits[limit].normalised(error_m).unwrap_or([0.0; 2]);
            let velocity = known.path.at(time_s).velocity;
            flown.points.push(LimitPoint {
                time_s,
                is_equipped: evaluation.drones[drone].equipped == Some(true),
                transponder_m: transponder_m.get(&(drone, grid.of(sample.time))).copied(),
                has_plots: known.has_plots(time_s),
                is_turning: known.path.turns(time_s),
                velocity_m_s: [velocity.x, velocity.y],
                errors_m: [product_m, one_m, two_m, three_m],
                delays_off_s: [f64::NAN, delay(&one), delay(&two), delay(&three)],
                nees: [nees(0, one_m), nees(1, two_m), nees(2, three_m)],
            });
        }
    }
    flown
}

impl LimitPoint {
    /// 3-D error, metres.
    pub fn distance_m(&self, way: usize) -> f64 {
        let [_, _, up] = self.errors_m[way];
        self.horizontal_m(way).hypot(up)
    }

    /// Horizontal error, metres.
    pub fn horizontal_m(&self, way: usize) -> f64 {
        let [east, north, _] = self.errors_m[way];
        east.hypot(north)
    }

    /// Vertical error, metres.
    pub fn vertical_m(&self, way: usize) -> f64 {
        self.errors_m[way][2].abs()
    }

    pub fn is_covered(&self) -> bool {
        self.is_equipped && self.transponder_m.is_some()
    }

    fn is_gap(&self) -> bool {
        self.is_equipped && self.transponder_m.is_none()
    }
}

/// Mean over the points for which `is_selected` holds.
pub fn mean<'a>(
    points: impl Iterator<Item = &'a LimitPoint>,
    is_selected: impl Fn(&LimitPoint) -> bool,
    of: impl Fn(&LimitPoint) -> f64,
) -> Option<f64> {
    let (sum, count) = points
        .filter(|point| is_selected(point))
        .fold((0.0, 0.0), |(sum, count), point| (sum + of(point), count + 1.0));
    (count > 0.0).then_some(sum / count)
}

/// A figure of a flight and an estimator.
type LimitFigure = fn(&LimitFlight, usize) -> Option<f64>;

const COVERED: LimitFigure =
    |flown, way| mean(flown.points.iter(), LimitPoint::is_covered, |point| point.distance_m(way));
const COVERED_RATIO: LimitFigure = |flown, way| {
    let transponder =
        mean(flown.points.iter(), LimitPoint::is_covered, |point| point.transponder_m.unwrap_or(0.0));
    Some(COVERED(flown, way)? / transponder?)
};
const HORIZONTAL: LimitFigure =
    |flown, way| mean(flown.points.iter(), LimitPoint::is_covered, |point| point.horizontal_m(way));
const VERTICAL: LimitFigure =
    |flown, way| mean(flown.points.iter(), LimitPoint::is_covered, |point| point.vertical_m(way));
const GAP: LimitFigure =
    |flown, way| mean(flown.points.iter(), LimitPoint::is_gap, |point| point.distance_m(way));
const UNEQUIPPED: LimitFigure =
    |flown, way| mean(flown.points.iter(), |point| !point.is_equipped, |point| point.distance_m(way));
const NEES: LimitFigure = |flown, way| nees(flown, way, LimitPoint::is_covered, 0);
const NEES_HEIGHT: LimitFigure = |flown, way| nees(flown, way, LimitPoint::is_covered, 1);
const NEES_WITHOUT: LimitFigure = |flown, way| nees(flown, way, |point| !point.is_equipped, 0);
const NEES_GAP: LimitFigure = |flown, way| nees(flown, way, LimitPoint::is_gap, 0);

fn nees(flown: &LimitFlight, way: usize, is_selected: fn(&LimitPoint) -> bool, part: usize) -> Option<f64> {
    let limit = way.checked_sub(1)?;
    mean(flown.points.iter(), is_selected, |point| point.nees[limit][part])
}

/// Columns of the table, with decimals.
const COLUMNS: [(&str, LimitFigure, usize); 10] = [
    ("covered / T", COVERED_RATIO, 3),
    ("horizontal, m", HORIZONTAL, 2),
    ("vertical, m", VERTICAL, 2),
    ("gap, m", GAP, 1),
    ("without transponder, m", UNEQUIPPED, 1),
    ("NEES", NEES, 2),
    ("height", NEES_HEIGHT, 2),
    ("gap", NEES_GAP, 2),
    ("without", NEES_WITHOUT, 2),
    ("product / it, covered", |flown, way| Some(COVERED(flown, PRODUCT)? / COVERED(flown, way)?), 3),
];

impl LimitResults {
    fn figure(&self, figure: LimitFigure, way: usize) -> Option<MeanValue> {
        MeanValue::of(&self.flights.iter().filter_map(|flown| figure(flown, way)).collect::<Vec<_>>())
    }

    /// Ratio of the product's figure to the limit's, flight by flight.
    fn against(&self, figure: LimitFigure, way: usize) -> Option<MeanValue> {
        let ratio = |flown: &LimitFlight| Some(figure(flown, PRODUCT)? / figure(flown, way)?);
        MeanValue::of(&self.flights.iter().filter_map(ratio).collect::<Vec<_>>())
    }

    /// Number of the product's points without an estimate of the limit.
    fn unknown(&self) -> usize {
        self.flights.iter().map(|flown| flown.unknown).sum()
    }
}

/// Table of `--quick --limit`.
pub fn table(measured: &[LimitResults]) -> String {
    let mut text = String::new();
    for row in measured {
        text += &format!(
            "{}, {} flights, {} points without a limit\n",
            row.name,
            row.flights.len(),
            row.unknown()
        );
        for (way, name) in WAYS.iter().enumerate() {
            let cells = COLUMNS.map(|(head, figure, decimals)| {
                format!("{head} {}", show(row.figure(figure, way), decimals))
            });
            text += &format!("  {name:<36} {}\n", cells.join("  "));
        }
    }
    text
}

/// Section of the document.
pub fn section(measured: &[LimitResults]) -> String {
    let mut text = include_str!("words/limit.md").to_owned();
    text += "\n| scenario | | covered / transponder's | horizontal, m | vertical, m | gaps, m | without transponder, m | NEES | in height |\n";
    text += "|---|---|---:|---:|---:|---:|---:|---:|---:|\n";
    for row in measured {
        for (way, name) in WAYS.iter().enumerate() {
            let cells = &COLUMNS[..7];
            let cells: Vec<String> =
                cells.iter().map(|(_, figure, decimals)| show(row.figure(*figure, way), *decimals)).collect();
            text += &format!("| `{}` | {name} | {} |\n", row.name, cells.join(" | "));
        }
    }
    text
}

/// Rows of the results.
pub fn rows(measured: &[LimitResults]) -> Vec<ResultRow> {
    let cases = |names: &[&str], figure: LimitFigure| {
        let rows = measured.iter().filter(|row| names.contains(&row.name));
        let case = |row: &LimitResults| ResultCase {
            at: row.name,
            result: row.against(figure, UNKNOWN),
            reference: None,
        };
        rows.map(case).collect::<Vec<_>>()
    };
    let covered = ["single", "crossing", "dense", AZIMUTH, SPARSE];
    vec![
        ResultRow::new("error on covered slots / limit with unknown delay", cases(&covered, COVERED))
            .decimals(3),
        ResultRow::new("error in gaps / limit with unknown delay", cases(&SCENARIOS, GAP)),
    ]
}
