//! Flies the flights, fuses them with both profiles, and scores them.

use std::collections::BTreeSet;
use std::path::Path;

use fusion::time::Time;
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Capture, MergedCaptures, ReadError, Reception};
use utm_fusion::config::{Config, Profile};
use utm_fusion::evaluate::{
    Evaluation, GeodeticPlace, InputsAlone, Label, Labels, ScoredStream, Scoring, StreamMetrics, TrueDrone,
    TrueTrack, Truth, evaluate, output, read,
};
use utm_fusion::simulate::{TRANSPONDER_ID, simulate};

use crate::degrade::degraded;
use crate::flights::{EvaluationFailure, EvaluationFlight, FlightRow, FlightSource};
use crate::parallel;

/// Scores of one flight.
pub struct FlightScores {
    pub row: FlightRow,
    pub seed: u64,
    pub reference: GroupScores,
    pub operational: GroupScores,
    pub radar: GroupScores,
    pub transponder: GroupScores,
}

/// Scores of one stream.
pub struct GroupScores {
    pub all: StreamMetrics,
    pub equipped: StreamMetrics,
    pub unequipped: StreamMetrics,
    /// Score of each drone with a transponder.
    pub each_equipped: Vec<StreamMetrics>,
    /// Score of each drone without a transponder.
    pub each_unequipped: Vec<StreamMetrics>,
}

impl GroupScores {
    fn new(scored: ScoredStream, drones: &[TrueDrone]) -> Self {
        let ScoredStream { all, equipped, unequipped, drones: each, .. } = scored;
        let (with, without): (Vec<_>, Vec<_>) =
            each.into_iter().zip(drones).partition(|(_, drone)| drone.equipped == Some(true));
        let scores = |of: Vec<(StreamMetrics, &TrueDrone)>| of.into_iter().map(|(score, _)| score).collect();
        Self { all, equipped, unequipped, each_equipped: scores(with), each_unequipped: scores(without) }
    }
}

/// Scores the flights, `threads` at a time. Returns the scores in the order of the flights.
pub fn score(flights: &[EvaluationFlight], threads: usize) -> Result<Vec<FlightScores>, EvaluationFailure> {
    let scored = parallel::each(flights, threads, |place, flight| {
        eprintln!("{} of {}: {}", place + 1, flights.len(), flight.name());
        of_flight(flight)
    });
    scored.into_iter().collect()
}

fn of_flight(flight: &EvaluationFlight) -> Result<FlightScores, EvaluationFailure> {
    match &flight.source {
        FlightSource::Simulated { scenario, seed, scored_from_s } => {
            let simulation = simulate(scenario, *seed, None)?;
            let from = Time::from_nanos(scenario.start_time().nanos() + (scored_from_s * 1e9) as i64);
            let truth = changed(&simulation.truth(), |(time, place)| (time >= from).then_some((time, place)));
            let labels = Labels::with_receivers(simulation.labels.clone(), &receivers(TRANSPONDER_ID));
            let known = FlightTruth { flight, truth: &truth, labels: &labels, config: &simulation.config };
            known.scores(|| simulation.receptions().map(Ok))
        }
        FlightSource::Recorded { directory, version, degraded_by } => {
            recorded(flight, directory, version, *degraded_by)
        }
    }
}

/// Applies `change` to each sample of the truth.
fn changed(truth: &Truth, change: impl Fn((Time, GeodeticPlace)) -> Option<(Time, GeodeticPlace)>) -> Truth {
    let samples = |track: &TrueTrack| track.samples().iter().copied().filter_map(&change).collect();
    Truth::new(truth.tracks().iter().map(|track| (track.id().to_owned(), samples(track))))
}

fn receivers(id: &str) -> BTreeSet<String> {
    [id.to_owned()].into()
}

/// Scores a real flight, with its transponder as recorded or degraded.
fn recorded(
    flight: &EvaluationFlight,
    directory: &Path,
    version: &str,
    degraded_by: Option<u64>,
) -> Result<FlightScores, EvaluationFailure> {
    let octets = |name: &str| std::fs::read(directory.join(name));
    let config = Config::load(directory.join(version).join("site.toml"))?;
    let truth = Truth::new(read::truth("truth.csv", "truth", &octets("truth.csv")?)?);
    // The heights are above take-off; without them, all errors are horizontal.
    let truth =
        changed(&truth, |(time, place)| Some((time, GeodeticPlace { altitude_amsl_m: None, ..place })));
    let rows: Vec<Label> = read::labels("labels.csv", &octets("labels.csv")?)?;
    let labels = Labels::with_receivers(rows, &receivers("drone-it"));
    let capture = Capture::open(&directory.join(version).join("capture.pcap"))?;
    let mut receptions =
        MergedCaptures::new(vec![capture], jiff::civil::Date::default()).collect::<Result<Vec<_>, _>>()?;
    if let Some(seed) = degraded_by {
        receptions = degraded(receptions, seed);
    }
    let known = FlightTruth { flight, truth: &truth, labels: &labels, config: &config };
    known.scores(|| receptions.iter().cloned().map(Ok))
}

/// Truth and labels of a flight.
struct FlightTruth<'a> {
    flight: &'a EvaluationFlight,
    truth: &'a Truth,
    labels: &'a Labels,
    config: &'a Config,
}

impl FlightTruth<'_> {
    fn scores<I: Iterator<Item = Result<Reception, ReadError>>>(
        &self,
        receptions: impl Fn() -> I,
    ) -> Result<FlightScores, EvaluationFailure> {
        let mut config = self.config.clone();
        (self.flight.configure)(&mut config);
        let alone = InputsAlone::of(receptions(), &config, Masks::default())?;
        let under = |profile| -> Result<Evaluation, EvaluationFailure> {
            let mut config = config.clone();
            config.fusion.profile = profile;
            let points = output(receptions(), &config, Masks::default())?;
            Ok(evaluate(self.truth, Some(self.labels), &points, Some(&alone), &Scoring::of(&config)))
        };
        let reference = under(Profile::Reference)?;
        let operational = under(Profile::Operational)?;
        let drones = operational.drones;
        let groups = |scored| GroupScores::new(scored, &drones);
        let (Some(radar), Some(transponder)) = (operational.radar, operational.transponder) else {
            return Err("a flight without inputs".into());
        };
        Ok(FlightScores {
            row: self.flight.row.clone(),
            seed: self.flight.seed(),
            reference: groups(reference.fused),
            operational: groups(operational.fused),
            radar: groups(radar),
            transponder: groups(transponder),
        })
    }
}
