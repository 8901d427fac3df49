//! Overrides of an identity's state by an operator.

use serde::{Deserialize, Serialize};

use crate::report::Identity;
use crate::slots::Slot;

/// Override of an identity's state by an operator. The index is not changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Trust {
    /// The identity is never suspect or failed.
    Trusted,
    /// The identity is always failed.
    Distrusted,
    /// The evidence decides; removes an override.
    Automatic,
}

crate::interface_names!(Trust { Trusted = "trusted", Distrusted = "distrusted", Automatic = "automatic" });

impl Trust {
    /// The override with this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|trust| trust.name() == name)
    }
}

/// An operator's decision on an identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrustOverride {
    /// The identity.
    pub identity: Identity,
    /// The override.
    pub trust: Trust,
}

/// An operator's override in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ActiveOverride {
    /// The decision; never [`Trust::Automatic`].
    pub word: TrustOverride,
    /// First slot published with the override.
    pub since: Slot,
}
