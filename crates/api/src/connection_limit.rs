//! Limits on open connections: in total, per client address, and some reserved for this machine.

use std::collections::{BTreeMap, HashMap};
use std::net::IpAddr;
use std::num::NonZeroU32;

use tokio::sync::watch;
use tokio::time::{Duration, Instant};
use tracing::{info, warn};

use super::client::Subscriber;

/// Minimum time between two log lines about connections refused for the same reason. The metrics count each one.
const LOG_INTERVAL: Duration = Duration::from_secs(60);

/// Counter of the open connections.
#[derive(Clone, Debug)]
pub struct ConnectionLimit {
    counts: watch::Sender<OpenConnections>,
    max: usize,
    reserved: usize,
}

#[derive(Debug, Default)]
struct OpenConnections {
    open: usize,
    per_client: HashMap<Subscriber, u32>,
    refused: BTreeMap<ConnectionRefusal, RefusalCount>,
}

#[derive(Debug, Default)]
struct RefusalCount {
    count: u64,
    logged: Option<Instant>,
}

/// Reason why a connection fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ConnectionRefusal {
    /// The client address has the maximum number of connections.
    Address,
    /// All connections that are not reserved are in use.
    Full,
    /// The TLS handshake failed.
    Tls,
}

impl ConnectionRefusal {
    /// Name of the reason in the metrics.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Address => "address",
            Self::Full => "full",
            Self::Tls => "tls",
        }
    }

    fn log(self, peer: IpAddr) {
        match self {
            Self::Address => warn!(
                "{peer} has as many HTTP connections as one address may have (http.connections_per_address); \
                 further ones are closed at once. If it is a reverse proxy, name it in http.trusted_proxies"
            ),
            Self::Full => warn!(
                "as many HTTP connections are open as there may be; further ones, now from {peer}, are closed at once"
            ),
            Self::Tls => info!(
                "no TLS handshake with {peer}: it speaks plain HTTP, does not trust the certificate, or says nothing"
            ),
        }
    }
}

impl ConnectionLimit {
    /// Limit of `max` connections, the last `reserved` of them for this machine. At most a quarter can be reserved.
    pub fn new(max: usize, reserved: usize) -> Self {
        Self { counts: watch::Sender::default(), max, reserved: reserved.min(max / 4) }
    }

    /// Counts a new connection, at most `cap` per client. It is released when the result is dropped.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn admit(
        &self,
        address: IpAddr,
        cap: Option<NonZeroU32>,
    ) -> Result<CountedConnection, ConnectionRefusal> {
        let client = Subscriber::at(address);
        let is_here = address.to_canonical().is_loopback();
        let max = if is_here { self.max } else { self.max - self.reserved };
        let mut entered = Ok(());
        self.counts.send_if_modified(|counts| {
            let of_client = counts.per_client.get(&client).copied().unwrap_or(0);
            if cap.is_some_and(|cap| of_client >= cap.get()) {
                entered = Err(ConnectionRefusal::Address);
            } else if counts.open >= max {
                entered = Err(ConnectionRefusal::Full);
            } else {
                counts.open += 1;
                counts.per_client.insert(client, of_client + 1);
            }
            // No task waits for a higher count.
            false
        });
        entered
            .map(|()| CountedConnection { connection_limit: self.clone(), client })
            .inspect_err(|&refused| self.refuse(refused, address))
    }

    /// Counts a failed connection, and logs it at most once a minute per reason.
    pub fn refuse(&self, refused: ConnectionRefusal, peer: IpAddr) {
        let mut is_news = false;
        self.counts.send_if_modified(|counts| {
            let refusals = counts.refused.entry(refused).or_default();
            refusals.count += 1;
            is_news = refusals.logged.is_none_or(|logged| logged.elapsed() >= LOG_INTERVAL);
            if is_news {
                refusals.logged = Some(Instant::now());
            }
            false
        });
        if is_news {
            refused.log(peer);
        }
    }

    /// Number of open connections.
    pub fn open(&self) -> usize {
        self.counts.borrow().open
    }

    /// Number of failed connections, by reason.
    pub fn refused(&self) -> [(ConnectionRefusal, u64); 3] {
        let counts = self.counts.borrow();
        [ConnectionRefusal::Address, ConnectionRefusal::Full, ConnectionRefusal::Tls]
            .map(|refused| (refused, counts.refused.get(&refused).map_or(0, |refusals| refusals.count)))
    }

    /// Waits until no connection is open.
    pub async fn all_closed(&self) {
        // `self` owns the sender, so the channel stays open.
        let _ = self.counts.subscribe().wait_for(|counts| counts.open == 0).await;
    }
}

/// An open connection, counted until it is dropped.
#[derive(Debug)]
pub struct CountedConnection {
    connection_limit: ConnectionLimit,
    client: Subscriber,
}

impl Drop for CountedConnection {
    fn drop(&mut self) {
        self.connection_limit.counts.send_if_modified(|counts| {
            counts.open -= 1;
            if let Some(of_client) = counts.per_client.get_mut(&self.client) {
                *of_client -= 1;
                if *of_client == 0 {
                    counts.per_client.remove(&self.client);
                }
            }
            counts.open == 0
        });
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn address(number: u8) -> IpAddr {
        if number == 0 { [127, 0, 0, 1].into() } else { [192, 0, 2, number].into() }
    }

    proptest! {
        /// Connections of any sequence of clients.
        #[test]
        fn connections_stay_within_cap_and_reserve(
            steps in prop::collection::vec((0..5u8, any::<bool>()), 1..300),
            max in 4..20usize,
            cap in 1..8u32,
        ) {
            let connection_limit = ConnectionLimit::new(max, 3);
            let reserved = 3.min(max / 4);
            let mut connections: BTreeMap<u8, Vec<CountedConnection>> = BTreeMap::new();
            for (client, comes) in steps {
                let open: usize = connections.values().map(Vec::len).sum();
                let of_client = connections.entry(client).or_default();
                if !comes {
                    of_client.pop();
                    continue;
                }
                let max = if client == 0 { max } else { max - reserved };
                let expected = if of_client.len() as u32 >= cap {
                    Some(ConnectionRefusal::Address)
                } else if open >= max {
                    Some(ConnectionRefusal::Full)
                } else {
                    None
                };
                match connection_limit.admit(address(client), NonZeroU32::new(cap)) {
                    Ok(connection) => {
                        prop_assert_eq!(expected, None);
                        of_client.push(connection);
                    }
                    Err(refused) => prop_assert_eq!(expected, Some(refused)),
                }
            }
            prop_assert_eq!(connection_limit.open(), connections.values().map(Vec::len).sum::<usize>());
            drop(connections);
            prop_assert_eq!(connection_limit.open(), 0);
            prop_assert!(connection_limit.counts.borrow().per_client.is_empty());
        }
    }
}
