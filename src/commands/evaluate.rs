//! `evaluate`: scores an output against the truth.

mod alerts;
mod conflicts;
pub(super) mod files;
mod integrity;
mod json;
mod require;
mod text;

use std::io::Write;
use std::path::{Path, PathBuf};

use jiff::civil::Date;
use tracing::{error, warn};

use super::moment::day;
use super::{CommandResult, Outcome};
use fusion::settings::Threshold;
use lab::evaluate::plot::Setting;
use lab::evaluate::{
    AlertScore, Evaluation, InputsAlone, Labels, OutputPoint, RadarResiduals, Scoring, Truth, evaluate,
    misalignments, residuals,
};
use site::areas::Masks;
use site::config::Config;

pub use require::Requirement;

const REQUIRE_HELP: &str = "Ends with exit code 5 unless this holds: [radar.|transponder.][equipped.|unequipped.]METRIC OP NUMBER, for \
example 'pu>=90'; repeat for more. METRIC: pu (%), epos, eposh, eposv, epos_covered, epos_gap (means, m), gap_within_50_m (%), \
precision, recall (0 to 1), id_changes (a drone and minute), two_numbers (%), ghosts, false_track (s a minute), gospa (m). OP: >= <= > <";

/// Scores an output against the truth: update rate, position accuracy and correctness of the identities
///
/// The metrics are those of section 4 of the paper and of docs/METRICS.md. With --capture and --config each input alone is scored
/// too, as in Table 1 of the paper. Without --labels a point belongs to the nearest drone within 150 m.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Args {
    /// Output of `replay -o`, in any of its formats but Parquet and MCAP, or CAT129 of another tracker; `-` is standard input
    #[arg(value_name = "OUTPUT")]
    pub output: PathBuf,
    /// True positions of the drones: CSV with time,id,lat,lon,alt_msl, or GPX. Several files are merged
    #[arg(long, required = true, value_name = "FILE")]
    pub truth: Vec<PathBuf>,
    /// Drone of each plot and transponder: CSV with time,sensor,number,id,seduced,identity
    #[arg(long, value_name = "FILE")]
    pub labels: Option<PathBuf>,
    /// Input from which the output was made, to score each input alone. Several are merged by reception time
    #[arg(long, value_name = "FILE", requires = "config")]
    pub capture: Vec<PathBuf>,
    /// Site configuration
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// UTC day of the first record of files without a date (raw ASTERIX). Default: the day of the truth
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = day)]
    pub date: Option<Date>,
    /// Scores the flags of false transponder reports too
    #[arg(long, requires_all = ["labels", "config", "capture"])]
    pub integrity: bool,
    /// Attacks on transponders: CSV with id,number,attack,from,until. Default: attacks.csv beside the truth
    #[arg(long, value_name = "FILE")]
    pub attacks: Option<PathBuf>,
    /// Alerts of the same flight, as written by `replay --alerts`, to be scored too: events raised, items an operator sees,
    /// duplicates, and items without a cause
    #[arg(long, value_name = "FILE", requires_all = ["labels", "config"])]
    pub alerts: Option<PathBuf>,
    /// Conflicts of the same flight, as written by `replay --conflicts`, to be scored too
    #[arg(long, value_name = "FILE", requires_all = ["labels", "config"])]
    pub conflicts: Option<PathBuf>,
    /// Prints one JSON object
    #[arg(long)]
    pub json: bool,
    /// Folder for figures (SVG) and a page with all tables and figures (index.html). With --conflicts there is a figure of the
    /// closest encounter
    #[arg(long, value_name = "DIR")]
    pub plot: Option<PathBuf>,
    /// Condition that a score must meet.
    #[arg(long, value_name = "CONDITION", help = REQUIRE_HELP)]
    pub require: Vec<Requirement>,
}

/// Inputs of the command.
struct EvaluateInputs {
    config: Option<Config>,
    truth: Truth,
    labels: Option<Labels>,
    output: Vec<OutputPoint>,
    alone: Option<InputsAlone>,
}

/// Scores, with the data needed to print them.
struct EvaluateScores<'a> {
    args: &'a Args,
    evaluation: &'a Evaluation,
    /// Reference rate of the probability of update (PU), in updates per second.
    reference_hz: f64,
    /// Present with `--integrity`.
    integrity: Option<integrity::IntegrityReport>,
    /// Present with `--alerts`.
    alerts: Option<AlertScore>,
    /// One entry per volume, with `--conflicts`.
    conflicts: Vec<conflicts::VolumeScore>,
    /// Requirements, with their values and whether they are met.
    requirements: Vec<(&'a Requirement, Result<f64, String>, bool)>,
}

/// Scores the output and writes the table, or JSON, to `out`.
///
/// # Errors
/// A file cannot be read, one of its lines is invalid, or `out` cannot be written.
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    let inputs = read(args)?;
    let settings = inputs.config.as_ref().map_or_else(Scoring::default, Scoring::of);
    let labels = inputs.labels.as_ref();
    let evaluation = evaluate(&inputs.truth, labels, &inputs.output, inputs.alone.as_ref(), &settings);
    let foreseen = args.conflicts.as_deref().map(files::conflicts).transpose()?;
    if let Some(directory) = &args.plot {
        let encounter = foreseen.as_deref().and_then(|all| conflicts::figure(all, &inputs, &settings));
        let residuals = residuals_of(args, &inputs, &evaluation)?;
        let config = inputs.config.as_ref();
        let threshold = config.and_then(|config| Threshold::new(config.fusion.threshold_m.clone()));
        let setting = Setting { site: settings.site, threshold: threshold.as_ref(), residuals: &residuals };
        files::write_plots(directory, &args.output, &evaluation, &inputs.truth, &setting, encounter)?;
    }
    if evaluation.fused.all.pu_percent.is_none() {
        warn!(
            "no slot counts: the first 10 s and the last 7.5 s of each drone's truth do not, nor do holes over 5 s"
        );
    }

    let known = args.integrity.then(|| integrity::AttackInputs::read(args)).transpose()?;
    let integrity = known.and_then(|known| known.scored(&inputs, &settings));
    let alerts = match &args.alerts {
        Some(path) => alerts::scored(&files::alerts(path)?, args, &inputs, &settings)?,
        None => None,
    };
    let conflicts = foreseen.as_deref().map(|all| conflicts::scored(all, &inputs, &settings));
    let requirements = args.require.iter().map(|requirement| {
        let value = requirement.value(&evaluation, args);
        let is_met = value.as_ref().is_ok_and(|&value| requirement.is_met_by(value));
        (requirement, value, is_met)
    });
    let scores = EvaluateScores {
        args,
        evaluation: &evaluation,
        reference_hz: 1.0 / settings.grid.slot_s(),
        integrity,
        alerts,
        conflicts: conflicts.unwrap_or_default(),
        requirements: requirements.collect(),
    };
    if args.json {
        serde_json::to_writer(&mut *out, &json::json(&scores))?;
        writeln!(out)?;
    } else {
        write!(out, "{}", text::text(&scores)?)?;
    }
    out.flush()?;
    Ok(print_scores(&scores))
}

/// Misalignments of the radars that their registrations leave uncorrected, as far as the capture shows them.
fn residuals_of(
    args: &Args,
    inputs: &EvaluateInputs,
    evaluation: &Evaluation,
) -> Result<Vec<RadarResiduals>, files::FileFailure> {
    let (Some(config), Some(alone)) = (&inputs.config, &inputs.alone) else { return Ok(Vec::new()) };
    if args.capture.iter().any(|capture| capture == Path::new("-")) {
        warn!("standard input is read once: --plot draws no residuals of the registration");
        return Ok(Vec::new());
    }
    let receptions = files::receptions(&args.capture, args.date, &inputs.truth)?;
    let known = misalignments(receptions, config, Masks::load(&config.areas)?)?;
    Ok(residuals(evaluation, &alone.radar, &known, config))
}

/// Reports the requirements that are not met.
fn print_scores(scores: &EvaluateScores<'_>) -> Outcome {
    let mut outcome = Outcome::Done;
    for (requirement, value, _) in scores.requirements.iter().filter(|(_, _, is_met)| !is_met) {
        outcome = Outcome::ThresholdMissed;
        match value {
            Ok(value) => error!("--require '{requirement}' is missed: it is {value:.4}"),
            Err(reason) => error!("--require '{requirement}' is missed: {reason}"),
        }
    }
    outcome
}

fn read(args: &Args) -> Result<EvaluateInputs, Box<dyn std::error::Error + Send + Sync>> {
    let config = args.config.as_deref().map(Config::load).transpose()?;
    files::refuse_exchanged(args)?;
    let truth = files::truth(&args.truth)?;
    let labels = args.labels.as_deref().map(|path| files::labels(path, config.as_ref())).transpose()?;
    if labels.as_ref().is_some_and(|labels| !files::name_a_drone(labels, &truth)) {
        warn!("no drone of --labels is in --truth: do they belong together? Their ids must be the same");
    }
    let output = files::output(&args.output, args.date, &truth)?;
    files::warn_unless_at_one_time(&args.output, &output, &truth);
    if let Some(labels) = &labels {
        files::warn_of_unnamed(&args.output, &output, labels);
    }
    let alone = match &config {
        Some(config) if !args.capture.is_empty() => {
            let receptions = files::receptions(&args.capture, args.date, &truth)?;
            let receptions = receptions.with_editions(config.editions());
            Some(InputsAlone::of(receptions, config, Masks::load(&config.areas)?)?)
        }
        _ => None,
    };
    Ok(EvaluateInputs { config, truth, labels, output, alone })
}
