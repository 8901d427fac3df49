//! `replay`: captured files through the engine.

use std::collections::BTreeSet;
use std::error::Error;
use std::io::{self, IsTerminal, Write};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use indicatif::ProgressBar;
use jiff::civil::Date;
use tracing::{error, info, warn};

use super::address::listen_address;
use super::moment::{Moment, Speed, day};
use super::stage::Stage;
use super::summary::registered;
use super::unmatched::unmatched;
use super::{CommandResult, Outcome, Usage, progress};
use crate::areas::Masks;
use crate::capture::{Capture, Format, Merged, OpenError, Reception, TrailerRules};
use crate::config::{Config, Profile};
use crate::formats::OutputFormat;
use crate::picture::PictureMaker;
use crate::pipeline::{Event, Output, Pipeline};
use crate::state::{SavedState, read_beside, read_kept, read_numbers_beside};

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
    /// How many times faster than it happened; `max`: as fast as it goes. By default max, with --udp or --serve 1.
    #[arg(long, value_name = "N|max")]
    pub speed: Option<Speed>,
    /// No output before this time of the flight: 2026-11-20T10:00:00Z, 10:00:00 or +90s.
    #[arg(long, value_name = "T")]
    pub start: Option<Moment>,
    /// No output from this time of the flight on.
    #[arg(long, value_name = "T")]
    pub end: Option<Moment>,
    /// UTC day of the first record of each file that does not say its day (raw ASTERIX, FINAL).
    /// Without it their times are dated from 1970-01-01 on, and a warning says so.
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = day)]
    pub date: Option<Date>,
    /// Begins with the transponder numbers and the radars' registration that the service has kept in this directory (`[state]
    /// dir`), or that stand beside a recording: `input-<start>`, for its `.numbers.json` and `.registration.json`; then what was
    /// decided by hand (`.decisions.jsonl`, of each input) is decided again. It is only read.
    #[arg(long, value_name = "DIR")]
    pub state: Option<PathBuf>,
    /// Sends the output as the service would, CAT129 and CAT065 to `[output] asterix`, in real time; Ctrl-C ends it. The
    /// times in it are those of the recording.
    #[arg(long)]
    pub udp: bool,
    /// Begins again at the end, with --udp or --serve, until Ctrl-C. The times are those of the recording each time: they
    /// step back where it begins again.
    #[arg(long = "loop")]
    pub again: bool,
    /// Serves the API and the map of it, until Ctrl-C; it can be paused, sped up, and taken to another time.
    #[arg(long, conflicts_with_all = ["output", "start", "end", "stats", "udp"])]
    pub serve: bool,
    /// Where --serve listens, instead of the configuration's http.listen: 127.0.0.1:8080, or only a port of this machine.
    #[arg(long, value_name = "ADDR", requires = "serve", value_parser = listen_address)]
    pub http: Option<SocketAddr>,
    /// Adds how long it took to the summary, and prints it to standard error where standard output holds data.
    #[arg(long)]
    pub stats: bool,
}

impl Args {
    /// The day on which files begin that do not say theirs; where none is given and one needs it, a warning is logged.
    pub(super) fn day_of(&self, captures: &[Capture]) -> Date {
        self.date.unwrap_or_else(|| {
            for capture in captures.iter().filter(|capture| capture.format().is_asterix_only()) {
                warn!(
                    "{}: a {} does not say on which day it was made: its times are dated from {UNDATED} on; give the day \
                     of its first record: --date YYYY-MM-DD",
                    capture.name(),
                    capture.format()
                );
            }
            UNDATED
        })
    }
}

/// Runs the command; the summary goes to `stdout` unless the output does.
pub fn run(args: &Args) -> CommandResult {
    check(args)?;
    let mut config = Config::load(&args.config)?;
    if let Some(name) = &args.profile {
        let profile = name.parse::<Profile>();
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
        return super::serve::replay(args, Arc::new(config), masks, speed);
    }
    let trailers = TrailerRules::of(&config);
    let captures = open(args, &trailers)?;
    let day = args.day_of(&captures);
    let maker = PictureMaker::new(&config, Pipeline::new(&config, masks.clone()).normaliser());
    let mut stage = Stage::open(args, &config, maker)?;
    let to_stdout = args.output.as_deref() == Some(Path::new("-"));
    let SavedState { numbers, registrations, correlations } = kept(args)?;
    let plan = correlations.plan(&config);
    plan.unused.iter().for_each(|unused| warn!("{unused}"));

    #[expect(clippy::disallowed_methods, reason = "how long it took")]
    let started = Instant::now();
    let pass = |stage: &mut Stage<'_>, captures| {
        let mut pipeline = Pipeline::new(&config, masks.clone());
        if args.state.is_none() {
            pipeline.engine_mut().keep_numbers_for_good();
        }
        let engine = pipeline.engine_mut();
        let refused = numbers.iter().filter(|&&given| !engine.remember(given)).count();
        if refused > 0 {
            warn!("{refused} numbers of --state contradict others and are given anew");
        }
        registrations.restore(&config, None, engine).iter().for_each(|unused| warn!("{unused}"));
        engine.plan(plan.correlated.clone());
        engine.resume(plan.kept.clone());
        let mut replay =
            Replay { pipeline, stage, warnings: 0, bar: None, unread: false, skipped: String::new() };
        let outcome = replay.run(captures, day)?;
        Ok::<_, Box<dyn Error + Send + Sync>>((outcome, replay.pipeline, replay.skipped))
    };
    let (mut outcome, mut pipeline, mut skipped) = pass(&mut stage, captures)?;
    // A recording without a slot would go round without a pause.
    while args.again && !stage.is_over() && !stage.summary.is_empty() {
        info!("the recording has come to its end and begins again");
        stage.begin_anew();
        (outcome, pipeline, skipped) = pass(&mut stage, open(args, &trailers)?)?;
    }
    let summary = std::mem::take(&mut stage.summary);
    let failed = stage.finish()?;
    let missed = pipeline.engine().missed();
    if missed > 0 {
        warn!("{missed} decisions of --state are about what was not there");
    }

    let mut text = summary.text(pipeline.tally(), &config)?;
    text += &skipped;
    text += &registered(pipeline.engine(), &config);
    let unnumbered = pipeline.engine().unnumbered();
    if unnumbered > 0 {
        text += &format!("dropped    {unnumbered} points of transponders for which no number was left\n");
    }
    if failed > 0 {
        text += &format!("failed     {failed} datagrams could not be sent\n");
    }
    if args.stats {
        text += &format!("took       {:.3} s\n", started.elapsed().as_secs_f64());
    }
    if !to_stdout {
        io::stdout().write_all(text.as_bytes())?;
    } else if args.stats {
        io::stderr().write_all(text.as_bytes())?;
    }
    if let Some(problem) = unmatched(pipeline.tally(), &config, args) {
        return Err(problem.into());
    }
    Ok(if failed > 0 && outcome == Outcome::Done { Outcome::Incomplete } else { outcome })
}

/// What `--state` names; of a recording in several files also the numbers and the decisions of each.
pub(super) fn kept(args: &Args) -> io::Result<SavedState> {
    let Some(path) = &args.state else { return Ok(SavedState::default()) };
    let mut kept = read_kept(path)?;
    if !path.is_dir() {
        for input in &args.inputs {
            kept.correlations.join(read_beside(input)?);
            // A number that was somebody else's before is his who had it first.
            let (numbers, identities): (BTreeSet<_>, BTreeSet<_>) =
                kept.numbers.iter().map(|given| (given.number, given.identity)).unzip();
            kept.numbers.extend(
                read_numbers_beside(input)?.into_iter().filter(|given| {
                    !numbers.contains(&given.number) && !identities.contains(&given.identity)
                }),
            );
        }
    }
    Ok(kept)
}

pub(super) fn open(args: &Args, trailers: &TrailerRules) -> Result<Vec<Capture>, OpenError> {
    let open = |path: &PathBuf| Ok(Capture::open(path)?.with_trailers(trailers.clone()));
    args.inputs.iter().map(open).collect()
}

/// What makes no sense together.
fn check(args: &Args) -> Result<(), Usage> {
    let refuse = |text: &str| Err(Usage(text.to_owned()));
    if args.again && !args.udp && !args.serve {
        return refuse("--loop needs --udp or --serve: anything else would never end");
    }
    if args.again && args.output.is_some() {
        return refuse("--loop and -o exclude each other: the file would grow without end");
    }
    if (args.again || args.serve) && args.inputs.iter().any(|path| path == Path::new("-")) {
        return refuse(
            "--loop and --serve read the input several times, and standard input cannot be; name a file",
        );
    }
    let is_empty = match (args.start, args.end) {
        (Some(Moment::After(start)), Some(Moment::After(end))) => end <= start,
        (Some(Moment::At(start)), Some(Moment::At(end))) => end <= start,
        // The day of a time of day is known once the recording is read.
        _ => false,
    };
    if is_empty {
        return refuse("--end is not after --start: nothing would come out");
    }
    Ok(())
}

/// A pass through the recording.
struct Replay<'a, 'b> {
    pipeline: Pipeline,
    stage: &'b mut Stage<'a>,
    warnings: u32,
    /// On a terminal.
    bar: Option<ProgressBar>,
    /// Whether octets of a file stayed unread in which there should be nothing else.
    unread: bool,
    /// Lines of the summary.
    skipped: String,
}

/// The day of files that do not say theirs, where none is given: the first of the epoch.
const UNDATED: Date = Date::constant(1970, 1, 1);

/// Warnings that are printed one by one; the rest is only counted.
const WARNINGS_SHOWN: u32 = 20;

impl Replay<'_, '_> {
    fn run(&mut self, captures: Vec<Capture>, date: Date) -> CommandResult {
        for capture in &captures {
            let compressed = if capture.is_compressed() { ", gzip-compressed" } else { "" };
            info!("{}: {}{compressed}", capture.name(), capture.format());
        }
        let total = captures.iter().map(Capture::size).sum::<Option<u64>>();
        self.bar = io::stderr().is_terminal().then(|| progress::bar(total));
        let mut merged = Merged::new(captures, date);
        let mut outcome = Outcome::Done;
        let mut count: u64 = 0;
        while let Some(next) = merged.next() {
            match next {
                Ok(reception) => {
                    if !self.stage.goes_on(reception.received)? {
                        break;
                    }
                    self.receive(&reception, &merged);
                }
                Err(damage) => {
                    error!("{damage}");
                    outcome = Outcome::InputUnreadable;
                }
            }
            count += 1;
            if let Some(bar) = &self.bar
                && count.is_multiple_of(256)
            {
                bar.set_position(merged.captures().map(Capture::consumed).sum());
            }
        }
        let Self { pipeline, stage, bar, .. } = self;
        pipeline.finish();
        pipeline.emissions().for_each(|emission| stage.emit(emission));
        if let Some(bar) = bar {
            bar.finish_and_clear();
        }
        for capture in merged.captures().filter(|capture| capture.skipped().total() > 0) {
            info!("{}: frames without a whole UDP datagram: {}", capture.name(), capture.skipped());
        }
        for capture in merged.captures() {
            capture.trailers().for_each(|trailer| info!("{}: {trailer}", capture.name()));
        }
        for capture in merged.captures().filter(|capture| !capture.gaps().is_empty()) {
            let (name, gaps) = (capture.name(), capture.gaps());
            warn!("{name}: {gaps} belong to no block and were skipped");
            self.skipped += &format!("skipped    {gaps} of {name}, which belong to no block\n");
            self.unread = true;
        }
        Ok(if self.unread && outcome == Outcome::Done { Outcome::InputErrors } else { outcome })
    }

    fn receive(&mut self, reception: &Reception, merged: &Merged) {
        let Self { pipeline, stage, warnings, bar, unread, .. } = self;
        pipeline.receive(reception);
        while let Some(output) = pipeline.poll() {
            let event = match output {
                Output::Emission(emission) => {
                    stage.emit(emission);
                    continue;
                }
                Output::Event(event) => event,
            };
            stage.note(&event, reception.received);
            if event.is_warning() {
                *warnings += 1;
                let Some(capture) = merged.captures().nth(reception.input) else { continue };
                *unread |= matches!(event, Event::Faulty { .. }) && *capture.format() == Format::Raw;
                let tell = || report(&event, reception, capture.name(), *warnings);
                // Not into the line of the bar.
                bar.as_ref().map_or_else(tell, |bar| bar.suspend(tell));
            }
        }
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
