//! Flights replayed in this process, and their flags scored.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use fusion::report::Report;
use utm_fusion::areas::Masks;
use utm_fusion::config::{Config, Profile};
use utm_fusion::evaluate::{
    self, Attack, AttackKind, Integrity, Labels, OutputPoint, Scoring, integrity, reports,
};
use utm_fusion::picture::PictureMaker;
use utm_fusion::pipeline::{Event, Output, Pipeline};
use utm_fusion::simulate::{Attacked, Simulation, TRANSPONDER_ID, simulate};

use super::flights::Flight;
use crate::flights::Failure;

/// A flight, and how well its flags were set.
pub struct Outcome {
    pub flight: Flown,
    pub integrity: Integrity,
}

/// Which flight it was.
pub struct Flown {
    pub what: super::flights::What,
    pub seed: u64,
}

/// Flies these, `threads` at a time; in their order, whichever ends first.
pub fn all(flights: &[Flight], threads: usize) -> Result<Vec<Outcome>, Failure> {
    let next = AtomicUsize::new(0);
    let outcomes: Mutex<Vec<Option<Result<Outcome, Failure>>>> =
        Mutex::new(flights.iter().map(|_| None).collect());
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                while let Some((place, flight)) = {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    flights.get(place).map(|flight| (place, flight))
                } {
                    let outcome = of(flight);
                    outcomes.lock().expect("no other flight has panicked")[place] = Some(outcome);
                }
            });
        }
    });
    let outcomes = outcomes.into_inner().expect("no flight has panicked");
    outcomes.into_iter().map(|outcome| outcome.expect("every flight was taken")).collect()
}

fn of(flight: &Flight) -> Result<Outcome, Failure> {
    let simulation = simulate(&flight.scenario, flight.seed, None)?;
    let mut config = simulation.config.clone();
    config.fusion.profile = Profile::Operational;
    // Several flights are flown at a time.
    config.fusion.threads = 1;
    let (output, reports) = replayed(&simulation, &config);
    let attacks: Vec<Attack> = simulation.attacks.iter().filter_map(attack).collect();
    let integrity = integrity(&evaluate::Flight {
        truth: &simulation.truth(),
        labels: &Labels::with_receivers(simulation.labels.clone(), &[TRANSPONDER_ID.to_owned()].into()),
        reports: &reports,
        attacks: &attacks,
        output: &output,
        alerts: None,
        settings: &Scoring::of(&config),
    });
    Ok(Outcome { flight: Flown { what: flight.what, seed: flight.seed }, integrity })
}

fn attack(attacked: &Attacked) -> Option<Attack> {
    let Attacked { id, number, attack, from, until } = attacked;
    let kind = attack.map_or(Some(AttackKind::Jammed), |attack| AttackKind::of_name(attack.name()))?;
    Some(Attack { id: id.clone(), number: *number, kind, from: *from, until: *until })
}

/// The points of the output, and the reports that it was made from.
fn replayed(simulation: &Simulation, config: &Config) -> (Vec<OutputPoint>, Vec<OutputPoint>) {
    let mut pipeline = Pipeline::new(config, Masks::default());
    let maker = PictureMaker::new(config, pipeline.normaliser());
    let (mut fixes, mut emissions) = (Vec::new(), Vec::new());
    for reception in simulation.receptions() {
        pipeline.receive(&reception);
        while let Some(output) = pipeline.poll() {
            match output {
                Output::Emission(emission) => emissions.push(emission),
                Output::Event(Event::Accepted { report: Report::Fix(fix), .. }) => fixes.push(fix),
                Output::Event(_) => {}
            }
        }
    }
    pipeline.finish();
    emissions.extend(pipeline.emissions());
    let reports = reports(&fixes, &emissions, pipeline.normaliser());
    let mut points = Vec::new();
    for emission in emissions {
        let picture = maker.picture(emission);
        let tracks = picture.within(config.output.max_accuracy_m);
        points.extend(tracks.map(|track| OutputPoint::of_track(track, &maker)));
    }
    (points, reports)
}
