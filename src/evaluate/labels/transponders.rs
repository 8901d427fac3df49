//! Who carries which transponder, by its identity or its number.

use std::collections::{BTreeMap, BTreeSet};

use super::Label;

/// Octets of I129/040.
const SERIAL_OCTETS: usize = 12;

/// The drones, and no drone, that are said to carry a transponder.
type Carriers = BTreeSet<Option<String>>;

/// Who carries each transponder.
#[derive(Clone, Debug, Default)]
pub(super) struct Transponders {
    /// By the name of the identity in upper case; a name that is too long for I129/040 also by its end, which is all that CAT129
    /// states of it.
    by_name: BTreeMap<String, Carriers>,
    /// By the service's number, of rows that state no identity.
    unnamed: BTreeMap<u32, Carriers>,
    /// By the service's number, as far as that is known.
    by_number: BTreeMap<u32, Carriers>,
}

impl Transponders {
    /// Takes a receiver's row; `given`: the service's numbers by serial number.
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

    /// Those of a transponder; rows that state another identity do not speak for it, whatever their number.
    pub(super) fn carriers(&self, identity: Option<&str>, number: u32) -> Option<&Carriers> {
        let Some(name) = identity else { return self.by_number.get(&number) };
        let named = if name.bytes().any(|octet| octet.is_ascii_lowercase()) {
            self.by_name.get(&name.to_ascii_uppercase())
        } else {
            self.by_name.get(name)
        };
        named.or_else(|| self.unnamed.get(&number))
    }

    /// Ids of all drones that carry one.
    pub(super) fn carried(&self) -> impl Iterator<Item = &str> {
        self.by_name.values().chain(self.unnamed.values()).flatten().flatten().map(String::as_str)
    }
}

impl Label {
    /// Whether the number is the service's own for the transponder, as far as the row shows it.
    pub(super) fn number_is_of_service(&self) -> bool {
        self.identity.as_deref().is_none_or(|name| name.parse() == Ok(self.number))
    }
}
