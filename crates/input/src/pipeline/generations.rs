//! A bounded map whose entries expire when they are not used.

use std::collections::BTreeMap;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use fusion::time::Time;

/// Keeps entries used within [`Generations::LASTS`]; unused ones are dropped after at most twice that time.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(deserialize = "K: Ord + Deserialize<'de>, V: Deserialize<'de>"))]
pub(super) struct Generations<K, V> {
    young: BTreeMap<K, V>,
    old: BTreeMap<K, V>,
    /// Time at which the young generation becomes the old one.
    turns: Time,
}

impl<K, V> Default for Generations<K, V> {
    fn default() -> Self {
        Self { young: BTreeMap::new(), old: BTreeMap::new(), turns: Time::from_nanos(i64::MIN) }
    }
}

impl<K: Ord, V> Generations<K, V> {
    /// Minimum time for which an unused entry is kept.
    const LASTS: SignedDuration = SignedDuration::from_secs(60);
    /// Maximum number of entries of a generation; further keys are not stored.
    const MOST: usize = 20_000;

    /// The value of a key, created by `new` if absent; `None`: the map is full.
    pub(super) fn of(&mut self, key: K, now: Time, new: impl FnOnce() -> V) -> Option<&mut V> {
        if now >= self.turns {
            // After a pause both generations have expired.
            self.old = if now < self.turns + Self::LASTS {
                std::mem::take(&mut self.young)
            } else {
                BTreeMap::new()
            };
            self.young.clear();
            self.turns = now + Self::LASTS;
        }
        if !self.young.contains_key(&key) {
            let known = self.old.remove(&key);
            if known.is_none() && self.young.len() >= Self::MOST {
                return None;
            }
            let value = known.unwrap_or_else(new);
            return Some(self.young.entry(key).or_insert(value));
        }
        self.young.get_mut(&key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fusion::time::SECOND;

    fn at(seconds: i64) -> Time {
        Time::from_nanos((1_700_000_000 + seconds) * SECOND)
    }

    #[test]
    fn used_entries_stay_and_unused_entries_expire() {
        let mut kept = Generations::default();
        *kept.of("used", at(0), || 0).unwrap() = 1;
        *kept.of("unused", at(0), || 0).unwrap() = 2;
        for seconds in (10..200).step_by(10) {
            assert_eq!(*kept.of("used", at(seconds), || 0).unwrap(), 1);
        }
        assert_eq!(*kept.of("unused", at(200), || 0).unwrap(), 0);
        assert_eq!(*kept.of("used", at(1000), || 0).unwrap(), 0, "after a pause");
    }

    #[test]
    fn number_of_entries_is_bounded() {
        let mut kept = Generations::default();
        let taken = (0..50_000).filter(|&key| kept.of(key, at(0), || ()).is_some()).count();
        assert_eq!(taken, Generations::<i32, ()>::MOST);
        assert!(kept.of(0, at(1), || ()).is_some(), "who is known stays");
    }
}
