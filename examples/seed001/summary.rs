//! Results of all flights, and their requirements.

use crate::experiment::{ExperimentRequirement, mean, quantile, rms, runs, said};
use crate::scenario::{INTRUDERS, Intruder};
use crate::sensors::CONFIGURATIONS;
use crate::tracking::{STEP_S, TrackSample, TrackerModels, track};

/// Time after the first detection from which the straight leg counts, seconds.
const SETTLED_S: f64 = 20.0;
/// Maximum error of a manoeuvre that is followed, metres.
const FOLLOWED_M: f64 = 1000.0;
/// Maximum time until the side of a turn is known, seconds.
const KNOWN_S: f64 = 10.0;
/// Time step of the rms error over time, seconds.
const EVERY_S: f64 = 1.0;

/// Errors of one flight.
#[derive(Clone, Debug)]
struct FlightErrors {
    /// Rms errors on the straight leg, and in the turn.
    position_m: [f64; 2],
    heading_deg: [f64; 2],
    /// Along-track error in the turn: mean, rms.
    along_m: [f64; 2],
    /// Maximum error.
    most_m: f64,
    /// Time from the beginning of the turn until its side has the higher probability, seconds; infinite: never.
    known_s: f64,
    /// Errors at multiples of [`EVERY_S`].
    over_time: Vec<(f64, f64)>,
}

impl FlightErrors {
    fn of(intruder: &Intruder, samples: &[TrackSample]) -> Self {
        let turn = intruder.turn_s();
        let straight = |sample: &&TrackSample| (SETTLED_S..turn).contains(&sample.at);
        let turning = |sample: &&TrackSample| sample.at >= turn;
        let legs = |of: fn(&TrackSample) -> f64| {
            let rms_of = |leg: Vec<f64>| rms(&leg);
            [
                rms_of(samples.iter().filter(straight).map(of).collect()),
                rms_of(samples.iter().filter(turning).map(of).collect()),
            ]
        };
        let along: Vec<f64> = samples.iter().filter(turning).map(|sample| sample.along_m).collect();
        let known = samples.iter().find(|sample| sample.at >= turn && sample.left > 0.5);
        let every = (EVERY_S / STEP_S).round() as usize;
        Self {
            position_m: legs(|sample| sample.error_m),
            heading_deg: legs(|sample| sample.heading_deg),
            along_m: [mean(&along), rms(&along)],
            most_m: samples.iter().map(|sample| sample.error_m).fold(0.0, f64::max),
            known_s: known.map_or(f64::INFINITY, |sample| sample.at - turn),
            over_time: samples.iter().step_by(every).map(|sample| (sample.at, sample.error_m)).collect(),
        }
    }
}

/// All flights of one intruder with one configuration and one set of models.
struct ModelCase {
    intruder: usize,
    configuration: usize,
    models: TrackerModels,
    flown: Vec<FlightErrors>,
}

impl ModelCase {
    fn over(&self, of: impl Fn(&FlightErrors) -> f64) -> f64 {
        rms(&self.flown.iter().map(of).collect::<Vec<_>>())
    }

    fn position_m(&self, leg: usize) -> f64 {
        self.over(|flown| flown.position_m[leg])
    }

    /// Along-track error in the turn: mean over the flights, and its standard error, metres.
    fn along(&self) -> (f64, f64) {
        let all: Vec<f64> = self.flown.iter().map(|flown| flown.along_m[0]).collect();
        let middle = mean(&all);
        (middle, self.over(|flown| flown.along_m[0] - middle) / (all.len() as f64).sqrt())
    }

    fn heading_deg(&self, leg: usize) -> f64 {
        self.over(|flown| flown.heading_deg[leg])
    }
}

/// Along-track lead of a track in the turn.
pub struct TurnLead {
    /// Mean over all flights, its standard error, and the rms error, metres.
    pub mean_m: f64,
    pub error_m: f64,
    pub rms_m: f64,
    /// Median time until the side of the turn is known, seconds.
    pub known_s: f64,
    /// Expected lag of a track that flies straight on until that time, metres.
    pub expected_m: f64,
}

pub struct TurnSummary {
    pub first_seed: u64,
    pub runs: u64,
    cases: Vec<ModelCase>,
}

/// The requirement that intruder 1 does not meet; the page explains it.
pub const BEHIND: &str = "2: mean error along the track in the turn (m)";
const LEGS: [&str; 2] = ["straight", "turn"];
const ALL: [TrackerModels; 4] =
    [TrackerModels::Seven, TrackerModels::Straight, TrackerModels::Crewed, TrackerModels::Three];

impl TurnSummary {
    pub fn measure(first_seed: u64, count: u64) -> Self {
        let mut cases = Vec::new();
        for (intruder, flying) in INTRUDERS.iter().enumerate() {
            for (configuration, sensors) in CONFIGURATIONS.iter().enumerate() {
                let sets: &[TrackerModels] = if intruder == 0 { &ALL } else { &ALL[..2] };
                let flown = runs(first_seed, count, |seed| {
                    let readings = sensors.readings(flying, seed);
                    let of =
                        |models: &TrackerModels| FlightErrors::of(flying, &track(flying, &readings, *models));
                    sets.iter().map(of).collect::<Vec<_>>()
                });
                for (place, &models) in sets.iter().enumerate() {
                    let flown = flown.iter().map(|flown| flown[place].clone()).collect();
                    cases.push(ModelCase { intruder, configuration, models, flown });
                }
            }
        }
        Self { first_seed, runs: count, cases }
    }

    fn case(&self, intruder: usize, configuration: usize, models: TrackerModels) -> &ModelCase {
        let is_it = |case: &&ModelCase| {
            (case.intruder, case.configuration, case.models) == (intruder, configuration, models)
        };
        self.cases.iter().find(is_it).expect("every case is measured")
    }

    /// Results with all models.
    pub fn table(&self) -> String {
        let mut table = "| intruder | configuration | position, straight (m) | position, turn (m) | heading, straight (°) | heading, turn (°) | along track in the turn: mean ± standard error, rms (m) | largest error, 99 % of the flights (m) | side of the turn known after, median (s) |\n|---|---|---|---|---|---|---|---|---|\n".to_owned();
        for (intruder, flying) in INTRUDERS.iter().enumerate() {
            for (configuration, sensors) in CONFIGURATIONS.iter().enumerate() {
                let case = self.case(intruder, configuration, TrackerModels::Seven);
                let all = |of: fn(&FlightErrors) -> f64| case.flown.iter().map(of).collect::<Vec<_>>();
                let (along, error) = case.along();
                table.push_str(&format!(
                    "| {} | {} | {} | {} | {} | {} | {} ± {}, {} | {} | {} |\n",
                    flying.name,
                    sensors.name,
                    said(case.position_m(0)),
                    said(case.position_m(1)),
                    said(case.heading_deg(0)),
                    said(case.heading_deg(1)),
                    said(along),
                    said(error),
                    said(case.over(|flown| flown.along_m[1])),
                    said(quantile(&all(|flown| flown.most_m), 0.99)),
                    said(quantile(&all(|flown| flown.known_s), 0.5)),
                ));
            }
        }
        table
    }

    /// Along-track error of intruder 1 in its turn, in configuration 2.
    pub fn lag(&self) -> TurnLead {
        let case = self.case(0, 1, TrackerModels::Seven);
        let (mean_m, error_m) = case.along();
        let known: Vec<f64> = case.flown.iter().map(|flown| flown.known_s).collect();
        let known_s = quantile(&known, 0.5);
        let Intruder { speed, turn, .. } = INTRUDERS[0];
        let rms_m = case.over(|flown| flown.along_m[1]);
        TurnLead { mean_m, error_m, rms_m, known_s, expected_m: speed * turn * turn * known_s.powi(3) / 3.0 }
    }

    /// Position errors by set of models.
    pub fn models_table(&self) -> String {
        let mut table = "| intruder | configuration | leg | seven models (m) | straight flight alone (m) | ± 2, ± 6 °/s (m) | ± 2 °/s (m) |\n|---|---|---|---|---|---|---|\n".to_owned();
        for (intruder, flying) in INTRUDERS.iter().enumerate() {
            for configuration in 0..CONFIGURATIONS.len() {
                for (leg, name) in LEGS.into_iter().enumerate() {
                    let mut cells = ALL.map(|models| {
                        let case = self.cases.iter().find(|case| {
                            (case.intruder, case.configuration, case.models)
                                == (intruder, configuration, models)
                        });
                        case.map_or_else(|| "–".to_owned(), |case| said(case.position_m(leg)))
                    });
                    table.push_str(&format!("| {} | {} | {name}", flying.name, configuration + 1));
                    cells.iter_mut().for_each(|cell| table.push_str(&format!(" | {cell}")));
                    table.push_str(" |\n");
                }
            }
        }
        table
    }

    pub fn requirements(&self) -> Vec<ExperimentRequirement> {
        let mut requirements = Vec::new();
        for intruder in 0..INTRUDERS.len() {
            self.requirements_of(intruder, &mut requirements);
        }
        for configuration in 0..CONFIGURATIONS.len() {
            let whole = |models: TrackerModels| {
                let case = self.case(0, configuration, models);
                case.position_m(0).hypot(case.position_m(1))
            };
            for (models, name) in [(TrackerModels::Crewed, "± 2, ± 6 °/s"), (TrackerModels::Three, "± 2 °/s")]
            {
                let what = format!("intruder 1, {}: {name} against seven models", configuration + 1);
                requirements.push(at_most(what, whole(models) / whole(TrackerModels::Seven), 1.05));
            }
        }
        requirements
    }

    fn requirements_of(&self, intruder: usize, requirements: &mut Vec<ExperimentRequirement>) {
        let name = INTRUDERS[intruder].name;
        let case = |configuration: usize| self.case(intruder, configuration, TrackerModels::Seven);
        let followed = case(0).flown.iter().filter(|flown| flown.most_m < FOLLOWED_M).count();
        let share = followed as f64 / self.runs as f64;
        requirements.push(at_least(format!("{name}, 1: flights within 1 km throughout"), share, 0.99));
        let heading = [0, 1, 2].map(|configuration| case(configuration).heading_deg(0));
        requirements.push(at_least(
            format!("{name}: heading on the straight, 1 against 3"),
            heading[0] / heading[2],
            2.0,
        ));
        requirements.push(at_least(
            format!("{name}: heading on the straight, 1 against 2"),
            heading[0] / heading[1],
            2.0,
        ));
        for (leg, leg_name) in LEGS.into_iter().enumerate() {
            let position = [0, 1, 2].map(|configuration| case(configuration).position_m(leg));
            requirements.push(at_most(
                format!("{name}, {leg_name}: position, 3 against the better of 1 and 2"),
                position[2] / position[0].min(position[1]),
                1.0,
            ));
        }
        let (along, error) = case(1).along();
        requirements.push(at_most(format!("{name}, {BEHIND}"), along, 0.0));
        let what = format!("{name}, 2: the same less two standard errors (m)");
        requirements.push(at_most(what, along - 2.0 * error, 0.0));
        let [second, third] = [1, 2].map(|configuration| case(configuration).over(|flown| flown.along_m[1]));
        requirements.push(at_least(
            format!("{name}: rms along the track in the turn, 2 against 3"),
            second / third,
            2.0,
        ));
        for configuration in 0..CONFIGURATIONS.len() {
            let straight = self.case(intruder, configuration, TrackerModels::Straight);
            let against = |leg: usize| case(configuration).position_m(leg) / straight.position_m(leg);
            let what =
                |leg: &str| format!("{name}, {}, {leg}: seven models / straight flight", configuration + 1);
            requirements.push(at_most(what(LEGS[1]), against(1), 1.0));
            requirements.push(at_most(what(LEGS[0]), against(0), 1.3));
            let known: Vec<f64> = case(configuration).flown.iter().map(|flown| flown.known_s).collect();
            let what = format!("{name}, {}: side of the turn known (s)", configuration + 1);
            requirements.push(at_most(what, quantile(&known, 0.5), KNOWN_S));
        }
    }

    /// Rms error over time with all models, for each configuration.
    pub fn over_time(&self, intruder: usize, configuration: usize) -> Vec<(f64, f64)> {
        let flown = &self.case(intruder, configuration, TrackerModels::Seven).flown;
        let moments = flown.iter().map(|flown| flown.over_time.len()).min().unwrap_or(0);
        (0..moments)
            .map(|moment| {
                let errors: Vec<f64> = flown.iter().map(|flown| flown.over_time[moment].1).collect();
                (flown[0].over_time[moment].0, rms(&errors))
            })
            .collect()
    }
}

fn at_most(what: String, value: f64, most: f64) -> ExperimentRequirement {
    ExperimentRequirement::within(what, value, f64::NEG_INFINITY..=most)
}

fn at_least(what: String, value: f64, least: f64) -> ExperimentRequirement {
    ExperimentRequirement::within(what, value, least..=f64::INFINITY)
}
