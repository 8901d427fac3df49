//! What is known of a track's transponder, as JSON.

use schemars::JsonSchema;
use serde::Serialize;

use super::PictureTrack;
use crate::json::rounded;
use fusion::integrity::{PointIntegrity, Reason, Reasons, State};

/// The properties of a track that say whether it can be trusted; all are left out where that is not judged.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
pub(super) struct TrackIntegrity<'a> {
    /// Operational: whether its transponder can be trusted; docs/INTEGRITY.md.
    #[serde(skip_serializing_if = "Option::is_none")]
    integrity: Option<StateName>,
    /// Natural logarithm of how much likelier a lie of its transponder is than none, by radar.
    #[serde(skip_serializing_if = "Option::is_none")]
    integrity_index: Option<f64>,
    /// Radius that holds 95 % of the offsets that radar would not have shown by now, metres; left out where nothing bounds it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    protection_level_m: Option<f64>,
    /// Of a suspect or failed one, how far it is from where radar sees it, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    offset_m: Option<f64>,
    /// What speaks against its transponder.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    reasons: Vec<ReasonName>,
    /// Tracks that claim to be the same aircraft elsewhere.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    linked: Vec<Link<'a>>,
    /// It flies without a transponder where one is to be heard.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    uncooperative: bool,
}

/// A state by its name.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
#[serde(transparent)]
#[schemars(inline, extend("enum" = State::NAMES))]
pub struct StateName(&'static str);

impl From<State> for StateName {
    fn from(state: State) -> Self {
        Self(state.name())
    }
}

/// What speaks against a transponder, by its name.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
#[serde(transparent)]
#[schemars(inline, extend("enum" = Reason::NAMES))]
pub struct ReasonName(&'static str);

impl ReasonName {
    /// Those of a set.
    pub fn all(reasons: Reasons) -> Vec<Self> {
        reasons.iter().map(|reason| Self(reason.name())).collect()
    }
}

/// Relation of two tracks of which only one is where the aircraft is.
const DISPUTED: &str = "disputed";

/// Another track that has to do with it.
#[derive(Clone, Debug, Serialize, JsonSchema)]
struct Link<'a> {
    /// Its id.
    id: &'a str,
    /// Disputed: only one of both is where the aircraft is.
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
