//! Conversion of received names to the same static texts that the program uses.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer};

/// Maximum number of stored names; some dozens are in use. Further ones become [`OTHER`].
const MOST: usize = 1024;
const OTHER: &str = "other";

static NAMES: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());

fn name(text: String) -> &'static str {
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    match names.get(&*text) {
        Some(known) => known,
        None if names.len() >= MOST => OTHER,
        None => {
            let kept: &'static str = text.leak();
            names.insert(kept);
            kept
        }
    }
}

/// Names of a type's values in the configuration.
pub fn configured<T: tables::named::Named>() -> Vec<&'static str> {
    T::NAMES.iter().map(|&(name, _)| name).collect()
}

/// `names` without `one`.
pub fn without(names: &[&'static str], one: &str) -> Vec<&'static str> {
    names.iter().copied().filter(|name| *name != one).collect()
}

/// `names` followed by `one`.
pub fn with(names: &[&'static str], one: &'static str) -> Vec<&'static str> {
    names.iter().copied().chain([one]).collect()
}

/// Count with its noun: `1 track`, `2 tracks`.
pub fn counted(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// A type that contains static names.
pub trait Known {
    /// Type with owned names.
    type Owned: DeserializeOwned;

    /// Converts the owned names to static ones.
    fn known(owned: Self::Owned) -> Self;
}

impl Known for &'static str {
    type Owned = String;

    fn known(owned: String) -> Self {
        name(owned)
    }
}

impl<K: DeserializeOwned> Known for (K, &'static str) {
    type Owned = (K, String);

    fn known((key, owned): (K, String)) -> Self {
        (key, name(owned))
    }
}

impl<K: Known + Ord> Known for BTreeMap<K, u64> {
    type Owned = Vec<(K::Owned, u64)>;

    fn known(owned: Self::Owned) -> Self {
        owned.into_iter().map(|(key, count)| (K::known(key), count)).collect()
    }
}

impl Known for Vec<(&'static str, u64)> {
    type Owned = Vec<(String, u64)>;

    fn known(owned: Self::Owned) -> Self {
        owned.into_iter().map(|(text, count)| (name(text), count)).collect()
    }
}

/// Deserializes a type with names. Maps are read as postcard writes them, as lists of pairs.
///
/// # Errors
/// The format returns an error.
pub fn known<'de, D: Deserializer<'de>, T: Known>(deserializer: D) -> Result<T, D::Error> {
    T::Owned::deserialize(deserializer).map(T::known)
}
