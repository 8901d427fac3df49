//! `replay`: captured files through the engine.

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

use super::moment::Speed;
use super::stage::Stage;
use super::summary::registered;
use super::unmatched::{nothing, unmatched};
use super::{CommandResult, Outcome, Usage, progress};
use crate::app::Failure;
use crate::areas::Masks;
use crate::capture::{Capture, Format, Merged, Receivers, Reception, TrailerRules};
use crate::config::{Config, PictureKind, Profile};
use crate::integrity::Lookout;
use crate::picture::PictureMaker;
use crate::pipeline::{Event, NotRestored, Output, Pipeline};
use crate::state::{EngineState, SavedState};

pub use args::Args;

/// Runs the command; the summary goes to `stdout` unless the output does.
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
            Some(Speed::Times(times)) => times,
            Some(Speed::Max) => {
                return Err(Usage("--serve needs a speed to be seen at: --speed 10".to_owned()).into());
            }
        };
        config.http.listen = args.http.unwrap_or(config.http.listen);
        return serve::serve(args, Arc::new(config), masks, speed);
    }
    let (trailers, receivers) = (TrailerRules::of(&config), Receivers::of(&config));
    let captures = args.open(&trailers, &receivers)?;
    let day = args.day_of(&captures);
    let maker = PictureMaker::new(&config, Pipeline::new(&config, masks.clone()).normaliser());
    let mut lookout = Lookout::load(&config, masks.clone())?;
    let SavedState { numbers, registrations, correlations, engine } = args.saved_state()?;
    let begun = engine.as_deref().and_then(|octets| begun(octets, &config, &masks, &mut lookout));
    let mut plan = correlations.plan(&config);
    let mut stage = Stage::open(args, &config, maker, lookout, std::mem::take(&mut plan.alerts))?;
    let to_stdout = args.output.as_deref() == Some(Path::new("-"));

    #[expect(clippy::disallowed_methods, reason = "how long it took")]
    let started = Instant::now();
    let pass = |stage: &mut Stage<'_>, captures| {
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
        pipeline.engine_mut().plan_words(plan.words.clone());
        let mut replay = Replay {
            pipeline,
            stage,
            warnings: 0,
            bar: None,
            unread: false,
            skipped: String::new(),
            frames: Vec::new(),
        };
        let outcome = replay.run(captures, day)?;
        Ok::<_, Failure>((outcome, replay.pipeline, replay.skipped, replay.frames))
    };
    let (mut outcome, mut pipeline, mut skipped, mut frames) = pass(&mut stage, captures)?;
    // A recording without a slot would go round without a pause.
    while args.again && !stage.is_over() && !stage.summary.is_empty() {
        info!("the recording has come to its end and begins again");
        stage.begin_anew();
        (outcome, pipeline, skipped, frames) = pass(&mut stage, args.open(&trailers, &receivers)?)?;
    }
    let summary = std::mem::take(&mut stage.summary);
    let failed = stage.finish()?;
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
    // An end before the first reception leaves nothing to read, which is what was asked for.
    let is_asked = args.end.is_some() && pipeline.tally().received == 0;
    if outcome == Outcome::Done
        && !is_asked
        && let Some(problem) = nothing(pipeline.tally(), &frames.join("; "), &input.to_string())
    {
        return Err(problem.into());
    }
    Ok(if failed > 0 && outcome == Outcome::Done { Outcome::Incomplete } else { outcome })
}

/// The pipeline as it was when the recording began, as octets; the lookout is then, too. `None`, which is logged: they are of
/// another version or site.
fn begun<'a>(octets: &'a [u8], config: &Config, masks: &Masks, lookout: &mut Lookout) -> Option<&'a [u8]> {
    let state = EngineState::parse(octets).ok_or(NotRestored::Unreadable);
    let state = state.and_then(|state| {
        Pipeline::restored(config, masks.clone(), state.pipeline)?;
        Ok(state)
    });
    match state {
        Ok(EngineState { pipeline, lookout: watched }) => {
            lookout.go_on(watched);
            Some(pipeline)
        }
        Err(error) => {
            warn!(%error, "the state that the recording begins with cannot be used: numbers and registration alone");
            None
        }
    }
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
    /// Frames without a datagram, by reason, of each input.
    frames: Vec<String>,
}

/// Warnings that are printed one by one; the rest is only counted.
const WARNINGS_SHOWN: u32 = 20;

impl Replay<'_, '_> {
    fn run(&mut self, captures: Vec<Capture>, date: Date) -> CommandResult {
        for capture in &captures {
            let (capture, format, gzip) = (capture.name(), capture.format(), capture.is_compressed());
            info!(capture, format = format.to_string(), gzip, "input");
        }
        let total = captures.iter().map(Capture::size).sum::<Option<u64>>();
        self.bar = io::stderr().is_terminal().then(|| progress::bar(total));
        let mut merged = Merged::new(captures, date).with_editions(self.pipeline.normaliser().editions());
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
        let Self { pipeline, stage, bar, .. } = self;
        pipeline.finish();
        pipeline.emissions().for_each(|emission| stage.emit(emission));
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
                *unread |= matches!(event, Event::Faulty { .. })
                    && capture.format().is_asterix_only()
                    && *capture.format() != Format::Final;
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
            warn!("more warnings are only counted");
        }
        return;
    }
    let mut event = *event;
    if let Event::Faulty { fault } = &mut event {
        // The operator looks for it in the file.
        fault.offset += reception.origin as usize;
    }
    let received = reception.received.map(display);
    error_span!("input", capture, received).in_scope(|| event.log());
}
