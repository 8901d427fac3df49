//! `replay`: processes captured files with the engine.

pub mod args;
mod redate;
mod serve;
mod to_inputs;

use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use indicatif::ProgressBar;
use jiff::civil::Date;
use tracing::field::display;
use tracing::{error, error_span, info, warn};

use super::moment::ReplaySpeed;
use super::replay_output::ReplayOutput;
use super::summary::registered;
use super::unmatched::{nothing, unmatched};
use super::{CommandResult, Outcome, Usage, progress};
use crate::app::AppError;
use input::capture::{Capture, CaptureFormat, MergedCaptures, Reception, SiteReceivers, TrailerRules};
use input::pipeline::{Event, NotRestored, Output, Pipeline};
use picture::{PictureMaker, PictureSeries, UncooperativeDetector};
use service::state::{EngineState, SavedState};
use site::areas::Masks;
use site::config::{Config, PictureKind, Profile};

pub use args::Args;

/// Runs the command. The summary is written to `stdout`, unless the output is.
pub fn run(args: &Args) -> CommandResult {
    args.check()?;
    if let Some(site) = args.inputs.iter().find(|input| input.extension().is_some_and(|name| name == "toml"))
    {
        let (site, other) = (site.display(), args.config.display());
        return Err(Usage(format!(
            "{site} is a configuration and no capture: utm-fusion replay CAPTURE --config {site} (--config is {other} now)"
        ))
        .into());
    }
    let mut config = Config::load(&args.config)?;
    if args.to_inputs {
        return to_inputs::send(args, &config);
    }
    if let Some(name) = &args.profile {
        let profile = name.parse::<Profile>();
        let profile = profile.map_err(|error| Usage(format!("--profile {name}: {error}")))?;
        let fusion = config.fusion.with_profile(profile);
        config.fusion = fusion.map_err(|error| Usage(format!("--profile {name}: {error}")))?;
    }
    if args.at == PictureKind::Now && !config.fusion.now {
        return Err(Usage("--at now: fusion.now is off, or the profile is reference".to_owned()).into());
    }
    let masks = Masks::load(&config.areas)?;
    if args.serve {
        let speed = match args.speed {
            None => 1.0,
            Some(ReplaySpeed::Times(times)) => times,
            Some(ReplaySpeed::Max) => {
                return Err(Usage("--serve needs a speed to be seen at: --speed 10".to_owned()).into());
            }
        };
        config.http.listen = args.http.unwrap_or(config.http.listen);
        return serve::serve(args, Arc::new(config), masks, speed);
    }
    let (trailers, receivers) = (TrailerRules::of(&config), SiteReceivers::of(&config));
    let captures = args.open(&trailers, &receivers)?;
    let day = args.day_of(&captures);
    let maker = PictureMaker::new(&config, Pipeline::new(&config, masks.clone()).normaliser());
    let mut detector = UncooperativeDetector::load(&config, masks.clone())?;
    let SavedState { numbers, registrations, correlations, engine } = args.saved_state()?;
    let begun = engine.as_deref().and_then(|octets| begun(octets, &config, &masks, &mut detector));
    let mut plan = correlations.plan(&config);
    let mut replay_output = ReplayOutput::open(
        args,
        &config,
        PictureSeries::new(maker, detector),
        std::mem::take(&mut plan.alerts),
    )?;
    let to_stdout = args.output.as_deref() == Some(Path::new("-"));

    #[expect(clippy::disallowed_methods, reason = "how long it took")]
    let started = Instant::now();
    let pass = |replay_output: &mut ReplayOutput<'_>, captures| {
        let begun = begun.map(|octets| Pipeline::restored(&config, masks.clone(), octets));
        let mut pipeline = match begun {
            Some(begun) => begun?,
            None => {
                let mut pipeline = Pipeline::new(&config, masks.clone());
                if args.state.is_none() {
                    pipeline.engine_mut().keep_numbers_for_good();
                }
                let engine = pipeline.engine_mut();
                let refused = numbers.iter().filter(|&&given| !engine.remember(given)).count();
                if refused > 0 {
                    warn!(numbers = refused, "numbers of --state contradict others and are given anew");
                }
                registrations.restore(&config, None, engine);
                engine.resume(plan.kept.clone());
                pipeline
            }
        };
        pipeline.engine_mut().plan(plan.correlated.clone());
        pipeline.engine_mut().plan_trust_overrides(plan.words.clone());
        pipeline.engine_mut().plan_relocations(plan.relocations.clone());
        let mut replay = ReplayRun {
            pipeline,
            replay_output,
            warnings: 0,
            bar: None,
            unread: false,
            skipped: String::new(),
            frames: Vec::new(),
        };
        let outcome = replay.run(captures, day)?;
        Ok::<_, AppError>((outcome, replay.pipeline, replay.skipped, replay.frames))
    };
    let (mut outcome, mut pipeline, mut skipped, mut frames) = pass(&mut replay_output, captures)?;
    // A recording without a slot would repeat without a pause.
    while args.again && !replay_output.is_stopped() && !replay_output.summary.is_empty() {
        info!("the recording has come to its end and begins again");
        replay_output.restart();
        (outcome, pipeline, skipped, frames) = pass(&mut replay_output, args.open(&trailers, &receivers)?)?;
    }
    let summary = std::mem::take(&mut replay_output.summary);
    let failed = replay_output.finish()?;
    let missed = pipeline.engine().missed();
    if missed > 0 {
        warn!(decisions = missed, "decisions of --state are about what was not there");
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
    let (site, input) =
        (args.config.display(), args.inputs.first().map_or(Path::new("-"), |input| input).display());
    if let Some(problem) = unmatched(pipeline.tally(), &config, &site.to_string(), &input.to_string()) {
        return Err(problem.into());
    }
    // No input is left if `--end` is before the first reception, as the user asked.
    let is_asked = args.end.is_some() && pipeline.tally().received == 0;
    if outcome == Outcome::Done
        && !is_asked
        && let Some(problem) = nothing(pipeline.tally(), &frames.join("; "), &input.to_string())
    {
        return Err(problem.into());
    }
    Ok(if failed > 0 && outcome == Outcome::Done { Outcome::Incomplete } else { outcome })
}

/// Restores the detector from the state at the start of a recording, and returns the octets of the pipeline's state. `None` if the
/// state is from another version or site; this is logged.
fn begun<'a>(
    octets: &'a [u8],
    config: &Config,
    masks: &Masks,
    detector: &mut UncooperativeDetector,
) -> Option<&'a [u8]> {
    let state = EngineState::parse(octets).ok_or(NotRestored::Unreadable);
    let state = state.and_then(|state| {
        Pipeline::restored(config, masks.clone(), state.pipeline)?;
        Ok(state)
    });
    match state {
        Ok(EngineState { pipeline, detector: watched }) => {
            detector.restore(watched);
            Some(pipeline)
        }
        Err(error) => {
            warn!(%error, "the state that the recording begins with cannot be used: numbers and registration alone");
            None
        }
    }
}

/// One pass through the recording.
struct ReplayRun<'a, 'b> {
    pipeline: Pipeline,
    replay_output: &'b mut ReplayOutput<'a>,
    warnings: u32,
    /// Progress bar, on a terminal.
    bar: Option<ProgressBar>,
    /// Whether octets of a file that should contain only ASTERIX could not be read.
    unread: bool,
    /// Lines of the summary about skipped data.
    skipped: String,
    /// Frames without a datagram, by reason, for each input.
    frames: Vec<String>,
}

/// Maximum number of warnings that are printed one by one; further ones are counted.
const WARNINGS_SHOWN: u32 = 20;

impl ReplayRun<'_, '_> {
    fn run(&mut self, captures: Vec<Capture>, date: Date) -> CommandResult {
        for capture in &captures {
            let (capture, format, gzip) = (capture.name(), capture.format(), capture.is_compressed());
            info!(capture, format = format.to_string(), gzip, "input");
        }
        let total = captures.iter().map(Capture::size).sum::<Option<u64>>();
        self.bar = io::stderr().is_terminal().then(|| progress::bar(total));
        let mut merged =
            MergedCaptures::new(captures, date).with_editions(self.pipeline.normaliser().editions());
        let mut outcome = Outcome::Done;
        let mut count: u64 = 0;
        while let Some(next) = merged.next() {
            match next {
                Ok(reception) => {
                    if !self.replay_output.continues(reception.received)? {
                        break;
                    }
                    self.receive(&reception, &merged);
                }
                Err(damage) => {
                    error!(%damage, "an input cannot be read on");
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
        let Self { pipeline, replay_output, bar, .. } = self;
        pipeline.finish();
        pipeline.emissions().for_each(|emission| replay_output.emit(emission));
        if let Some(bar) = bar {
            bar.finish_and_clear();
        }
        for capture in merged.captures().filter(|capture| capture.skipped().total() > 0) {
            info!(capture = capture.name(), frames = %capture.skipped(), "frames without a whole UDP datagram");
            self.frames.push(capture.skipped().to_string());
        }
        for capture in merged.captures() {
            for trailer in capture.trailers() {
                info!(capture = capture.name(), %trailer, "datagrams have a trailer");
            }
        }
        for capture in merged.captures().filter(|capture| !capture.gaps().is_empty()) {
            let (name, gaps) = (capture.name(), capture.gaps());
            warn!(capture = name, octets = %gaps, "octets that belong to no block were skipped");
            self.skipped += &format!("skipped    {gaps} of {name}, which belong to no block\n");
            self.unread = true;
        }
        Ok(if self.unread && outcome == Outcome::Done { Outcome::InputErrors } else { outcome })
    }

    fn receive(&mut self, reception: &Reception, merged: &MergedCaptures) {
        let Self { pipeline, replay_output, warnings, bar, unread, .. } = self;
        pipeline.receive(reception);
        while let Some(output) = pipeline.poll() {
            let event = match output {
                Output::Emission(emission) => {
                    replay_output.emit(emission);
                    continue;
                }
                Output::Event(event) => event,
            };
            replay_output.note(&event, reception.received);
            if event.is_warning() {
                *warnings += 1;
                let Some(capture) = merged.captures().nth(reception.input) else { continue };
                *unread |= matches!(event, Event::Faulty { .. })
                    && capture.format().is_asterix_only()
                    && *capture.format() != CaptureFormat::Final;
                let tell = || report(&event, reception, capture.name(), *warnings);
                // Printed above the progress bar, not into its line.
                bar.as_ref().map_or_else(tell, |bar| bar.suspend(tell));
            }
        }
    }
}

/// Reports a fault with its file and position.
fn report(event: &Event, reception: &Reception, capture: &str, number: u32) {
    if number > WARNINGS_SHOWN {
        if number == WARNINGS_SHOWN + 1 {
            warn!("more warnings are only counted");
        }
        return;
    }
    let mut event = *event;
    if let Event::Faulty { fault } = &mut event {
        // The operator looks up the offset in the file.
        fault.offset += reception.origin as usize;
    }
    let received = reception.received.map(display);
    error_span!("input", capture, received).in_scope(|| event.log());
}
