//! Limits on open streams, in total and per client address, and counters of streams ended because of their clients.

use std::collections::{BTreeMap, HashMap};
use std::net::{IpAddr, Ipv4Addr};
use std::sync::{Arc, Mutex, PoisonError};

use super::client::Subscriber;

/// Counter of the open streams.
#[derive(Clone, Debug)]
pub struct StreamLimit {
    open: Arc<Mutex<HashMap<Subscriber, usize>>>,
    dropped: Arc<Mutex<BTreeMap<StreamDropReason, u64>>>,
    in_all: usize,
    per_address: usize,
}

impl StreamLimit {
    /// Creates a counter with these limits.
    pub fn new(in_all: usize, per_address: usize) -> Self {
        Self { open: Arc::default(), dropped: Arc::default(), in_all, per_address }
    }

    /// Counts a new stream; `None` if a limit is reached.
    pub fn admit(&self, client: Option<IpAddr>) -> Option<CountedStream> {
        let client = Subscriber::at(client.unwrap_or(Ipv4Addr::UNSPECIFIED.into()));
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        let here = open.get(&client).copied().unwrap_or(0);
        if open.values().sum::<usize>() >= self.in_all || here >= self.per_address {
            return None;
        }
        open.insert(client, here + 1);
        Some(CountedStream { stream_limit: self.clone(), client })
    }

    /// Counts a stream that was dropped for this reason.
    pub fn record_drop(&self, dropped: StreamDropReason) {
        *self.dropped.lock().unwrap_or_else(PoisonError::into_inner).entry(dropped).or_default() += 1;
    }

    /// Number of dropped streams, by reason.
    pub fn drops(&self) -> [(StreamDropReason, u64); 3] {
        let counts = self.dropped.lock().unwrap_or_else(PoisonError::into_inner);
        StreamDropReason::ALL.map(|dropped| (dropped, counts.get(&dropped).copied().unwrap_or(0)))
    }

    /// Number of open streams.
    pub fn open_streams(&self) -> usize {
        self.open.lock().unwrap_or_else(PoisonError::into_inner).values().sum()
    }
}

/// Reason why a WebSocket is dropped. (A stream of Server-Sent Events ends with its connection.)
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum StreamDropReason {
    /// The client does not read its messages in time.
    Slow,
    /// The client answers no ping.
    Silent,
    /// The client violates the protocol.
    Protocol,
}

impl StreamDropReason {
    /// All reasons.
    pub const ALL: [Self; 3] = [Self::Slow, Self::Silent, Self::Protocol];

    /// Name of the reason in the metrics.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Slow => "slow",
            Self::Silent => "silent",
            Self::Protocol => "protocol",
        }
    }
}

/// An open stream, counted until it is dropped.
#[derive(Debug)]
pub struct CountedStream {
    stream_limit: StreamLimit,
    client: Subscriber,
}

impl Drop for CountedStream {
    fn drop(&mut self) {
        let mut open = self.stream_limit.open.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(count) = open.get_mut(&self.client) {
            *count -= 1;
            if *count == 0 {
                open.remove(&self.client);
            }
        }
    }
}
