//! `demo`: a simulated flight through the engine, with a live table in the terminal.

mod http;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::net::SocketAddr;

use jiff::SignedDuration;

use super::address::listen_address;
use super::demo_score::demo_score;
use super::moment::{ReplaySpeed, duration};
use super::pace::Pace;
use super::screen::{TerminalPainter, TerminalSize, wrap};
use super::summary::ReplaySummary;
use super::{CommandResult, Outcome};
use crate::app::AppError;
use fusion::Enu;
use fusion::integrity::PointIntegrity;
use fusion::point::{Association, AssociationEvidence, TransponderPart};
use fusion::time::Time;
use fusion::{Emission, Source};
use input::pipeline::{Output, Pipeline, Tally};
use lab::evaluate::{self, InputsAlone, Labels, Scoring};
use lab::simulate::{Scenario, SimulatedAttack, Simulation, simulate};
use picture::{MAX_ACCURACY_M, Picture, PictureMaker, PictureTrack, serial_text, text};
use site::areas::Masks;

/// Shows the service's main task on a simulated flight: radar and transponders in, one air picture out.
///
/// The default scenario (config/scenarios/crossing.toml) lasts five minutes: ten drones cross at one point, two of them without a
/// transponder, among birds. One transponder starts to report false positions. Choose others with --scenario. In a terminal the
/// table is updated live; otherwise it is printed once a minute of the flight. With --http the flight is sent as multicast on
/// this machine, fused by the live service, and shown on its map.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Serves the live API and the map at this address until Ctrl-C. Default: 127.0.0.1:8080. A port alone is on this machine.
    #[arg(long, value_name = "ADDR", value_parser = listen_address, num_args = 0..=1, default_missing_value = "127.0.0.1:8080")]
    pub http: Option<SocketAddr>,
    /// Duration of the demonstration in a terminal (default 60s), or of the service with --http (default until Ctrl-C).
    #[arg(long, value_name = "DURATION", value_parser = duration)]
    pub duration: Option<SignedDuration>,
    /// Random seed of the flight.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Scenario to simulate.
    #[arg(long, value_enum, default_value_t = DemoFlight::Crossing, value_name = "NAME")]
    pub scenario: DemoFlight,
}

/// Scenarios of the demonstration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum DemoFlight {
    /// Ten drones that cross at one point, seen by a radar.
    Crossing,
    /// An aerodrome without a radar: aircraft with ADS-B, drones with Remote ID, and two drones about to meet.
    Airfield,
    /// A public event: radars, a camera, CAT129, Remote ID, a helicopter with ADS-B, and false identities.
    Event,
}

impl DemoFlight {
    /// Name of the scenario file, and its text.
    const fn file(self) -> (&'static str, &'static str) {
        match self {
            Self::Crossing => {
                ("config/scenarios/crossing.toml", include_str!("../../config/scenarios/crossing.toml"))
            }
            Self::Airfield => {
                ("config/scenarios/airfield.toml", include_str!("../../config/scenarios/airfield.toml"))
            }
            Self::Event => ("config/scenarios/event.toml", include_str!("../../config/scenarios/event.toml")),
        }
    }
}

/// Default duration of the demonstration in a terminal, in seconds.
const SHOW_S: f64 = 60.0;
/// Number of transponders in `crossing` that report false positions.
const LIARS: u32 = 1;
/// Time for which a track stays in the table after its last point, in seconds. The radar misses single detections.
const LINGER_S: f64 = 2.0;
/// Width of the labels in the summary, in characters.
const SUMMARY_INDENT: usize = 11;
/// Size of an output that is not a terminal.
const UNBOUNDED: TerminalSize = TerminalSize { rows: usize::MAX, columns: usize::MAX };
/// Time of the flight between two printed tables if the output is not a terminal, in seconds.
const PRINT_EVERY_S: f64 = 60.0;

/// Runs the command.
pub fn run(args: &Args) -> CommandResult {
    let (file, text) = args.scenario.file();
    let mut scenario = Scenario::parse(text, file)?;
    if args.scenario == DemoFlight::Crossing {
        scenario.drones.spoofed = LIARS;
    }
    if let Some(listen) = args.http {
        return http::serve(scenario, args.seed, listen, args.duration);
    }
    let simulation = simulate(&scenario, args.seed, None)?;
    let config = &simulation.config;
    let live = TerminalSize::of_stdout().is_some();
    let show_s = args.duration.map_or(SHOW_S, |duration| duration.as_secs_f64());
    let speed = if live && show_s > 0.0 {
        ReplaySpeed::Times(scenario.duration_s / show_s)
    } else {
        ReplaySpeed::Max
    };

    let mut pipeline = Pipeline::new(config, Masks::default());
    let mut show = DemoScreen {
        site: &config.site.name,
        latency_s: config.fusion.latency().as_secs_f64(),
        maker: PictureMaker::new(config, pipeline.normaliser()),
        pace: Pace::new(speed),
        summary: ReplaySummary::default(),
        shown: BTreeMap::new(),
        flagged: BTreeMap::new(),
        next_print: None,
        painting: live.then(TerminalPainter::default),
    };
    // A slot is shown with the data received before it was emitted.
    for reception in simulation.receptions() {
        pipeline.receive(&reception);
        show.slots(&mut pipeline)?;
    }
    pipeline.finish();
    show.slots(&mut pipeline)?;

    let liars = simulation.attacks.iter().map(|attack| show.detection_text(attack)).collect::<String>();
    let summary = show.summary.text(pipeline.tally(), config)?;
    let end = format!("\n{summary}\n{liars}\n{}", score(&simulation)?);
    let columns = TerminalSize::of_stdout().map_or(usize::MAX, |size| size.columns);
    io::stdout().write_all(wrap(&end, columns, SUMMARY_INDENT).as_bytes())?;
    Ok(Outcome::Done)
}

/// Scores of the output and of each input alone against the truth of the simulated flight.
fn score(simulation: &Simulation) -> Result<String, AppError> {
    let Simulation { config, labels, .. } = simulation;
    let receptions = || simulation.receptions().map(Ok);
    let points = evaluate::output(receptions(), config, Masks::default())?;
    let alone = InputsAlone::of(receptions(), config, Masks::default())?;
    let labels = Labels::of_site(labels.clone(), config);
    let settings = Scoring::of(config);
    let evaluation = evaluate::evaluate(&simulation.truth(), Some(&labels), &points, Some(&alone), &settings);
    Ok(demo_score(&evaluation, &simulation.attacks, settings.grid))
}

struct DemoScreen<'a> {
    site: &'a str,
    /// Time from the start of a slot to its emission, in seconds.
    latency_s: f64,
    maker: PictureMaker,
    pace: Pace,
    summary: ReplaySummary,
    /// Recent tracks, by source and number.
    shown: BTreeMap<(u8, u32), PictureTrack>,
    /// First slot in which each transponder was flagged, by transponder number.
    flagged: BTreeMap<u32, Time>,
    next_print: Option<f64>,
    /// Screen updates, in a terminal.
    painting: Option<TerminalPainter>,
}

impl DemoScreen<'_> {
    fn slots(&mut self, pipeline: &mut Pipeline) -> io::Result<()> {
        while let Some(output) = pipeline.poll() {
            if let Output::Emission(emission) = output {
                self.slot(emission, pipeline.tally())?;
            }
        }
        Ok(())
    }

    fn slot(&mut self, emission: Emission, tally: &Tally) -> io::Result<()> {
        let mut picture = self.maker.picture(emission);
        picture.keep_within(MAX_ACCURACY_M);
        self.summary.count(&picture);
        self.pace.wait_for(picture.time);
        self.update(&picture);
        let now = picture.time.as_seconds();
        let next = *self.next_print.get_or_insert(now + PRINT_EVERY_S);
        if self.painting.is_some() || now >= next {
            self.next_print = Some(next + PRINT_EVERY_S);
            self.draw(picture.time, tally)?;
        }
        Ok(())
    }

    fn update(&mut self, picture: &Picture) {
        self.shown.retain(|_, track| picture.time.seconds_since(track.time) < LINGER_S);
        for track in &picture.tracks {
            let source = &track.point.source;
            let is_flagged = track.point.integrity.is_some_and(|integrity| integrity.state.is_flagged());
            if let Some(part) = source.transponder().filter(|_| is_flagged) {
                self.flagged.entry(part.number).or_insert(picture.time);
            }
            let rank = u8::from(source.radar().is_none()) * 2 + u8::from(source.transponder().is_none());
            if let Some(part) = source.transponder() {
                // One row per aircraft: a fused track replaces a single-sensor track and vice versa.
                self.shown.retain(|_, other| {
                    other.point.source.transponder().is_none_or(|other| other.number != part.number)
                });
            }
            self.shown.insert((rank, track.point.number), track.clone());
        }
    }

    /// Text of an attack: when it began, and when it was detected.
    fn detection_text(&self, attack: &SimulatedAttack) -> String {
        let SimulatedAttack { id, number, from, .. } = attack;
        let found = match self.flagged.get(number) {
            // Detection counts from the publication of the slot.
            Some(flagged) => {
                format!("{:.0} s later it was flagged", flagged.seconds_since(*from) + self.latency_s)
            }
            None => "it was not flagged".to_owned(),
        };
        format!("The transponder of drone {id} (track {number}) lied from {from} on; {found}.\n")
    }

    fn draw(&mut self, time: Time, tally: &Tally) -> io::Result<()> {
        let size = self.painting.and_then(|_| TerminalSize::of_stdout());
        let lines = self.lines(time, tally, size.unwrap_or(UNBOUNDED));
        let mut out = io::stdout().lock();
        match (&mut self.painting, size) {
            (Some(painting), Some(size)) => out.write_all(painting.paint(&lines, size).as_bytes())?,
            _ => {
                lines.iter().try_for_each(|line| writeln!(out, "{line}"))?;
                writeln!(out)?;
            }
        }
        out.flush()
    }

    /// Lines of the table that fit on the screen.
    fn lines(&self, time: Time, tally: &Tally, size: TerminalSize) -> Vec<String> {
        let mut lines = vec![
            format!("{}  {time}  (shown {} s after it happened)", self.site, self.latency_s),
            format!(
                "{} datagrams received, {} reports used, {} not used",
                tally.received,
                tally.accepted.values().sum::<u64>(),
                tally.dropped(),
            ),
        ];
        let reasons = tally.dropped_by_reason();
        if !reasons.is_empty() {
            let reasons: Vec<_> = reasons.iter().map(|(reason, count)| format!("{count} {reason}")).collect();
            lines.push(format!("not used: {}", reasons.join(", ")));
        }
        lines.push(format!(
            "{:>6}  {:<11}  {:<12}  {:>5}  {:>7}  {:>6}  {:>6}  apart",
            "track", "source", "who", "radar", "bearing", "range", "height",
        ));
        // The cursor takes a line.
        let room = size.rows.saturating_sub(lines.len() + 1);
        let fitting = if self.shown.len() > room { room.saturating_sub(1) } else { self.shown.len() };
        lines.extend(self.shown.values().take(fitting).map(|track| row(track, time, size.columns)));
        if fitting < self.shown.len() {
            lines.push(format!("and {} more; a taller window shows them", self.shown.len() - fitting));
        }
        lines
    }
}

/// A line of the table. The accuracies of radar and transponder are given in as much detail as the width allows.
fn row(track: &PictureTrack, now: Time, columns: usize) -> String {
    let source = &track.point.source;
    let identity_text = source.transponder().map_or("-".to_owned(), identity_text);
    let radar = source.radar().map_or("-".to_owned(), |part| part.track.number.to_string());
    let (bearing_deg, range_m) = bearing_and_range(track.point.position);
    let height = track.altitude_amsl_m.map_or("-".to_owned(), |metres| format!("{metres:.0} m"));
    let flagged = track.point.integrity.filter(|integrity| integrity.state.is_flagged());
    let (apart, more) = match source {
        _ if flagged.is_some() => flagged.as_ref().map(integrity_text).unwrap_or_default(),
        Source::Fused(_, _, Association { distance_m, because }) => {
            let why = match because {
                AssociationEvidence::Ratio { threshold_m, ratio } => format!(
                    " of {threshold_m:.0} m, {:.0} % of {} slots",
                    100.0 * ratio.value(),
                    ratio.co_present
                ),
                AssociationEvidence::Likelihood { score } => format!(", log-likelihood ratio {score:.0}"),
                AssociationEvidence::Manual { .. } => ", decided by hand".to_owned(),
            };
            (format!("{distance_m:.1} m"), why)
        }
        _ if track.time < now => (format!("({:.2} s ago)", now.seconds_since(track.time)), String::new()),
        _ => (String::new(), String::new()),
    };
    let range = format!("{range_m:.0} m");
    let line = format!(
        "{:>6}  {:<11}  {identity_text:<12}  {radar:>5}  {bearing_deg:>6.1}°  {range:>6}  {height:>6}  {apart}",
        // An aircraft without a serial number has ten digits, the last four of which are of no use here.
        source
            .transponder()
            .filter(|part| part.identity.serial().is_none())
            .map_or(track.point.number, |part| part.number),
        track.source_name(),
    );
    let has_room = line.chars().count() + more.chars().count() <= columns;
    if has_room { line + &more } else { line }
}

/// Callsign of a transponder, or the name of its identity.
fn identity_text(part: &TransponderPart) -> String {
    let callsign = text(&part.aircraft.callsign).map(Cow::into_owned);
    callsign.unwrap_or_else(|| serial_text(part.identity))
}

/// Text about a doubtful transponder, and its estimated offset.
fn integrity_text(integrity: &PointIntegrity) -> (String, String) {
    let off = integrity.offset_m.map_or_else(String::new, |metres| format!(", {metres:.0} m off"));
    (integrity.state.name().to_uppercase(), off)
}

/// Bearing in degrees clockwise from north and distance over ground in metres, from the origin.
fn bearing_and_range(position: Enu) -> (f64, f64) {
    let bearing = position.east().atan2(position.north()).to_degrees();
    (bearing.rem_euclid(360.0), position.east().hypot(position.north()))
}
