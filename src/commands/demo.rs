//! `demo`: a simulated flight through the engine, with a live table in the terminal.

mod http;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::net::SocketAddr;

use jiff::SignedDuration;

use super::address::listen_address;
use super::moment::{Speed, duration};
use super::pace::Pace;
use super::screen::{Painting, Size, broken};
use super::summary::Summary;
use super::verdict::verdict;
use super::{CommandResult, Outcome};
use crate::app::Failure;
use crate::areas::Masks;
use crate::evaluate::{self, InputsAlone, Labels, Scoring};
use crate::picture::{MAX_ACCURACY_M, Picture, PictureMaker, PictureTrack, serial_text, text};
use crate::pipeline::{Output, Pipeline, Tally};
use crate::simulate::{Attacked, Scenario, Simulation, simulate};
use fusion::Enu;
use fusion::integrity::PointIntegrity;
use fusion::point::{Association, Because, TransponderPart};
use fusion::time::Time;
use fusion::{Emission, Source};

/// Shows the main job on a simulated flight: radar and transponders in, one air picture out.
///
/// Ten drones through one point, two of them without a transponder, and birds (config/scenarios/crossing.toml): five
/// minutes, and one of the transponders begins to lie. Others with --scenario. In a terminal the table is live; elsewhere it is printed once a minute of the flight. With --http the flight
/// is sent as multicast on this machine, fused by the live service, and shown on its map.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Serves the API and the map there, live, until Ctrl-C: 127.0.0.1:8080, which is the default, or only a port of this
    /// machine.
    #[arg(long, value_name = "ADDR", value_parser = listen_address, num_args = 0..=1, default_missing_value = "127.0.0.1:8080")]
    pub http: Option<SocketAddr>,
    /// How long the show takes in a terminal (60s), or how long --http serves (until Ctrl-C).
    #[arg(long, value_name = "DURATION", value_parser = duration)]
    pub duration: Option<SignedDuration>,
    /// Another seed flies otherwise.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// What flies.
    #[arg(long, value_enum, default_value_t = Flight::Crossing, value_name = "NAME")]
    pub scenario: Flight,
}

/// What can be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Flight {
    /// Ten drones through one point, under a radar.
    Crossing,
    /// An aerodrome without any radar: aircraft with ADS-B, drones with Remote ID, and two about to meet.
    Airfield,
    /// A public event: radars, a camera, CAT129, Remote ID, a helicopter with ADS-B, and identities that are made up.
    Event,
}

impl Flight {
    /// Its file, and the text of that.
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

/// How long the show takes in a terminal, seconds.
const SHOW_S: f64 = 60.0;
/// Transponders that lie, in `crossing`.
const LIARS: u32 = 1;
/// A track stays in the table this long after its last point, seconds: the radar misses a detection now and then.
const LINGER_S: f64 = 2.0;
/// What the summary's lines begin with, characters.
const SUMMARY_INDENT: usize = 11;
/// Where there is no terminal.
const UNBOUNDED: Size = Size { rows: usize::MAX, columns: usize::MAX };
/// Between two tables where there is no terminal, seconds of the flight.
const PRINT_EVERY_S: f64 = 60.0;

/// Runs the command.
pub fn run(args: &Args) -> CommandResult {
    let (file, text) = args.scenario.file();
    let mut scenario = Scenario::parse(text, file)?;
    if args.scenario == Flight::Crossing {
        scenario.drones.spoofed = LIARS;
    }
    if let Some(listen) = args.http {
        return http::serve(scenario, args.seed, listen, args.duration);
    }
    let simulation = simulate(&scenario, args.seed, None)?;
    let config = &simulation.config;
    let live = Size::of_stdout().is_some();
    let show_s = args.duration.map_or(SHOW_S, |duration| duration.as_secs_f64());
    let speed = if live && show_s > 0.0 { Speed::Times(scenario.duration_s / show_s) } else { Speed::Max };

    let mut pipeline = Pipeline::new(config, Masks::default());
    let mut show = Show {
        site: &config.site.name,
        latency_s: config.fusion.latency().as_secs_f64(),
        maker: PictureMaker::new(config, pipeline.normaliser()),
        pace: Pace::new(speed),
        summary: Summary::default(),
        shown: BTreeMap::new(),
        flagged: BTreeMap::new(),
        next_print: None,
        painting: live.then(Painting::default),
    };
    // A slot is shown with what had come in when it was emitted.
    for reception in simulation.receptions() {
        pipeline.receive(&reception);
        show.slots(&mut pipeline)?;
    }
    pipeline.finish();
    show.slots(&mut pipeline)?;

    let liars = simulation.attacks.iter().map(|attack| show.found_out(attack)).collect::<String>();
    let summary = show.summary.text(pipeline.tally(), config)?;
    let end = format!("\n{summary}\n{liars}\n{}", score(&simulation)?);
    let columns = Size::of_stdout().map_or(usize::MAX, |size| size.columns);
    io::stdout().write_all(broken(&end, columns, SUMMARY_INDENT).as_bytes())?;
    Ok(Outcome::Done)
}

/// What the output and each input alone are worth, since the truth of a simulated flight is known.
fn score(simulation: &Simulation) -> Result<String, Failure> {
    let Simulation { config, labels, .. } = simulation;
    let receptions = || simulation.receptions().map(Ok);
    let points = evaluate::output(receptions(), config, Masks::default())?;
    let alone = InputsAlone::of(receptions(), config, Masks::default())?;
    let labels = Labels::of_site(labels.clone(), config);
    let settings = Scoring::of(config);
    Ok(verdict(&evaluate::evaluate(&simulation.truth(), Some(&labels), &points, Some(&alone), &settings)))
}

struct Show<'a> {
    site: &'a str,
    /// From the opening of a slot to its emission.
    latency_s: f64,
    maker: PictureMaker,
    pace: Pace,
    summary: Summary,
    /// By source and number: the tracks of the last moments.
    shown: BTreeMap<(u8, u32), PictureTrack>,
    /// By transponder number: the first slot in which it was flagged.
    flagged: BTreeMap<u32, Time>,
    next_print: Option<f64>,
    /// In a terminal.
    painting: Option<Painting>,
}

impl Show<'_> {
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
                // One row an aircraft: fused and alone take turns.
                self.shown.retain(|_, other| {
                    other.point.source.transponder().is_none_or(|other| other.number != part.number)
                });
            }
            self.shown.insert((rank, track.point.number), track.clone());
        }
    }

    /// When an attack began, and when it was found out.
    fn found_out(&self, attack: &Attacked) -> String {
        let Attacked { id, number, from, .. } = attack;
        let found = match self.flagged.get(number) {
            // It is published that much later.
            Some(flagged) => {
                format!("{:.0} s later it was flagged", flagged.seconds_since(*from) + self.latency_s)
            }
            None => "it was not flagged".to_owned(),
        };
        format!(
            "The transponder of drone {id} (track {number}) lied from {from} on; {found}. Below, its lie counts as error.\n"
        )
    }

    fn draw(&mut self, time: Time, tally: &Tally) -> io::Result<()> {
        let size = self.painting.and_then(|_| Size::of_stdout());
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

    /// The table, as much of it as there is room for.
    fn lines(&self, time: Time, tally: &Tally, size: Size) -> Vec<String> {
        let mut lines = vec![
            format!("{}  {time}  (shown {} s after it happened)", self.site, self.latency_s),
            format!(
                "{} datagrams received, {} reports used, {} dropped or not used",
                tally.received,
                tally.accepted.values().sum::<u64>(),
                tally.dropped(),
            ),
            format!(
                "{:>6}  {:<11}  {:<12}  {:>5}  {:>7}  {:>6}  {:>6}  apart",
                "track", "source", "who", "radar", "bearing", "range", "height",
            ),
        ];
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

/// A line of the table; how near the radar's and the transponder's places are is said as fully as there is room.
fn row(track: &PictureTrack, now: Time, columns: usize) -> String {
    let source = &track.point.source;
    let who = source.transponder().map_or("-".to_owned(), who);
    let radar = source.radar().map_or("-".to_owned(), |part| part.track.number.to_string());
    let (bearing_deg, range_m) = bearing_and_range(track.point.position);
    let height = track.altitude_amsl_m.map_or("-".to_owned(), |metres| format!("{metres:.0} m"));
    let flagged = track.point.integrity.filter(|integrity| integrity.state.is_flagged());
    let (apart, more) = match source {
        _ if flagged.is_some() => flagged.as_ref().map(doubt).unwrap_or_default(),
        Source::Fused(_, _, Association { distance_m, because }) => {
            let why = match because {
                Because::Ratio { threshold_m, ratio } => format!(
                    " of {threshold_m:.0} m, {:.0} % of {} slots",
                    100.0 * ratio.value(),
                    ratio.co_present
                ),
                Because::Likelihood { score } => format!(", log-likelihood ratio {score:.0}"),
                Because::Manual { .. } => ", decided by hand".to_owned(),
            };
            (format!("{distance_m:.1} m"), why)
        }
        _ if track.time < now => (format!("({:.2} s ago)", now.seconds_since(track.time)), String::new()),
        _ => (String::new(), String::new()),
    };
    let range = format!("{range_m:.0} m");
    let line = format!(
        "{:>6}  {:<11}  {who:<12}  {radar:>5}  {bearing_deg:>6.1}°  {range:>6}  {height:>6}  {apart}",
        // Of an aircraft without a serial number it has ten digits, of which the last four say nothing.
        source
            .transponder()
            .filter(|part| part.identity.serial().is_none())
            .map_or(track.point.number, |part| part.number),
        track.source_name(),
    );
    let has_room = line.chars().count() + more.chars().count() <= columns;
    if has_room { line + &more } else { line }
}

/// A callsign, or the name of an identity.
fn who(part: &TransponderPart) -> String {
    let callsign = text(&part.aircraft.callsign).map(Cow::into_owned);
    callsign.unwrap_or_else(|| serial_text(part.identity))
}

/// That a transponder is not to be trusted, and how far off it is.
fn doubt(integrity: &PointIntegrity) -> (String, String) {
    let off = integrity.offset_m.map_or_else(String::new, |metres| format!(", {metres:.0} m off"));
    (integrity.state.name().to_uppercase(), off)
}

/// From the origin: degrees clockwise from north, metres over ground.
fn bearing_and_range(position: Enu) -> (f64, f64) {
    let bearing = position.east().atan2(position.north()).to_degrees();
    (bearing.rem_euclid(360.0), position.east().hypot(position.north()))
}
