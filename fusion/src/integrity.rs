//! Whether a transponder's identity can be trusted, and what speaks against it (`operational` profile).
//!
//! A flag informs: it moves no position. What each state means is in `docs/INTEGRITY.md`.

mod bank;
mod motion;
mod rules;

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use crate::frames::Enu;
use crate::report::{Identity, RadarTrackKey};
use crate::slots::Slot;
use crate::time::Time;

pub(crate) use bank::{Bank, Delay, Look, Slow};
pub(crate) use motion::{Motion, Step};
pub(crate) use rules::{Finding, Jammed, ReportRules};

/// How far a transponder's identity can be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum State {
    /// Nothing independent speaks for or against it.
    #[default]
    Unverified,
    /// Radar agrees.
    Verified,
    /// Something speaks against it.
    Suspect,
    /// Two independent radar tracks speak against it, or what cannot be honest.
    Failed,
}

crate::interface_names!(State {
    Unverified = "unverified",
    Verified = "verified",
    Suspect = "suspect",
    Failed = "failed",
});

impl State {
    /// Whether it is suspect or failed.
    pub const fn is_flagged(self) -> bool {
        matches!(self, Self::Suspect | Self::Failed)
    }
}

/// What speaks against an identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Reason {
    /// Radar tracks that are its own see it elsewhere.
    Radar,
    /// A report lies where the motion before it did not lead.
    Jump,
    /// The position stands still to the octet.
    Frozen,
    /// Earlier reports come again.
    Replay,
    /// Two transmitters send it.
    Duplicate,
    /// It has changed places with another identity.
    Swapped,
    /// The stated velocity is not that of the positions.
    Velocity,
    /// The time stamps are off.
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
    /// Adds one.
    pub fn insert(&mut self, reason: Reason) {
        self.0 |= 1 << reason as u8;
    }

    /// Whether it is in the set.
    pub fn contains(self, reason: Reason) -> bool {
        self.0 & (1 << reason as u8) != 0
    }

    /// Whether there is none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Those of either set.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// In the order of [`Reason::ALL`].
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

/// What is published of it with a point that a transponder takes part in.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointIntegrity {
    /// The state.
    pub state: State,
    /// Log-likelihood ratio of "it lies" to "it does not", by radar.
    pub index: f64,
    /// The offset that radar would not have shown by now, metres: radius that holds 95 %. `None`: nothing bounds it.
    pub protection_level_m: Option<f64>,
    /// Estimated distance between where it says it is and where radar sees it, metres; of a suspect only.
    pub offset_m: Option<f64>,
    /// What speaks against it.
    pub reasons: Reasons,
}

/// What is known of an identity that was heard lately.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Assessment {
    /// Who.
    pub identity: Identity,
    /// Its transponder number, where it has one.
    pub number: Option<u32>,
    /// State, index, protection level, offset and reasons.
    pub integrity: PointIntegrity,
    /// When the state began: the slot's centre.
    pub since: Time,
    /// Estimated offset of its positions, east and north, metres, with covariance, m²; of a suspect only.
    pub offset: Option<(Vector2<f64>, Matrix2<f64>)>,
    /// Time of its newest report.
    pub heard: Time,
    /// Whether it has fallen silent.
    pub is_silent: bool,
    /// What an operator says of it; never [`Trust::Automatic`].
    pub trust: Option<Trust>,
    /// Track number of the aircraft that a radar sees where it is not.
    pub twin: Option<u32>,
    /// The last radar tracks that it was compared with, the latest first.
    pub evidence: Vec<Evidence>,
}

impl Assessment {
    /// Nothing is known of it but that it was heard then.
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

/// What a radar track says of an identity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// The radar track.
    pub track: RadarTrackKey,
    /// Whether it was where the transponder says; otherwise it flies alike elsewhere.
    pub is_near: bool,
    /// The first second that counted.
    pub from: Time,
    /// How many seconds counted.
    pub seconds: u32,
    /// What it added to the index.
    pub gain: f64,
}

/// What an operator says of an identity: it overrides the state, not the index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Trust {
    /// It is what it says: never suspect or failed.
    Trusted,
    /// It is not: failed.
    Distrusted,
    /// Left to the evidence again.
    Automatic,
}

crate::interface_names!(Trust { Trusted = "trusted", Distrusted = "distrusted", Automatic = "automatic" });

impl Trust {
    /// The one of that name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|trust| trust.name() == name)
    }
}

/// What an operator says of an identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Word {
    /// Who.
    pub identity: Identity,
    /// What.
    pub trust: Trust,
}

/// An operator's word in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct HeldWord {
    /// The word; never [`Trust::Automatic`].
    pub word: Word,
    /// The first slot published by it.
    pub since: Slot,
}

/// What is wrong with transponders at a slot: in every emission for as long as it holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Concern {
    /// An identity is suspect or failed.
    Integrity {
        /// Who.
        identity: Identity,
        /// Track number of its point.
        track: Option<u32>,
        /// Track number of the aircraft that a radar sees where it is not.
        twin: Option<u32>,
        /// Suspect or failed.
        state: State,
        /// What speaks against it.
        reasons: Reasons,
        /// How far its positions are off, metres, where that is known.
        offset_m: Option<f64>,
    },
    /// An identity has been silent for longer than gaps last, by itself, and a radar still sees it.
    Silent {
        /// Who.
        identity: Identity,
        /// Track number of its point.
        track: Option<u32>,
        /// Its last report.
        heard: Time,
    },
    /// Many identities fell silent at once.
    Jamming {
        /// Who.
        identities: Vec<Identity>,
        /// Where they were heard last.
        places: Vec<Enu>,
        /// When the first of them fell silent: its last report.
        since: Time,
    },
}

/// The numbers of the integrity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegrityRules {
    /// What is done about a transponder that lies.
    pub action: Action,
    /// The index above which an identity is suspect (9).
    pub on: f64,
    /// The index below which it is no longer (2).
    pub off: f64,
    /// The protection level up to which an identity is verified, metres (60).
    pub alert_limit_m: f64,
    /// Whether the covariance of a suspect holds its offset.
    pub accuracy: bool,
    /// Whether what a radar sees where a suspect is not is published as soon as it lasts 2 s.
    pub show_twin: bool,
    /// Whether a suspect counts for nothing in the registration and the association of others.
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

/// What is done about a transponder that lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Action {
    /// Nothing is computed.
    Off,
    /// It is flagged.
    #[default]
    Flag,
    /// It is flagged, and published where it says it is, apart from what the radar sees.
    Split,
}
