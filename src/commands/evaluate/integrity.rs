//! `--integrity`: scores of the detection of false transponder reports.

use std::fmt::{self, Write as _};
use std::path::{Path, PathBuf};

use fusion::integrity::Reason;
use serde::Serialize;
use tracing::warn;

use super::{Args, EvaluateInputs, files};
use crate::commands::table::TextTable;
use lab::evaluate::{
    AlertLine, Attack, AttackDetection, FalseFlag, FlaggedCoverage, IntegrityFlight, IntegrityScore, Scoring,
    integrity,
};

/// Name of the file with the attacks that the simulator writes beside the truth.
const ATTACKS: &str = "attacks.csv";

/// Attacks on transponders, and alerts about them.
pub(super) struct AttackInputs {
    attacks: Vec<Attack>,
    /// File of the attacks; `None` if there is none.
    file: Option<PathBuf>,
    alerts: Option<Vec<AlertLine>>,
}

/// Score of the integrity flags.
#[derive(Serialize)]
pub(super) struct IntegrityReport {
    /// Whether the attacks are known. If not, no transponder counts as attacked.
    attacks_known: bool,
    #[serde(skip)]
    file: Option<PathBuf>,
    #[serde(flatten)]
    score: IntegrityScore,
}

/// File of the attacks: the one given, else the one beside the truth.
pub(super) fn attack_file(args: &Args) -> Option<PathBuf> {
    let beside = || {
        let truth = args.truth.first().filter(|truth| truth.as_path() != Path::new("-"))?;
        Some(truth.with_file_name(ATTACKS)).filter(|path| path.exists())
    };
    args.attacks.clone().or_else(beside)
}

impl AttackInputs {
    /// Reads the attacks and the alerts.
    pub(super) fn read(args: &Args) -> Result<Self, files::FileFailure> {
        let file = attack_file(args);
        let attacks = file.as_deref().map(files::attacks).transpose()?;
        if attacks.is_none() {
            warn!(
                "there is no {ATTACKS} beside the truth, and no --attacks: nobody counts as attacked, and every flag as false"
            );
        }
        let alerts = args.alerts.as_deref().map(files::alerts).transpose()?;
        Ok(Self { attacks: attacks.unwrap_or_default(), file, alerts })
    }

    /// Scores the flags. `None` if a required input is missing; the command line requires it.
    pub(super) fn scored(self, inputs: &EvaluateInputs, settings: &Scoring) -> Option<IntegrityReport> {
        let EvaluateInputs { truth, labels, output, alone, .. } = inputs;
        let score = integrity(&IntegrityFlight {
            truth,
            labels: labels.as_ref()?,
            reports: &alone.as_ref()?.reports,
            attacks: &self.attacks,
            output,
            alerts: self.alerts.as_deref(),
            settings,
        });
        for attack in &self.attacks {
            if truth.index_of(&attack.id).is_none() {
                warn!("no drone of --truth is {:?}, which is attacked: it is not scored", attack.id);
            }
        }
        Some(IntegrityReport { attacks_known: self.file.is_some(), file: self.file, score })
    }
}

/// Section of the report.
pub(super) fn text(scored: &IntegrityReport) -> Result<String, fmt::Error> {
    let IntegrityReport { file, score, .. } = scored;
    let mut text = String::new();
    match file {
        Some(file) => writeln!(text, "Transponders that lie, by {}:\n", file.display())?,
        None => writeln!(
            text,
            "Transponders that lie: it is not known whether any does, so every flag counts as false. Give --attacks.\n"
        )?,
    }
    if !score.attacks.is_empty() {
        writeln!(text, "{}", attacks(&score.attacks))?;
    }
    write!(text, "{}", figures(score))?;
    let mut flags = TextTable::new("rllrl", &["clean transponder", "flagged from", "until", "s", "reasons"]);
    for FalseFlag { number, from, until, reasons } in &score.clean.flags {
        let reasons: Vec<&str> = reasons.iter().map(Reason::name).collect();
        flags.row(vec![
            number.to_string(),
            from.to_string(),
            until.to_string(),
            format!("{:.1}", until.seconds_since(*from)),
            reasons.join(", "),
        ]);
    }
    if !score.clean.flags.is_empty() {
        write!(text, "\n{flags}")?;
    }
    Ok(text)
}

/// Table with a row per attack.
fn attacks(attacks: &[AttackDetection]) -> TextTable {
    let mut table = TextTable::new(
        "lrllrlrrl",
        &[
            "drone",
            "transponder",
            "attack",
            "begins",
            "seen s",
            "observable",
            "flagged after s",
            "named after s",
            "reasons, each after s",
        ],
    );
    for attack in attacks {
        let reasons = attack.reasons.iter().map(|(reason, s)| format!("{} {s:.2}", reason.name()));
        let named_s = attack.kind.reason().and_then(|reason| attack.delay_by_s(reason));
        let silent = if attack.is_silent { " (silent)" } else { "" };
        table.row(vec![
            attack.id.clone(),
            attack.number.to_string(),
            format!("{}{silent}", attack.kind.name()),
            attack.begin.map_or_else(|| "-".to_owned(), |begin| begin.to_string()),
            attack.seen_s.to_string(),
            (if attack.is_observable { "yes" } else { "no" }).to_owned(),
            attack.delay_s.map_or_else(|| "never".to_owned(), |s| format!("{s:.2}")),
            seconds(named_s),
            reasons.collect::<Vec<_>>().join(", "),
        ]);
    }
    table
}

/// Table with a row per figure.
fn figures(score: &IntegrityScore) -> TextTable {
    let IntegrityScore { attacks, clean, uncooperative, jamming } = score;
    let shown =
        attacks.iter().map(|attack| attack.shown).fold(FlaggedCoverage::default(), FlaggedCoverage::and);
    let mut table = TextTable::new("lr", &["integrity", "reached"]);
    let mut row = |name: &str, value: String| table.row(vec![name.to_owned(), value]);
    row("hours of identities that do not lie", format!("{:.3}", clean.identity_h));
    row("flags on them", clean.flags.len().to_string());
    row("slots with a plot of a flagged drone", shown.seen_slots.to_string());
    row(
        "with a point within 60 m of it (%)",
        shown.near_share().map_or_else(|| "-".to_owned(), |share| format!("{:.2}", 100.0 * share)),
    );
    // Output files do not state covariances.
    if let Some(nees) = shown.nees() {
        row("NEES, horizontal, of flagged points", format!("{nees:.4}"));
    }
    row("drones without transponder, 20 s seen by radar alone", uncooperative.aircraft.to_string());
    row("uncooperative by then", uncooperative.marked.to_string());
    row("uncooperative, of drones with transponder", uncooperative.false_marks.to_string());
    if let Some(jamming) = jamming {
        row("jammed transponders", jamming.jammed.to_string());
        row("alert of jamming after (s)", seconds(jamming.delay_s));
        row("false alerts of jamming", jamming.false_alerts.to_string());
    }
    table
}

fn seconds(seconds: Option<f64>) -> String {
    seconds.map_or_else(|| "-".to_owned(), |seconds| format!("{seconds:.2}"))
}
