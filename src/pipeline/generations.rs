//! A bounded memory of what was heard lately.

use std::collections::BTreeMap;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use fusion::time::Time;

/// Keeps what was used within [`Generations::LASTS`], and nothing for longer than twice that.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(deserialize = "K: Ord + Deserialize<'de>, V: Deserialize<'de>"))]
pub(super) struct Generations<K, V> {
    young: BTreeMap<K, V>,
    old: BTreeMap<K, V>,
    /// When the young ones become the old ones.
    turns: Time,
}

impl<K, V> Default for Generations<K, V> {
    fn default() -> Self {
        Self { young: BTreeMap::new(), old: BTreeMap::new(), turns: Time::from_nanos(i64::MIN) }
    }
}

impl<K: Ord, V> Generations<K, V> {
    /// What is not used for so long may be forgotten.
    const LASTS: SignedDuration = SignedDuration::from_secs(60);
    /// Most of a generation: who comes when there are as many is not remembered.
    const MOST: usize = 20_000;

    /// What is kept under that key, as `new` makes it where there is nothing; `None`: there are too many.
    pub(super) fn of(&mut self, key: K, now: Time, new: impl FnOnce() -> V) -> Option<&mut V> {
        if now >= self.turns {
            // After a pause neither is of any use.
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
    fn what_is_used_stays_and_what_is_not_goes() {
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
    fn it_is_bounded() {
        let mut kept = Generations::default();
        let taken = (0..50_000).filter(|&key| kept.of(key, at(0), || ()).is_some()).count();
        assert_eq!(taken, Generations::<i32, ()>::MOST);
        assert!(kept.of(0, at(1), || ()).is_some(), "who is known stays");
    }
}
