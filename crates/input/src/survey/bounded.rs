//! Maps of bounded size.

use std::collections::BTreeMap;

/// The values of the first `MOST` keys; further keys are refused.
#[derive(Clone, Debug)]
pub(super) struct Bounded<K, V, const MOST: usize>(BTreeMap<K, V>);

impl<K, V, const MOST: usize> Default for Bounded<K, V, MOST> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<K: Ord, V: Default, const MOST: usize> Bounded<K, V, MOST> {
    /// The value of a key, created if the key is new; `None`: the map is full.
    pub(super) fn get(&mut self, key: K) -> Option<&mut V> {
        if self.0.len() >= MOST && !self.0.contains_key(&key) {
            return None;
        }
        Some(self.0.entry(key).or_default())
    }

    /// The entries in the order of the keys.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&K, &V)> {
        self.0.iter()
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }
}
