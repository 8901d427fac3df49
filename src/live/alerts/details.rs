//! What is known of an alert beside its text.

use crate::areas::{Zone, ZoneKind};
use fusion::Identity;
use fusion::integrity::{Reasons, State};

/// What alerts about areas, transponders and conflicts say for programs.
#[derive(Clone, Debug, PartialEq)]
pub enum Details {
    /// Nothing but the text.
    None,
    /// A transponder is suspect or failed.
    Integrity {
        /// Who.
        identity: Identity,
        /// Id of its track.
        track_id: Option<String>,
        /// Id of the track that radar sees where it is not.
        twin_id: Option<String>,
        /// Suspect or failed.
        state: State,
        /// What speaks against it.
        reasons: Reasons,
        /// How far its positions are off, whole metres.
        offset_m: Option<f64>,
    },
    /// Many transponders fell silent at once.
    Jamming {
        /// Who.
        identities: Vec<Identity>,
        /// Where they were heard last: longitude and latitude, degrees, a closed ring counterclockwise around all of them.
        hull: Vec<(f64, f64)>,
    },
    /// A transponder fell silent.
    Silent {
        /// Who.
        identity: Identity,
        /// Id of its track.
        track_id: Option<String>,
    },
    /// An aircraft declares an emergency.
    Emergency {
        /// Who.
        identity: Identity,
        /// Id of its track.
        track_id: Option<String>,
    },
    /// A drone without a transponder.
    Uncooperative {
        /// It has ended because one was heard after all, or because it is the twin of one that lies.
        is_resolved: bool,
    },
    /// A track is inside an area.
    Area {
        /// Which.
        area: AreaName,
        /// It is inside only if its height is, which nobody knows.
        is_height_unknown: bool,
    },
    /// A track is about to enter an area.
    AreaPredicted {
        /// Which.
        area: AreaName,
        /// When it enters at its course, seconds; `None`: only at one beside it.
        time_to_entry_s: Option<f64>,
        /// The least of that at its course and at those a deviation beside it.
        earliest_s: f64,
    },
    /// Two aircraft come near each other.
    Conflict {
        /// The engine's number of it.
        id: u64,
        /// Ids of their tracks.
        tracks: [String; 2],
        /// Name of the volume.
        volume: String,
    },
}

/// What tells an area from others.
#[derive(Clone, Debug, PartialEq)]
pub struct AreaName {
    /// What people call it.
    pub name: String,
    /// What its authority calls it.
    pub identifier: Option<String>,
    /// What holds in it, where that is said.
    pub kind: Option<ZoneKind>,
}

impl From<&Zone> for AreaName {
    fn from(zone: &Zone) -> Self {
        Self { name: zone.name.clone(), identifier: zone.identifier.clone(), kind: zone.kind }
    }
}

impl Details {
    /// Whether `later` says something that an operator is told.
    pub(super) fn are_news_to(&self, later: &Self) -> bool {
        match (self, later) {
            (
                Self::Integrity { state, reasons, twin_id, .. },
                Self::Integrity { state: state_now, reasons: reasons_now, twin_id: twin_now, .. },
            ) => (state, reasons, twin_id) != (state_now, reasons_now, twin_now),
            (Self::Jamming { identities, .. }, Self::Jamming { identities: now, .. }) => identities != now,
            _ => false,
        }
    }
}
