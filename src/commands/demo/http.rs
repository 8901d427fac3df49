//! `demo --http`: a simulated flight through the live service on this machine, with its map.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use jiff::SignedDuration;
use tracing::{error, info};

use crate::app::{LiveBuilder, Signals, listen_locally, runtime};
use crate::commands::reserved_ports::ReservedPorts;
use crate::commands::simulate::{send, start};
use crate::commands::{CommandResult, Outcome, needs_tokens};
use api::pmtiles::Basemap;
use lab::simulate::{Scenario, Simulation, simulate};
use site::areas::Areas;

/// The invented ground of the scenarios' place, written by the example `ground`.
const GROUND: &[u8] = include_bytes!("../../../config/ground.pmtiles");

/// Sends the scenario to a live service and serves its picture, one flight after another, until Ctrl-C or for `duration`.
///
/// # Errors
/// The address is in use, or the loopback interface has no multicast.
pub fn serve(
    scenario: Scenario,
    seed: u64,
    http: SocketAddr,
    duration: Option<SignedDuration>,
) -> CommandResult {
    let mut first = simulate(&scenario, seed, Some(start(&scenario)))?;
    let ports =
        ReservedPorts::reserve(&first.config).map_err(|error| format!("no UDP port is free: {error}"))?;
    ports.replace_ports(&mut first);
    let mut config = first.config.clone();
    config.http.listen = http;
    config.conflicts.enabled = true;
    let config = Arc::new(config);
    runtime(2)?.block_on(async {
        let mut signals = Signals::listen()?;
        let listener = listen_locally(&config)?.ok_or_else(|| needs_tokens(&config))?;
        let live = LiveBuilder::new(config.clone(), Areas::default(), listener)
            .with_basemap(Basemap::embedded(GROUND)?)
            .start()?;
        // The thread sleeps most of the time, and ends with the process.
        std::thread::spawn(move || fly(&scenario, seed, first, &ports));
        for sink in &config.output.asterix {
            info!(to = sink.name(), "fused picture is sent");
        }
        info!(url = %live.served.url, flight = config.site.name, "live; Ctrl-C ends it");
        let over = async {
            match duration.map(Duration::try_from) {
                Some(Ok(duration)) => tokio::time::sleep(duration).await,
                _ => std::future::pending().await,
            }
        };
        tokio::select! {
            () = signals.stop() => {}
            () = over => {}
        }
        live.stop(&mut signals).await?;
        Ok(Outcome::Done)
    })
}

/// Sends one flight after another.
fn fly(scenario: &Scenario, mut seed: u64, first: Simulation, ports: &ReservedPorts) {
    let mut next = Ok(first);
    loop {
        let sent = next.map_err(Into::into).and_then(|simulation| send(&simulation));
        if let Err(error) = sent {
            return error!(%error, "the flight has ended");
        }
        seed += 1;
        next = simulate(scenario, seed, Some(start(scenario))).map(|mut simulation| {
            ports.replace_ports(&mut simulation);
            simulation
        });
    }
}
