//! The flights flown, fused under both profiles, and scored.

use std::collections::BTreeSet;
use std::path::Path;

use fusion::time::Time;
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Capture, Merged, ReadError, Reception};
use utm_fusion::config::{Config, Profile};
use utm_fusion::evaluate::{
    Drone, Evaluation, InputsAlone, Label, Labels, Place, Score, Scored, Scoring, TrueTrack, Truth, evaluate,
    output, read,
};
use utm_fusion::simulate::{TRANSPONDER_ID, simulate};

use crate::degrade::degraded;
use crate::flights::{Failure, Flight, Row, Source};
use crate::parallel;

/// The scores of one flight.
pub struct Scores {
    pub row: Row,
    pub seed: u64,
    pub reference: Groups,
    pub operational: Groups,
    pub radar: Groups,
    pub transponder: Groups,
}

/// The scores of one stream.
pub struct Groups {
    pub all: Score,
    pub equipped: Score,
    pub unequipped: Score,
    /// Of each drone that carries a transponder.
    pub each_equipped: Vec<Score>,
    /// Of each that carries none.
    pub each_unequipped: Vec<Score>,
}

impl Groups {
    fn new(scored: Scored, drones: &[Drone]) -> Self {
        let Scored { all, equipped, unequipped, drones: each, .. } = scored;
        let (with, without): (Vec<_>, Vec<_>) =
            each.into_iter().zip(drones).partition(|(_, drone)| drone.equipped == Some(true));
        let scores = |of: Vec<(Score, &Drone)>| of.into_iter().map(|(score, _)| score).collect();
        Self { all, equipped, unequipped, each_equipped: scores(with), each_unequipped: scores(without) }
    }
}

/// Scores the flights, `threads` at a time; in the order of the flights, whichever ends first.
pub fn score(flights: &[Flight], threads: usize) -> Result<Vec<Scores>, Failure> {
    let scored = parallel::each(flights, threads, |place, flight| {
        eprintln!("{} of {}: {}", place + 1, flights.len(), flight.name());
        of_flight(flight)
    });
    scored.into_iter().collect()
}

fn of_flight(flight: &Flight) -> Result<Scores, Failure> {
    match &flight.source {
        Source::Simulated { scenario, seed, scored_from_s } => {
            let simulation = simulate(scenario, *seed, None)?;
            let from = Time::from_nanos(scenario.start_time().nanos() + (scored_from_s * 1e9) as i64);
            let truth = changed(&simulation.truth(), |(time, place)| (time >= from).then_some((time, place)));
            let labels = Labels::with_receivers(simulation.labels.clone(), &receivers(TRANSPONDER_ID));
            let known = Known { flight, truth: &truth, labels: &labels, config: &simulation.config };
            known.scores(|| simulation.receptions().map(Ok))
        }
        Source::Recorded { directory, version, degraded_by } => {
            recorded(flight, directory, version, *degraded_by)
        }
    }
}

/// The truth with each sample as `change` has it.
fn changed(truth: &Truth, change: impl Fn((Time, Place)) -> Option<(Time, Place)>) -> Truth {
    let samples = |track: &TrueTrack| track.samples().iter().copied().filter_map(&change).collect();
    Truth::new(truth.tracks().iter().map(|track| (track.id().to_owned(), samples(track))))
}

fn receivers(id: &str) -> BTreeSet<String> {
    [id.to_owned()].into()
}

/// A real flight, its transponder as it is or made worse.
fn recorded(
    flight: &Flight,
    directory: &Path,
    version: &str,
    degraded_by: Option<u64>,
) -> Result<Scores, Failure> {
    let octets = |name: &str| std::fs::read(directory.join(name));
    let config = Config::load(directory.join(version).join("site.toml"))?;
    let truth = Truth::new(read::truth("truth.csv", "truth", &octets("truth.csv")?)?);
    // Its heights are above take-off: without them, all errors are horizontal.
    let truth = changed(&truth, |(time, place)| Some((time, Place { altitude_amsl_m: None, ..place })));
    let rows: Vec<Label> = read::labels("labels.csv", &octets("labels.csv")?)?;
    let labels = Labels::with_receivers(rows, &receivers("drone-it"));
    let capture = Capture::open(&directory.join(version).join("capture.pcap"))?;
    let mut receptions =
        Merged::new(vec![capture], jiff::civil::Date::default()).collect::<Result<Vec<_>, _>>()?;
    if let Some(seed) = degraded_by {
        receptions = degraded(receptions, seed);
    }
    let known = Known { flight, truth: &truth, labels: &labels, config: &config };
    known.scores(|| receptions.iter().cloned().map(Ok))
}

/// What is known of a flight besides what was received.
struct Known<'a> {
    flight: &'a Flight,
    truth: &'a Truth,
    labels: &'a Labels,
    config: &'a Config,
}

impl Known<'_> {
    fn scores<I: Iterator<Item = Result<Reception, ReadError>>>(
        &self,
        receptions: impl Fn() -> I,
    ) -> Result<Scores, Failure> {
        let mut config = self.config.clone();
        (self.flight.configure)(&mut config);
        let alone = InputsAlone::of(receptions(), &config, Masks::default())?;
        let under = |profile| -> Result<Evaluation, Failure> {
            let mut config = config.clone();
            config.fusion.profile = profile;
            let points = output(receptions(), &config, Masks::default())?;
            Ok(evaluate(self.truth, Some(self.labels), &points, Some(&alone), &Scoring::of(&config)))
        };
        let reference = under(Profile::Reference)?;
        let operational = under(Profile::Operational)?;
        let drones = operational.drones;
        let groups = |scored| Groups::new(scored, &drones);
        let (Some(radar), Some(transponder)) = (operational.radar, operational.transponder) else {
            return Err("a flight without inputs".into());
        };
        Ok(Scores {
            row: self.flight.row.clone(),
            seed: self.flight.seed(),
            reference: groups(reference.fused),
            operational: groups(operational.fused),
            radar: groups(radar),
            transponder: groups(transponder),
        })
    }
}
