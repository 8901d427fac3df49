//! All flights, and what is asked of them.

use crate::experiment::{Asked, mean, quantile, rms, runs, said};
use crate::scenario::{INTRUDERS, Intruder};
use crate::sensors::CONFIGURATIONS;
use crate::tracking::{Models, STEP_S, Sample, track};

/// The straight leg counts from here on, seconds after the first detection.
const SETTLED_S: f64 = 20.0;
/// A manoeuvre that is followed stays within this, metres.
const FOLLOWED_M: f64 = 1000.0;
/// A turn is known within this, seconds.
const KNOWN_S: f64 = 10.0;
/// The moments of the rms error over time, seconds apart.
const EVERY_S: f64 = 1.0;

/// The errors of one flight.
#[derive(Clone, Debug)]
struct Flown {
    /// On the straight leg, and in the turn: rms.
    position_m: [f64; 2],
    heading_deg: [f64; 2],
    /// In the turn along the way: mean, rms.
    along_m: [f64; 2],
    /// The largest.
    most_m: f64,
    /// From the begin of the turn until its side is likelier than not, seconds; infinite: never.
    known_s: f64,
    /// Errors at whole moments.
    over_time: Vec<(f64, f64)>,
}

impl Flown {
    fn of(intruder: &Intruder, samples: &[Sample]) -> Self {
        let turn = intruder.turn_s();
        let straight = |sample: &&Sample| (SETTLED_S..turn).contains(&sample.at);
        let turning = |sample: &&Sample| sample.at >= turn;
        let legs = |of: fn(&Sample) -> f64| {
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
struct Case {
    intruder: usize,
    configuration: usize,
    models: Models,
    flown: Vec<Flown>,
}

impl Case {
    fn over(&self, of: impl Fn(&Flown) -> f64) -> f64 {
        rms(&self.flown.iter().map(of).collect::<Vec<_>>())
    }

    fn position_m(&self, leg: usize) -> f64 {
        self.over(|flown| flown.position_m[leg])
    }

    /// In the turn along the way: mean over the flights, and its standard error, metres.
    fn along(&self) -> (f64, f64) {
        let all: Vec<f64> = self.flown.iter().map(|flown| flown.along_m[0]).collect();
        let middle = mean(&all);
        (middle, self.over(|flown| flown.along_m[0] - middle) / (all.len() as f64).sqrt())
    }

    fn heading_deg(&self, leg: usize) -> f64 {
        self.over(|flown| flown.heading_deg[leg])
    }
}

/// How far a track is ahead in the turn.
pub struct Lag {
    /// Mean over all flights, its standard error, and the rms error, metres.
    pub mean_m: f64,
    pub error_m: f64,
    pub rms_m: f64,
    /// When the side of the turn is known, median, seconds.
    pub known_s: f64,
    /// How far one falls behind that flies straight on until then, metres.
    pub expected_m: f64,
}

pub struct Summary {
    pub first_seed: u64,
    pub runs: u64,
    cases: Vec<Case>,
}

/// Intruder 1 does not do this; the page says why.
pub const BEHIND: &str = "2: mean error along the track in the turn (m)";
const LEGS: [&str; 2] = ["straight", "turn"];
const ALL: [Models; 4] = [Models::Seven, Models::Straight, Models::Crewed, Models::Three];

impl Summary {
    pub fn measure(first_seed: u64, count: u64) -> Self {
        let mut cases = Vec::new();
        for (intruder, flying) in INTRUDERS.iter().enumerate() {
            for (configuration, sensors) in CONFIGURATIONS.iter().enumerate() {
                let sets: &[Models] = if intruder == 0 { &ALL } else { &ALL[..2] };
                let flown = runs(first_seed, count, |seed| {
                    let readings = sensors.readings(flying, seed);
                    let of = |models: &Models| Flown::of(flying, &track(flying, &readings, *models));
                    sets.iter().map(of).collect::<Vec<_>>()
                });
                for (place, &models) in sets.iter().enumerate() {
                    let flown = flown.iter().map(|flown| flown[place].clone()).collect();
                    cases.push(Case { intruder, configuration, models, flown });
                }
            }
        }
        Self { first_seed, runs: count, cases }
    }

    fn case(&self, intruder: usize, configuration: usize, models: Models) -> &Case {
        let is_it = |case: &&Case| {
            (case.intruder, case.configuration, case.models) == (intruder, configuration, models)
        };
        self.cases.iter().find(is_it).expect("every case is measured")
    }

    /// What was measured with all models.
    pub fn table(&self) -> String {
        let mut table = "| intruder | configuration | position, straight (m) | position, turn (m) | heading, straight (°) | heading, turn (°) | along track in the turn: mean ± standard error, rms (m) | largest error, 99 % of the flights (m) | side of the turn known after, median (s) |\n|---|---|---|---|---|---|---|---|---|\n".to_owned();
        for (intruder, flying) in INTRUDERS.iter().enumerate() {
            for (configuration, sensors) in CONFIGURATIONS.iter().enumerate() {
                let case = self.case(intruder, configuration, Models::Seven);
                let all = |of: fn(&Flown) -> f64| case.flown.iter().map(of).collect::<Vec<_>>();
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

    /// Intruder 1 along the track in its turn, in configuration 2.
    pub fn lag(&self) -> Lag {
        let case = self.case(0, 1, Models::Seven);
        let (mean_m, error_m) = case.along();
        let known: Vec<f64> = case.flown.iter().map(|flown| flown.known_s).collect();
        let known_s = quantile(&known, 0.5);
        let Intruder { speed, turn, .. } = INTRUDERS[0];
        let rms_m = case.over(|flown| flown.along_m[1]);
        Lag { mean_m, error_m, rms_m, known_s, expected_m: speed * turn * turn * known_s.powi(3) / 3.0 }
    }

    /// Position errors by set of models.
    pub fn models_table(&self) -> String {
        let mut table = "| intruder | configuration | leg | seven models (m) | straight flight alone (m) | ± 2, ± 6 °/s (m) | ± 2 °/s (m) |\n|---|---|---|---|---|---|---|\n".to_owned();
        for (intruder, flying) in INTRUDERS.iter().enumerate() {
            for (configuration, sensors) in CONFIGURATIONS.iter().enumerate() {
                for (leg, name) in LEGS.into_iter().enumerate() {
                    let mut cells = ALL.map(|models| {
                        let case = self.cases.iter().find(|case| {
                            (case.intruder, case.configuration, case.models)
                                == (intruder, configuration, models)
                        });
                        case.map_or_else(|| "–".to_owned(), |case| said(case.position_m(leg)))
                    });
                    table.push_str(&format!("| {} | {} | {name}", flying.name, sensors.name));
                    cells.iter_mut().for_each(|cell| table.push_str(&format!(" | {cell}")));
                    table.push_str(" |\n");
                }
            }
        }
        table
    }

    pub fn asked(&self) -> Vec<Asked> {
        let mut asked = Vec::new();
        for intruder in 0..INTRUDERS.len() {
            self.asked_of(intruder, &mut asked);
        }
        for (configuration, sensors) in CONFIGURATIONS.iter().enumerate() {
            let whole = |models: Models| {
                let case = self.case(0, configuration, models);
                case.position_m(0).hypot(case.position_m(1))
            };
            for (models, name) in [(Models::Crewed, "± 2, ± 6 °/s"), (Models::Three, "± 2 °/s")] {
                let what = format!(
                    "intruder 1, {}: models of its class ({name}), rms position against seven models",
                    sensors.name
                );
                asked.push(at_most(what, whole(models) / whole(Models::Seven), 1.05));
            }
        }
        asked
    }

    fn asked_of(&self, intruder: usize, asked: &mut Vec<Asked>) {
        let name = INTRUDERS[intruder].name;
        let case = |configuration: usize| self.case(intruder, configuration, Models::Seven);
        let followed = case(0).flown.iter().filter(|flown| flown.most_m < FOLLOWED_M).count();
        let share = followed as f64 / self.runs as f64;
        asked.push(at_least(format!("{name}, 1: flights within 1 km throughout"), share, 0.99));
        let heading = [0, 1, 2].map(|configuration| case(configuration).heading_deg(0));
        asked.push(at_least(
            format!("{name}: heading on the straight, 1 against 3"),
            heading[0] / heading[2],
            2.0,
        ));
        asked.push(at_least(
            format!("{name}: heading on the straight, 1 against 2"),
            heading[0] / heading[1],
            2.0,
        ));
        for (leg, leg_name) in LEGS.into_iter().enumerate() {
            let position = [0, 1, 2].map(|configuration| case(configuration).position_m(leg));
            asked.push(at_most(
                format!("{name}, {leg_name}: position, 3 against the better of 1 and 2"),
                position[2] / position[0].min(position[1]),
                1.0,
            ));
        }
        let (along, error) = case(1).along();
        asked.push(at_most(format!("{name}, {BEHIND}"), along, 0.0));
        let what = format!("{name}, 2: the same less two standard errors (m)");
        asked.push(at_most(what, along - 2.0 * error, 0.0));
        let [second, third] = [1, 2].map(|configuration| case(configuration).over(|flown| flown.along_m[1]));
        asked.push(at_least(
            format!("{name}: rms along the track in the turn, 2 against 3"),
            second / third,
            2.0,
        ));
        for (configuration, sensors) in CONFIGURATIONS.iter().enumerate() {
            let straight = self.case(intruder, configuration, Models::Straight);
            let against = |leg: usize| case(configuration).position_m(leg) / straight.position_m(leg);
            let what = |leg: &str| {
                format!("{name}, {}, {leg}: seven models against straight flight alone", sensors.name)
            };
            asked.push(at_most(what(LEGS[1]), against(1), 1.0));
            asked.push(at_most(what(LEGS[0]), against(0), 1.3));
            let known: Vec<f64> = case(configuration).flown.iter().map(|flown| flown.known_s).collect();
            let what = format!("{name}, {}: side of the turn known after, median (s)", sensors.name);
            asked.push(at_most(what, quantile(&known, 0.5), KNOWN_S));
        }
    }

    /// The rms error over time with all models, of each configuration.
    pub fn over_time(&self, intruder: usize, configuration: usize) -> Vec<(f64, f64)> {
        let flown = &self.case(intruder, configuration, Models::Seven).flown;
        let moments = flown.iter().map(|flown| flown.over_time.len()).min().unwrap_or(0);
        (0..moments)
            .map(|moment| {
                let errors: Vec<f64> = flown.iter().map(|flown| flown.over_time[moment].1).collect();
                (flown[0].over_time[moment].0, rms(&errors))
            })
            .collect()
    }
}

fn at_most(what: String, value: f64, most: f64) -> Asked {
    Asked::within(what, value, f64::NEG_INFINITY..=most)
}

fn at_least(what: String, value: f64, least: f64) -> Asked {
    Asked::within(what, value, least..=f64::INFINITY)
}
