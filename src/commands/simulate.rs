//! `simulate`: writes a scenario as files, or sends it as datagrams in real time.

use std::error::Error;
use std::fs;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::PathBuf;

use jiff::SignedDuration;
use tracing::info;

use super::{CommandResult, Outcome};
use fusion::time::{SECOND, Time};
use lab::simulate::{Scenario, Simulation, random, simulate, write};
use service::live::now;
use service::net::send;

/// Simulates radars, transponders, ADS-B, Remote ID and cameras with realistic faults, and writes the truth with them.
///
/// The same scenario and seed give the same files.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Scenario (TOML). config/scenarios/ has examples; every-key.toml there explains all keys.
    #[arg(value_name = "SCENARIO", required_unless_present = "random_world")]
    pub scenario: Option<PathBuf>,
    /// Generates a random scenario with this seed, and writes it as scenario.toml beside the other files.
    #[arg(long, value_name = "SEED", conflicts_with_all = ["scenario", "seed"])]
    pub random_world: Option<u64>,
    /// Directory for radar.ast, transponder.ast, capture.pcap, truth.csv, labels.csv and site.toml.
    #[arg(long, value_name = "DIR", required_unless_present = "udp")]
    pub out: Option<PathBuf>,
    /// Random seed of the flight.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Sends the datagrams to the inputs of site.toml in real time, starting now.
    #[arg(long)]
    pub udp: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> CommandResult {
    let (scenario, seed) = flown(args)?;
    let start = args.udp.then(|| start(&scenario));
    let simulation = simulate(&scenario, seed, start)?;
    info!(
        "{}: {} s, {} drones, {} labelled plots and reports, {} datagrams",
        scenario.name,
        scenario.duration_s,
        simulation.flights.len(),
        simulation.labels.len(),
        simulation.datagrams.len()
    );
    if let Some(directory) = &args.out {
        let about = format!("The site of scenario {}, seed {seed}.", scenario.name);
        write(&simulation, &about, directory)?;
        if args.random_world.is_some() {
            let file = directory.join("scenario.toml");
            let written = fs::write(&file, scenario.show());
            written.map_err(|error| format!("{}: cannot be written: {error}", file.display()))?;
        }
        info!("written to {}", directory.display());
    }
    if args.udp {
        send(&simulation)?;
    }
    Ok(Outcome::Done)
}

/// Scenario and seed of the flight.
fn flown(args: &Args) -> Result<(Scenario, u64), Box<dyn Error + Send + Sync>> {
    match (&args.scenario, args.random_world) {
        (_, Some(seed)) => Ok((random::random_world(seed), seed)),
        (Some(scenario), None) => Ok((Scenario::load(scenario)?, args.seed)),
        (None, None) => Err("name a scenario, or --random-world SEED".into()),
    }
}

/// Start time of a flight that is sent: some whole seconds ahead, because the simulation takes time, for a city more.
pub(super) fn start(scenario: &Scenario) -> Time {
    let lead_s = 3 + (f64::from(scenario.drone_count()) * scenario.duration_s / 12_000.0) as i64;
    Time::from_nanos((now().nanos() / SECOND + lead_s) * SECOND)
}

/// Sends every datagram at its time.
pub(super) fn send(simulation: &Simulation) -> Result<(), Box<dyn Error + Send + Sync>> {
    let Some(last) = simulation.datagrams.last() else { return Ok(()) };
    // The multicast stays on this machine.
    let socket = send::socket(Some(Ipv4Addr::LOCALHOST), 1)
        .and_then(|socket| socket.set_nonblocking(false).map(|()| socket))
        .map_err(|error| format!("no UDP socket to send from: {error}"))?;
    info!("sending until {}; stop with Ctrl-C", last.received);
    let mut latest = SignedDuration::ZERO;
    for datagram in &simulation.datagrams {
        let early = datagram.received - now();
        if let Ok(early) = std::time::Duration::try_from(early) {
            #[expect(clippy::disallowed_methods, reason = "in real time")]
            std::thread::sleep(early);
        }
        latest = latest.max(now() - datagram.received);
        let to = SocketAddrV4::new(datagram.flow.to, datagram.flow.port);
        socket.send_to(&datagram.payload, to).map_err(|error| format!("to {to}: cannot be sent: {error}"))?;
    }
    info!(
        "{} datagrams sent, the latest {:.1} ms late",
        simulation.datagrams.len(),
        latest.as_secs_f64() * 1e3
    );
    Ok(())
}
