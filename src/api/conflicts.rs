//! `/api/v1/conflicts`.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use super::ask::Ask;
use super::problem::Problem;
use crate::config::Profile;
use crate::conflicts::{ConflictJson, NO_LEVEL, Outlook, VolumeJson};
use crate::live::Lateness;
use crate::picture::Rfc3339;
use fusion::conflicts::Level;

/// Conflicts older than this, as against the picture, are none of now, seconds.
const OUTDATED_S: f64 = 3.0;

const LEVEL: &str = "none, advisory, warning or violation";

/// Who will come near whom.
#[derive(Serialize, JsonSchema)]
pub struct Conflicts {
    /// Of the positions; where nothing is computed, now.
    time: Rfc3339,
    /// Where it is false an empty list does not mean that there are none.
    computed: bool,
    /// Why they are not computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'static str>,
    volumes: Vec<VolumeJson>,
    /// Aircraft that took part.
    aircraft: usize,
    /// Aircraft of which too little is known to take part.
    left_out: usize,
    /// The worst first, then the soonest.
    conflicts: Vec<ConflictJson>,
}

/// `?level=` (that or worse), `?id=` (of a track).
pub fn conflicts(ask: &Ask) -> Result<Conflicts, Problem> {
    let level = |name: &str| Level::ALL.into_iter().find(|level| level.name() == name);
    let least = match ask.query.text("level") {
        None | Some(NO_LEVEL) => None,
        Some(name) => Some(level(name).ok_or_else(|| Problem::parameter("level", LEVEL))?),
    };
    // Ids are made of letters, digits, `-`, `.` and `_`; one that nobody has is that of a track that has ended.
    let is_plain = |id: &String| !id.is_empty() && !id.contains(',');
    let track = ask.query.value("id", "the id of one track", is_plain)?;
    let rules = ask.state.hub.config.conflicts.rules();
    let volumes = rules.volumes.iter().map(VolumeJson::from).collect();
    let outlook = match latest(ask) {
        Ok(outlook) => outlook,
        Err(reason) => {
            return Ok(Conflicts {
                time: ask.state.now().into(),
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
        let t_cpa_s = one.found.approach.t_cpa_s.total_cmp(&other.found.approach.t_cpa_s);
        other.level().cmp(&one.level()).then(t_cpa_s)
    });
    Ok(Conflicts {
        time: outlook.time.into(),
        computed: true,
        reason: None,
        volumes,
        aircraft: outlook.aircraft,
        left_out: outlook.left_out,
        conflicts: wanted.into_iter().map(ConflictJson::from).collect(),
    })
}

/// What was found in the latest second, or why there is nothing to rely on.
fn latest(ask: &Ask) -> Result<Arc<Outlook>, &'static str> {
    let hub = &ask.state.hub;
    if hub.config.fusion.profile == Profile::Reference {
        return Err("the reference profile knows no velocities: no conflicts are computed");
    }
    if !hub.config.finds_conflicts() {
        return Err("conflicts are switched off: set conflicts.enabled");
    }
    let outlook = hub.outlooks.latest().ok_or("nothing was computed yet")?;
    let due = hub.latest().map(|latest| latest.due);
    if hub.lateness().as_ref().is_some_and(Lateness::is_late)
        || due.is_some_and(|due| due.seconds_since(outlook.time) > OUTDATED_S)
    {
        return Err("the picture is late, and with it the conflicts");
    }
    Ok(outlook)
}
