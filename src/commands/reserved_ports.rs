//! UDP ports that no other program on this machine uses, so that two demos do not receive each other's data.

use std::collections::BTreeMap;
use std::io;
use std::net::{Ipv4Addr, UdpSocket};

use lab::simulate::Simulation;
use site::config::Config;

/// Ports that replace the usual ones, reserved while this value exists.
#[derive(Debug)]
pub struct ReservedPorts(BTreeMap<u16, ReservedPort>);

#[derive(Debug)]
struct ReservedPort {
    port: u16,
    /// Bound to the host's own address, where no multicast arrives: it only reserves the port.
    _socket: UdpSocket,
}

impl ReservedPorts {
    /// Reserves a port for each port to which the configuration listens or sends.
    ///
    /// # Errors
    /// No port is free.
    pub fn reserve(config: &Config) -> io::Result<Self> {
        let inputs = config.sensors.iter().flat_map(|sensor| &sensor.inputs).map(|input| input.port);
        let mut held = BTreeMap::new();
        for usual in inputs.chain(config.output.asterix.iter().map(|sink| sink.port)) {
            #[expect(clippy::disallowed_methods, reason = "a port is held, nothing is sent or received")]
            let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))?;
            held.insert(usual, ReservedPort { port: socket.local_addr()?.port(), _socket: socket });
        }
        Ok(Self(held))
    }

    /// Replaces the ports of the simulation and of its site.
    pub fn replace_ports(&self, simulation: &mut Simulation) {
        simulation.map_ports(|usual| self.0.get(&usual).map_or(usual, |held| held.port));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lab::simulate::{Scenario, simulate};

    #[test]
    fn two_sites_share_no_ports() {
        let text = "name = \"ports\"\nduration_s = 20\n[drones]\nmultirotors = 1\nequipped = 1\n";
        let scenario = Scenario::parse(text, "ports.toml").unwrap();
        let reserved = || {
            let mut simulation = simulate(&scenario, 1, None).unwrap();
            let ports = ReservedPorts::reserve(&simulation.config).unwrap();
            ports.replace_ports(&mut simulation);
            (simulation, ports)
        };
        let ((one, _held), (other, _also_held)) = (reserved(), reserved());
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
