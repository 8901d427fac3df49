//! States of a transponder's identity, and kinds of evidence against it.

use serde::{Deserialize, Serialize};

/// Degree to which a transponder's identity can be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum State {
    /// No independent evidence for or against the identity.
    #[default]
    Unverified,
    /// A radar agrees with the positions.
    Verified,
    /// Evidence contradicts the identity.
    Suspect,
    /// Two independent radar tracks contradict the identity, or it reports what an honest transponder cannot.
    Failed,
}

crate::interface_names!(State {
    Unverified = "unverified",
    Verified = "verified",
    Suspect = "suspect",
    Failed = "failed",
});

impl State {
    /// Whether the state is suspect or failed.
    pub const fn is_flagged(self) -> bool {
        matches!(self, Self::Suspect | Self::Failed)
    }
}

/// Kind of evidence against an identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Reason {
    /// A radar sees the aircraft away from the reported positions.
    Radar,
    /// A report lies far from the predicted motion.
    Jump,
    /// The position does not change by a single octet.
    Frozen,
    /// Earlier reports are repeated.
    Replay,
    /// Two transmitters send the identity.
    Duplicate,
    /// The identity has changed places with another one.
    Swapped,
    /// The stated velocity does not match the positions.
    Velocity,
    /// The time stamps are wrong.
    Time,
}

crate::interface_names!(Reason {
    Radar = "radar",
    Jump = "jump",
    Frozen = "frozen",
    Replay = "replay",
    Duplicate = "duplicate",
    Swapped = "swapped",
    Velocity = "velocity",
    Time = "time",
});

/// A set of reasons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Reasons(u8);

impl Reasons {
    /// Adds a reason.
    pub fn insert(&mut self, reason: Reason) {
        self.0 |= 1 << reason as u8;
    }

    /// Whether the set contains a reason.
    pub fn contains(self, reason: Reason) -> bool {
        self.0 & (1 << reason as u8) != 0
    }

    /// Whether the set is empty.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Union of two sets.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The reasons in the order of [`Reason::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Reason> {
        Reason::ALL.into_iter().filter(move |&reason| self.contains(reason))
    }
}

impl FromIterator<Reason> for Reasons {
    fn from_iter<T: IntoIterator<Item = Reason>>(reasons: T) -> Self {
        let mut set = Self::default();
        reasons.into_iter().for_each(|reason| set.insert(reason));
        set
    }
}
