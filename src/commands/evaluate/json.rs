//! Scores as JSON, for each group and drone. Metrics without a value are omitted.

use serde::Serialize;

use super::{EvaluateScores, conflicts, integrity};
use lab::evaluate::{AlertScore, ScoredStream, StreamMetrics};

#[derive(Serialize)]
pub(super) struct EvaluationJson<'a> {
    /// Reference rate of the probability of update (PU), in updates per second.
    reference_hz: f64,
    labels: bool,
    capture: bool,
    fused: GroupsJson<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    radar: Option<GroupsJson<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    transponder: Option<GroupsJson<'a>>,
    drones: Vec<DroneJson<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    integrity: Option<&'a integrity::IntegrityReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    alerts: Option<&'a AlertScore>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    conflicts: &'a [conflicts::VolumeScore],
    #[serde(skip_serializing_if = "Vec::is_empty")]
    requirements: Vec<RequirementJson>,
}

#[derive(Serialize)]
struct GroupsJson<'a> {
    all: &'a StreamMetrics,
    equipped: &'a StreamMetrics,
    unequipped: &'a StreamMetrics,
}

#[derive(Serialize)]
struct DroneJson<'a> {
    id: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    equipped: Option<bool>,
    fused: &'a StreamMetrics,
    #[serde(skip_serializing_if = "Option::is_none")]
    radar: Option<&'a StreamMetrics>,
    #[serde(skip_serializing_if = "Option::is_none")]
    transponder: Option<&'a StreamMetrics>,
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

pub(super) fn json<'a>(scores: &'a EvaluateScores<'a>) -> EvaluationJson<'a> {
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
    EvaluationJson {
        reference_hz: scores.reference_hz,
        labels: scores.args.labels.is_some(),
        capture: evaluation.radar.is_some(),
        fused: GroupsJson::of(&evaluation.fused),
        radar: evaluation.radar.as_ref().map(GroupsJson::of),
        transponder: evaluation.transponder.as_ref().map(GroupsJson::of),
        drones: drones.collect(),
        integrity: scores.integrity.as_ref(),
        alerts: scores.alerts.as_ref(),
        conflicts: &scores.conflicts,
        requirements: requirements.collect(),
    }
}

impl<'a> GroupsJson<'a> {
    fn of(scored: &'a ScoredStream) -> Self {
        Self { all: &scored.all, equipped: &scored.equipped, unequipped: &scored.unequipped }
    }
}
