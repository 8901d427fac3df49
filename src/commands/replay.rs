//! `replay`: captured files through the engine.

use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use indicatif::ProgressBar;
use jiff::SignedDuration;
use jiff::civil::Date;
use tracing::{error, info, warn};

use super::moment::{Moment, Speed, day};
use super::pace::Pace;
use super::summary::Summary;
use super::{CommandResult, Outcome, Usage, progress};
use crate::areas::Masks;
use crate::config::{Config, Profile};
use crate::fusion::Emission;
use crate::ingest::{Capture, Merged, Reception};
use crate::picture::{Picture, PictureMaker};
use crate::pipeline::{Event, Output, Pipeline};
use crate::publish::{OutputFormat, PictureWriter};
use crate::time::Time;

/// Replays captured files through the same engine as the live service.
///
/// The same input gives the same bytes, at any speed. Without -o a summary is printed.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Captures: raw ASTERIX, pcap, pcapng or FINAL, gzip-compressed or not, recognised by content; `-` is standard input.
    /// Several are merged by reception time.
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// The site's configuration.
    #[arg(long, value_name = "FILE")]
    pub config: PathBuf,
    /// Where the output goes; `-` is standard output. The extension tells the format: .ast .pcap .ndjson .geojson .csv.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// The output's format, where the extension does not tell.
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub output_format: Option<OutputFormat>,
    /// The engine's profile, instead of the configuration's.
    #[arg(long, value_name = "PROFILE")]
    pub profile: Option<String>,
    /// How many times faster than it happened; `max`: as fast as it goes. By default max, with --serve 1.
    #[arg(long, value_name = "N|max")]
    pub speed: Option<Speed>,
    /// No output before this time of the flight: 2026-11-20T10:00:00Z, 10:00:00 or +90s.
    #[arg(long, value_name = "T")]
    pub start: Option<Moment>,
    /// No output from this time of the flight on.
    #[arg(long, value_name = "T")]
    pub end: Option<Moment>,
    /// UTC day of the first record of each file that does not say its day (raw ASTERIX, FINAL).
    #[arg(long, default_value = "1970-01-01", value_name = "YYYY-MM-DD", value_parser = day)]
    pub date: Date,
    /// Begins with the transponder numbers that the service has kept in this directory (`[state] dir`), or that stand in this
    /// file (`….numbers.json` of a recording). It is only read.
    #[arg(long, value_name = "DIR")]
    pub state: Option<PathBuf>,
    /// Serves the API and the map of it, until Ctrl-C; it can be paused, sped up, and taken to another time.
    #[arg(long, conflicts_with_all = ["output", "start", "end", "stats"])]
    pub serve: bool,
    /// Where --serve listens, instead of the configuration's http.listen.
    #[arg(long, value_name = "ADDR", requires = "serve")]
    pub http: Option<SocketAddr>,
    /// Adds how long it took to the summary, and prints it to standard error where standard output holds data.
    #[arg(long)]
    pub stats: bool,
}

/// Runs the command; the summary goes to `stdout` unless the output does.
pub fn run(args: &Args) -> CommandResult {
    let mut config = Config::load(&args.config)?;
    if let Some(name) = &args.profile {
        let profile = name.parse::<Profile>().and_then(Profile::supported);
        config.fusion.profile = profile.map_err(|error| Usage(format!("--profile {name}: {error}")))?;
    }
    let masks = Masks::load(&config.areas)?;
    if args.serve {
        let speed = match args.speed {
            None => 1.0,
            Some(Speed::Times(times)) => times,
            Some(Speed::Max) => {
                return Err(Usage("--serve needs a speed to be seen at: --speed 10".to_owned()).into());
            }
        };
        config.http.listen = args.http.unwrap_or(config.http.listen);
        return super::serve::replay(args.inputs.clone(), args.date, Arc::new(config), masks, speed);
    }
    let captures = args.inputs.iter().map(|path| Capture::open(path)).collect::<Result<Vec<_>, _>>()?;
    let output = Destination::open(args, &config)?;
    let to_stdout = args.output.as_deref() == Some(Path::new("-"));

    #[expect(clippy::disallowed_methods, reason = "how long it took")]
    let started = Instant::now();
    let mut replay = Replay::new(args, &config, masks, output);
    if let Some(state) = &args.state {
        let numbers = crate::state::read_numbers(state)?;
        let refused = numbers.iter().filter(|&&given| !replay.pipeline.remember(given)).count();
        if refused > 0 {
            warn!("{}: {refused} numbers contradict others and are given anew", state.display());
        }
    }
    let outcome = replay.run(captures)?;
    let (summary, pipeline) = replay.finish()?;

    let mut text = summary.text(pipeline.tally(), &config)?;
    let unnumbered = pipeline.engine().unnumbered();
    if unnumbered > 0 {
        text += &format!("dropped    {unnumbered} points of transponders for which no number was left\n");
    }
    if args.stats {
        text += &format!("took       {:.3} s\n", started.elapsed().as_secs_f64());
    }
    if !to_stdout {
        io::stdout().write_all(text.as_bytes())?;
    } else if args.stats {
        io::stderr().write_all(text.as_bytes())?;
    }
    Ok(outcome)
}

/// Where pictures are written; nowhere without `-o`.
struct Destination(Option<PictureWriter<Box<dyn Write>>>);

impl Destination {
    fn open(args: &Args, config: &Config) -> Result<Self, Box<dyn std::error::Error + Send + Sync>> {
        let Some(path) = &args.output else {
            return match args.output_format {
                Some(_) => {
                    Err(Usage("--output-format needs -o FILE, or -o - for standard output".to_owned()).into())
                }
                None => Ok(Self(None)),
            };
        };
        let format = args.output_format.or_else(|| OutputFormat::of(path)).ok_or_else(|| {
            Usage(format!(
                "-o {}: the extension is none of .ast .pcap .ndjson .geojson .csv; name one with --output-format",
                path.display()
            ))
        })?;
        let same = |input: &PathBuf| std::fs::canonicalize(input).ok() == std::fs::canonicalize(path).ok();
        if path.exists() && args.inputs.iter().any(same) {
            return Err(
                Usage(format!("-o {} is also an input: it would be overwritten", path.display())).into()
            );
        }
        let out: Box<dyn Write> = if path == Path::new("-") {
            Box::new(BufWriter::new(io::stdout().lock()))
        } else {
            #[expect(clippy::disallowed_methods, reason = "the file that -o names")]
            let file = File::create(path)
                .map_err(|error| format!("{}: cannot be written: {error}", path.display()))?;
            Box::new(BufWriter::with_capacity(1 << 16, file))
        };
        Ok(Self(Some(PictureWriter::new(format, out, config)?)))
    }
}

struct Replay<'a> {
    args: &'a Args,
    pipeline: Pipeline,
    stage: Stage<'a>,
    warnings: u32,
    /// On a terminal.
    bar: Option<ProgressBar>,
}

/// What happens to an emission.
struct Stage<'a> {
    args: &'a Args,
    maker: PictureMaker,
    output: Destination,
    summary: Summary,
    pace: Pace,
    /// The first reception: what `--start` and `--end` may be relative to.
    first: Option<Time>,
    /// From the opening of a slot to its emission.
    latency: SignedDuration,
    failed: Option<io::Error>,
}

/// Warnings that are printed one by one; the rest is only counted.
const WARNINGS_SHOWN: u32 = 20;

impl<'a> Replay<'a> {
    fn new(args: &'a Args, config: &Config, masks: Masks, output: Destination) -> Self {
        let pipeline = Pipeline::new(config, masks);
        let stage = Stage {
            args,
            maker: PictureMaker::new(config, pipeline.normaliser()),
            output,
            summary: Summary::default(),
            pace: Pace::new(args.speed.unwrap_or(Speed::Max)),
            first: None,
            latency: config.fusion.latency(),
            failed: None,
        };
        Self { args, pipeline, stage, warnings: 0, bar: None }
    }

    fn run(&mut self, captures: Vec<Capture>) -> CommandResult {
        for capture in &captures {
            let compressed = if capture.is_compressed() { ", gzip-compressed" } else { "" };
            info!("{}: {}{compressed}", capture.name(), capture.format());
        }
        let total = captures.iter().map(Capture::size).sum::<Option<u64>>();
        self.bar = io::stderr().is_terminal().then(|| progress::bar(total));
        let mut merged = Merged::new(captures, self.args.date);
        let mut outcome = Outcome::Done;
        let mut count: u64 = 0;
        while let Some(next) = merged.next() {
            match next {
                Ok(reception) => {
                    if self.stage.ended(reception.received) {
                        break;
                    }
                    self.receive(&reception, &merged);
                }
                Err(damage) => {
                    error!("{damage}");
                    outcome = Outcome::InputUnreadable;
                }
            }
            if let Some(error) = self.stage.failed.take() {
                return Err(error.into());
            }
            count += 1;
            if let Some(bar) = &self.bar
                && count.is_multiple_of(256)
            {
                bar.set_position(merged.captures().map(Capture::consumed).sum());
            }
        }
        let Self { pipeline, stage, bar, .. } = self;
        pipeline.finish(|emission| stage.emit(emission));
        if let Some(bar) = bar {
            bar.finish_and_clear();
        }
        for capture in merged.captures().filter(|capture| capture.skipped().total() > 0) {
            info!("{}: frames without a whole UDP datagram: {}", capture.name(), capture.skipped());
        }
        Ok(outcome)
    }

    fn receive(&mut self, reception: &Reception, merged: &Merged) {
        let Self { pipeline, stage, warnings, bar, .. } = self;
        if stage.first.is_none() {
            stage.first = reception.received;
        }
        pipeline.receive(reception, |output| match output {
            Output::Emission(emission) => stage.emit(emission),
            Output::Event(event) if event.is_warning() => {
                *warnings += 1;
                let capture = merged.captures().nth(reception.input).map_or("", Capture::name);
                let tell = || report(&event, reception, capture, *warnings);
                // Not into the line of the bar.
                bar.as_ref().map_or_else(tell, |bar| bar.suspend(tell));
            }
            Output::Event(_) => {}
        });
    }

    fn finish(self) -> Result<(Summary, Pipeline), io::Error> {
        if let Some(error) = self.stage.failed {
            return Err(error);
        }
        if let Some(writer) = self.stage.output.0 {
            writer.finish()?;
        }
        Ok((self.stage.summary, self.pipeline))
    }
}

/// Says where in which file something was wrong.
fn report(event: &Event, reception: &Reception, capture: &str, number: u32) {
    if number > WARNINGS_SHOWN {
        if number == WARNINGS_SHOWN + 1 {
            warn!("more like this is only counted");
        }
        return;
    }
    let mut event = *event;
    if let Event::Faulty { fault } = &mut event {
        // The operator looks for it in the file.
        fault.offset += reception.origin as usize;
    }
    match reception.received {
        Some(received) => warn!("{capture}: {received}: {event}"),
        None => warn!("{capture}: {event}"),
    }
}

impl Stage<'_> {
    fn emit(&mut self, emission: Emission) {
        if self.failed.is_some() {
            return;
        }
        let picture = self.maker.picture(emission);
        if !self.is_wanted(&picture) {
            return;
        }
        self.pace.wait_for(picture.time);
        self.summary.count(&picture);
        if let Some(writer) = &mut self.output.0 {
            self.failed = writer.write(&picture, &self.maker).err();
        }
    }

    fn is_wanted(&self, picture: &Picture) -> bool {
        let Some(first) = self.first else { return true };
        let at = |moment: Option<Moment>| moment.map(|moment| moment.resolve(first));
        at(self.args.start).is_none_or(|start| start <= picture.time)
            && at(self.args.end).is_none_or(|end| picture.time < end)
    }

    /// Whether every slot that is wanted was due before this reception.
    fn ended(&self, received: Option<Time>) -> bool {
        let (Some(first), Some(end), Some(received)) = (self.first, self.args.end, received) else {
            return false;
        };
        received > end.resolve(first) + self.latency
    }
}
