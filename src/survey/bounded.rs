//! Maps that stop growing.

use std::collections::BTreeMap;

/// The first `MOST` keys that came, each with its value; later ones are refused.
#[derive(Clone, Debug)]
pub(super) struct Bounded<K, V, const MOST: usize>(BTreeMap<K, V>);

impl<K, V, const MOST: usize> Default for Bounded<K, V, MOST> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<K: Ord, V: Default, const MOST: usize> Bounded<K, V, MOST> {
    /// The value of a key, new where the key is; `None` for a new key beyond the bound.
    pub(super) fn get(&mut self, key: K) -> Option<&mut V> {
        if self.0.len() >= MOST && !self.0.contains_key(&key) {
            return None;
        }
        Some(self.0.entry(key).or_default())
    }

    /// In the order of the keys.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&K, &V)> {
        self.0.iter()
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }
}
