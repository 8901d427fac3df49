//! Trust in a transponder's identity, and the evidence against it (`operational` profile).
//!
//! A flag moves no position. `docs/INTEGRITY.md` defines the states.

mod bank;
mod motion;
mod rules;

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use crate::frames::Enu;
use crate::report::{Identity, RadarTrackKey};
use crate::slots::Slot;
use crate::time::Time;

pub(crate) use bank::{HypothesisBank, PersistentErrors, StampDelay, TrackObservation};
pub(crate) use motion::{MotionComparison, MotionStep};
pub(crate) use rules::{Finding, Jammed, ReportRules};

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

/// Integrity of the transponder of a published point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointIntegrity {
    /// State of the identity.
    pub state: State,
    /// Natural logarithm of the likelihood ratio, by radar, that the transponder reports false positions.
    pub index: f64,
    /// Largest offset that radar could have missed so far, metres: radius that holds 95 %. `None`: no radar bounds it.
    pub protection_level_m: Option<f64>,
    /// Estimated distance between the reported and the radar's position, metres; only of a suspect.
    pub offset_m: Option<f64>,
    /// Evidence against the identity.
    pub reasons: Reasons,
}

/// Integrity of an identity with recent reports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Assessment {
    /// The identity.
    pub identity: Identity,
    /// Transponder number of the identity, if assigned.
    pub number: Option<u32>,
    /// State, index, protection level, offset and reasons.
    pub integrity: PointIntegrity,
    /// Time of the slot's centre at which the state began.
    pub since: Time,
    /// Estimated offset of the positions, east and north, metres, with covariance, m²; only of a suspect.
    pub offset: Option<(Vector2<f64>, Matrix2<f64>)>,
    /// Time of the newest report.
    pub heard: Time,
    /// Whether the identity has fallen silent.
    pub is_silent: bool,
    /// Override by an operator; never [`Trust::Automatic`].
    pub trust: Option<Trust>,
    /// Track number of the aircraft that a radar sees away from the reported positions.
    pub twin: Option<u32>,
    /// Latest radar tracks that the identity was compared with, the newest first.
    pub evidence: Vec<Evidence>,
}

impl Assessment {
    /// An identity that was first received at `time`, without evidence.
    pub(crate) fn new(identity: Identity, time: Time) -> Self {
        Self {
            identity,
            number: None,
            integrity: PointIntegrity {
                state: State::Unverified,
                index: 0.0,
                protection_level_m: None,
                offset_m: None,
                reasons: Reasons::default(),
            },
            since: time,
            offset: None,
            heard: time,
            is_silent: false,
            trust: None,
            twin: None,
            evidence: Vec::new(),
        }
    }
}

/// Evidence of a radar track on an identity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// The radar track.
    pub track: RadarTrackKey,
    /// Whether the radar track was at the reported position; otherwise it flies the same motion elsewhere.
    pub is_near: bool,
    /// First second that counted.
    pub from: Time,
    /// Number of seconds that counted.
    pub seconds: u32,
    /// Contribution to the index.
    pub gain: f64,
}

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

/// Problem with transponders at a slot, repeated in every emission while it lasts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Concern {
    /// An identity is suspect or failed.
    Integrity {
        /// The identity.
        identity: Identity,
        /// Track number of the identity's point.
        track: Option<u32>,
        /// Track number of the aircraft that a radar sees away from the reported positions.
        twin: Option<u32>,
        /// Suspect or failed.
        state: State,
        /// Evidence against the identity.
        reasons: Reasons,
        /// Offset of the positions, metres, if estimated.
        offset_m: Option<f64>,
    },
    /// One identity alone has been silent for longer than usual gaps, while a radar still sees the aircraft.
    Silent {
        /// The identity.
        identity: Identity,
        /// Track number of the identity's point.
        track: Option<u32>,
        /// Time of the last report.
        heard: Time,
    },
    /// A transponder's heights differ from those of radars by a constant: their reference is unknown. Its integrity state does not
    /// change.
    Height {
        /// Identity of the transponder.
        identity: Identity,
        /// Track number of its point.
        track: Option<u32>,
        /// Reported less true height, metres.
        offset_m: f64,
        /// Standard deviation of the offset, metres.
        deviation_m: f64,
    },
    /// Many identities fell silent at once.
    Jamming {
        /// The identities.
        identities: Vec<Identity>,
        /// Last reported positions of the identities.
        places: Vec<Enu>,
        /// Time of the last report of the identity that fell silent first.
        since: Time,
    },
}

/// Settings of the integrity checks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegrityRules {
    /// Action on a transponder that reports false positions.
    pub action: Action,
    /// Index above which an identity is suspect (default 8.5).
    pub on: f64,
    /// Index below which an identity is no longer suspect (default 2).
    pub off: f64,
    /// Protection level up to which an identity is verified, metres (default 100).
    pub alert_limit_m: f64,
    /// Whether the covariance of a suspect includes its offset.
    pub accuracy: bool,
    /// Whether a radar track away from a suspect's positions is published as an aircraft of its own once it has lasted 2 s.
    pub show_twin: bool,
    /// Whether a suspect is ignored in the registration and in the association of others.
    pub protect: bool,
}

impl Default for IntegrityRules {
    fn default() -> Self {
        Self {
            action: Action::Flag,
            on: 8.5,
            off: 2.0,
            alert_limit_m: 100.0,
            accuracy: true,
            show_twin: true,
            protect: true,
        }
    }
}

/// Action on a transponder that reports false positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Action {
    /// Integrity is not computed.
    Off,
    /// The transponder is flagged.
    #[default]
    Flag,
    /// The transponder is flagged, and published at its reported position, separate from the radar's aircraft.
    Split,
}
