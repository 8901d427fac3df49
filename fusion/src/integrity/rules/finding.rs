//! Result of the rules for one identity.

use crate::integrity::state::Reasons;
use crate::time::Time;

/// Present result of the rules for an identity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Finding {
    /// Rules that make the identity suspect.
    pub(crate) suspect: Reasons,
    /// Rules that are certain: the identity has failed.
    pub(crate) failed: Reasons,
    /// Time since which the reported position is exactly constant, after 12 s and five reports. The identity has failed
    /// if a radar track of it moves.
    pub(crate) still_since: Option<Time>,
    /// Time of its last report, if it has fallen silent.
    pub(crate) silent_since: Option<Time>,
}
