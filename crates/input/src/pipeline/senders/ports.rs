//! Addresses from which datagrams were received recently.

use std::collections::BTreeMap;
use std::net::SocketAddr;

use serde::{Deserialize, Serialize};

use super::is_within;
use fusion::time::{SECOND, Time};

/// Time of use below which a port represents its host, in nanoseconds.
const STEADY_NS: i64 = 2 * SECOND;
/// Time for which addresses are remembered, in nanoseconds.
const REMEMBERED_NS: i64 = 60 * SECOND;
/// Maximum number of addresses remembered: a flood of forged ones must not exhaust the memory.
pub(super) const ADDRESSES: usize = 4096;

/// The use of an address.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Port {
    first: Time,
    last: Time,
}

/// Addresses from which datagrams were received recently.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Ports(BTreeMap<SocketAddr, Port>);

impl Ports {
    /// Notes a datagram from this address.
    pub(super) fn hear(&mut self, from: SocketAddr, now: Time) {
        let known = self.0.get(&from).filter(|port| is_within(now, port.last, REMEMBERED_NS));
        let first = known.map_or(now, |port| port.first);
        self.0.insert(from, Port { first, last: now });
    }

    /// Time of the last datagram from this address.
    pub(super) fn last(&self, address: SocketAddr) -> Option<Time> {
        self.0.get(&address).map(|port| port.last)
    }

    /// Whether the port has been in use for at least 2 s.
    pub(super) fn is_steady(&self, address: SocketAddr) -> bool {
        self.0.get(&address).is_some_and(|port| port.last.nanos() - port.first.nanos() >= STEADY_NS)
    }

    /// Removes addresses without a datagram for a minute.
    pub(super) fn forget(&mut self, now: Time) {
        self.0.retain(|_, port| is_within(now, port.last, REMEMBERED_NS));
        if self.0.len() > ADDRESSES {
            self.0.clear();
        }
    }

    /// Number of addresses remembered.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }
}
