//! `simulate`: a scenario as files, or as datagrams in real time.

use std::error::Error;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::PathBuf;

use jiff::SignedDuration;
use tracing::info;

use super::{CommandResult, Outcome};
use crate::live::now;
use crate::net::send;
use crate::simulate::{Scenario, Simulation, simulate, write};
use fusion::time::{SECOND, Time};

/// Simulates radars, transponders, ADS-B, Remote ID and cameras that fail as real ones do, and gives the truth beside them.
///
/// The same scenario and seed give the same files.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// The scenario: TOML; config/scenarios/ has some, and every-key.toml there explains all keys.
    #[arg(value_name = "SCENARIO")]
    pub scenario: PathBuf,
    /// Where radar.ast, transponder.ast, capture.pcap, truth.csv, labels.csv and site.toml are written.
    #[arg(long, value_name = "DIR", required_unless_present = "udp")]
    pub out: Option<PathBuf>,
    /// Another seed flies otherwise.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Sends the datagrams to the inputs of site.toml, in real time, beginning now.
    #[arg(long)]
    pub udp: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> CommandResult {
    let scenario = Scenario::load(&args.scenario)?;
    let start = args.udp.then(|| start(&scenario));
    let simulation = simulate(&scenario, args.seed, start)?;
    info!(
        "{}: {} s, {} drones, {} labelled plots and reports, {} datagrams",
        scenario.name,
        scenario.duration_s,
        simulation.flights.len(),
        simulation.labels.len(),
        simulation.datagrams.len()
    );
    if let Some(directory) = &args.out {
        let about = format!("The site of scenario {}, seed {}.", scenario.name, args.seed);
        write(&simulation, &about, directory)?;
        info!("written to {}", directory.display());
    }
    if args.udp {
        send(&simulation)?;
    }
    Ok(Outcome::Done)
}

/// Start of a flight that is sent: whole seconds ahead, since simulating it takes time, more so for a city.
pub(super) fn start(scenario: &Scenario) -> Time {
    let lead_s = 3 + (f64::from(scenario.drone_count()) * scenario.duration_s / 12_000.0) as i64;
    Time::from_nanos((now().nanos() / SECOND + lead_s) * SECOND)
}

/// Sends every datagram at its time.
pub(super) fn send(simulation: &Simulation) -> Result<(), Box<dyn Error + Send + Sync>> {
    let Some(last) = simulation.datagrams.last() else { return Ok(()) };
    // Its multicast stays on this machine.
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
