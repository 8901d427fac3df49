//! Attacks on transponders: what was done to whom, and when.

use fusion::integrity::Reason;
use fusion::time::Time;

/// A row of `attacks.csv`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attack {
    /// The drone's id in the truth.
    pub id: String,
    /// The service's number of its transponder.
    pub number: u32,
    /// What is done.
    pub kind: AttackKind,
    /// When it begins, by the time of measurement.
    pub from: Time,
    /// When it ends.
    pub until: Time,
}

/// What is done to a transponder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AttackKind {
    /// Positions that drift away.
    Drift,
    /// Positions that are off at once.
    Jump,
    /// The same position for good.
    Frozen,
    /// Earlier reports again.
    Replay,
    /// A second transmitter of the same identity.
    Duplicate,
    /// Two identities exchanged.
    Swapped,
    /// Time stamps that are off.
    Time,
    /// It is not received: no lie.
    Jammed,
}

impl AttackKind {
    /// All of them.
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

    /// The one of that name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The reason of a flag that names it; `None` where none does.
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

    /// Whether the transponder lies.
    pub const fn is_lie(self) -> bool {
        !matches!(self, Self::Jammed)
    }

    /// Within how many seconds the rule for it has to find it, where it is found in the reports alone: `None` where it takes a
    /// radar.
    pub(super) const fn limit_s(self) -> Option<f64> {
        match self {
            Self::Jump => Some(15.0),
            Self::Frozen | Self::Replay | Self::Duplicate | Self::Swapped => Some(30.0),
            Self::Drift | Self::Time | Self::Jammed => None,
        }
    }
}
