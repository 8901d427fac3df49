//! How many streams are open: in all, and from each address; and how many ended because of their clients.

use std::collections::{BTreeMap, HashMap};
use std::net::{IpAddr, Ipv4Addr};
use std::sync::{Arc, Mutex, PoisonError};

use super::client::Subscriber;

/// The open streams.
#[derive(Clone, Debug)]
pub struct Seats {
    taken: Arc<Mutex<HashMap<Subscriber, usize>>>,
    dropped: Arc<Mutex<BTreeMap<Dropped, u64>>>,
    in_all: usize,
    per_address: usize,
}

impl Seats {
    /// With these limits.
    pub fn new(in_all: usize, per_address: usize) -> Self {
        Self { taken: Arc::default(), dropped: Arc::default(), in_all, per_address }
    }

    /// One more; `None` where that is too many.
    pub fn take(&self, client: Option<IpAddr>) -> Option<Seat> {
        let client = Subscriber::at(client.unwrap_or(Ipv4Addr::UNSPECIFIED.into()));
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let here = taken.get(&client).copied().unwrap_or(0);
        if taken.values().sum::<usize>() >= self.in_all || here >= self.per_address {
            return None;
        }
        taken.insert(client, here + 1);
        Some(Seat { seats: self.clone(), client })
    }

    /// One that its client has ended so.
    pub fn note_dropped(&self, dropped: Dropped) {
        *self.dropped.lock().unwrap_or_else(PoisonError::into_inner).entry(dropped).or_default() += 1;
    }

    /// How many ended so, by reason.
    pub fn dropped(&self) -> [(Dropped, u64); 3] {
        let counts = self.dropped.lock().unwrap_or_else(PoisonError::into_inner);
        Dropped::ALL.map(|dropped| (dropped, counts.get(&dropped).copied().unwrap_or(0)))
    }

    /// How many are open.
    pub fn taken(&self) -> usize {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner).values().sum()
    }
}

/// Why a WebSocket is dropped. (A stream of Server-Sent Events ends with its connection.)
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Dropped {
    /// Its client does not take what it asked for.
    Slow,
    /// It answers no ping.
    Silent,
    /// It does not keep to what is agreed.
    Protocol,
}

impl Dropped {
    /// All reasons.
    pub const ALL: [Self; 3] = [Self::Slow, Self::Silent, Self::Protocol];

    /// Its name in the metrics.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Slow => "slow",
            Self::Silent => "silent",
            Self::Protocol => "protocol",
        }
    }
}

/// An open stream; given back when it is dropped.
#[derive(Debug)]
pub struct Seat {
    seats: Seats,
    client: Subscriber,
}

impl Drop for Seat {
    fn drop(&mut self) {
        let mut taken = self.seats.taken.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(count) = taken.get_mut(&self.client) {
            *count -= 1;
            if *count == 0 {
                taken.remove(&self.client);
            }
        }
    }
}
