//! Flights replayed in this process, and their flags scored.

use fusion::Emission;
use fusion::integrity::Concern;
use fusion::report::Report;
use utm_fusion::areas::{Areas, Masks};
use utm_fusion::capture::Reception;
use utm_fusion::config::{Config, Profile};
use utm_fusion::evaluate::{
    self, Alert, Attack, AttackKind, Integrity, Labels, OutputPoint, Scoring, integrity, reports,
};
use utm_fusion::integrity::Lookout;
use utm_fusion::picture::{Picture, PictureMaker};
use utm_fusion::pipeline::{Event, Output, Pipeline};
use utm_fusion::simulate::{Attacked, Simulation, TRANSPONDER_ID, simulate};

use super::coverage;
use super::flights::{Flight, What};
use crate::flights::Failure;
use crate::parallel;

/// How well the flags of a flight were set.
pub struct Outcome {
    pub what: What,
    pub seed: u64,
    pub integrity: Integrity,
}

/// Flies these, `threads` at a time.
pub fn all(flights: &[Flight], threads: usize) -> Result<Vec<Outcome>, Failure> {
    parallel::each(flights, threads, |_, flight| of(flight)).into_iter().collect()
}

fn of(flight: &Flight) -> Result<Outcome, Failure> {
    let Flight { what, scenario, seed } = flight;
    let simulation = simulate(scenario, *seed, None)?;
    let mut config = configured(&simulation.config);
    let areas = coverage::add(&mut config, scenario)?;
    let Replayed { points, reports, alerts, .. } = Replayed::of(simulation.receptions(), &config, &areas);
    let integrity = integrity(&evaluate::Flight {
        truth: &simulation.truth(),
        labels: &labels(&simulation),
        reports: &reports,
        attacks: &attacks(&simulation),
        output: &points,
        alerts: Some(&alerts),
        settings: &Scoring::of(&config),
    });
    Ok(Outcome { what: *what, seed: *seed, integrity })
}

/// The `operational` profile, on one core: several flights are flown at a time.
pub fn configured(site: &Config) -> Config {
    let mut config = site.clone();
    config.fusion.profile = Profile::Operational;
    config.fusion.threads = 1;
    config
}

pub fn labels(simulation: &Simulation) -> Labels {
    Labels::with_receivers(simulation.labels.clone(), &[TRANSPONDER_ID.to_owned()].into())
}

pub fn attacks(simulation: &Simulation) -> Vec<Attack> {
    let attack = |attacked: &Attacked| {
        let Attacked { id, number, attack, from, until } = attacked;
        let kind = attack.map_or(Some(AttackKind::Jammed), |attack| AttackKind::of_name(attack.name()))?;
        Some(Attack { id: id.clone(), number: *number, kind, from: *from, until: *until })
    };
    simulation.attacks.iter().filter_map(attack).collect()
}

/// What a replay gives.
pub struct Replayed {
    /// The output.
    pub points: Vec<OutputPoint>,
    /// The transponder reports that it was made from.
    pub reports: Vec<OutputPoint>,
    /// The alerts of jamming.
    pub alerts: Vec<Alert>,
    /// The bearing of the first radar's registration at the end, degrees.
    pub bearing_deg: Option<f64>,
}

impl Replayed {
    pub fn of(receptions: impl Iterator<Item = Reception>, config: &Config, areas: &Areas) -> Self {
        let mut pipeline = Pipeline::new(config, Masks::default());
        let maker = PictureMaker::new(config, pipeline.normaliser());
        let (mut fixes, mut emissions) = (Vec::new(), Vec::<Emission>::new());
        for reception in receptions {
            pipeline.receive(&reception);
            while let Some(output) = pipeline.poll() {
                match output {
                    Output::Emission(emission) => emissions.push(emission),
                    Output::Event(Event::Accepted { report: Report::Fix(fix), .. }) => fixes.push(fix),
                    Output::Event(_) => {}
                }
            }
        }
        let registered = pipeline.engine().registered().next();
        let bearing_deg = registered.map(|(_, radar)| radar.estimate.bearing.value.to_degrees());
        pipeline.finish();
        emissions.extend(pipeline.emissions());
        let reports = reports(&fixes, &emissions, pipeline.normaliser());
        let mut lookout = Lookout::new(config, areas);
        let (mut points, mut alerts) = (Vec::new(), Vec::new());
        for emission in emissions {
            let mut picture = maker.picture(emission);
            lookout.look(&mut picture, &maker);
            note_jamming(&picture, &mut alerts);
            let tracks = picture.within(config.output.max_accuracy_m);
            points.extend(tracks.map(|track| OutputPoint::of_track(track, &maker)));
        }
        Self { points, reports, alerts, bearing_deg }
    }
}

/// The alert of jamming, as it is raised and as it ends.
fn note_jamming(picture: &Picture, alerts: &mut Vec<Alert>) {
    let is_jammed = picture.concerns.iter().any(|concern| matches!(concern, Concern::Jamming { .. }));
    let lasting = alerts.len().checked_sub(1).filter(|&last| alerts[last].until.is_none());
    match (lasting, is_jammed) {
        (None, true) => alerts.push(Alert {
            id: format!("jamming-{}", alerts.len()),
            kind: "jamming".to_owned(),
            since: picture.time,
            until: None,
        }),
        (Some(last), false) => alerts[last].until = Some(picture.time),
        _ => {}
    }
}
