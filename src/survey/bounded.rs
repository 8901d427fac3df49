//! Maps that stop growing.

use std::collections::BTreeMap;

/// The first `most` keys that came, each with its value; later ones are refused.
#[derive(Clone, Debug)]
pub(super) struct Bounded<K, V> {
    entries: BTreeMap<K, V>,
    most: usize,
}

impl<K: Ord, V: Default> Bounded<K, V> {
    pub(super) fn new(most: usize) -> Self {
        Self { entries: BTreeMap::new(), most }
    }

    /// The value of a key, new where the key is; `None` for a new key beyond the bound.
    pub(super) fn get(&mut self, key: K) -> Option<&mut V> {
        if self.entries.len() >= self.most && !self.entries.contains_key(&key) {
            return None;
        }
        Some(self.entries.entry(key).or_default())
    }

    /// In the order of the keys.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&K, &V)> {
        self.entries.iter()
    }

    pub(super) fn len(&self) -> usize {
        self.entries.len()
    }
}
