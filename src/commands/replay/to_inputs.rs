//! `replay --to-inputs`: sends a recording to the inputs of a live service on this machine.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::time::Duration;

use asterix::{DataSource, blocks, cat021};
use jiff::SignedDuration;
use jiff::civil::Date;
use tracing::{error, info};

use super::args::Args;
use super::redate::Redating;
use crate::app::{AppError, Stop};
use crate::commands::moment::{ReplaySpeed, TimeArgument};
use crate::commands::table::grouped;
use crate::commands::{CommandResult, Outcome, Usage};
use input::capture::{Capture, MergedCaptures, Reception, SiteReceivers, TrailerRules};
use input::gateways::remote_id::{BroadcastLine, is_broadcast, is_lines, lines};
use input::names::counted;
use input::normalise::Normaliser;
use service::live::now;
use service::net::send::local_socket;
use site::areas::Masks;
use site::config::{Address, Config, Input, Sensor, SensorKind};

/// Sends the datagrams of the recording to the inputs of the site, with their timing and with present times, until its end or
/// Ctrl-C.
///
/// # Errors
/// The site has no UDP input, an input accepts nothing from this machine, or no datagram is for the site.
pub(super) fn send(args: &Args, config: &Config) -> CommandResult {
    let speed = match args.speed {
        None => 1.0,
        Some(ReplaySpeed::Times(times)) => times,
        Some(ReplaySpeed::Max) => {
            let text = "--to-inputs needs a speed: a service of now takes no hour within a second";
            return Err(Usage(text.to_owned()).into());
        }
    };
    let normaliser = Normaliser::new(config, Masks::default());
    let (trailers, receivers) = (TrailerRules::of(config), SiteReceivers::of(config));
    let mut rehearsal = Rehearsal {
        lines: UdpInputs::open(config)?,
        config,
        editions: normaliser.editions(),
        normaliser,
        stop: Stop::listen()?,
        sent: BTreeMap::new(),
        unsent: BTreeMap::new(),
        latest: SignedDuration::ZERO,
    };
    let mut captures = args.open(&trailers, &receivers)?;
    let day = args.day_of(&captures);
    let (outcome, is_whole) = loop {
        let (outcome, is_whole) = rehearsal.pass(args, captures, day, speed)?;
        // A recording without a datagram would repeat without a pause.
        if !args.again || !is_whole || rehearsal.sent.is_empty() {
            break (outcome, is_whole);
        }
        info!("the recording has come to its end and begins again");
        captures = args.open(&trailers, &receivers)?;
    };
    io::stdout().write_all(rehearsal.summary().as_bytes())?;
    if rehearsal.sent.is_empty() && is_whole && outcome == Outcome::Done {
        let site = args.config.display();
        return Err(format!(
            "no datagram of the recording is for an input of {site}; have a configuration written for it: \
             utm-fusion info CAPTURE --config-out FILE"
        )
        .into());
    }
    Ok(outcome)
}

/// Sends datagrams and counts them.
struct Rehearsal<'a> {
    config: &'a Config,
    lines: UdpInputs,
    normaliser: Normaliser,
    editions: BTreeMap<DataSource, cat021::Edition>,
    stop: Stop,
    /// Number of datagrams sent, by the index of the input in `lines`.
    sent: BTreeMap<usize, u64>,
    /// Number of datagrams without an input, by content.
    unsent: BTreeMap<String, u64>,
    /// Maximum delay of a datagram beyond its due time.
    latest: SignedDuration,
}

impl Rehearsal<'_> {
    /// Sends the recording once. Returns whether its end was reached.
    fn pass(
        &mut self,
        args: &Args,
        captures: Vec<Capture>,
        day: Date,
        speed: f64,
    ) -> Result<(Outcome, bool), AppError> {
        let mut merged = MergedCaptures::new(captures, day).with_editions(self.editions.clone());
        let mut outcome = Outcome::Done;
        let (mut first, mut redating) = (None, None);
        while let Some(next) = merged.next() {
            let mut reception = match next {
                Ok(reception) => reception,
                Err(damage) => {
                    error!(%damage, "an input cannot be read on");
                    outcome = Outcome::InputUnreadable;
                    continue;
                }
            };
            let Some(received) = reception.received else {
                *self.unsent.entry("records before the first time of a recording".to_owned()).or_default() +=
                    1;
                continue;
            };
            let first = *first.get_or_insert(received);
            let is_before = |moment: TimeArgument| received < moment.resolve(first);
            if args.start.is_some_and(is_before) {
                continue;
            }
            if args.end.is_some_and(|end| !is_before(end)) {
                break;
            }
            let redating = *redating.get_or_insert_with(|| {
                let redating = Redating::new(received, now(), speed);
                info!(recorded = %received, now = %redating.now(received), speed, "sending to the site's inputs; Ctrl-C ends it");
                redating
            });
            let Some(line) = self.line_of(&reception, merged.destination()) else {
                let name = self.content(&reception.payload, merged.destination());
                *self.unsent.entry(name).or_default() += 1;
                continue;
            };
            let edition = |source| self.editions.get(&source).copied().unwrap_or_default();
            redating.move_times(&mut reception.payload, received, edition);
            let due = redating.now(received);
            let early = Duration::try_from(due - now()).unwrap_or_default();
            if self.stop.comes_within(early) {
                return Ok((outcome, false));
            }
            self.latest = self.latest.max(now() - due);
            self.lines.send(line, &mut reception.payload)?;
            *self.sent.entry(line).or_default() += 1;
        }
        Ok((outcome, true))
    }

    /// Input for a datagram: the one with the address it was recorded at, else the first input of the sensor that sent the
    /// records.
    fn line_of(&self, reception: &Reception, destination: Option<SocketAddr>) -> Option<usize> {
        let at = destination.and_then(|destination| self.lines.at(destination));
        at.or_else(|| self.lines.first_of(self.sensor(&reception.payload)?))
    }

    /// Index of the sensor in the configuration.
    fn sensor(&self, payload: &[u8]) -> Option<usize> {
        let mut sensors = self.config.sensors.iter();
        let is_receiver =
            |sensor: &Sensor| matches!(sensor.kind, SensorKind::RemoteId(_)) && !sensor.inputs.is_empty();
        if is_broadcast(payload) {
            return sensors.position(is_receiver);
        }
        if is_lines(payload) {
            let named = lines(payload).find_map(|line| BroadcastLine::parse(line).ok()?.receiver);
            return sensors.position(|sensor| {
                is_receiver(sensor) && named.as_ref().is_none_or(|receiver| *receiver == sensor.id)
            });
        }
        let of = |(category, source)| self.normaliser.sensor(category, source);
        sources(payload).find_map(of).map(|index| usize::from(index.0))
    }

    /// Content of a datagram without an input.
    fn content(&self, payload: &[u8], destination: Option<SocketAddr>) -> String {
        let content = if is_broadcast(payload) || is_lines(payload) {
            "Remote ID".to_owned()
        } else if let Some((category, source)) = sources(payload).next() {
            let sensor = self.normaliser.sensor(category, source);
            let sensor = sensor.and_then(|index| self.config.sensors.get(usize::from(index.0)));
            match sensor {
                Some(sensor) => format!("CAT{category:03} of {}, which has no UDP input", sensor.id),
                None => {
                    format!("CAT{category:03} of {}/{}, which the site does not have", source.sac, source.sic)
                }
            }
        } else {
            "other content".to_owned()
        };
        match destination {
            Some(destination) => format!("{content}, recorded at {destination}"),
            None => content,
        }
    }

    fn summary(&self) -> String {
        let mut text = String::new();
        for (&line, &count) in &self.sent {
            // Writing to a String does not fail.
            let _ = writeln!(text, "sent       {} to {}", datagrams(count), self.lines.name(line));
        }
        for (content, &count) in &self.unsent {
            let _ = writeln!(text, "not sent   {}: {content}", datagrams(count));
        }
        if !self.sent.is_empty() {
            let _ = writeln!(text, "latest     {:.1} ms after its time", self.latest.as_secs_f64() * 1e3);
        }
        text
    }
}

fn datagrams(count: u64) -> String {
    let text = counted(count, "datagram");
    text.replacen(&count.to_string(), &grouped(count), 1)
}

/// Category and first data source of each block.
fn sources(payload: &[u8]) -> impl Iterator<Item = (u8, DataSource)> {
    blocks(payload).flatten().filter_map(|block| Some((block.category, block.first_source()?)))
}

/// UDP inputs of a site, each with a socket that sends to it.
struct UdpInputs {
    lines: Vec<UdpInput>,
    /// One socket per pair of interface and own address, so that all inputs of a sensor have one sender, as when recorded.
    sockets: BTreeMap<(Option<Ipv4Addr>, Ipv4Addr), UdpSocket>,
}

struct UdpInput {
    /// Index of the sensor in the configuration.
    sensor: usize,
    /// Text with sensor and address.
    name: String,
    input: Input,
    to: SocketAddrV4,
    socket: (Option<Ipv4Addr>, Ipv4Addr),
}

impl UdpInputs {
    fn open(config: &Config) -> Result<Self, AppError> {
        let mut opened = Self { lines: Vec::new(), sockets: BTreeMap::new() };
        for (index, sensor) in config.sensors.iter().enumerate() {
            for &input in &sensor.inputs {
                opened.add(index, &sensor.id, input)?;
            }
        }
        if opened.lines.is_empty() {
            return Err(Usage("--to-inputs: no sensor of the site has a UDP input".to_owned()).into());
        }
        Ok(opened)
    }

    fn add(&mut self, sensor: usize, id: &str, input: Input) -> Result<(), AppError> {
        let (to, interface, own) = match input.address {
            Address::Multicast { group, interface } => {
                let own = if interface.is_loopback() { interface } else { Ipv4Addr::UNSPECIFIED };
                (group, Some(interface), own)
            }
            Address::Unicast(address) if address.is_unspecified() => {
                (Ipv4Addr::LOCALHOST, None, Ipv4Addr::LOCALHOST)
            }
            // Only an address of this machine can be bound, so nothing is sent to another machine.
            Address::Unicast(address) => (address, None, address),
        };
        let to = SocketAddrV4::new(to, input.port);
        let name = format!("{to} ({id})");
        let socket = (interface, input.source.unwrap_or(own));
        if let Entry::Vacant(entry) = self.sockets.entry(socket) {
            let problem = |error: io::Error| match input.source {
                Some(source) => format!(
                    "sensor {id}: its input {to} takes datagrams from {source} alone, and this machine cannot send \
                     from there ({error}); remove source in a copy of the site to rehearse it here"
                ),
                None => format!("sensor {id}: nothing can be sent to its input {to}: {error}"),
            };
            entry.insert(local_socket(socket.0, socket.1).map_err(problem)?);
        }
        self.lines.push(UdpInput { sensor, name, input, to, socket });
        Ok(())
    }

    /// Input that listens at the address.
    fn at(&self, destination: SocketAddr) -> Option<usize> {
        let IpAddr::V4(address) = destination.ip() else { return None };
        self.lines.iter().position(|line| {
            let is_same = match line.input.address {
                Address::Multicast { group, .. } => group == address,
                Address::Unicast(own) => own == address || own.is_unspecified() && !address.is_multicast(),
            };
            is_same && line.input.port == destination.port()
        })
    }

    fn first_of(&self, sensor: usize) -> Option<usize> {
        self.lines.iter().position(|line| line.sensor == sensor)
    }

    fn name(&self, line: usize) -> &str {
        &self.lines[line].name
    }

    fn send(&self, line: usize, payload: &mut Vec<u8>) -> Result<(), AppError> {
        let line = &self.lines[line];
        // The input removes the same number of octets.
        payload.resize(payload.len() + usize::from(line.input.trailer_octets.unwrap_or(0)), 0);
        let socket = &self.sockets[&line.socket];
        socket
            .send_to(payload, line.to)
            .map_err(|error| format!("{}: cannot be sent to: {error}", line.name))?;
        Ok(())
    }
}
