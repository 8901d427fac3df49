//! A site on this machine: its sensors, its service, and a listener to its output.

use std::net::{Ipv4Addr, UdpSocket};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::Duration;

use fusion::time::{SECOND, Time};
use utm_fusion::config::{Address, Config, Record};
use utm_fusion::live::now;
use utm_fusion::net::send::socket;
use utm_fusion::simulate::Simulation;

use crate::common::{Running, Scratch, flight, group, joined, on_own_ports, utm_fusion};

pub(crate) struct Stage {
    pub(crate) scratch: Scratch,
    pub(crate) simulation: Simulation,
    pub(crate) config: Config,
    pub(crate) site: PathBuf,
    /// Socket that sends the flight; for the service another port would be another sender.
    socket: OnceLock<UdpSocket>,
}

impl Stage {
    /// A flight that begins in 2 to 3 s, over a site with `change`s.
    pub(crate) fn new(scenario: &str, port: u16, change: impl FnOnce(&mut Config, &Scratch)) -> Self {
        let scratch = Scratch::new();
        // A whole second.
        let start = Time::from_nanos((now().nanos() / SECOND + 3) * SECOND);
        let simulation = flight(scenario, 1, Some(start));
        let record =
            Record { dir: scratch.path("recordings"), rotate_mib: 256, keep: 4, keep_mib: 0, keep_hours: 0 };
        let mut config = on_own_ports(&simulation.config, port, &scratch, Some(record));
        change(&mut config, &scratch);
        let site = scratch.file("site.toml", config.to_string());
        Self { scratch, simulation, config, site, socket: OnceLock::new() }
    }

    pub(crate) fn run(&self, log: &str) -> Running {
        let mut running =
            Running::start(utm_fusion("run").arg("--config").arg(&self.site), self.scratch.path(log));
        running.says("running");
        for _ in &self.config.sensors {
            running.says("listening receive_buffer");
        }
        running
    }

    pub(crate) fn sender(&self) -> UdpSocket {
        socket(Some(self.interface()), 1).unwrap()
    }

    pub(crate) fn to(&self, sensor: usize) -> (Ipv4Addr, u16) {
        let input = &self.config.sensors[sensor].inputs[0];
        match input.address {
            Address::Multicast { group, .. } => (group, input.port),
            Address::Unicast(address) => (address, input.port),
        }
    }

    /// Sends the simulation from `from_s` to `until_s`, in real time.
    pub(crate) fn send(&self, from_s: f64, until_s: f64) {
        let sender = self.socket.get_or_init(|| self.sender());
        let start = self.simulation.datagrams[0].received;
        for datagram in &self.simulation.datagrams {
            let at_s = datagram.received.seconds_since(start);
            if !(from_s < at_s || from_s == 0.0) || at_s > until_s {
                continue;
            }
            if let Ok(early) = Duration::try_from(datagram.received - now()) {
                std::thread::sleep(early);
            }
            let sensor = usize::from(datagram.payload[0] == 129);
            sender.send_to(&datagram.payload, self.to(sensor)).unwrap();
        }
    }

    /// Interface of its output.
    fn interface(&self) -> Ipv4Addr {
        match self.config.output.asterix[0].address {
            Address::Multicast { interface, .. } => interface,
            Address::Unicast(address) => address,
        }
    }

    /// Time of reception of the first datagram of the flight.
    pub(crate) fn start(&self) -> Time {
        self.simulation.datagrams[0].received
    }

    /// Receives the output; returns its datagrams of CAT129.
    pub(crate) fn listen(&self) -> (Arc<AtomicBool>, JoinHandle<Vec<Vec<u8>>>) {
        let stop = Arc::new(AtomicBool::new(false));
        let listener = self.listen_to(group(99), self.config.output.asterix[0].port, &stop);
        (stop, listener)
    }

    /// Receives the datagrams of CAT129 of any group until stopped.
    pub(crate) fn listen_to(
        &self,
        group: Ipv4Addr,
        port: u16,
        stop: &Arc<AtomicBool>,
    ) -> JoinHandle<Vec<Vec<u8>>> {
        self.listen_for(group, port, stop, |datagram| datagram[0] == 129)
    }

    /// Receives the datagrams for which `is_wanted` returns `true`, until stopped.
    pub(crate) fn listen_for(
        &self,
        group: Ipv4Addr,
        port: u16,
        stop: &Arc<AtomicBool>,
        is_wanted: fn(&[u8]) -> bool,
    ) -> JoinHandle<Vec<Vec<u8>>> {
        let socket = joined(group, port, self.interface());
        let stopped = stop.clone();
        std::thread::spawn(move || {
            let mut heard = Vec::new();
            let mut octets = [0; 65536];
            loop {
                match socket.recv(&mut octets) {
                    Ok(length) if is_wanted(&octets[..length]) => heard.push(octets[..length].to_vec()),
                    Ok(_) => {}
                    Err(_) if stopped.load(Ordering::Relaxed) => return heard,
                    Err(_) => {}
                }
            }
        })
    }
}
