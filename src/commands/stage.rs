//! What happens to the pictures of a replay: they are waited for, counted, written, sent.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use jiff::SignedDuration;

use super::Usage;
use super::alert_file::AlertFile;
use super::broadcast::Broadcast;
use super::line_file::LineFile;
use super::moment::{Moment, Speed};
use super::pace::Pace;
use super::replay::args::Args;
use super::summary::Summary;
use crate::app::{Failure, Stop};
use crate::config::{Config, PictureKind, Profile};
use crate::conflicts::{ConflictLine, ConflictWatch, Outlook};
use crate::formats::{OutputFormat, PictureWriter};
use crate::integrity::Lookout;
use crate::live::Ahead;
use crate::picture::{Picture, PictureMaker};
use crate::pipeline::Event;
use crate::state::AlertDecision;
use fusion::Emission;
use fusion::time::Time;

/// What `-o` writes with.
type Writer = PictureWriter<Box<dyn Write + Send>>;

/// Where the pictures go.
pub(super) struct Stage<'a> {
    args: &'a Args,
    config: &'a Config,
    maker: PictureMaker,
    /// As it is at the beginning of the recording, and now.
    at_first: Lookout,
    lookout: Lookout,
    /// With `--alerts`.
    alerts: Option<AlertFile>,
    /// With `--conflicts`, and with `--alerts` where the configuration asks for them.
    conflicts: Option<ConflictWatch>,
    /// With `--conflicts`.
    conflict_file: Option<LineFile>,
    /// With `-o`.
    output: Option<Writer>,
    /// With `--udp`.
    broadcast: Option<(Broadcast, Stop)>,
    pub(super) summary: Summary,
    pace: Pace,
    /// The first reception: what `--start` and `--end` may be relative to.
    first: Option<Time>,
    /// From the opening of a slot to its emission, of the picture that is written.
    latency: SignedDuration,
    is_over: bool,
    failed: Option<io::Error>,
}

impl<'a> Stage<'a> {
    pub(super) fn open(
        args: &'a Args,
        config: &'a Config,
        maker: PictureMaker,
        lookout: Lookout,
        decisions: Vec<AlertDecision>,
    ) -> Result<Self, Failure> {
        let usual = if args.udp { Speed::Times(1.0) } else { Speed::Max };
        Ok(Self {
            args,
            config,
            maker,
            lookout: lookout.clone(),
            at_first: lookout,
            output: open_output(args, config)?,
            alerts: open_alerts(args, config, decisions)?,
            conflicts: open_watch(args, config)?,
            conflict_file: open_conflicts(args)?,
            broadcast: if args.udp { Some((Broadcast::open(config)?, Stop::listen()?)) } else { None },
            summary: Summary::default(),
            pace: Pace::new(args.speed.unwrap_or(usual)),
            first: None,
            latency: config.fusion.latency_of(args.at),
            is_over: false,
            failed: None,
        })
    }

    /// Something is received. Whether the replay goes on; it does not where it was asked to end, or what follows is
    /// behind `--end`.
    pub(super) fn goes_on(&mut self, received: Option<Time>) -> Result<bool, io::Error> {
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
        self.is_over |= self.broadcast.as_ref().is_some_and(asked);
        Ok(!self.is_over && !self.is_behind_end(received))
    }

    /// Whether the user has asked it to end.
    pub(super) fn is_over(&self) -> bool {
        self.is_over
    }

    /// Something happened to what was received.
    pub(super) fn note(&mut self, event: &Event, received: Option<Time>) {
        if let (Some((broadcast, _)), Some(received)) = (&mut self.broadcast, received) {
            broadcast.note(event, received);
        }
    }

    pub(super) fn emit(&mut self, mut emission: Emission) {
        if self.failed.is_some() || self.is_over {
            return;
        }
        let foresees_now = self.conflicts.as_ref().is_some_and(|watch| watch.on() == PictureKind::Now);
        let needs_now = self.args.at == PictureKind::Now
            || self.broadcast.is_some()
            || self.alerts.is_some()
            || foresees_now;
        let mut now = emission.now.take().filter(|_| needs_now).map(|now| self.maker.now(now));
        let mut lagged = self.maker.picture(emission);
        self.lookout.look(&mut lagged, &self.maker);
        if let Some(now) = &mut now {
            now.mark_as(&lagged);
        }
        let is_lagged_wanted = self.is_wanted(&lagged);
        if let Some(alerts) = &mut self.alerts {
            let fusion = &self.config.fusion;
            let ahead = match &now {
                Some(now) => Some(Ahead::Now(now)),
                None if fusion.now => None,
                None => Some(Ahead::Lagged(&lagged, fusion.latency() - fusion.slot / 2)),
            };
            self.failed = alerts.note(&lagged, ahead, &self.maker, is_lagged_wanted).err();
        }
        let outlook = self.conflicts.as_mut().and_then(|watch| match watch.on() {
            PictureKind::Lagged => watch.look(&lagged, &self.maker),
            PictureKind::Now => watch.look(now.as_ref()?, &self.maker),
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
            self.is_over = stop.comes_within(self.pace.due_in(picture.time));
            if self.is_over {
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
            self.failed =
                writer.write(picture, &self.maker).map_err(|error| unwritten(self.args, &error)).err();
        }
    }

    fn note_outlook(&mut self, outlook: &Outlook) -> io::Result<()> {
        let is_wanted = self.is_time_wanted(outlook.time);
        if let Some(alerts) = &mut self.alerts
            && self.config.finds_conflicts()
        {
            alerts.note_outlook(outlook, is_wanted)?;
        }
        let Some(file) = self.conflict_file.as_mut().filter(|_| is_wanted) else { return Ok(()) };
        outlook.conflicts.iter().try_for_each(|conflict| file.write(&ConflictLine::from(conflict)))
    }

    /// The recording is replayed once more.
    pub(super) fn begin_anew(&mut self) {
        self.first = None;
        self.lookout = self.at_first.clone();
        self.summary = Summary::default();
        self.pace.begin_anew(self.config.fusion.slot.unsigned_abs());
    }

    /// Completes the output; how many datagrams could not be sent.
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
        let at = |moment: Option<Moment>| moment.map(|moment| moment.resolve(first));
        at(self.args.start).is_none_or(|start| start <= time)
            && at(self.args.end).is_none_or(|end| time < end)
    }

    /// Whether every slot that is wanted was due before this reception.
    fn is_behind_end(&self, received: Option<Time>) -> bool {
        let (Some(first), Some(end), Some(received)) = (self.first, self.args.end, received) else {
            return false;
        };
        received > end.resolve(first) + self.latency
    }
}

/// With the name of the file; a closed pipe stays one.
fn unwritten(args: &Args, error: &io::Error) -> io::Error {
    let file = args.output.as_deref().unwrap_or(Path::new("-"));
    io::Error::new(error.kind(), format!("{}: cannot be written: {error}", file.display()))
}

/// Opens what `--alerts` names.
fn open_alerts(
    args: &Args,
    config: &Config,
    decisions: Vec<AlertDecision>,
) -> Result<Option<AlertFile>, Failure> {
    let Some(path) = &args.alerts else { return Ok(None) };
    refuse_input("--alerts", path, args)?;
    Ok(Some(AlertFile::create(path, config, decisions)?))
}

/// Who looks for conflicts, where somebody wants to know.
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

/// Opens what `--conflicts` names.
fn open_conflicts(args: &Args) -> Result<Option<LineFile>, Failure> {
    let Some(path) = &args.conflicts else { return Ok(None) };
    refuse_input("--conflicts", path, args)?;
    Ok(Some(LineFile::create(path)?))
}

/// An input is not written.
fn refuse_input(option: &str, path: &Path, args: &Args) -> Result<(), Usage> {
    let same = |input: &PathBuf| std::fs::canonicalize(input).ok() == std::fs::canonicalize(path).ok();
    if path.exists() && args.inputs.iter().any(same) {
        return Err(Usage(format!("{option} {} is also an input: it would be overwritten", path.display())));
    }
    Ok(())
}

/// Opens what `-o` names.
fn open_output(args: &Args, config: &Config) -> Result<Option<Writer>, Failure> {
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
