//! The flights, and their scores.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use utm_fusion::areas::Masks;
use utm_fusion::config::Config;
use utm_fusion::evaluate::{
    Alone, Evaluation, Label, Labels, Score, Scored, Settings, Truth, evaluate, output, read,
};
use utm_fusion::ingest::{Capture, Merged, ReadError, Reception};
use utm_fusion::simulate::{Scenario, TRANSPONDER_ID, simulate};

use crate::degrade::degraded;

type Failure = Box<dyn Error + Send + Sync>;

/// Scenarios of the experiment, in the order of its tables; `city` follows with its own number of seeds.
pub const SCENARIOS: [&str; 7] = ["single", "crossing", "dense", "bias", "spoof", "gaps", "flock"];
/// The real flights.
pub const RECORDINGS: [&str; 3] = ["1_1", "1_4", "2_1"];
/// Seeds of a real flight whose transponder is made worse.
const DEGRADED_SEEDS: u64 = 20;

/// A flight to be scored, and the row of the tables that it belongs to.
pub struct Flight {
    pub row: Row,
    source: Source,
}

/// What the tables have rows for.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Row {
    Scenario(&'static str),
    Clean(&'static str),
    Degraded(&'static str),
    Prepared(&'static str),
}

enum Source {
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

/// The scores of one flight.
pub struct Scores {
    pub row: Row,
    pub fused: Groups,
    pub radar: Groups,
    pub transponder: Groups,
}

/// The scores of one stream.
pub struct Groups {
    pub all: Score,
    pub equipped: Score,
    pub unequipped: Score,
}

impl From<&Scored> for Groups {
    fn from(scored: &Scored) -> Self {
        let Scored { all, equipped, unequipped, .. } = scored;
        Self { all: all.clone(), equipped: equipped.clone(), unequipped: unequipped.clone() }
    }
}

/// Every flight of the experiment; the largest first, so that two of them do not end it alone.
pub fn all(seeds: u64, city_seeds: u64, recordings: Option<&Path>) -> Result<Vec<Flight>, Failure> {
    let mut flights = Vec::new();
    let scenarios = [("city", city_seeds)].into_iter().chain(SCENARIOS.map(|name| (name, seeds)));
    for (name, seeds) in scenarios {
        let scenario = Scenario::load(&Path::new("config/scenarios").join(format!("{name}.toml")))?;
        flights.extend((1..=seeds).map(|seed| Flight {
            row: Row::Scenario(name),
            source: Source::Simulated { scenario: Box::new(scenario.clone()), seed },
        }));
    }
    let trial = recordings.map(|folder| folder.join("drone-trial")).filter(|folder| folder.is_dir());
    for name in RECORDINGS.into_iter().filter(|_| trial.is_some()) {
        let directory = trial.clone().unwrap_or_default().join(name);
        let recorded =
            |version, degraded_by| Source::Recorded { directory: directory.clone(), version, degraded_by };
        flights.push(Flight { row: Row::Clean(name), source: recorded("", None) });
        flights.push(Flight { row: Row::Prepared(name), source: recorded("degraded", None) });
        flights.extend(
            (1..=DEGRADED_SEEDS)
                .map(|seed| Flight { row: Row::Degraded(name), source: recorded("", Some(seed)) }),
        );
    }
    Ok(flights)
}

/// Scores the flights, `threads` at a time; in the order of the flights, whichever ends first.
pub fn score(flights: &[Flight], threads: usize) -> Result<Vec<Scores>, Failure> {
    let next = AtomicUsize::new(0);
    let scored: Mutex<Vec<Option<Result<Scores, Failure>>>> =
        Mutex::new(flights.iter().map(|_| None).collect());
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                while let Some((place, flight)) = {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    flights.get(place).map(|flight| (place, flight))
                } {
                    eprintln!("{} of {}: {}", place + 1, flights.len(), flight.name());
                    let scores = flight.score();
                    scored.lock().expect("no other flight has panicked")[place] = Some(scores);
                }
            });
        }
    });
    let scored = scored.into_inner().expect("no flight has panicked");
    scored.into_iter().map(|scores| scores.expect("every flight was taken")).collect()
}

impl Flight {
    fn name(&self) -> String {
        match &self.source {
            Source::Simulated { scenario, seed } => format!("{} seed {seed}", scenario.name),
            Source::Recorded { directory, version, degraded_by } => {
                let seed = degraded_by.map_or(String::new(), |seed| format!(" degraded, seed {seed}"));
                format!("{}{seed}", directory.join(version).display())
            }
        }
    }

    fn score(&self) -> Result<Scores, Failure> {
        let evaluation = match &self.source {
            Source::Simulated { scenario, seed } => {
                let simulation = simulate(scenario, *seed, None)?;
                let labels = Labels::with_receivers(simulation.labels.clone(), &receivers(TRANSPONDER_ID));
                let receptions = || simulation.receptions().map(Ok);
                scores_of(&simulation.truth(), &labels, &simulation.config, receptions)?
            }
            Source::Recorded { directory, version, degraded_by } => {
                recorded(directory, version, *degraded_by)?
            }
        };
        let (Some(radar), Some(transponder)) = (&evaluation.radar, &evaluation.transponder) else {
            return Err("a flight without inputs".into());
        };
        Ok(Scores {
            row: self.row.clone(),
            fused: (&evaluation.fused).into(),
            radar: radar.into(),
            transponder: transponder.into(),
        })
    }
}

fn receivers(id: &str) -> std::collections::BTreeSet<String> {
    [id.to_owned()].into()
}

fn scores_of<I: Iterator<Item = Result<Reception, ReadError>>>(
    truth: &Truth,
    labels: &Labels,
    config: &Config,
    receptions: impl Fn() -> I,
) -> Result<Evaluation, Failure> {
    let points = output(receptions(), config, Masks::default())?;
    let alone = Alone::of(receptions(), config, Masks::default())?;
    Ok(evaluate(truth, Some(labels), &points, Some(&alone), &Settings::of(config)))
}

/// A real flight, its transponder as it is or made worse.
fn recorded(directory: &Path, version: &str, degraded_by: Option<u64>) -> Result<Evaluation, Failure> {
    let octets = |name: &str| std::fs::read(directory.join(name));
    let config = Config::load(directory.join(version).join("site.toml"))?;
    let truth = Truth::new(read::truth("truth.csv", "truth", &octets("truth.csv")?)?);
    let rows: Vec<Label> = read::labels("labels.csv", &octets("labels.csv")?)?;
    let labels = Labels::with_receivers(rows, &receivers("drone-it"));
    let capture = Capture::open(&directory.join(version).join("capture.pcap"))?;
    let mut receptions =
        Merged::new(vec![capture], jiff::civil::Date::default()).collect::<Result<Vec<_>, _>>()?;
    if let Some(seed) = degraded_by {
        receptions = degraded(receptions, seed);
    }
    scores_of(&truth, &labels, &config, || receptions.iter().cloned().map(Ok))
}
