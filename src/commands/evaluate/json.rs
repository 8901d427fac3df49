//! The scores as JSON, for each group and drone; metrics without a value are omitted.

use serde::Serialize;

use super::{Scores, conflicts, integrity};
use crate::evaluate::{Score, Scored};

#[derive(Serialize)]
pub(super) struct Json<'a> {
    /// Reference rate of the PU, updates per second.
    reference_hz: f64,
    labels: bool,
    capture: bool,
    fused: Groups<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    radar: Option<Groups<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    transponder: Option<Groups<'a>>,
    drones: Vec<DroneJson<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    integrity: Option<&'a integrity::Scored>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    conflicts: &'a [conflicts::Scored],
    #[serde(skip_serializing_if = "Vec::is_empty")]
    requirements: Vec<RequirementJson>,
}

#[derive(Serialize)]
struct Groups<'a> {
    all: &'a Score,
    equipped: &'a Score,
    unequipped: &'a Score,
}

#[derive(Serialize)]
struct DroneJson<'a> {
    id: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    equipped: Option<bool>,
    fused: &'a Score,
    #[serde(skip_serializing_if = "Option::is_none")]
    radar: Option<&'a Score>,
    #[serde(skip_serializing_if = "Option::is_none")]
    transponder: Option<&'a Score>,
}

#[derive(Serialize)]
struct RequirementJson {
    require: String,
    met: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    value: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

pub(super) fn json<'a>(scores: &'a Scores<'a>) -> Json<'a> {
    let evaluation = scores.evaluation;
    let drones = evaluation.drones.iter().enumerate().map(|(index, drone)| DroneJson {
        id: &drone.id,
        equipped: drone.equipped,
        fused: &evaluation.fused.drones[index],
        radar: evaluation.radar.as_ref().map(|scored| &scored.drones[index]),
        transponder: evaluation.transponder.as_ref().map(|scored| &scored.drones[index]),
    });
    let requirements = scores.requirements.iter().map(|(requirement, value, met)| RequirementJson {
        require: requirement.to_string(),
        met: *met,
        value: value.as_ref().ok().copied(),
        reason: value.as_ref().err().cloned(),
    });
    Json {
        reference_hz: scores.reference_hz,
        labels: scores.args.labels.is_some(),
        capture: evaluation.radar.is_some(),
        fused: Groups::of(&evaluation.fused),
        radar: evaluation.radar.as_ref().map(Groups::of),
        transponder: evaluation.transponder.as_ref().map(Groups::of),
        drones: drones.collect(),
        integrity: scores.integrity.as_ref(),
        conflicts: &scores.conflicts,
        requirements: requirements.collect(),
    }
}

impl<'a> Groups<'a> {
    fn of(scored: &'a Scored) -> Self {
        Self { all: &scored.all, equipped: &scored.equipped, unequipped: &scored.unequipped }
    }
}
