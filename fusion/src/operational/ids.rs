//! Names of tracklets and targets inside the engine: in the order in which they began, never used again.

use serde::{Deserialize, Serialize};

/// Tells tracklets apart, also those that had one radar track number after another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub(super) struct TrackletId(pub(super) u64);

/// Tells targets apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub(super) struct TargetId(pub(super) u64);
