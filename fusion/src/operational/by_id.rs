//! Map with keys and values in sorted vectors: it is iterated far more often than searched.

use serde::{Deserialize, Serialize};

/// Values in the order of their keys. New keys are almost always the largest.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct ById<K, T> {
    ids: Vec<K>,
    /// Values in the order of the keys.
    all: Vec<T>,
}

impl<K, T> Default for ById<K, T> {
    fn default() -> Self {
        Self { ids: Vec::new(), all: Vec::new() }
    }
}

impl<K: Ord + Copy, T> ById<K, T> {
    fn index(&self, id: K) -> Result<usize, usize> {
        match self.ids.last() {
            Some(&last) if last < id => Err(self.ids.len()),
            _ => self.ids.binary_search(&id),
        }
    }

    pub(super) fn get(&self, id: K) -> Option<&T> {
        self.all.get(self.index(id).ok()?)
    }

    pub(super) fn get_mut(&mut self, id: K) -> Option<&mut T> {
        let index = self.index(id).ok()?;
        self.all.get_mut(index)
    }

    /// Inserts a value, or replaces the one with this key.
    pub(super) fn insert(&mut self, id: K, thing: T) {
        match self.index(id) {
            Ok(index) => self.all[index] = thing,
            Err(index) => {
                self.ids.insert(index, id);
                self.all.insert(index, thing);
            }
        }
    }

    pub(super) fn remove(&mut self, id: K) -> Option<T> {
        let index = self.index(id).ok()?;
        self.ids.remove(index);
        Some(self.all.remove(index))
    }

    /// Keeps the values for which `is_kept` returns true, called in order.
    pub(super) fn retain(&mut self, mut is_kept: impl FnMut(K, &mut T) -> bool) {
        let Self { ids, all } = self;
        let kept: Vec<bool> = ids.iter().zip(all.iter_mut()).map(|(&id, thing)| is_kept(id, thing)).collect();
        if kept.iter().all(|&kept| kept) {
            return;
        }
        let mut of_ids = kept.iter();
        ids.retain(|_| of_ids.next() == Some(&true));
        let mut of_things = kept.iter();
        all.retain(|_| of_things.next() == Some(&true));
    }

    pub(super) fn values(&self) -> &[T] {
        &self.all
    }

    pub(super) fn values_mut(&mut self) -> &mut [T] {
        &mut self.all
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn map_by_id_matches_a_tree_map(steps in prop::collection::vec((0..4_u8, 0..12_u64), 0..60)) {
            let mut expected = BTreeMap::new();
            let mut things = ById::default();
            for (at, (step, id)) in steps.into_iter().enumerate() {
                match step {
                    0 | 1 => {
                        expected.insert(id, at);
                        things.insert(id, at);
                    }
                    2 => {
                        expected.remove(&id);
                        things.remove(id);
                    }
                    _ => {
                        expected.retain(|&other, thing| (other + *thing as u64) % 3 != id % 3);
                        things.retain(|other, thing| (other + *thing as u64) % 3 != id % 3);
                    }
                }
                prop_assert_eq!(things.values(), expected.values().copied().collect::<Vec<_>>());
                for id in 0..12 {
                    prop_assert_eq!(things.get(id), expected.get(&id));
                    prop_assert_eq!(things.get_mut(id), expected.get_mut(&id));
                }
            }
        }
    }
}
