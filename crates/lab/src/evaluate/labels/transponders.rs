//! Carriers of transponders, by identity or number.

use std::collections::{BTreeMap, BTreeSet};

use super::Label;

/// Length of I129/040, octets.
const SERIAL_OCTETS: usize = 12;

/// Drones that the labels name as carriers of one transponder; `None`: not a drone.
type Carriers = BTreeSet<Option<String>>;

/// Carriers of all transponders.
#[derive(Clone, Debug, Default)]
pub(super) struct LabelledTransponders {
    /// By identity in upper case. A name that is too long for I129/040 is also listed by its end, the only part that
    /// CAT129 contains.
    by_name: BTreeMap<String, Carriers>,
    /// By the service's number, from rows without an identity.
    unnamed: BTreeMap<u32, Carriers>,
    /// By the service's number, as far as known.
    by_number: BTreeMap<u32, Carriers>,
}

impl LabelledTransponders {
    /// Adds a receiver's row; `given` holds the service's numbers by serial number.
    pub(super) fn insert(&mut self, row: &Label, given: &BTreeMap<String, u32>) {
        let Label { number, id, identity, .. } = row;
        let is_given = identity.as_ref().is_some_and(|name| given.get(name) == Some(number));
        if is_given || row.number_is_of_service() {
            self.by_number.entry(*number).or_default().insert(id.clone());
        }
        let Some(name) = identity.as_deref().map(str::to_ascii_uppercase) else {
            self.unnamed.entry(*number).or_default().insert(id.clone());
            return;
        };
        let from = name.len().checked_sub(SERIAL_OCTETS).filter(|&from| from > 0);
        if let Some(end) = from.and_then(|from| name.get(from..)) {
            self.by_name.entry(end.to_owned()).or_default().insert(id.clone());
        }
        self.by_name.entry(name).or_default().insert(id.clone());
    }

    /// Carriers of a transponder. Rows with another identity are ignored, whatever their number.
    pub(super) fn carriers(&self, identity: Option<&str>, number: u32) -> Option<&Carriers> {
        let Some(name) = identity else { return self.by_number.get(&number) };
        let named = if name.bytes().any(|octet| octet.is_ascii_lowercase()) {
            self.by_name.get(&name.to_ascii_uppercase())
        } else {
            self.by_name.get(name)
        };
        named.or_else(|| self.unnamed.get(&number))
    }

    /// Ids of all drones that carry a transponder.
    pub(super) fn carried(&self) -> impl Iterator<Item = &str> {
        self.by_name.values().chain(self.unnamed.values()).flatten().flatten().map(String::as_str)
    }
}

impl Label {
    /// Whether the number is the service's number of the transponder, as far as the row shows.
    pub(super) fn number_is_of_service(&self) -> bool {
        self.identity.as_deref().is_none_or(|name| name.parse() == Ok(self.number))
    }
}
