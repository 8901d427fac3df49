//! Attacks on transponders, as recorded with the truth.

use fusion::integrity::Reason;
use fusion::time::Time;

/// A row of `attacks.csv`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attack {
    /// Id of the drone in the truth.
    pub id: String,
    /// The service's number of its transponder.
    pub number: u32,
    /// Kind of attack.
    pub kind: AttackKind,
    /// Beginning of the attack, by time of measurement.
    pub from: Time,
    /// End of the attack, by time of measurement.
    pub until: Time,
}

/// Kind of attack on a transponder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AttackKind {
    /// Positions drift away.
    Drift,
    /// Positions jump away by a constant offset.
    Jump,
    /// The position stays the same.
    Frozen,
    /// Earlier reports are repeated.
    Replay,
    /// A second transmitter of the same identity.
    Duplicate,
    /// Two transponders exchange identities.
    Swapped,
    /// Time stamps are shifted.
    Time,
    /// The transponder is not received; no false reports.
    Jammed,
}

impl AttackKind {
    /// All kinds.
    pub const ALL: [Self; 8] = [
        Self::Drift,
        Self::Jump,
        Self::Frozen,
        Self::Replay,
        Self::Duplicate,
        Self::Swapped,
        Self::Time,
        Self::Jammed,
    ];

    /// Name in `attacks.csv`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Drift => "drift",
            Self::Jump => "jump",
            Self::Frozen => "frozen",
            Self::Replay => "replay",
            Self::Duplicate => "duplicate",
            Self::Swapped => "swapped",
            Self::Time => "time",
            Self::Jammed => "jammed",
        }
    }

    /// Returns the kind with this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Reason of a flag that identifies this attack; `None` if there is no such reason.
    pub const fn reason(self) -> Option<Reason> {
        match self {
            Self::Drift | Self::Jammed => None,
            Self::Jump => Some(Reason::Jump),
            Self::Frozen => Some(Reason::Frozen),
            Self::Replay => Some(Reason::Replay),
            Self::Duplicate => Some(Reason::Duplicate),
            Self::Swapped => Some(Reason::Swapped),
            Self::Time => Some(Reason::Time),
        }
    }

    /// Whether the transponder sends false reports.
    pub const fn is_attack(self) -> bool {
        !matches!(self, Self::Jammed)
    }

    /// Time limit for detection by a rule on reports alone, seconds; `None` if detection needs a radar.
    pub(super) const fn limit_s(self) -> Option<f64> {
        match self {
            Self::Jump => Some(15.0),
            Self::Frozen | Self::Replay | Self::Duplicate | Self::Swapped => Some(30.0),
            Self::Drift | Self::Time | Self::Jammed => None,
        }
    }
}
