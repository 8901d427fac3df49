//! The addresses that datagrams have come from lately.

use std::collections::BTreeMap;
use std::net::SocketAddr;

use serde::{Deserialize, Serialize};

use super::is_within;
use fusion::time::{SECOND, Time};

/// A port that has been in use for less than this stands for its host, nanoseconds.
const STEADY_NS: i64 = 2 * SECOND;
/// Addresses are remembered for this long, nanoseconds.
const REMEMBERED_NS: i64 = 60 * SECOND;
/// Most addresses that are remembered: a flood of made-up ones must not fill the memory.
pub(super) const ADDRESSES: usize = 4096;

/// An address that datagrams come from.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Port {
    first: Time,
    last: Time,
}

/// The addresses that datagrams have come from lately.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Ports(BTreeMap<SocketAddr, Port>);

impl Ports {
    /// A datagram has come from this address.
    pub(super) fn hear(&mut self, from: SocketAddr, now: Time) {
        let known = self.0.get(&from).filter(|port| is_within(now, port.last, REMEMBERED_NS));
        let first = known.map_or(now, |port| port.first);
        self.0.insert(from, Port { first, last: now });
    }

    /// Reception of the last datagram from this address.
    pub(super) fn last(&self, address: SocketAddr) -> Option<Time> {
        self.0.get(&address).map(|port| port.last)
    }

    /// Whether the port has been in use for some time.
    pub(super) fn is_steady(&self, address: SocketAddr) -> bool {
        self.0.get(&address).is_some_and(|port| port.last.nanos() - port.first.nanos() >= STEADY_NS)
    }

    /// Forgets the addresses that nothing has come from for a minute.
    pub(super) fn forget(&mut self, now: Time) {
        self.0.retain(|_, port| is_within(now, port.last, REMEMBERED_NS));
        if self.0.len() > ADDRESSES {
            self.0.clear();
        }
    }

    /// Number of addresses that are remembered.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }
}
