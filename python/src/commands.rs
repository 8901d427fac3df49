//! `encode`, `simulate` and `evaluate`, like the commands with these names.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use utm_fusion::commands::{cli, evaluate as scores};
use utm_fusion::json::Encoder;
use utm_fusion::simulate::{Scenario, simulate as simulated, write};

use crate::source::{EditionNames, decoder, error};
use crate::told::told;

/// Runs the command line program; returns its exit code.
#[pyfunction]
pub(crate) fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| cli::main(arguments))
}

/// Encodes one or several records as ASTERIX, with the keys that `records` returns. Records with the same `block` share a block.
/// `edition` applies to records that state none.
///
/// Raises Error at the first record that cannot be encoded, with the reason.
#[pyfunction]
#[pyo3(signature = (records, *, edition=None))]
pub(crate) fn encode(
    py: Python<'_>,
    records: Bound<'_, PyAny>,
    edition: Option<EditionNames>,
) -> PyResult<Vec<u8>> {
    let records = match records.cast::<PyDict>() {
        Ok(record) => PyList::new(py, [record])?.into_any(),
        Err(_) => records,
    };
    let mut encoder = Encoder::new(decoder(None, edition, false)?.editions);
    let dumps = py.import("json")?.getattr("dumps")?;
    let mut octets = Vec::new();
    for (number, record) in records.try_iter()?.enumerate() {
        let line: String = dumps.call1((record?,))?.extract()?;
        encoder.line(&line, &mut octets).map_err(|reason| error(format!("record {number}: {reason}")))?;
    }
    encoder.finish(&mut octets);
    Ok(octets)
}

/// Simulates a scenario (a TOML file) and writes files to the folder `out`, which is created if needed. Returns their paths by
/// name: `capture` (pcap), `radar` and `transponder` (raw), `site` (configuration), `truth`, `labels` (CSV), and those of
/// further sensors. The same scenario, seed and duration give the same files. `duration_s` is 20 to 43200.
#[pyfunction]
#[pyo3(signature = (scenario, out, *, seed=1, duration_s=None))]
pub(crate) fn simulate(
    py: Python<'_>,
    scenario: PathBuf,
    out: PathBuf,
    seed: u64,
    duration_s: Option<f64>,
) -> PyResult<BTreeMap<String, PathBuf>> {
    let files = told(py, || {
        let mut scenario = Scenario::load(&scenario).map_err(error)?;
        if let Some(duration_s) = duration_s {
            if !(20.0..=43_200.0).contains(&duration_s) {
                return Err(error(format!("duration_s {duration_s}: a scenario lasts 20 to 43200 seconds")));
            }
            scenario.duration_s = duration_s;
        }
        let simulation = simulated(&scenario, seed, None).map_err(error)?;
        let about = format!("The site of scenario {}, seed {seed}.", scenario.name);
        write(&simulation, &about, &out).map_err(error)
    })?;
    let stem = |path: &PathBuf| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    Ok(files.into_iter().map(|path| (stem(&path).unwrap_or_default(), path)).collect())
}

/// Scores an output of `replay` against the truth; returns the object of `utm-fusion evaluate --json`. `labels` states which
/// drone each plot and report belongs to; with `capture` and `config` each input is also scored alone. `plot` is a folder for
/// figures (SVG).
#[pyfunction]
#[pyo3(signature = (output, truth, *, labels=None, capture=None, config=None, date=None, integrity=false, attacks=None, alerts=None, conflicts=None, plot=None))]
#[expect(clippy::too_many_arguments, reason = "the options of the command")]
pub(crate) fn evaluate<'py>(
    py: Python<'py>,
    output: PathBuf,
    truth: Paths,
    labels: Option<PathBuf>,
    capture: Option<Paths>,
    config: Option<PathBuf>,
    date: Option<&str>,
    integrity: bool,
    attacks: Option<PathBuf>,
    alerts: Option<PathBuf>,
    conflicts: Option<PathBuf>,
    plot: Option<PathBuf>,
) -> PyResult<Bound<'py, PyAny>> {
    let args = scores::Args {
        output,
        truth: truth.into(),
        labels,
        capture: capture.map_or_else(Vec::new, Paths::into),
        config,
        date: date.map(utm_fusion::commands::moment::day).transpose().map_err(error)?,
        integrity,
        attacks,
        alerts,
        conflicts,
        plot,
        json: true,
        require: Vec::new(),
    };
    refuse(&args)?;
    let text = told(py, || {
        let mut out = Vec::new();
        scores::run(&args, &mut out).map_err(error)?;
        Ok(out)
    })?;
    py.import("json")?.call_method1("loads", (text,))
}

/// Checks which options require or exclude each other, as the command does.
fn refuse(args: &scores::Args) -> PyResult<()> {
    let need =
        |is_asked: bool, has: bool, text: &str| if is_asked && !has { Err(error(text)) } else { Ok(()) };
    let (labels, config, capture) = (args.labels.is_some(), args.config.is_some(), !args.capture.is_empty());
    need(capture, config, "capture needs config")?;
    need(args.integrity, labels && config && capture, "integrity needs labels, config and capture")?;
    need(args.attacks.is_some(), args.integrity, "attacks needs integrity")?;
    need(args.alerts.is_some(), args.integrity, "alerts needs integrity")?;
    need(args.conflicts.is_some(), labels && config, "conflicts needs labels and config")
}

/// One file or several.
#[derive(FromPyObject)]
pub(crate) enum Paths {
    One(PathBuf),
    Several(Vec<PathBuf>),
}

impl From<Paths> for Vec<PathBuf> {
    fn from(paths: Paths) -> Self {
        match paths {
            Paths::One(path) => vec![path],
            Paths::Several(paths) => paths,
        }
    }
}
