//! Input and output files of `evaluate`.

use std::collections::BTreeSet;
use std::error::Error;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use jiff::Timestamp;
use jiff::civil::Date;
use jiff::tz::TimeZone;
use tracing::{info, warn};

use super::Args;
use crate::commands::Usage;
use fusion::time::Time;
use input::capture::{Capture, MergedCaptures, OpenError};
use input::normalise::{nearest_day, time_of_day_count};
use lab::evaluate::plot::{self, Figure, Setting, TruthLine};
use lab::evaluate::read::{self, DayReference, FileKind};
use lab::evaluate::{AlertLine, Attack, ConflictPrediction, Evaluation, Label, Labels, OutputPoint, Truth};
use site::config::Config;

/// Number of octets by which the kind of a file is recognised.
const BEGINNING: u64 = 4096;

pub(in crate::commands) type FileFailure = Box<dyn Error + Send + Sync>;

/// Checks that truth and output were not exchanged.
///
/// # Errors
/// They were.
pub(super) fn refuse_exchanged(args: &Args) -> Result<(), Usage> {
    let kind_of = |path: &Path| {
        let mut beginning = Vec::new();
        #[expect(clippy::disallowed_methods, reason = "the files that the user names")]
        let file = std::fs::File::open(path).ok()?;
        file.take(BEGINNING).read_to_end(&mut beginning).ok()?;
        read::kind(&beginning)
    };
    let [truth] = &args.truth[..] else { return Ok(()) };
    if kind_of(&args.output) == Some(FileKind::Truth) && kind_of(truth) != Some(FileKind::Truth) {
        let (truth, output) = (truth.display(), args.output.display());
        return Err(Usage(format!(
            "{output} is {}, and {truth} is not: they are exchanged. Write: utm-fusion evaluate {truth} --truth {output}",
            FileKind::Truth
        )));
    }
    Ok(())
}

/// Reads the truth from all files.
pub(in crate::commands) fn truth(paths: &[PathBuf]) -> Result<Truth, FileFailure> {
    let mut tracks = Vec::new();
    for path in paths {
        let stem =
            path.file_stem().map_or_else(|| "truth".to_owned(), |stem| stem.to_string_lossy().into_owned());
        tracks.extend(read::truth(&name(path), &stem, &octets(path)?)?);
    }
    let truth = Truth::new(tracks);
    if truth.span().is_none() {
        return Err(format!("{}: no drone is in the truth", names(paths)).into());
    }
    Ok(truth)
}

/// Reads the labels. The configuration defines which sensors are transponder receivers.
pub(super) fn labels(path: &Path, config: Option<&Config>) -> Result<Labels, FileFailure> {
    let rows = read::labels(&name(path), &octets(path)?)?;
    Ok(match config {
        Some(config) => Labels::of_site(rows, config),
        None => Labels::new(rows),
    })
}

/// Whether the labels name a drone of the truth.
pub(super) fn name_a_drone(labels: &Labels, truth: &Truth) -> bool {
    let ids: BTreeSet<&str> = labels.rows().iter().filter_map(|Label { id, .. }| id.as_deref()).collect();
    ids.into_iter().any(|id| truth.index_of(id).is_some())
}

/// Reads the attacks on transponders.
pub(super) fn attacks(path: &Path) -> Result<Vec<Attack>, FileFailure> {
    Ok(read::attacks(&name(path), &octets(path)?)?)
}

/// Reads the output of `replay --conflicts`.
pub(super) fn conflicts(path: &Path) -> Result<Vec<(String, ConflictPrediction)>, FileFailure> {
    Ok(read::conflicts(&name(path), &octets(path)?)?)
}

/// Reads the output of `replay --alerts`.
pub(super) fn alerts(path: &Path) -> Result<Vec<AlertLine>, FileFailure> {
    Ok(read::alerts(&name(path), &octets(path)?)?)
}

/// Reads the points to be scored.
pub(super) fn output(
    path: &Path,
    date: Option<Date>,
    truth: &Truth,
) -> Result<Vec<OutputPoint>, FileFailure> {
    let file = read::output(
        &name(path),
        octets(path)?,
        date.map_or(DayReference::Near(start(truth)), DayReference::From),
    )?;
    if file.unknown_sources > 0 {
        warn!(
            "{}: {} CAT129 records do not say what they are made of: each belongs to the nearest drone, and counts as fused",
            name(path),
            file.unknown_sources
        );
    }
    if file.inputs > 0 {
        warn!(
            "{}: {} CAT129 records without a fusion report were passed over: they are what the tracker was fed",
            name(path),
            file.inputs
        );
    }
    Ok(file.points)
}

/// Warns if the output has no identities, the labels have some, and the labels do not have the output's numbers.
pub(super) fn warn_of_unnamed(path: &Path, output: &[OutputPoint], labels: &Labels) {
    if labels.rows().iter().all(|row| row.identity.is_none()) {
        return;
    }
    let transponders =
        output.iter().filter(|point| point.identity.is_none()).filter_map(|point| point.transponder);
    let unknown = transponders.filter(|&number| labels.transponder(None, number).is_none()).count();
    if unknown > 0 {
        warn!(
            "{}: {unknown} points do not state the identity of their transponder, and its number is not in --labels: each belongs to the nearest drone; NDJSON and GeoJSON state it",
            name(path)
        );
    }
}

/// Warns if all points are before or after the truth: another flight, or other times.
pub(super) fn warn_unless_at_one_time(path: &Path, output: &[OutputPoint], truth: &Truth) {
    let times = output.iter().map(|point| point.time);
    let (Some(first), Some(last), Some((from, until))) = (times.clone().min(), times.max(), truth.span())
    else {
        warn!("{}: holds no point", name(path));
        return;
    };
    if last < from || first > until {
        warn!(
            "{}: its points are of {first} to {last}, and the truth is of {from} to {until}: no point counts",
            name(path)
        );
    }
}

/// Opens the captures, merged by time of reception.
pub(super) fn receptions(
    paths: &[PathBuf],
    date: Option<Date>,
    truth: &Truth,
) -> Result<MergedCaptures, FileFailure> {
    let date = match date {
        Some(date) => date,
        None => day_of(paths, truth)?,
    };
    let captures = paths.iter().map(|path| Capture::open(path)).collect::<Result<Vec<_>, _>>()?;
    Ok(MergedCaptures::new(captures, date))
}

/// Day for files without dates: it puts the first record of the first capture nearest to the start of the truth.
pub(in crate::commands) fn day_of(paths: &[PathBuf], truth: &Truth) -> Result<Date, OpenError> {
    let mut near = start(truth);
    if let Some(path) = paths.first().filter(|path| path.as_path() != Path::new("-")) {
        let mut receptions =
            MergedCaptures::new(vec![Capture::open(path)?], Date::new(1970, 1, 1).unwrap_or_default());
        let first = receptions.find_map(|reception| reception.ok()?.received);
        near = first.and_then(|first| nearest_day(time_of_day_count(first), near)).unwrap_or(near);
    }
    let stamp = Timestamp::from_nanosecond(near.nanos().into()).unwrap_or_default();
    Ok(stamp.to_zoned(TimeZone::UTC).date())
}

fn start(truth: &Truth) -> Time {
    truth.span().map_or_else(Time::default, |span| span.0)
}

/// Writes each figure, and a page with all of them.
pub(super) fn write_plots(
    directory: &Path,
    output: &Path,
    evaluation: &Evaluation,
    truth: &Truth,
    setting: &Setting<'_>,
    encounter: Option<Figure>,
) -> Result<(), FileFailure> {
    let lines: Vec<TruthLine<'_>> =
        truth.tracks().iter().map(|track| TruthLine { id: track.id(), points: track.samples() }).collect();
    let mut figures = plot::figures(evaluation, &lines, setting);
    figures.extend(encounter);
    let page = plot::page(&name(output), evaluation, &figures);
    let mut files: Vec<(String, &str)> =
        figures.iter().map(|figure| (format!("{}.svg", figure.name), figure.svg.as_str())).collect();
    files.push(("index.html".to_owned(), &page));
    std::fs::create_dir_all(directory)
        .and_then(|()| {
            files.iter().try_for_each(|(name, contents)| std::fs::write(directory.join(name), contents))
        })
        .map_err(|error| format!("--plot {}: cannot be written: {error}", directory.display()))?;
    info!("{}: {} figures", directory.join("index.html").display(), figures.len());
    Ok(())
}

pub(in crate::commands) fn octets(path: &Path) -> Result<Vec<u8>, FileFailure> {
    let mut octets = Vec::new();
    let read = if path == Path::new("-") {
        io::stdin().lock().read_to_end(&mut octets).map(|_| octets)
    } else {
        std::fs::read(path)
    };
    read.map_err(|error| {
        format!("{}: cannot be read: {error}; check the path and its permissions", name(path)).into()
    })
}

fn name(path: &Path) -> String {
    if path == Path::new("-") { "standard input".to_owned() } else { path.display().to_string() }
}

fn names(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| name(path)).collect::<Vec<_>>().join(", ")
}
