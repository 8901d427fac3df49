//! Real flights: as recorded, and one with attacks added.

use std::path::Path;

use fusion::time::Time;
use jiff::SignedDuration;
use utm_fusion::areas::Areas;
use utm_fusion::capture::{Capture, MergedCaptures, Reception};
use utm_fusion::config::Config;
use utm_fusion::evaluate::{
    self, Attack, AttackDetection, AttackKind, GeodeticPlace, Label, Labels, OutputPoint, Scoring, TrueTrack,
    Truth, integrity, read,
};

use super::attacked::{AttackedReceptions, attacked};
use super::flights::FlightKind;
use super::flown::{FlightOutcome, Replayed, configured};
use super::rows::row;
use super::shares::share;
use crate::flights::{EvaluationFailure, RECORDINGS};
use crate::parallel;
use crate::results::ResultRow;
use crate::summary::MeanValue;

/// The flight that attacks are added to: a flight of one drone, which the radar detects most often. `ATTACKS` are the
/// attacks; `BEGINS` are their beginnings as shares of the duration.
const ATTACKED: &str = "1_4";
const ATTACKS: [AttackKind; 5] =
    [AttackKind::Drift, AttackKind::Jump, AttackKind::Frozen, AttackKind::Replay, AttackKind::Duplicate];
const BEGINS: [f64; 3] = [0.25, 0.4, 0.55];
/// Receiver, serial number of its transponder, and number and id of the drone.
const RECEIVER: &str = "drone-it";
const SERIAL: &[u8] = b"000000000001";
const NUMBER: u32 = 1;
const ID: &str = "1";

/// A flight with an optional attack.
struct RealFlight {
    name: &'static str,
    attack: Option<(AttackKind, usize)>,
}

/// Flies all flights in this folder.
pub fn all(recordings: &Path, threads: usize) -> Result<Vec<FlightOutcome>, EvaluationFailure> {
    let trial = recordings.join("drone-trial");
    let mut flights: Vec<RealFlight> =
        RECORDINGS.into_iter().map(|name| RealFlight { name, attack: None }).collect();
    for kind in ATTACKS {
        flights.extend(
            (0..BEGINS.len()).map(|begin| RealFlight { name: ATTACKED, attack: Some((kind, begin)) }),
        );
    }
    flights.retain(|_| trial.is_dir());
    parallel::each(&flights, threads, |_, flight| flight.flown(&trial)).into_iter().collect()
}

impl RealFlight {
    fn flown(&self, trial: &Path) -> Result<FlightOutcome, EvaluationFailure> {
        let directory = trial.join(self.name);
        let octets = |name: &str| std::fs::read(directory.join(name));
        let mut config = configured(&Config::load(directory.join("site.toml"))?);
        config.areas.clear();
        let truth = Truth::new(read::truth("truth.csv", "truth", &octets("truth.csv")?)?);
        // The heights are above take-off, so they are not scored.
        let flat = |track: &TrueTrack| {
            let samples = track.samples().iter();
            let samples =
                samples.map(|&(time, place)| (time, GeodeticPlace { altitude_amsl_m: None, ..place }));
            (track.id().to_owned(), samples.collect())
        };
        let truth = Truth::new(truth.tracks().iter().map(flat));
        let mut labels = read::labels("labels.csv", &octets("labels.csv")?)?;
        let capture = Capture::open(&directory.join("capture.pcap"))?;
        let mut receptions = MergedCaptures::new(vec![capture], jiff::civil::Date::default())
            .collect::<Result<Vec<Reception>, _>>()?;
        let mut attacks = Vec::new();
        if let (Some((kind, begin)), Some((first, last))) = (self.attack, truth.span()) {
            let from = first + duration(BEGINS[begin] * last.seconds_since(first));
            let changed = attacked(receptions, SERIAL, kind, from);
            receptions = relabelled(changed, &mut labels, kind, from);
            attacks.push(Attack { id: ID.to_owned(), number: NUMBER, kind, from, until: last });
        }
        let replayed = Replayed::of(receptions.into_iter(), &config, &Areas::default());
        let reports: Vec<OutputPoint> = replayed.reports;
        let integrity = integrity(&evaluate::IntegrityFlight {
            truth: &truth,
            labels: &Labels::with_receivers(labels, &[RECEIVER.to_owned()].into()),
            reports: &reports,
            attacks: &attacks,
            output: &replayed.points,
            alerts: Some(&replayed.alerts),
            settings: &Scoring::of(&config),
        });
        let what = if self.attack.is_some() {
            FlightKind::RealAttack(self.name)
        } else {
            FlightKind::RealClean(self.name)
        };
        Ok(FlightOutcome { what, seed: self.attack.map_or(0, |(_, begin)| begin as u64), integrity })
    }
}

/// Adds labels of reports that an attacker sends, and removes those of reports that are dropped.
fn relabelled(
    changed: AttackedReceptions,
    labels: &mut Vec<Label>,
    kind: AttackKind,
    from: Time,
) -> Vec<Reception> {
    if kind == AttackKind::Replay {
        labels.retain(|label| label.sensor != RECEIVER || label.number != NUMBER || label.time < from);
    }
    labels.extend(changed.foreign.into_iter().map(|time| Label {
        time,
        sensor: RECEIVER.to_owned(),
        number: NUMBER,
        id: None,
        seduced: false,
        identity: None,
    }));
    changed.receptions
}

fn duration(seconds: f64) -> SignedDuration {
    SignedDuration::from_nanos((seconds * 1e9) as i64)
}

/// Rows of the table.
pub fn rows(flown: &[FlightOutcome]) -> Vec<ResultRow> {
    let clean: Vec<&FlightOutcome> =
        flown.iter().filter(|outcome| matches!(outcome.what, FlightKind::RealClean(_))).collect();
    let flags: usize = clean.iter().map(|outcome| outcome.integrity.clean.flags.len()).sum();
    let flags = MeanValue { mean: flags as f64, error: None, count: clean.len() };
    let attacks = || flown.iter().flat_map(|outcome| &outcome.integrity.attacks);
    let found = |kind: AttackKind| {
        let counts = move |attack: &&AttackDetection| {
            attack.kind == kind && attack.begin.is_some() && !(attack.is_silent && kind.reason().is_some())
        };
        let in_time = |attack: &AttackDetection| {
            attack.named_delay_s().is_some_and(|s| kind.reason().is_none() || s <= 30.0)
        };
        share(attacks().filter(counts).map(in_time))
    };
    let mut rows = vec![row(
        "real flights as recorded: flags (n: flights)",
        Some(flags).filter(|flags| flags.count > 0),
    )];
    rows.extend(ATTACKS.map(|kind| {
        let limit = if kind.reason().is_some() { "named within 30 s" } else { "flagged before it ends" };
        let figure = format!("{} put into real flight {ATTACKED}: {limit}, percent", kind.name());
        row(figure, found(kind))
    }));
    rows
}
