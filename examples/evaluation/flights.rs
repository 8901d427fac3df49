//! What is flown.

use std::error::Error;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use utm_fusion::config::Config;
use utm_fusion::simulate::Scenario;

pub type Failure = Box<dyn Error + Send + Sync>;

/// Scenarios of the experiment, in the order of its tables; `city` is last, with its own number of seeds.
pub const SCENARIOS: [&str; 8] = ["single", "crossing", "dense", "bias", "spoof", "gaps", "flock", CITY];
/// The largest.
pub const CITY: &str = "city";
/// The real flights.
pub const RECORDINGS: [&str; 3] = ["1_1", "1_4", "2_1"];

/// A flight to be scored, and the row of the tables that it belongs to.
pub struct Flight {
    pub row: Row,
    pub source: Source,
    /// What the service is configured otherwise than the site is.
    pub configure: fn(&mut Config),
}

/// What the tables have rows for.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Row {
    Scenario(&'static str),
    /// A scenario that was changed; see [`crate::variants`].
    Variant(&'static str),
    /// A scenario with errors of the radar that are so many percent of those its data sheet stands for; see
    /// [`crate::sheet`].
    Sheet(&'static str, u32),
    /// A long flight of a scenario, of which only the end is scored.
    Settled(&'static str),
    Clean(&'static str),
    Degraded(&'static str),
    Prepared(&'static str),
}

impl Row {
    /// Of its scenario, its variant, or its real flight.
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

/// Where it comes from.
pub enum Source {
    Simulated {
        scenario: Box<Scenario>,
        seed: u64,
        /// Only this end of it is scored, seconds after its start.
        scored_from_s: f64,
    },
    /// A real flight; its capture and site may be a worse version of it in a folder beside.
    Recorded { directory: PathBuf, version: &'static str, degraded_by: Option<u64> },
}

/// The flights of a scenario with these seeds.
pub fn simulated(name: &'static str, seeds: RangeInclusive<u64>) -> Result<Vec<Flight>, Failure> {
    Ok(of_scenario(&Row::Scenario(name), &scenario(name)?, seeds, 0.0))
}

/// Flights of `bias` of 35 minutes, of which the last 15 are scored: two transponders have been heard for 20 before.
pub fn settled(seeds: RangeInclusive<u64>) -> Result<Vec<Flight>, Failure> {
    let mut scenario = scenario("bias")?;
    scenario.duration_s = 2100.0;
    Ok(of_scenario(&Row::Settled("bias"), &scenario, seeds, 1200.0))
}

/// The flights of a row with these seeds.
pub fn of_scenario(
    row: &Row,
    scenario: &Scenario,
    seeds: RangeInclusive<u64>,
    scored_from_s: f64,
) -> Vec<Flight> {
    let flight = |seed| Flight {
        row: row.clone(),
        source: Source::Simulated { scenario: Box::new(scenario.clone()), seed, scored_from_s },
        configure: |_| {},
    };
    seeds.map(flight).collect()
}

/// The scenario as it is shipped.
pub fn scenario(name: &str) -> Result<Scenario, Failure> {
    Ok(Scenario::load(&Path::new("config/scenarios").join(format!("{name}.toml")))?)
}

/// The real flights that are in this folder: clean, made worse with these seeds, and as they were prepared.
pub fn recorded(recordings: &Path, seeds: RangeInclusive<u64>) -> Vec<Flight> {
    let trial = recordings.join("drone-trial");
    let mut flights = Vec::new();
    for name in RECORDINGS.into_iter().filter(|_| trial.is_dir()) {
        let recorded = |row, version, degraded_by| Flight {
            row,
            source: Source::Recorded { directory: trial.join(name), version, degraded_by },
            configure: |_| {},
        };
        flights.push(recorded(Row::Clean(name), "", None));
        flights.push(recorded(Row::Prepared(name), "degraded", None));
        flights.extend(seeds.clone().map(|seed| recorded(Row::Degraded(name), "", Some(seed))));
    }
    flights
}

impl Flight {
    /// What its chance begins with; 0 where there is none.
    pub fn seed(&self) -> u64 {
        match self.source {
            Source::Simulated { seed, .. } => seed,
            Source::Recorded { degraded_by, .. } => degraded_by.unwrap_or(0),
        }
    }

    pub fn name(&self) -> String {
        match &self.source {
            Source::Simulated { scenario, seed, .. } => format!("{} seed {seed}", scenario.name),
            Source::Recorded { directory, version, degraded_by } => {
                let seed = degraded_by.map_or(String::new(), |seed| format!(" degraded, seed {seed}"));
                format!("{}{seed}", directory.join(version).display())
            }
        }
    }
}
