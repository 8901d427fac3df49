//! Replays flights in this process, and scores their flags.

use fusion::Emission;
use fusion::integrity::Concern;
use fusion::report::Report;
use utm_fusion::areas::{Areas, Masks};
use utm_fusion::capture::Reception;
use utm_fusion::config::{Config, Profile};
use utm_fusion::evaluate::{
    self, AlertLine, Attack, AttackKind, IntegrityScore, Labels, OutputPoint, Scoring, integrity, reports,
};
use utm_fusion::picture::UncooperativeDetector;
use utm_fusion::picture::{Picture, PictureMaker};
use utm_fusion::pipeline::{Event, Output, Pipeline};
use utm_fusion::simulate::{SimulatedAttack, Simulation, TRANSPONDER_ID, simulate};

use super::coverage;
use super::flights::{AttackFlight, FlightKind};
use crate::flights::EvaluationFailure;
use crate::parallel;

/// Score of the flags of a flight.
pub struct FlightOutcome {
    pub what: FlightKind,
    pub seed: u64,
    pub integrity: IntegrityScore,
}

/// Flies these, `threads` at a time.
pub fn all(flights: &[AttackFlight], threads: usize) -> Result<Vec<FlightOutcome>, EvaluationFailure> {
    parallel::each(flights, threads, |_, flight| of(flight)).into_iter().collect()
}

fn of(flight: &AttackFlight) -> Result<FlightOutcome, EvaluationFailure> {
    let AttackFlight { what, scenario, seed } = flight;
    let simulation = simulate(scenario, *seed, None)?;
    let mut config = configured(&simulation.config);
    let areas = coverage::add(&mut config, scenario)?;
    let Replayed { points, reports, alerts, .. } = Replayed::of(simulation.receptions(), &config, &areas);
    let integrity = integrity(&evaluate::IntegrityFlight {
        truth: &simulation.truth(),
        labels: &labels(&simulation),
        reports: &reports,
        attacks: &attacks(&simulation),
        output: &points,
        alerts: Some(&alerts),
        settings: &Scoring::of(&config),
    });
    Ok(FlightOutcome { what: *what, seed: *seed, integrity })
}

/// Configures the `operational` profile on one core, because several flights are replayed at a time.
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
    let attack = |attacked: &SimulatedAttack| {
        let SimulatedAttack { id, number, attack, from, until } = attacked;
        let kind = attack.map_or(Some(AttackKind::Jammed), |attack| AttackKind::of_name(attack.name()))?;
        Some(Attack { id: id.clone(), number: *number, kind, from: *from, until: *until })
    };
    simulation.attacks.iter().filter_map(attack).collect()
}

/// Result of a replay.
pub struct Replayed {
    /// The output.
    pub points: Vec<OutputPoint>,
    /// The transponder reports in the input.
    pub reports: Vec<OutputPoint>,
    /// Alerts of kind `jamming`.
    pub alerts: Vec<AlertLine>,
    /// Azimuth registration of the first radar at the end, degrees.
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
        let mut detector = UncooperativeDetector::new(config, areas);
        let (mut points, mut alerts) = (Vec::new(), Vec::new());
        for emission in emissions {
            let mut picture = maker.picture(emission);
            detector.look(&mut picture, &maker);
            note_jamming(&picture, &mut alerts);
            let tracks = picture.within(config.output.max_accuracy_m);
            points.extend(tracks.map(|track| OutputPoint::of_track(track, &maker)));
        }
        Self { points, reports, alerts, bearing_deg }
    }
}

/// Notes the beginning and end of the alert `jamming`.
fn note_jamming(picture: &Picture, alerts: &mut Vec<AlertLine>) {
    let is_jammed = picture.concerns.iter().any(|concern| matches!(concern, Concern::Jamming { .. }));
    let lasting = alerts.len().checked_sub(1).filter(|&last| alerts[last].until.is_none());
    match (lasting, is_jammed) {
        (None, true) => alerts.push(AlertLine {
            id: format!("jamming-{}", alerts.len()),
            kind: "jamming".to_owned(),
            since: picture.time,
            until: None,
            is_critical: false,
            tracks: Vec::new(),
            identity: None,
            area: None,
            text: String::new(),
        }),
        (Some(last), false) => alerts[last].until = Some(picture.time),
        _ => {}
    }
}
