//! Data of an alert beside its text.

use fusion::Identity;
use fusion::integrity::{Reasons, State};
use fusion::time::Time;
use site::areas::{Zone, ZoneKind};

/// Machine-readable data of alerts about areas, transponders and conflicts.
#[derive(Clone, Debug, PartialEq)]
pub enum AlertDetails {
    /// The alert has no data beside its text.
    None,
    /// A transponder is suspect or failed.
    Integrity {
        /// The transponder.
        identity: Identity,
        /// Id of its track.
        track_id: Option<String>,
        /// Id of the track that radar sees elsewhere, most likely the real aircraft.
        twin_id: Option<String>,
        /// Suspect or failed.
        state: State,
        /// Reasons against the transponder.
        reasons: Reasons,
        /// Error of its positions, in whole metres.
        offset_m: Option<f64>,
    },
    /// Many transponders fell silent at once.
    Jamming {
        /// The silent transponders.
        identities: Vec<Identity>,
        /// Area of their last positions: longitude and latitude in degrees, a closed counterclockwise ring around all of
        /// them.
        hull: Vec<(f64, f64)>,
    },
    /// A transponder fell silent.
    Silent {
        /// The transponder.
        identity: Identity,
        /// Id of its track.
        track_id: Option<String>,
    },
    /// A transponder's heights contradict those of radars.
    Height {
        /// Identity of the transponder.
        identity: Identity,
        /// Id of its track.
        track_id: Option<String>,
        /// Reported less true height, whole metres.
        offset_m: Option<f64>,
    },
    /// An aircraft declares an emergency.
    Emergency {
        /// Its transponder.
        identity: Identity,
        /// Id of its track.
        track_id: Option<String>,
    },
    /// A drone without a transponder.
    Uncooperative {
        /// Ended because a transponder was received after all, or because the drone is the twin of a suspect transponder.
        is_resolved: bool,
    },
    /// A track is inside an area.
    Area {
        /// The area.
        area: AreaName,
        /// Label of the area: identifies the alert, with the track.
        label: String,
        /// The track's height is unknown, and the area is limited in height.
        is_height_unknown: bool,
    },
    /// A track is about to enter an area.
    AreaPredicted {
        /// The area.
        area: AreaName,
        /// Label of the area: identifies the alert, with the track.
        label: String,
        /// Time to entry on the present course, in seconds; `None` if only a course one standard deviation beside it
        /// enters.
        time_to_entry_s: Option<f64>,
        /// Earliest time to entry, in seconds: on the present course or one standard deviation beside it.
        earliest_s: f64,
    },
    /// Two aircraft come close to each other.
    Conflict {
        /// The engine's number of the conflict.
        id: u64,
        /// Ids of the tracks of all aircraft of the situation, those of the worst pair first.
        tracks: Vec<String>,
        /// Name of the protection volume.
        volume: String,
        /// Closest approach of the situation so far.
        closest: ClosestPair,
        /// Number of aircraft that were in a violation so far.
        endangered: usize,
        /// Whether a volume is entered now.
        is_entered: bool,
    },
}

/// Two aircraft at the time of their closest approach.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosestPair {
    /// Time of the approach.
    pub at: Time,
    /// Distance over ground, metres.
    pub horizontal_m: f64,
    /// Difference of the heights, metres; `None`: not known.
    pub vertical_m: Option<f64>,
}

/// Identification of an area.
#[derive(Clone, Debug, PartialEq)]
pub struct AreaName {
    /// Name of the area.
    pub name: String,
    /// Identifier that the authority gave the area.
    pub identifier: Option<String>,
    /// Kind of the zone, if stated.
    pub kind: Option<ZoneKind>,
}

impl From<&Zone> for AreaName {
    fn from(zone: &Zone) -> Self {
        Self { name: zone.name.clone(), identifier: zone.identifier.clone(), kind: zone.kind }
    }
}

impl AlertDetails {
    /// Label of the alert area; empty if the alert is not about one.
    pub(super) fn area(&self) -> &str {
        match self {
            Self::Area { label, .. } | Self::AreaPredicted { label, .. } => label,
            _ => "",
        }
    }

    /// Whether `later` is about further aircraft in danger.
    pub(super) fn is_wider(&self, later: &Self) -> bool {
        match (self, later) {
            (Self::Conflict { endangered, .. }, Self::Conflict { endangered: now, .. }) => now > endangered,
            _ => false,
        }
    }

    /// Whether `later` differs in a way that is reported to operators.
    pub(super) fn are_news_to(&self, later: &Self) -> bool {
        match (self, later) {
            (
                Self::Integrity { state, reasons, twin_id, .. },
                Self::Integrity { state: state_now, reasons: reasons_now, twin_id: twin_now, .. },
            ) => (state, reasons, twin_id) != (state_now, reasons_now, twin_now),
            (
                Self::Conflict { tracks, is_entered, .. },
                Self::Conflict { tracks: tracks_now, is_entered: entered_now, .. },
            ) => is_entered != entered_now || tracks_now.iter().any(|track| !tracks.contains(track)),
            (Self::Jamming { identities, .. }, Self::Jamming { identities: now, .. }) => identities != now,
            _ => false,
        }
    }
}
