//! How many streams are open: in all, and from each address.

use std::collections::HashMap;
use std::net::{IpAddr, Ipv4Addr};
use std::sync::{Arc, Mutex, PoisonError};

use super::client::Subscriber;

/// The open streams.
#[derive(Clone, Debug)]
pub struct Seats {
    taken: Arc<Mutex<HashMap<Subscriber, usize>>>,
    in_all: usize,
    per_address: usize,
}

impl Seats {
    /// With these limits.
    pub fn new(in_all: usize, per_address: usize) -> Self {
        Self { taken: Arc::default(), in_all, per_address }
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

    /// How many are open.
    pub fn taken(&self) -> usize {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner).values().sum()
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
