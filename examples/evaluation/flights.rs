//! The flights of the evaluation.

use std::error::Error;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use utm_fusion::config::Config;
use utm_fusion::simulate::Scenario;

pub type EvaluationFailure = Box<dyn Error + Send + Sync>;

/// Scenarios of the experiment, in the order of its tables; `city` is last, with its own number of seeds.
pub const SCENARIOS: [&str; 8] = ["single", "crossing", "dense", "bias", "spoof", "gaps", "flock", CITY];
/// The largest scenario.
pub const CITY: &str = "city";
/// The real flights.
pub const RECORDINGS: [&str; 3] = ["1_1", "1_4", "2_1"];

/// A flight to be scored, and its row in the tables.
pub struct EvaluationFlight {
    pub row: FlightRow,
    pub source: FlightSource,
    /// Change to the site's configuration.
    pub configure: fn(&mut Config),
}

/// Rows of the tables.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FlightRow {
    Scenario(&'static str),
    /// A modified scenario; see [`crate::variants`].
    Variant(&'static str),
    /// A scenario whose radar errors are this percentage of those in the data sheet; see [`crate::sheet`].
    Sheet(&'static str, u32),
    /// A long flight of a scenario, of which only the end is scored.
    Settled(&'static str),
    Clean(&'static str),
    Degraded(&'static str),
    Prepared(&'static str),
}

impl FlightRow {
    /// Name of the scenario, variant or real flight.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Scenario(name)
            | Self::Variant(name)
            | Self::Sheet(name, _)
            | Self::Settled(name)
            | Self::Clean(name)
            | Self::Degraded(name)
            | Self::Prepared(name) => name,
        }
    }
}

/// Source of a flight.
pub enum FlightSource {
    Simulated {
        scenario: Box<Scenario>,
        seed: u64,
        /// Only the flight after this time is scored, seconds after its start.
        scored_from_s: f64,
    },
    /// A real flight; a degraded version of its capture and site may be in a subfolder.
    Recorded { directory: PathBuf, version: &'static str, degraded_by: Option<u64> },
}

/// Flights of a scenario with these seeds.
pub fn simulated(
    name: &'static str,
    seeds: RangeInclusive<u64>,
) -> Result<Vec<EvaluationFlight>, EvaluationFailure> {
    Ok(of_scenario(&FlightRow::Scenario(name), &scenario(name)?, seeds, 0.0))
}

/// Flights of `bias` over 35 minutes, of which the last 15 are scored, after 20 minutes with two transponders.
pub fn settled(seeds: RangeInclusive<u64>) -> Result<Vec<EvaluationFlight>, EvaluationFailure> {
    let mut scenario = scenario("bias")?;
    scenario.duration_s = 2100.0;
    Ok(of_scenario(&FlightRow::Settled("bias"), &scenario, seeds, 1200.0))
}

/// Flights of a row with these seeds.
pub fn of_scenario(
    row: &FlightRow,
    scenario: &Scenario,
    seeds: RangeInclusive<u64>,
    scored_from_s: f64,
) -> Vec<EvaluationFlight> {
    let flight = |seed| EvaluationFlight {
        row: row.clone(),
        source: FlightSource::Simulated { scenario: Box::new(scenario.clone()), seed, scored_from_s },
        configure: |_| {},
    };
    seeds.map(flight).collect()
}

/// Loads a shipped scenario.
pub fn scenario(name: &str) -> Result<Scenario, EvaluationFailure> {
    Ok(Scenario::load(&Path::new("config/scenarios").join(format!("{name}.toml")))?)
}

/// The real flights in this folder: clean, degraded with these seeds, and as prepared.
pub fn recorded(recordings: &Path, seeds: RangeInclusive<u64>) -> Vec<EvaluationFlight> {
    let trial = recordings.join("drone-trial");
    let mut flights = Vec::new();
    for name in RECORDINGS.into_iter().filter(|_| trial.is_dir()) {
        let recorded = |row, version, degraded_by| EvaluationFlight {
            row,
            source: FlightSource::Recorded { directory: trial.join(name), version, degraded_by },
            configure: |_| {},
        };
        flights.push(recorded(FlightRow::Clean(name), "", None));
        flights.push(recorded(FlightRow::Prepared(name), "degraded", None));
        flights.extend(seeds.clone().map(|seed| recorded(FlightRow::Degraded(name), "", Some(seed))));
    }
    flights
}

impl EvaluationFlight {
    /// Seed of the flight; 0 if there is none.
    pub fn seed(&self) -> u64 {
        match self.source {
            FlightSource::Simulated { seed, .. } => seed,
            FlightSource::Recorded { degraded_by, .. } => degraded_by.unwrap_or(0),
        }
    }

    pub fn name(&self) -> String {
        match &self.source {
            FlightSource::Simulated { scenario, seed, .. } => format!("{} seed {seed}", scenario.name),
            FlightSource::Recorded { directory, version, degraded_by } => {
                let seed = degraded_by.map_or(String::new(), |seed| format!(" degraded, seed {seed}"));
                format!("{}{seed}", directory.join(version).display())
            }
        }
    }
}
