//! How many connections may be open: in all, from one address, and some that only this machine can have.

use std::collections::{BTreeMap, HashMap};
use std::net::IpAddr;
use std::num::NonZeroU32;

use tokio::sync::watch;

use super::client::Subscriber;

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
    refused: BTreeMap<Refused, u64>,
}

/// Why a connection is not let in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Refused {
    /// Its address has as many as one may have.
    Address,
    /// There are as many as there may be, but for the places that are reserved.
    Full,
}

impl Refused {
    /// Its name in the metrics.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Address => "address",
            Self::Full => "full",
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
            entered = if cap.is_some_and(|cap| own >= cap.get()) {
                Err(Refused::Address)
            } else if inside.open >= most {
                Err(Refused::Full)
            } else {
                Ok(())
            };
            match entered {
                Ok(()) => {
                    inside.open += 1;
                    inside.by.insert(who, own + 1);
                }
                Err(refused) => *inside.refused.entry(refused).or_default() += 1,
            }
            // Nobody waits for more.
            false
        });
        entered.map(|()| Place { door: self.clone(), who })
    }

    /// How many are open.
    pub fn open(&self) -> usize {
        self.inside.borrow().open
    }

    /// How many were not let in, by reason.
    pub fn refused(&self) -> [(Refused, u64); 2] {
        let inside = self.inside.borrow();
        [Refused::Address, Refused::Full]
            .map(|refused| (refused, inside.refused.get(&refused).copied().unwrap_or(0)))
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
