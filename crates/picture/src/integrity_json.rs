//! Integrity of a track's transponder as JSON.

use schemars::JsonSchema;
use serde::Serialize;

use super::PictureTrack;
use fusion::integrity::{PointIntegrity, Reason, Reasons, State};
use input::json::rounded;

/// Properties of a track about its integrity. All are left out if integrity is not evaluated.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
pub(super) struct TrackIntegrity<'a> {
    /// Operational profile: integrity of its transponder; docs/INTEGRITY.md.
    #[serde(skip_serializing_if = "Option::is_none")]
    integrity: Option<StateName>,
    /// Natural logarithm of the likelihood ratio of a false to a true report of its transponder, by radar.
    #[serde(skip_serializing_if = "Option::is_none")]
    integrity_index: Option<f64>,
    /// Protection level, in metres: radius that contains 95 % of the position offsets that radar would not have revealed so far.
    /// Left out if there is no bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    protection_level_m: Option<f64>,
    /// Distance between a suspect or failed transponder's position and that seen by radar, in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    offset_m: Option<f64>,
    /// Evidence against its transponder.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    reasons: Vec<ReasonName>,
    /// Tracks that claim to be the same aircraft at another position.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    linked: Vec<Link<'a>>,
    /// Whether it flies without a transponder where a receiver should hear one.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    uncooperative: bool,
}

/// Name of an integrity state.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
#[serde(transparent)]
#[schemars(inline, extend("enum" = State::NAMES))]
pub struct StateName(&'static str);

impl From<State> for StateName {
    fn from(state: State) -> Self {
        Self(state.name())
    }
}

/// Name of a reason against a transponder.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
#[serde(transparent)]
#[schemars(inline, extend("enum" = Reason::NAMES))]
pub struct ReasonName(&'static str);

impl ReasonName {
    /// Names of a set of reasons.
    pub fn all(reasons: Reasons) -> Vec<Self> {
        reasons.iter().map(|reason| Self(reason.name())).collect()
    }
}

/// Relation of two tracks, only one of which is the aircraft.
const DISPUTED: &str = "disputed";

/// A related track.
#[derive(Clone, Debug, Serialize, JsonSchema)]
struct Link<'a> {
    /// Id of the track.
    id: &'a str,
    /// `disputed`: only one of the two tracks is the aircraft.
    #[schemars(extend("enum" = [DISPUTED]))]
    relation: &'static str,
}

impl<'a> TrackIntegrity<'a> {
    pub(super) fn new(track: &'a PictureTrack) -> Self {
        let linked = track.disputed.iter().map(|id| Link { id, relation: DISPUTED }).collect();
        let known = Self { linked, uncooperative: track.is_uncooperative, ..Self::default() };
        let Some(PointIntegrity { state, index, protection_level_m, offset_m, reasons }) =
            track.point.integrity
        else {
            return known;
        };
        let metres = |metres: Option<f64>| metres.map(|metres| rounded(metres, 1));
        Self {
            integrity: Some(state.into()),
            integrity_index: Some(rounded(index, 2)),
            protection_level_m: metres(protection_level_m),
            offset_m: metres(offset_m),
            reasons: ReasonName::all(reasons),
            ..known
        }
    }
}
