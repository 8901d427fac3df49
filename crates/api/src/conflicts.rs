//! `/api/v1/conflicts`.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use super::problem::Problem;
use super::request::ApiRequest;
use conflict::Level;
use picture::Rfc3339;
use picture::conflicts::{ConflictJson, NO_LEVEL, Outlook, VolumeJson};
use service::live::PictureLateness;
use site::config::Profile;

/// Maximum age of conflicts relative to the picture, in seconds. Older ones are not returned.
const OUTDATED_S: f64 = 3.0;

const LEVEL: &str = "none, advisory, warning or violation";

/// Predicted conflicts between aircraft.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Conflicts")]
pub struct ConflictList {
    /// Time of the positions. Present time if conflicts are not computed.
    time: Rfc3339,
    /// Whether conflicts are computed. If false, an empty list does not mean that there are no conflicts.
    computed: bool,
    /// Reason why conflicts are not computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'static str>,
    volumes: Vec<VolumeJson>,
    /// Number of aircraft that were compared.
    aircraft: usize,
    /// Number of aircraft that were left out because too little is known about them.
    left_out: usize,
    /// Conflicts, highest level first, then those of known heights, then by time to the entry of the volume.
    conflicts: Vec<ConflictJson>,
}

/// Conflicts selected by `?level=` (this level or higher) and `?id=` (of a track).
pub fn conflicts(request: &ApiRequest) -> Result<ConflictList, Problem> {
    let level = |name: &str| Level::ALL.into_iter().find(|level| level.name() == name);
    let least = match request.query.text("level") {
        None | Some(NO_LEVEL) => None,
        Some(name) => Some(level(name).ok_or_else(|| Problem::parameter("level", LEVEL))?),
    };
    // Ids consist of letters, digits, `-`, `.` and `_`. An unknown id may belong to a track that has ended.
    let is_plain = |id: &String| !id.is_empty() && !id.contains(',');
    let track = request.query.value("id", "the id of one track", is_plain)?;
    let rules = request.state.hub.config.conflicts.rules();
    let volumes = rules.volumes.iter().map(VolumeJson::from).collect();
    let outlook = match latest(request) {
        Ok(outlook) => outlook,
        Err(reason) => {
            return Ok(ConflictList {
                time: request.state.now().into(),
                computed: false,
                reason: Some(reason),
                volumes,
                aircraft: 0,
                left_out: 0,
                conflicts: Vec::new(),
            });
        }
    };
    let mut wanted: Vec<_> = outlook
        .conflicts
        .iter()
        .filter(|conflict| conflict.level() >= least)
        .filter(|conflict| track.as_ref().is_none_or(|id| conflict.tracks.contains(id)))
        .collect();
    wanted.sort_by(|one, other| {
        let entry_s = one.found.entry_s.total_cmp(&other.found.entry_s);
        let heights = other.are_heights_known.cmp(&one.are_heights_known);
        other.level().cmp(&one.level()).then(heights).then(entry_s)
    });
    Ok(ConflictList {
        time: outlook.time.into(),
        computed: true,
        reason: None,
        volumes,
        aircraft: outlook.aircraft,
        left_out: outlook.left_out,
        conflicts: wanted.into_iter().map(ConflictJson::from).collect(),
    })
}

/// Latest conflict report, or the reason why there is no current one.
pub(super) fn latest(request: &ApiRequest) -> Result<Arc<Outlook>, &'static str> {
    let hub = &request.state.hub;
    if hub.config.fusion.profile == Profile::Reference {
        return Err("the reference profile knows no velocities: no conflicts are computed");
    }
    if !hub.config.predicts_conflicts() {
        return Err("conflicts are switched off: set conflicts.enabled");
    }
    let outlook = hub.conflict_reports.latest().ok_or("nothing was computed yet")?;
    let due = hub.latest().map(|latest| latest.due);
    if hub.lateness().as_ref().is_some_and(PictureLateness::is_late)
        || due.is_some_and(|due| due.seconds_since(outlook.time) > OUTDATED_S)
    {
        return Err("the picture is late, and with it the conflicts");
    }
    Ok(outlook)
}
