//! Track numbers of transponders: given once, kept for good, with when that was.

use std::collections::{BTreeMap, BTreeSet};

use super::slots::Slot;
use crate::normalise::Identity;

/// The largest number: fused tracks are number · 10000 + radar track, which must fit 32 bits.
pub const LARGEST: u32 = 429_496;

/// A transponder's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Numbered {
    /// The number T.
    pub number: u32,
    /// The slot it was given in: the first emitted one with a point of the transponder.
    pub since: Slot,
}

/// Who was given which number: what outlives a restart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Given {
    /// The number T, 1 to [`LARGEST`].
    pub number: u32,
    /// The transponder.
    pub identity: Identity,
}

/// Who has which number.
#[derive(Clone, Debug, Default)]
pub struct Numbers {
    configured: BTreeMap<Vec<u8>, u32>,
    reserved: BTreeSet<u32>,
    given: BTreeMap<Identity, Numbered>,
    /// Given before a restart, to identities that have not been seen again since.
    remembered: BTreeMap<Identity, u32>,
    taken: BTreeSet<u32>,
    /// Given since the start, in the order in which they were.
    new: Vec<(Slot, Given)>,
    /// No number below this is free for an identity without a claim.
    lowest: u32,
    /// Points left out because no number was left.
    unnumbered: u64,
}

impl Numbers {
    /// None given yet; `configured`: trimmed serial number to number.
    pub fn new(configured: BTreeMap<Vec<u8>, u32>) -> Self {
        let reserved = configured.values().copied().collect();
        Self { configured, reserved, lowest: 1, ..Self::default() }
    }

    /// The number of an identity: the one it has; else its configured one if that is not taken; else its serial number
    /// if that is a number that is free; else the lowest free one. `None` when all are used up.
    ///
    /// `slot`: the slot being emitted, in which the identity has a point.
    pub fn of(&mut self, identity: Identity, slot: Slot) -> Option<Numbered> {
        if let Some(&numbered) = self.given.get(&identity) {
            return Some(numbered);
        }
        if let Some(number) = self.remembered.remove(&identity) {
            let numbered = Numbered { number, since: slot };
            self.given.insert(identity, numbered);
            return Some(numbered);
        }
        let configured = self.configured.get(identity.serial()).copied();
        let number = configured
            .filter(|number| !self.taken.contains(number))
            .or_else(|| decimal(identity.serial()).filter(|&number| self.is_free(number)))
            .or_else(|| self.lowest_free())?;
        self.taken.insert(number);
        let numbered = Numbered { number, since: slot };
        self.given.insert(identity, numbered);
        self.new.push((slot, Given { number, identity }));
        Some(numbered)
    }

    /// Takes over a number given before a restart: its identity has it again from the first slot emitted with a point of
    /// it, which is then its `since`. It stays even where the configuration has since given that number, or that serial,
    /// to someone else.
    ///
    /// `false`, and nothing is changed: the number is not 1 to [`LARGEST`], or it or the identity is taken.
    pub fn remember(&mut self, given: Given) -> bool {
        let Given { number, identity } = given;
        let has_one = self.given.contains_key(&identity) || self.remembered.contains_key(&identity);
        if !(1..=LARGEST).contains(&number) || has_one || !self.taken.insert(number) {
            return false;
        }
        self.remembered.insert(identity, number);
        true
    }

    /// The numbers given since the start, in the order in which they were, each with the slot in which it was; those
    /// remembered are not among them.
    pub fn new_ones(&self) -> &[(Slot, Given)] {
        &self.new
    }

    /// A point is left out because no number was left.
    pub(super) fn note_unnumbered(&mut self) {
        self.unnumbered += 1;
    }

    /// Points left out because no number was left.
    pub fn unnumbered(&self) -> u64 {
        self.unnumbered
    }

    fn is_free(&self, number: u32) -> bool {
        !self.taken.contains(&number) && !self.reserved.contains(&number)
    }

    fn lowest_free(&mut self) -> Option<u32> {
        while self.lowest <= LARGEST && !self.is_free(self.lowest) {
            self.lowest += 1;
        }
        (self.lowest <= LARGEST).then_some(self.lowest)
    }
}

/// A serial number that is a decimal integer from 1 to [`LARGEST`]; leading zeros are allowed.
fn decimal(serial: &[u8]) -> Option<u32> {
    if serial.is_empty() || !serial.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let number = serial.iter().fold(0_u64, |number, digit| number * 10 + u64::from(digit - b'0'));
    u32::try_from(number).ok().filter(|number| (1..=LARGEST).contains(number))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identity(serial: &str, country: &[u8; 2]) -> Identity {
        let mut octets = [b' '; 12];
        octets[..serial.len()].copy_from_slice(serial.as_bytes());
        Identity::new(&octets, Some(country)).unwrap()
    }

    #[test]
    fn configured_then_the_serial_itself_then_the_lowest_free() {
        let configured = BTreeMap::from([(b"ALPHA".to_vec(), 2), (b"BRAVO".to_vec(), 7)]);
        let mut numbers = Numbers::new(configured);
        let mut slot = 0;
        let mut of = |serial, country| {
            slot += 1;
            numbers.of(identity(serial, country), Slot(slot)).unwrap().number
        };
        assert_eq!(of("ALPHA", b"NO"), 2);
        assert_eq!(of("X", b"NO"), 1);
        assert_eq!(of("Y", b"NO"), 3, "2 is taken");
        assert_eq!(of("ALPHA", b"SE"), 4, "its configured number is taken");
        assert_eq!(of("0007", b"NO"), 5, "7 is configured for another");
        assert_eq!(of("000429496", b"NO"), 429_496);
        assert_eq!(of("429497", b"NO"), 6);
        assert_eq!(of("Z", b"NO"), 8, "7 is kept for BRAVO");
        assert_eq!(of("X", b"NO"), 1, "a number given stays");
        assert_eq!(of("BRAVO", b"NO"), 7);
        let alpha = numbers.of(identity("ALPHA", b"NO"), Slot(99));
        assert_eq!(alpha, Some(Numbered { number: 2, since: Slot(1) }), "and so does its first slot");
    }

    #[test]
    fn numbers_of_before_are_kept_and_bad_ones_refused() {
        let mut numbers = Numbers::new(BTreeMap::from([(b"ALPHA".to_vec(), 2)]));
        let given = |number, serial| Given { number, identity: identity(serial, b"NO") };
        assert!(numbers.remember(given(1, "X")));
        assert!(numbers.remember(given(2, "Y")), "although it is configured for another now");
        assert!(!numbers.remember(given(2, "Z")), "taken");
        assert!(!numbers.remember(given(3, "X")), "X has one");
        assert!(!numbers.remember(given(0, "Z")) && !numbers.remember(given(LARGEST + 1, "Z")));
        let mut of = |serial, slot| numbers.of(identity(serial, b"NO"), Slot(slot));
        assert_eq!(of("X", 5), Some(Numbered { number: 1, since: Slot(5) }));
        assert_eq!(of("X", 6), Some(Numbered { number: 1, since: Slot(5) }));
        assert_eq!(of("ALPHA", 7), Some(Numbered { number: 3, since: Slot(7) }), "1 and 2 are taken");
        assert_eq!(of("Y", 8), Some(Numbered { number: 2, since: Slot(8) }));
        assert_eq!(numbers.new_ones(), [(Slot(7), given(3, "ALPHA"))]);
    }

    #[test]
    fn numbers_end() {
        let mut numbers = Numbers { lowest: LARGEST, ..Numbers::new(BTreeMap::new()) };
        let mut of = |serial| numbers.of(identity(serial, b"NO"), Slot(0)).map(|numbered| numbered.number);
        assert_eq!(of("A"), Some(LARGEST));
        assert_eq!(of("B"), None);
        assert_eq!(of("C"), None);
        assert_eq!(of("A"), Some(LARGEST));
    }
}
