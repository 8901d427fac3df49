//! Assessment of an identity: its state, the index, and the evidence.

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use super::state::{Reasons, State};
use super::trust::Trust;
use crate::report::{Identity, RadarTrackKey};
use crate::time::Time;

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
