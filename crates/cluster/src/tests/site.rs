//! The engine of a site in the virtual world: a flight of drones and birds.

use std::sync::LazyLock;

use fusion::time::Time;

use super::world::{BEGINS_MS, Engine, Feed, LASTS_MS};
use crate::engine::SiteEngine;
use lab::simulate::{Scenario, Simulation, simulate};
use site::areas::Masks;

/// The simulated flight.
static FLIGHT: LazyLock<Simulation> = LazyLock::new(|| {
    let text = include_str!("../../../../config/scenarios/crossing.toml")
        .replace("duration_s = 300", &format!("duration_s = {}", LASTS_MS / 1000));
    let begins = Time::from_nanos(BEGINS_MS * 1_000_000);
    simulate(&Scenario::parse(&text, "crossing.toml").unwrap(), 1, Some(begins)).unwrap()
});

impl Engine for SiteEngine {
    fn new() -> Self {
        Self::new(FLIGHT.config.clone(), Masks::default(), Time::from_nanos(BEGINS_MS * 1_000_000))
    }

    fn written(&self) -> Vec<u8> {
        self.checkpoint()
    }

    fn read(octets: &[u8]) -> Self {
        <Self as Engine>::new().restored(Masks::default(), octets).unwrap()
    }
}

/// Datagrams of its sensors.
pub(super) fn feed() -> Feed {
    let sensors = &FLIGHT.config.sensors;
    let sent = |datagram: &lab::simulate::SimulatedDatagram| {
        let sensor = &sensors[usize::from(datagram.payload[0] == 129)];
        let source = asterix::DataSource { sac: sensor.sac, sic: sensor.sic };
        (datagram.received.nanos() / 1_000_000 - BEGINS_MS, source, datagram.payload.clone())
    };
    FLIGHT.datagrams.iter().map(sent).collect()
}
