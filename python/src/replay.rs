//! `replay`: processes captures with the engine and returns columns.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use fusion::Emission;
use pyo3::prelude::*;
use tracing::{error as log_error, warn as log_warn};
use utm_fusion::areas::Masks;
use utm_fusion::capture::{MergedCaptures, ReadError, SiteReceivers, TrailerRules};
use utm_fusion::commands::moment::day;
use utm_fusion::commands::unmatched::unmatched;
use utm_fusion::config::{Config, PictureKind, Profile};
use utm_fusion::formats::table::TableWriter as _;
use utm_fusion::formats::{OutputFormat, PictureWriter, track_columns, write_track};
use utm_fusion::picture::{Picture, PictureMaker, PictureSeries, UncooperativeDetector};
use utm_fusion::pipeline::{Output, Pipeline};

use crate::columns::{Gatherer, Shelf, take};
use crate::source::{Source, check_signals, error};
use crate::table::Table;
use crate::told::told;

/// Number of receptions between checks for an interrupt.
const AT_ONCE: usize = 1024;

/// Default day for files that state none.
const UNDATED: &str = "1970-01-01";

/// One capture or several.
#[derive(FromPyObject)]
pub(crate) enum Sources {
    One(Source),
    Several(Vec<Source>),
}

/// Replays captures, merged by time of reception, with the engine of the live service. Returns the fused points as columns, one
/// row per track and slot, as in `utm-fusion replay -o x.parquet`.
///
/// `config` is the site's configuration; `profile` overrides its profile ("operational", "reference"). `at` is the picture:
/// "lagged", the slots as published, or "now". `date` (YYYY-MM-DD) is the UTC day on which files without a date begin. `output`
/// is a file to write in addition, in the format of its extension: .ast .pcap .ndjson .geojson .csv .parquet .mcap.
///
/// Data that cannot be read cause an InputWarning. A truncated or damaged capture is replayed up to the damage, which `damage`
/// describes.
#[pyfunction]
#[pyo3(signature = (source, config, *, profile=None, at="lagged", date=None, output=None))]
pub(crate) fn replay(
    py: Python<'_>,
    source: Sources,
    config: PathBuf,
    profile: Option<&str>,
    at: &str,
    date: Option<&str>,
    output: Option<PathBuf>,
) -> PyResult<Table> {
    let sources = match source {
        Sources::One(source) => vec![source],
        Sources::Several(sources) => sources,
    };
    let asked = Asked {
        profile: profile
            .map(|name| name.parse().map_err(|reason| error(format!("profile {name}: {reason}"))))
            .transpose()?,
        at: at.parse().map_err(|reason| error(format!("at {at}: {reason}")))?,
        date: date.map(str::to_owned),
        output,
    };
    told(py, || run(sources, &config, &asked))
}

struct Asked {
    profile: Option<Profile>,
    at: PictureKind,
    date: Option<String>,
    output: Option<PathBuf>,
}

fn run(sources: Vec<Source>, path: &Path, asked: &Asked) -> PyResult<Table> {
    let mut config = Config::load(path).map_err(error)?;
    if let Some(profile) = asked.profile {
        config.fusion = config.fusion.with_profile(profile).map_err(error)?;
    }
    if asked.at == PictureKind::Now && !config.fusion.now {
        return Err(error("at now: fusion.now is off, or the profile is reference"));
    }
    let masks = Masks::load(&config.areas).map_err(error)?;
    let (trailers, receivers) = (TrailerRules::of(&config), SiteReceivers::of(&config));
    let mut captures = Vec::with_capacity(sources.len());
    for source in sources {
        let capture = source.open().map_err(error)?;
        captures.push(capture.with_trailers(trailers.clone()).with_receivers(&receivers));
    }
    let first = captures.first().ok_or_else(|| error("there is no capture to replay"))?.name().to_owned();
    if asked.date.is_none()
        && let Some(capture) = captures.iter().find(|capture| !capture.is_dated())
    {
        log_warn!(
            "{}: {} has no date, and is taken to begin on {UNDATED}: give it as date",
            capture.name(),
            capture.format()
        );
    }
    let date = day(asked.date.as_deref().unwrap_or(UNDATED)).map_err(error)?;

    let mut pipeline = Pipeline::new(&config, masks.clone());
    pipeline.engine_mut().keep_numbers_for_good();
    let merged = MergedCaptures::new(captures, date).with_editions(pipeline.normaliser().editions());
    let mut show = Show::open(&config, &pipeline, masks, asked)?;
    let damage = pass(&mut pipeline, merged, &mut show)?;
    let problem = unmatched(pipeline.tally(), &config, &path.display().to_string(), &first);
    let table = show.finish(damage)?;
    problem.map_or(Ok(table), |problem| Err(error(problem)))
}

/// Replays captures; returns the damage that ends one of them, if any.
fn pass(pipeline: &mut Pipeline, mut merged: MergedCaptures, show: &mut Show) -> PyResult<Option<ReadError>> {
    let mut damaged = None;
    for count in 0_usize.. {
        if count.is_multiple_of(AT_ONCE) {
            check_signals()?;
        }
        match merged.next() {
            Some(Ok(reception)) => pipeline.receive(&reception),
            Some(Err(damage)) => damaged = Some(damage),
            None => break,
        }
        while let Some(output) = pipeline.poll() {
            match output {
                Output::Emission(emission) => show.emit(emission)?,
                Output::Event(event) if event.is_warning() => event.log(),
                Output::Event(_) => {}
            }
        }
    }
    pipeline.finish();
    pipeline.emissions().try_for_each(|emission| show.emit(emission))?;
    for capture in merged.captures().filter(|capture| !capture.gaps().is_empty()) {
        log_warn!("{}: {}, which belong to no block, were skipped", capture.name(), capture.gaps());
    }
    if let Some(damage) = &damaged {
        log_error!("{damage}");
    }
    Ok(damaged)
}

/// Outputs of the emissions.
struct Show {
    series: PictureSeries,
    at: PictureKind,
    max_accuracy_m: f64,
    rows: Box<Gatherer>,
    shelf: Shelf,
    writer: Option<PictureWriter<BufWriter<File>>>,
}

impl Show {
    fn open(config: &Config, pipeline: &Pipeline, masks: Masks, asked: &Asked) -> PyResult<Self> {
        let shelf = Shelf::default();
        let writer = asked.output.as_deref().map(|path| {
            let format = OutputFormat::of(path).ok_or_else(|| {
                error(format!(
                    "output {}: the extension is none of .ast .pcap .ndjson .geojson .csv .parquet .mcap",
                    path.display()
                ))
            })?;
            let unwritten = |reason| error(format!("{}: cannot be written: {reason}", path.display()));
            #[expect(clippy::disallowed_methods, reason = "the file that the user names")]
            let file = BufWriter::new(File::create(path).map_err(unwritten)?);
            PictureWriter::new(format, file, config, asked.at).map_err(unwritten)
        });
        Ok(Self {
            series: PictureSeries::new(
                PictureMaker::new(config, pipeline.normaliser()),
                UncooperativeDetector::load(config, masks).map_err(error)?,
            ),
            at: asked.at,
            max_accuracy_m: config.output.max_accuracy_m,
            rows: Box::new(Gatherer::new("tracks", &track_columns(), &shelf)),
            shelf,
            writer: writer.transpose()?,
        })
    }

    fn emit(&mut self, emission: Emission) -> PyResult<()> {
        let (lagged, now) = self.series.pictures(emission, self.at == PictureKind::Now);
        match (self.at, now) {
            (PictureKind::Lagged, _) => self.write(lagged),
            (PictureKind::Now, Some(now)) => self.write(now),
            (PictureKind::Now, None) => Ok(()),
        }
    }

    fn write(&mut self, mut picture: Picture) -> PyResult<()> {
        picture.keep_within(self.max_accuracy_m);
        for track in &picture.tracks {
            write_track(&mut *self.rows, track, self.series.maker())?;
        }
        if let Some(writer) = &mut self.writer {
            writer.write(&picture, self.series.maker())?;
        }
        Ok(())
    }

    fn finish(self, damage: Option<ReadError>) -> PyResult<Table> {
        self.rows.finish()?;
        if let Some(writer) = self.writer {
            writer.finish()?;
        }
        let frame = take(&self.shelf, "tracks").ok_or_else(|| error("the table was not made"))?;
        Ok(Table::new(frame, damage))
    }
}
