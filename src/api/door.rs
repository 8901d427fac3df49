//! How many connections may be open: in all, from one address, and some that only this machine can have.

use std::collections::{BTreeMap, HashMap};
use std::net::IpAddr;
use std::num::NonZeroU32;

use tokio::sync::watch;
use tokio::time::{Duration, Instant};
use tracing::{info, warn};

use super::client::Subscriber;

/// The log speaks of connections that are refused for a reason once in that time; the metrics count each.
const TELL_AGAIN: Duration = Duration::from_secs(60);

/// The open connections.
#[derive(Clone, Debug)]
pub struct Door {
    inside: watch::Sender<Inside>,
    most: usize,
    reserved: usize,
}

#[derive(Debug, Default)]
struct Inside {
    open: usize,
    by: HashMap<Subscriber, u32>,
    refused: BTreeMap<Refused, Refusals>,
}

#[derive(Debug, Default)]
struct Refusals {
    count: u64,
    told: Option<Instant>,
}

/// Why a connection comes to nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Refused {
    /// Its address has as many as one may have.
    Address,
    /// There are as many as there may be, but for the places that are reserved.
    Full,
    /// No TLS handshake came about.
    Tls,
}

impl Refused {
    /// Its name in the metrics.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Address => "address",
            Self::Full => "full",
            Self::Tls => "tls",
        }
    }

    fn tell(self, peer: IpAddr) {
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

impl Door {
    /// `most` connections, the last `reserved` of them for this machine; where there are few, at most a quarter of them.
    pub fn new(most: usize, reserved: usize) -> Self {
        Self { inside: watch::Sender::default(), most, reserved: reserved.min(most / 4) }
    }

    /// One more, of at most `cap` from its address; given back when it is dropped.
    ///
    /// # Errors
    /// It is one too many.
    pub fn enter(&self, address: IpAddr, cap: Option<NonZeroU32>) -> Result<Place, Refused> {
        let who = Subscriber::at(address);
        let is_here = address.to_canonical().is_loopback();
        let most = if is_here { self.most } else { self.most - self.reserved };
        let mut entered = Ok(());
        self.inside.send_if_modified(|inside| {
            let own = inside.by.get(&who).copied().unwrap_or(0);
            if cap.is_some_and(|cap| own >= cap.get()) {
                entered = Err(Refused::Address);
            } else if inside.open >= most {
                entered = Err(Refused::Full);
            } else {
                inside.open += 1;
                inside.by.insert(who, own + 1);
            }
            // Nobody waits for more.
            false
        });
        entered
            .map(|()| Place { door: self.clone(), who })
            .inspect_err(|&refused| self.refuse(refused, address))
    }

    /// Counts a connection that came to nothing, and tells of it once in a while.
    pub fn refuse(&self, refused: Refused, peer: IpAddr) {
        let mut is_news = false;
        self.inside.send_if_modified(|inside| {
            let refusals = inside.refused.entry(refused).or_default();
            refusals.count += 1;
            is_news = refusals.told.is_none_or(|told| told.elapsed() >= TELL_AGAIN);
            if is_news {
                refusals.told = Some(Instant::now());
            }
            false
        });
        if is_news {
            refused.tell(peer);
        }
    }

    /// How many are open.
    pub fn open(&self) -> usize {
        self.inside.borrow().open
    }

    /// How many came to nothing, by reason.
    pub fn refused(&self) -> [(Refused, u64); 3] {
        let inside = self.inside.borrow();
        [Refused::Address, Refused::Full, Refused::Tls]
            .map(|refused| (refused, inside.refused.get(&refused).map_or(0, |refusals| refusals.count)))
    }

    /// Until none is open.
    pub async fn emptied(&self) {
        // The sender is this one's own.
        let _ = self.inside.subscribe().wait_for(|inside| inside.open == 0).await;
    }
}

/// An open connection.
#[derive(Debug)]
pub struct Place {
    door: Door,
    who: Subscriber,
}

impl Drop for Place {
    fn drop(&mut self) {
        self.door.inside.send_if_modified(|inside| {
            inside.open -= 1;
            if let Some(own) = inside.by.get_mut(&self.who) {
                *own -= 1;
                if *own == 0 {
                    inside.by.remove(&self.who);
                }
            }
            inside.open == 0
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
        /// Whoever comes and goes.
        #[test]
        fn nobody_has_more_than_the_cap_and_this_machine_has_its_reserve(
            steps in prop::collection::vec((0..5u8, any::<bool>()), 1..300),
            most in 4..20usize,
            cap in 1..8u32,
        ) {
            let door = Door::new(most, 3);
            let reserved = 3.min(most / 4);
            let mut places: BTreeMap<u8, Vec<Place>> = BTreeMap::new();
            for (who, comes) in steps {
                let inside: usize = places.values().map(Vec::len).sum();
                let own = places.entry(who).or_default();
                if !comes {
                    own.pop();
                    continue;
                }
                let most = if who == 0 { most } else { most - reserved };
                let expected = if own.len() as u32 >= cap {
                    Some(Refused::Address)
                } else if inside >= most {
                    Some(Refused::Full)
                } else {
                    None
                };
                match door.enter(address(who), NonZeroU32::new(cap)) {
                    Ok(place) => {
                        prop_assert_eq!(expected, None);
                        own.push(place);
                    }
                    Err(refused) => prop_assert_eq!(expected, Some(refused)),
                }
            }
            prop_assert_eq!(door.open(), places.values().map(Vec::len).sum::<usize>());
            drop(places);
            prop_assert_eq!(door.open(), 0);
            prop_assert!(door.inside.borrow().by.is_empty());
        }
    }
}
