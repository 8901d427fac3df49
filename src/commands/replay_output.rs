//! Pictures of a replay: pacing, counting, writing and sending.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use jiff::SignedDuration;

use super::Usage;
use super::alert_file::AlertFile;
use super::broadcast::Broadcast;
use super::line_file::LineFile;
use super::moment::{ReplaySpeed, TimeArgument};
use super::pace::Pace;
use super::replay::args::Args;
use super::summary::ReplaySummary;
use crate::app::{AppError, Stop};
use fusion::Emission;
use fusion::time::Time;
use input::pipeline::Event;
use picture::conflicts::{ConflictLine, ConflictWatch, Outlook};
use picture::formats::{OutputFormat, PictureWriter};
use picture::{Picture, PictureSeries};
use service::live::PredictionPicture;
use service::state::AlertDecision;
use site::config::{Config, PictureKind, Profile};

/// Writer of `-o`.
type PicturesWriter = PictureWriter<Box<dyn Write + Send>>;

/// Destinations of the pictures.
pub(super) struct ReplayOutput<'a> {
    args: &'a Args,
    config: &'a Config,
    /// Pictures from the start of the recording on, and from here on.
    initial: PictureSeries,
    series: PictureSeries,
    /// Present with `--alerts`.
    alerts: Option<AlertFile>,
    /// Present with `--conflicts`, and with `--alerts` if conflicts are enabled.
    conflicts: Option<ConflictWatch>,
    /// Present with `--conflicts`.
    conflict_file: Option<LineFile>,
    /// Present with `-o`.
    output: Option<PicturesWriter>,
    /// Present with `--udp`.
    broadcast: Option<(Broadcast, Stop)>,
    pub(super) summary: ReplaySummary,
    pace: Pace,
    /// Time of the first reception, to which `--start` and `--end` may be relative.
    first: Option<Time>,
    /// Time from the start of a slot to its emission, for the picture that is written.
    latency: SignedDuration,
    is_stopped: bool,
    failed: Option<io::Error>,
}

impl<'a> ReplayOutput<'a> {
    pub(super) fn open(
        args: &'a Args,
        config: &'a Config,
        series: PictureSeries,
        decisions: Vec<AlertDecision>,
    ) -> Result<Self, AppError> {
        let usual = if args.udp { ReplaySpeed::Times(1.0) } else { ReplaySpeed::Max };
        Ok(Self {
            args,
            config,
            initial: series.clone(),
            series,
            output: open_output(args, config)?,
            alerts: open_alerts(args, config, decisions)?,
            conflicts: open_watch(args, config)?,
            conflict_file: open_conflicts(args)?,
            broadcast: if args.udp { Some((Broadcast::open(config)?, Stop::listen()?)) } else { None },
            summary: ReplaySummary::default(),
            pace: Pace::new(args.speed.unwrap_or(usual)),
            first: None,
            latency: config.fusion.latency_of(args.at),
            is_stopped: false,
            failed: None,
        })
    }

    /// Processes a reception. Returns whether the replay continues: not after a stop request, nor if all further slots are after
    /// `--end`.
    pub(super) fn continues(&mut self, received: Option<Time>) -> Result<bool, io::Error> {
        if let Some(error) = self.failed.take() {
            return Err(error);
        }
        if let (None, Some(first)) = (self.first, received) {
            self.first = Some(first);
            if let Some((broadcast, _)) = &mut self.broadcast {
                broadcast.begin(self.config, first);
            }
        }
        let asked = |(_, stop): &(Broadcast, Stop)| stop.comes_within(Duration::ZERO);
        self.is_stopped |= self.broadcast.as_ref().is_some_and(asked);
        Ok(!self.is_stopped && !self.is_behind_end(received))
    }

    /// Whether the user asked to stop.
    pub(super) fn is_stopped(&self) -> bool {
        self.is_stopped
    }

    /// Processes an event of the received data.
    pub(super) fn note(&mut self, event: &Event, received: Option<Time>) {
        if let (Some((broadcast, _)), Some(received)) = (&mut self.broadcast, received) {
            broadcast.note(event, received);
        }
    }

    pub(super) fn emit(&mut self, emission: Emission) {
        if self.failed.is_some() || self.is_stopped {
            return;
        }
        let foresees_now = self.conflicts.as_ref().is_some_and(|watch| watch.on() == PictureKind::Now);
        let needs_now = self.args.at == PictureKind::Now
            || self.broadcast.is_some()
            || self.alerts.is_some()
            || foresees_now;
        let (lagged, now) = self.series.pictures(emission, needs_now);
        let is_lagged_wanted = self.is_wanted(&lagged);
        if let Some(alerts) = &mut self.alerts {
            let fusion = &self.config.fusion;
            let ahead = match &now {
                Some(now) => Some(PredictionPicture::Now(now)),
                None if fusion.now => None,
                None => Some(PredictionPicture::Lagged(&lagged, fusion.latency() - fusion.slot / 2)),
            };
            self.failed = alerts.note(&lagged, ahead, self.series.maker(), is_lagged_wanted).err();
        }
        let outlook = self.conflicts.as_mut().and_then(|watch| match watch.on() {
            PictureKind::Lagged => watch.look(&lagged, self.series.maker()),
            PictureKind::Now => watch.look(now.as_ref()?, self.series.maker()),
        });
        if let Some(outlook) = outlook {
            self.failed = self.failed.take().or_else(|| self.note_outlook(&outlook).err());
        }
        if self.failed.is_some() {
            return;
        }
        let [lagged, now] = [Some(lagged), now].map(|picture| {
            let mut picture = picture?;
            picture.keep_within(self.config.output.max_accuracy_m);
            Some(picture)
        });
        let picture = match self.args.at {
            PictureKind::Lagged => lagged.as_ref(),
            PictureKind::Now => now.as_ref(),
        };
        let Some(picture) = picture.filter(|picture| self.is_wanted(picture)) else { return };
        if let Some((_, stop)) = &self.broadcast {
            self.is_stopped = stop.comes_within(self.pace.due_in(picture.time));
            if self.is_stopped {
                return;
            }
        } else {
            self.pace.wait_for(picture.time);
        }
        self.summary.count(picture);
        if let (Some((broadcast, _)), Some(lagged)) = (&mut self.broadcast, &lagged) {
            broadcast.send(lagged, now.as_ref());
        }
        if let Some(writer) = &mut self.output {
            self.failed = writer
                .write(picture, self.series.maker())
                .map_err(|error| unwritten(self.args, &error))
                .err();
        }
    }

    fn note_outlook(&mut self, outlook: &Outlook) -> io::Result<()> {
        let is_wanted = self.is_time_wanted(outlook.time);
        if let Some(alerts) = &mut self.alerts
            && self.config.predicts_conflicts()
        {
            alerts.note_outlook(outlook, is_wanted)?;
        }
        let Some(file) = self.conflict_file.as_mut().filter(|_| is_wanted) else { return Ok(()) };
        outlook.conflicts.iter().try_for_each(|conflict| file.write(&ConflictLine::from(conflict)))
    }

    /// Prepares for a repetition of the recording.
    pub(super) fn restart(&mut self) {
        self.first = None;
        self.series = self.initial.clone();
        self.summary = ReplaySummary::default();
        self.pace.restart(self.config.fusion.slot.unsigned_abs());
    }

    /// Completes the output. Returns the number of datagrams that could not be sent.
    pub(super) fn finish(self) -> Result<u64, io::Error> {
        if let Some(error) = self.failed {
            return Err(error);
        }
        if let Some(alerts) = self.alerts {
            alerts.finish()?;
        }
        if let Some(file) = self.conflict_file {
            file.finish()?;
        }
        if let Some(writer) = self.output {
            writer.finish().map_err(|error| unwritten(self.args, &error))?;
        }
        Ok(self.broadcast.map_or(0, |(broadcast, _)| broadcast.failed()))
    }

    fn is_wanted(&self, picture: &Picture) -> bool {
        self.is_time_wanted(picture.time)
    }

    fn is_time_wanted(&self, time: Time) -> bool {
        let Some(first) = self.first else { return true };
        let at = |moment: Option<TimeArgument>| moment.map(|moment| moment.resolve(first));
        at(self.args.start).is_none_or(|start| start <= time)
            && at(self.args.end).is_none_or(|end| time < end)
    }

    /// Whether every wanted slot was due before this reception.
    fn is_behind_end(&self, received: Option<Time>) -> bool {
        let (Some(first), Some(end), Some(received)) = (self.first, self.args.end, received) else {
            return false;
        };
        received > end.resolve(first) + self.latency
    }
}

/// Adds the name of the file to an error; a closed pipe stays one.
fn unwritten(args: &Args, error: &io::Error) -> io::Error {
    let file = args.output.as_deref().unwrap_or(Path::new("-"));
    io::Error::new(error.kind(), format!("{}: cannot be written: {error}", file.display()))
}

/// Creates the file of `--alerts`.
fn open_alerts(
    args: &Args,
    config: &Config,
    decisions: Vec<AlertDecision>,
) -> Result<Option<AlertFile>, AppError> {
    let Some(path) = &args.alerts else { return Ok(None) };
    refuse_input("--alerts", path, args)?;
    Ok(Some(AlertFile::create(path, config, decisions)?))
}

/// Conflict detection, if `--conflicts` or `--alerts` needs it.
fn open_watch(args: &Args, config: &Config) -> Result<Option<ConflictWatch>, Usage> {
    if args.conflicts.is_none() {
        return Ok(ConflictWatch::of(config).filter(|_| args.alerts.is_some()));
    }
    if config.fusion.profile == Profile::Reference {
        return Err(Usage(
            "--conflicts: the reference profile knows no velocities to look ahead with".to_owned(),
        ));
    }
    if config.conflicts.picture == PictureKind::Now && !config.fusion.now {
        return Err(Usage(
            "--conflicts: fusion.now is off; set it, or conflicts.picture = \"lagged\"".to_owned(),
        ));
    }
    Ok(Some(ConflictWatch::new(config)))
}

/// Creates the file of `--conflicts`.
fn open_conflicts(args: &Args) -> Result<Option<LineFile>, AppError> {
    let Some(path) = &args.conflicts else { return Ok(None) };
    refuse_input("--conflicts", path, args)?;
    Ok(Some(LineFile::create(path)?))
}

/// Refuses an output file that is an input.
fn refuse_input(option: &str, path: &Path, args: &Args) -> Result<(), Usage> {
    let same = |input: &PathBuf| std::fs::canonicalize(input).ok() == std::fs::canonicalize(path).ok();
    if path.exists() && args.inputs.iter().any(same) {
        return Err(Usage(format!("{option} {} is also an input: it would be overwritten", path.display())));
    }
    Ok(())
}

/// Creates the file of `-o`.
fn open_output(args: &Args, config: &Config) -> Result<Option<PicturesWriter>, AppError> {
    let Some(path) = &args.output else {
        return match args.output_format {
            Some(_) => {
                Err(Usage("--output-format needs -o FILE, or -o - for standard output".to_owned()).into())
            }
            None => Ok(None),
        };
    };
    let format = args.output_format.or_else(|| OutputFormat::of(path)).ok_or_else(|| {
        Usage(format!(
            "-o {}: the extension is none of .ast .pcap .ndjson .geojson .csv .parquet .mcap; name one with --output-format",
            path.display()
        ))
    })?;
    refuse_input("-o", path, args)?;
    if format == OutputFormat::Parquet {
        super::check_parquet()?;
    }
    let out: Box<dyn Write + Send> = if path == Path::new("-") {
        Box::new(BufWriter::new(io::stdout()))
    } else {
        #[expect(clippy::disallowed_methods, reason = "the file that -o names")]
        let file =
            File::create(path).map_err(|error| format!("{}: cannot be written: {error}", path.display()))?;
        Box::new(BufWriter::with_capacity(1 << 16, file))
    };
    Ok(Some(PictureWriter::new(format, out, config, args.at)?))
}
