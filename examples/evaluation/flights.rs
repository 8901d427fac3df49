//! What is flown.

use std::error::Error;
use std::path::{Path, PathBuf};

use utm_fusion::simulate::Scenario;

pub type Failure = Box<dyn Error + Send + Sync>;

/// Scenarios of the experiment, in the order of its tables; `city` is last, with its own number of seeds.
pub const SCENARIOS: [&str; 8] = ["single", "crossing", "dense", "bias", "spoof", "gaps", "flock", CITY];
/// The largest.
pub const CITY: &str = "city";
/// The real flights.
pub const RECORDINGS: [&str; 3] = ["1_1", "1_4", "2_1"];
/// Seeds of a real flight whose transponder is made worse.
const DEGRADED_SEEDS: u64 = 20;

/// A flight to be scored, and the row of the tables that it belongs to.
pub struct Flight {
    pub row: Row,
    pub source: Source,
}

/// What the tables have rows for.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Row {
    Scenario(&'static str),
    Clean(&'static str),
    Degraded(&'static str),
    Prepared(&'static str),
}

/// Where it comes from.
pub enum Source {
    Simulated {
        scenario: Box<Scenario>,
        seed: u64,
    },
    /// A real flight; its capture and site may be a worse version of it in a folder beside.
    Recorded {
        directory: PathBuf,
        version: &'static str,
        degraded_by: Option<u64>,
    },
}

/// So many flights of a scenario.
pub fn simulated(name: &'static str, seeds: u64) -> Result<Vec<Flight>, Failure> {
    let scenario = scenario(name)?;
    let flight = |seed| Flight {
        row: Row::Scenario(name),
        source: Source::Simulated { scenario: Box::new(scenario.clone()), seed },
    };
    Ok((1..=seeds).map(flight).collect())
}

/// The scenario as it is shipped.
pub fn scenario(name: &str) -> Result<Scenario, Failure> {
    Ok(Scenario::load(&Path::new("config/scenarios").join(format!("{name}.toml")))?)
}

/// The real flights that are in this folder: clean, made worse, and as they were prepared.
pub fn recorded(recordings: &Path) -> Vec<Flight> {
    let trial = recordings.join("drone-trial");
    let mut flights = Vec::new();
    for name in RECORDINGS.into_iter().filter(|_| trial.is_dir()) {
        let recorded =
            |version, degraded_by| Source::Recorded { directory: trial.join(name), version, degraded_by };
        flights.push(Flight { row: Row::Clean(name), source: recorded("", None) });
        flights.push(Flight { row: Row::Prepared(name), source: recorded("degraded", None) });
        flights.extend(
            (1..=DEGRADED_SEEDS)
                .map(|seed| Flight { row: Row::Degraded(name), source: recorded("", Some(seed)) }),
        );
    }
    flights
}

impl Flight {
    pub fn name(&self) -> String {
        match &self.source {
            Source::Simulated { scenario, seed } => format!("{} seed {seed}", scenario.name),
            Source::Recorded { directory, version, degraded_by } => {
                let seed = degraded_by.map_or(String::new(), |seed| format!(" degraded, seed {seed}"));
                format!("{}{seed}", directory.join(version).display())
            }
        }
    }
}
