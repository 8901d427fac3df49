//! Problems with transponders, repeated in every emission while they last.

use serde::{Deserialize, Serialize};

use super::state::{Reasons, State};
use crate::frames::Enu;
use crate::report::Identity;
use crate::time::Time;

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
