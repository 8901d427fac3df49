//! UDP ports that no other program of this machine has: two demos at a time do not hear each other.

use std::collections::BTreeMap;
use std::io;
use std::net::{Ipv4Addr, UdpSocket};

use crate::config::Config;
use crate::simulate::Simulation;

/// Ports in place of the usual ones, held for as long as this lives.
#[derive(Debug)]
pub struct OwnPorts(BTreeMap<u16, HeldPort>);

#[derive(Debug)]
struct HeldPort {
    port: u16,
    /// On the host's own address, where no multicast arrives: it only keeps the port from everybody else.
    _socket: UdpSocket,
}

impl OwnPorts {
    /// One for each port that the configuration listens or sends to.
    ///
    /// # Errors
    /// No port is free.
    pub fn instead_of(config: &Config) -> io::Result<Self> {
        let inputs = config.sensors.iter().flat_map(|sensor| &sensor.inputs).map(|input| input.port);
        let mut held = BTreeMap::new();
        for usual in inputs.chain(config.output.asterix.iter().map(|sink| sink.port)) {
            #[expect(clippy::disallowed_methods, reason = "a port is held, nothing is sent or received")]
            let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))?;
            held.insert(usual, HeldPort { port: socket.local_addr()?.port(), _socket: socket });
        }
        Ok(Self(held))
    }

    /// Leads what is sent in the simulation, and the site that listens to it, over these ports.
    pub fn lead(&self, simulation: &mut Simulation) {
        simulation.map_ports(|usual| self.0.get(&usual).map_or(usual, |held| held.port));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::{Scenario, simulate};

    #[test]
    fn two_sites_share_no_port_and_each_hears_its_own_sensors() {
        let text = "name = \"ports\"\nduration_s = 20\n[drones]\nmultirotors = 1\nequipped = 1\n";
        let scenario = Scenario::parse(text, "ports.toml").unwrap();
        let led = || {
            let mut simulation = simulate(&scenario, 1, None).unwrap();
            let ports = OwnPorts::instead_of(&simulation.config).unwrap();
            ports.lead(&mut simulation);
            (simulation, ports)
        };
        let ((one, _held), (other, _also_held)) = (led(), led());
        let ports = |simulation: &Simulation| -> Vec<u16> {
            let Config { sensors, output, .. } = &simulation.config;
            let inputs = sensors.iter().flat_map(|sensor| &sensor.inputs).map(|input| input.port);
            inputs.chain(output.asterix.iter().map(|sink| sink.port)).collect()
        };
        let mut all = [ports(&one), ports(&other)].concat();
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), count, "{all:?}");
        for simulation in [&one, &other] {
            let heard = ports(simulation);
            assert!(simulation.datagrams.iter().all(|datagram| heard.contains(&datagram.flow.port)));
        }
    }
}
