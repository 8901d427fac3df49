//! `check`: validates the configuration and prints the effective one.

mod lines;

use std::io::{self, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::time::Duration;

use tracing::warn;

use super::zones;
use super::{CommandResult, Outcome, Usage, check_mqtt, mqtt_inputs, mqtt_receivers};
use crate::app::runtime;
use api::AccessSettings;
use api::pmtiles::Basemap;
use input::normalise::Normaliser;
use lab::simulate::Scenario;
use service::live::{AlertSettings, now};
use service::net::listen as udp;
use service::net::send::UdpDestinations;
use service::notices::NoticeReceivers;
use service::sinks::PictureSinks;
use site::areas::Areas;
use site::config::{Address, Config, ConfigError, ConfigErrors, Connection, Place};

/// Validates a configuration with its areas, tokens and certificate, and prints it with all defaults filled in.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Configuration file.
    #[arg(value_name = "FILE", required_unless_present = "config")]
    pub file: Option<PathBuf>,
    /// Configuration file, as for the other commands.
    #[arg(long, value_name = "FILE", conflicts_with = "file")]
    pub config: Option<PathBuf>,
    /// Opens all inputs and outputs on this machine, joins their groups, and connects to the receivers of the picture. Prints the
    /// results instead of the configuration. Sends nothing. Exit code 1 if any fails.
    #[arg(long)]
    pub network: bool,
    /// Sends a test notice to each receiver of alerts (`alerts.webhooks`, `alerts.mqtt`), and prints the results instead of the
    /// configuration. Exit code 1 if any fails.
    #[arg(long, conflicts_with = "network")]
    pub notify: bool,
    /// Prints what the lines of this file become, for a sensor whose connection has format `json` or `csv`, instead of the
    /// configuration. Exit code 1 if a line is no report.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["network", "notify"])]
    pub lines: Option<PathBuf>,
    /// Sensor of the lines, if several have some.
    #[arg(long, value_name = "ID", requires = "lines")]
    pub sensor: Option<String>,
}

/// Runs the command.
pub fn run(args: &Args) -> CommandResult {
    let Some(file) = args.file.as_ref().or(args.config.as_ref()) else {
        return Err(Usage("no configuration is named: utm-fusion check FILE".to_owned()).into());
    };
    let config = Config::load(file).map_err(|errors| scenario(file).unwrap_or(errors))?;
    check_mqtt(file, mqtt_inputs(&config).chain(mqtt_receivers(&config)))?;
    let areas = Areas::load(&config.areas)?;
    AlertSettings::new(&config.alerts, &areas)?;
    let warnings =
        AccessSettings::load(&config, &areas)?.warnings(now()).into_iter().chain(areas.warnings(now()));
    warnings.for_each(|warning| warn!("{warning}"));
    if let Some(path) = &config.map.pmtiles {
        Basemap::open(path).map_err(|error| format!("map.pmtiles: {}: {error}", path.display()))?;
    }
    let receivers = NoticeReceivers::open(&config)?;
    receivers.warnings().iter().for_each(|warning| warn!("{warning}"));
    let sinks = PictureSinks::open(&config)?;
    sinks.warnings().iter().for_each(|warning| warn!("{warning}"));
    #[cfg(feature = "cluster")]
    super::cluster::checked_proofs(&config)?.iter().for_each(|warning| warn!("{warning}"));
    let normaliser = Normaliser::new(&config, areas.masks());
    let undulation_m = normaliser.undulation_m();
    let mut out = io::stdout().lock();
    if let Some(file) = &args.lines {
        return lines::lines(&config, &normaliser, (args.sensor.as_deref(), file), now(), &mut out);
    }
    if args.network {
        return network(&config, &sinks, &mut out);
    }
    if args.notify {
        return notify(&receivers, &mut out);
    }
    writeln!(out, "# {}: valid. In force, defaults filled in:", file.display())?;
    writeln!(out, "# geoid undulation: {undulation_m:.2} m")?;
    writeln!(out, "{}", zones::lines(&areas, now(), undulation_m))?;
    #[cfg(feature = "cluster")]
    super::cluster::cells(&config)?.iter().try_for_each(|line| writeln!(out, "# {line}"))?;
    receivers.lines().iter().chain(sinks.lines()).try_for_each(|line| writeln!(out, "# {line}"))?;
    write!(out, "{config}")?;
    Ok(Outcome::Done)
}

/// Error about a file that is a scenario; `None` for other files.
fn scenario(file: &Path) -> Option<ConfigErrors> {
    let name = file.display().to_string();
    #[expect(clippy::disallowed_methods, reason = "a file that is no configuration is looked at")]
    let text = std::fs::read_to_string(file).ok()?;
    Scenario::parse(&text, &name).ok()?;
    Some(ConfigErrors::from(ConfigError {
        message: format!(
            "this is a scenario, and no site; `utm-fusion simulate {name}` flies it and writes a site that can be checked"
        ),
        file: name,
        place: Place::File,
        key: "duration_s".to_owned(),
        value: None,
    }))
}

/// Prints a line for each receiver of alerts.
fn notify(receivers: &NoticeReceivers, out: &mut impl Write) -> CommandResult {
    let answers = runtime(1)?.block_on(receivers.test());
    if answers.is_empty() {
        writeln!(out, "nobody hears of alerts: there are neither alerts.webhooks nor alerts.mqtt")?;
    }
    let mut failed = false;
    for (name, answer) in answers {
        failed |= answer.is_err();
        match answer {
            Ok(answer) => writeln!(out, "{name}: ok, {answer}")?,
            Err(why) => writeln!(out, "{name}: FAILED: {why}")?,
        }
    }
    Ok(if failed { Outcome::Incomplete } else { Outcome::Done })
}

/// Connects to a receiver or a broker.
fn reach(line: &udp::ConfiguredLine) -> io::Result<()> {
    const PATIENCE: Duration = Duration::from_secs(2);
    let broker = line.connection.as_ref().and_then(Connection::broker);
    let mut addresses = match &broker {
        Some(broker) => {
            (broker.host.trim_matches(['[', ']']), broker.port).to_socket_addrs()?.collect::<Vec<_>>()
        }
        None => vec![line.destination().into()],
    };
    let last = addresses.pop().ok_or_else(|| io::Error::other("the name has no address"))?;
    let is_reached = |address: &SocketAddr| TcpStream::connect_timeout(address, PATIENCE).is_ok();
    if addresses.iter().any(is_reached) {
        Ok(())
    } else {
        TcpStream::connect_timeout(&last, PATIENCE).map(|_| ())
    }
}

/// Prints a line for each input and output.
fn network(config: &Config, sinks: &PictureSinks, out: &mut impl Write) -> CommandResult {
    let mut failed = false;
    for line in udp::lines(config) {
        let sensors: Vec<&str> =
            line.sensors.iter().map(|&index| config.sensors[index].id.as_str()).collect();
        write!(out, "input   {} ({}): ", line.name(), sensors.join(", "))?;
        if line.is_posted() {
            writeln!(out, "ok while the service runs: gateways post to it")?;
            continue;
        }
        if !line.is_udp() {
            match reach(&line) {
                Ok(()) => writeln!(out, "ok, it answers")?,
                Err(error) => {
                    failed = true;
                    writeln!(out, "FAILED: {error}; is it running, and does it listen there?")?;
                }
            }
            continue;
        }
        match line.open() {
            Ok((_, buffer)) if buffer < udp::RECEIVE_BUFFER => writeln!(
                out,
                "ok, but the receive buffer is {} KiB of {}: raise net.core.rmem_max to {}",
                buffer >> 10,
                udp::RECEIVE_BUFFER >> 10,
                udp::RECEIVE_BUFFER
            )?,
            Ok((_, buffer)) => writeln!(out, "ok, receive buffer {} KiB", buffer >> 10)?,
            Err(error) => {
                failed = true;
                writeln!(out, "FAILED: {error}{}", remedy(&error, line.address))?;
            }
        }
    }
    for sink in &config.output.asterix {
        let to = sink.name();
        match UdpDestinations::open(std::slice::from_ref(sink)) {
            Ok(_) => writeln!(out, "output  {to}: ok")?,
            Err(error) => {
                failed = true;
                writeln!(out, "output  {to}: FAILED: {error}{}", remedy(&error, sink.address))?;
            }
        }
    }
    for (name, reached) in runtime(1)?.block_on(sinks.reach()) {
        failed |= reached.is_err();
        match reached {
            Ok(()) => writeln!(out, "output  {name}: ok")?,
            Err(why) => writeln!(out, "output  {name}: FAILED: {why}")?,
        }
    }
    #[cfg(feature = "cluster")]
    for (server, reached) in super::cluster::reached(config)? {
        failed |= reached.is_err();
        match reached {
            Ok(()) => writeln!(out, "log     {server}: ok")?,
            Err(why) => writeln!(out, "log     {server}: FAILED: {why}")?,
        }
    }
    Ok(if failed { Outcome::Incomplete } else { Outcome::Done })
}

/// Remedy for the error, if one is known.
fn remedy(error: &io::Error, address: Address) -> String {
    // ENODEV has no `ErrorKind`.
    const NO_SUCH_DEVICE: i32 = 19;
    let missing = |address| format!("; no interface of this machine has the address {address} (ip address)");
    match (error.kind(), address) {
        (_, Address::Multicast { interface, .. })
            if interface.is_unspecified()
                && (error.raw_os_error() == Some(NO_SUCH_DEVICE)
                    || matches!(
                        error.kind(),
                        io::ErrorKind::NetworkUnreachable | io::ErrorKind::HostUnreachable
                    )) =>
        {
            "; no route of this machine leads to the group: name the address of a network interface in the configuration, or \
             add a route (ip route add 224.0.0.0/4 dev INTERFACE)"
                .to_owned()
        }
        (io::ErrorKind::AddrNotAvailable, Address::Unicast(address)) => missing(address),
        (io::ErrorKind::AddrNotAvailable, Address::Multicast { interface, .. }) => missing(interface),
        (_, Address::Multicast { interface, .. }) if error.raw_os_error() == Some(NO_SUCH_DEVICE) => {
            missing(interface)
        }
        (io::ErrorKind::AddrInUse, _) => "; another program has this port for itself (ss -ulpn)".to_owned(),
        (io::ErrorKind::PermissionDenied, _) => "; ports below 1024 need a right to them".to_owned(),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use std::net::Ipv4Addr;

    use super::*;

    #[test]
    fn missing_multicast_route_is_named() {
        let group = Ipv4Addr::new(239, 192, 48, 1);
        // ENODEV when a group is joined, ENETUNREACH for an output.
        for code in [19, 101] {
            let error = io::Error::from_raw_os_error(code);
            let any = Address::Multicast { group, interface: Ipv4Addr::UNSPECIFIED };
            assert!(remedy(&error, any).contains("no route of this machine leads to the group"), "{code}");
        }
        let named = Address::Multicast { group, interface: Ipv4Addr::new(192, 0, 2, 1) };
        let text = remedy(&io::Error::from_raw_os_error(19), named);
        assert!(text.contains("no interface of this machine has the address 192.0.2.1"), "{text}");
    }
}
