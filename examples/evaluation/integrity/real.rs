//! Real flights: as they were recorded, and one with attacks put into it.

use std::path::Path;

use fusion::time::Time;
use jiff::SignedDuration;
use utm_fusion::areas::Areas;
use utm_fusion::capture::{Capture, Merged, Reception};
use utm_fusion::config::Config;
use utm_fusion::evaluate::{
    self, Attack, AttackKind, Detection, Label, Labels, OutputPoint, Place, Scoring, TrueTrack, Truth,
    integrity, read,
};

use super::flights::What;
use super::flown::{Outcome, Replayed, configured};
use super::lies::{Lied, lied};
use super::rows::row;
use super::shares::share;
use crate::asked::Asked;
use crate::asked::Bound::{AtLeast, AtMost};
use crate::flights::{Failure, RECORDINGS};
use crate::parallel;
use crate::summary::Mean;

/// The flight that attacks are put into: that of one drone which the radar sees most. What is put into it, and when: shares
/// of its duration.
const ATTACKED: &str = "1_4";
const ATTACKS: [AttackKind; 5] =
    [AttackKind::Drift, AttackKind::Jump, AttackKind::Frozen, AttackKind::Replay, AttackKind::Duplicate];
const BEGINS: [f64; 3] = [0.25, 0.4, 0.55];
/// The receiver, its transponder's serial number, and the number and the id of its drone.
const RECEIVER: &str = "drone-it";
const SERIAL: &[u8] = b"000000000001";
const NUMBER: u32 = 1;
const ID: &str = "1";

/// A flight to be flown: which, and what is put into it.
struct Order {
    name: &'static str,
    attack: Option<(AttackKind, usize)>,
}

/// Flies all that are in this folder.
pub fn all(recordings: &Path, threads: usize) -> Result<Vec<Outcome>, Failure> {
    let trial = recordings.join("drone-trial");
    let mut orders: Vec<Order> = RECORDINGS.into_iter().map(|name| Order { name, attack: None }).collect();
    for kind in ATTACKS {
        orders.extend((0..BEGINS.len()).map(|begin| Order { name: ATTACKED, attack: Some((kind, begin)) }));
    }
    orders.retain(|_| trial.is_dir());
    parallel::each(&orders, threads, |_, order| order.flown(&trial)).into_iter().collect()
}

impl Order {
    fn flown(&self, trial: &Path) -> Result<Outcome, Failure> {
        let directory = trial.join(self.name);
        let octets = |name: &str| std::fs::read(directory.join(name));
        let mut config = configured(&Config::load(directory.join("site.toml"))?);
        config.areas.clear();
        let truth = Truth::new(read::truth("truth.csv", "truth", &octets("truth.csv")?)?);
        // Its heights are above take-off.
        let flat = |track: &TrueTrack| {
            let samples = track.samples().iter();
            let samples = samples.map(|&(time, place)| (time, Place { altitude_amsl_m: None, ..place }));
            (track.id().to_owned(), samples.collect())
        };
        let truth = Truth::new(truth.tracks().iter().map(flat));
        let mut labels = read::labels("labels.csv", &octets("labels.csv")?)?;
        let capture = Capture::open(&directory.join("capture.pcap"))?;
        let mut receptions = Merged::new(vec![capture], jiff::civil::Date::default())
            .collect::<Result<Vec<Reception>, _>>()?;
        let mut attacks = Vec::new();
        if let (Some((kind, begin)), Some((first, last))) = (self.attack, truth.span()) {
            let from = first + duration(BEGINS[begin] * last.seconds_since(first));
            let changed = lied(receptions, SERIAL, kind, from);
            receptions = relabelled(changed, &mut labels, kind, from);
            attacks.push(Attack { id: ID.to_owned(), number: NUMBER, kind, from, until: last });
        }
        let replayed = Replayed::of(receptions.into_iter(), &config, &Areas::default());
        let reports: Vec<OutputPoint> = replayed.reports;
        let integrity = integrity(&evaluate::Flight {
            truth: &truth,
            labels: &Labels::with_receivers(labels, &[RECEIVER.to_owned()].into()),
            reports: &reports,
            attacks: &attacks,
            output: &replayed.points,
            alerts: Some(&replayed.alerts),
            settings: &Scoring::of(&config),
        });
        let what =
            if self.attack.is_some() { What::RealAttack(self.name) } else { What::RealClean(self.name) };
        Ok(Outcome { what, seed: self.attack.map_or(0, |(_, begin)| begin as u64), integrity })
    }
}

/// Labels for what an attacker sends; those of what is no longer sent are gone.
fn relabelled(changed: Lied, labels: &mut Vec<Label>, kind: AttackKind, from: Time) -> Vec<Reception> {
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

/// The rows of the table.
pub fn asked(flown: &[Outcome]) -> Vec<Asked> {
    let clean: Vec<&Outcome> =
        flown.iter().filter(|outcome| matches!(outcome.what, What::RealClean(_))).collect();
    let flags: usize = clean.iter().map(|outcome| outcome.integrity.clean.flags.len()).sum();
    let flags = Mean { mean: flags as f64, error: None, count: clean.len() };
    let attacks = || flown.iter().flat_map(|outcome| &outcome.integrity.attacks);
    let found = |kind: AttackKind| {
        let counts = move |attack: &&Detection| {
            attack.kind == kind && attack.begin.is_some() && !(attack.is_silent && kind.reason().is_some())
        };
        let in_time =
            |attack: &Detection| attack.named_delay_s().is_some_and(|s| kind.reason().is_none() || s <= 30.0);
        share(attacks().filter(counts).map(in_time))
    };
    let mut rows = vec![
        row("real flights as recorded: flags (n: flights)", Some(flags).filter(|flags| flags.count > 0))
            .required(AtMost(0.0)),
    ];
    rows.extend(ATTACKS.map(|kind| {
        let limit = if kind.reason().is_some() { "named within 30 s" } else { "flagged before it ends" };
        let figure = format!("{} put into real flight {ATTACKED}: {limit}, percent", kind.name());
        row(figure, found(kind)).required(AtLeast(100.0))
    }));
    rows
}
