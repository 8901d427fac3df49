//! `assess`: a report on what a recording shows of its sensors and of the picture.

mod files;

use std::io::Write;
use std::path::{Path, PathBuf};

use jiff::civil::Date;
use tracing::{info, warn};

use super::evaluate::files as evaluated;
use super::moment::day;
use super::unmatched::{nothing, unmatched};
use super::{CommandResult, Outcome, Usage};
use files::{Hashed, Opened};
use lab::assess::{
    AssessedRecording, Assessment, AssessmentReference, AssessmentReport, Limit, Provenance, assess, compare,
    html,
};
use picture::UncooperativeDetector;
use site::areas::Masks;
use site::config::Config;

/// Layout of the JSON.
const FORMAT: &str = "utm-fusion-assess-1";
/// Seeds of the draws: of the recording, and of the other one.
const SEEDS: [u64; 2] = [1, 2];

/// Assesses a recording: detection, tracking, accuracy, identification, latency, alignment and integrity of each sensor and of the
/// picture
///
/// The figures have 95 % confidence intervals and are defined in docs/ASSESS.md. Without --truth the reports of transponders in
/// the recording are the reference, and the report states what cannot be said. The same files give the same report, octet by octet.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Args {
    /// Recordings of one site, in any format of `replay`; several are merged by reception time
    #[arg(required = true, value_name = "RECORDING")]
    pub inputs: Vec<PathBuf>,
    /// Site configuration. Default: site.toml beside the recording
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// True positions of the aircraft: CSV with time,id,lat,lon,alt_msl and optionally class, or GPX. Several files are merged
    #[arg(long, value_name = "FILE")]
    pub truth: Vec<PathBuf>,
    /// Another recording to compare with: the report then states which figures differ
    #[arg(long, value_name = "RECORDING")]
    pub against: Vec<PathBuf>,
    /// Site configuration of the other recording. Default: that of the first
    #[arg(long, value_name = "FILE", requires = "against")]
    pub against_config: Option<PathBuf>,
    /// Truth of the other recording
    #[arg(long, value_name = "FILE", requires = "against")]
    pub against_truth: Vec<PathBuf>,
    /// File for the report (HTML). The figures are written beside it as JSON. Default: JSON to standard output
    #[arg(short, long, value_name = "REPORT.html")]
    pub output: Option<PathBuf>,
    /// UTC day of the first record of files without a date (raw ASTERIX). Default: the day of the truth
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = day)]
    pub date: Option<Date>,
}

/// A recording with its assessment.
struct Assessed {
    assessment: Assessment,
    provenance: Provenance,
    outcome: Outcome,
}

/// Assesses the recording, and writes the report.
///
/// # Errors
/// A file cannot be read, the recording has no record of the site's sensors, or the report cannot be written.
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    let json_file = args.output.as_deref().map(json_beside).transpose()?;
    if !args.against.is_empty() && args.truth.is_empty() != args.against_truth.is_empty() {
        return Err(Usage(
            "--truth and --against-truth belong together: figures against a truth and against transponders are not comparable"
                .to_owned(),
        )
        .into());
    }
    let config = config_of(&args.inputs, args.config.as_deref())?;
    let this = assessed(&args.inputs, &config, &args.truth, args.date, SEEDS[0])?;
    let other = match args.against.is_empty() {
        true => None,
        false => {
            let config = args.against_config.as_deref().unwrap_or(&config);
            Some(assessed(&args.against, config, &args.against_truth, args.date, SEEDS[1])?)
        }
    };
    let comparison = other.as_ref().map(|other| compare(&this.assessment, &other.assessment));
    let mut outcome = this.outcome;
    if let Some(other) = &other
        && outcome == Outcome::Done
    {
        outcome = other.outcome;
    }
    let report = AssessmentReport {
        format: FORMAT,
        provenance: this.provenance,
        assessment: this.assessment,
        against: other.map(|other| other.provenance),
        comparison: comparison.unwrap_or_default(),
    };
    let mut json = serde_json::to_string_pretty(&report)?;
    json.push('\n');
    match args.output.as_deref().zip(json_file) {
        Some((page, json_file)) => {
            files::write(page, &html(&report)?)?;
            files::write(&json_file, &json)?;
            info!("{}: written, with its figures in {}", page.display(), json_file.display());
        }
        None => out.write_all(json.as_bytes())?,
    }
    out.flush()?;
    Ok(outcome)
}

/// Name of the JSON file beside a page.
fn json_beside(page: &Path) -> Result<PathBuf, Usage> {
    let json = page.with_extension("json");
    if json == page {
        return Err(Usage(format!(
            "-o {}: this is the name of the figures; name a page, as report.html",
            page.display()
        )));
    }
    Ok(json)
}

/// The named configuration, or the one beside the recording.
fn config_of(inputs: &[PathBuf], named: Option<&Path>) -> Result<PathBuf, Usage> {
    if let Some(named) = named {
        return Ok(named.to_owned());
    }
    let first = inputs.first().map_or(Path::new(""), PathBuf::as_path);
    let beside = first.with_file_name("site.toml");
    match beside.is_file() {
        true => Ok(beside),
        false => Err(Usage(format!(
            "no --config, and no site.toml beside the recording; `utm-fusion locate {} -o site.toml` makes one",
            first.display()
        ))),
    }
}

fn assessed(
    inputs: &[PathBuf],
    config_file: &Path,
    truth_files: &[PathBuf],
    date: Option<Date>,
    seed: u64,
) -> Result<Assessed, evaluated::FileFailure> {
    let mut hashed = Hashed::default();
    for input in inputs {
        hashed.add("recording", input)?;
    }
    hashed.add("configuration", config_file)?;
    hashed.add_overrides();
    let config = Config::load(config_file)?;
    for area in &config.areas {
        hashed.add("areas", &area.file)?;
    }
    let mut classes = std::collections::BTreeMap::new();
    for file in truth_files {
        hashed.add("truth", file)?;
        classes.extend(lab::evaluate::read::classes(&file.display().to_string(), &evaluated::octets(file)?)?);
    }
    let truth = (!truth_files.is_empty()).then(|| evaluated::truth(truth_files)).transpose()?;
    let masks = Masks::load(&config.areas)?;
    let detector = UncooperativeDetector::load(&config, masks.clone())?;
    let mut opened = Opened::open(inputs, &config, date, truth.as_ref())?;
    let recording = AssessedRecording::read(opened.receptions(), &config, masks, detector)?;
    let (site, input) =
        (config_file.display().to_string(), inputs.first().map_or(Path::new("-"), PathBuf::as_path));
    let input = input.display().to_string();
    let problem = unmatched(&recording.tally, &config, &site, &input);
    if let Some(problem) = problem.or_else(|| nothing(&recording.tally, &opened.skipped(), &input)) {
        return Err(problem.into());
    }
    let reference = AssessmentReference { truth: truth.as_ref(), classes: &classes, seed };
    let mut assessment = assess(&recording, &config, reference);
    if assessment.method.aircraft == 0 {
        warn!("no aircraft of the reference has a slot that counts: do recording and truth belong together?");
    }
    let outcome = match opened.is_damaged() {
        true => {
            let what = "The rest of a recording".to_owned();
            let why = "a file is damaged, and was read up to there.".to_owned();
            assessment.cannot_say.insert(0, Limit { what, why });
            Outcome::InputUnreadable
        }
        false => Outcome::Done,
    };
    let provenance = Provenance {
        program: concat!("utm-fusion ", env!("CARGO_PKG_VERSION")).to_owned(),
        commit: option_env!("UTM_FUSION_COMMIT").map(str::to_owned),
        site: config.site.name.clone(),
        profile: config.fusion.profile.name().to_owned(),
        files: hashed.files,
    };
    Ok(Assessed { assessment, provenance, outcome })
}
