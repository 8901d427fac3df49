//! `/api/v1/relocations`: radars that operators moved to where their tracks show them.

use schemars::JsonSchema;
use serde::Serialize;
use tracing::info;

use super::correlations::{PATIENCE, problem, refuse_standing};
use super::problem::Problem;
use super::request::{AnswerFuture, ApiRequest};
use fusion::SensorIndex;
use fusion::operational::{ActiveRelocation, AssociationRefusal};
use fusion::slots::SlotGrid;
use input::json::rounded;
use picture::Rfc3339;
use service::live::{RelocationRequest, RequestError};
use site::config::{Profile, SensorKind};

/// Relocations in force.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Relocations")]
pub struct RelocationList {
    relocations: Vec<RelocationJson>,
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Relocation")]
struct RelocationJson {
    /// Id of the radar.
    sensor: String,
    /// Metres that the radar stands east of its configured position.
    east_m: f64,
    north_m: f64,
    /// Angle taken off the azimuths, beside the configured correction.
    bearing_deg: f64,
    /// Time of the first slot with it.
    since: Rfc3339,
}

/// Relocations in force.
pub fn all(request: &ApiRequest) -> Result<RelocationList, Problem> {
    Ok(list(request, &request.state.hub.relocation_requests.in_force()))
}

/// Uses the position that the radar's tracks show.
pub fn apply(request: ApiRequest) -> AnswerFuture<RelocationList> {
    decide(request, true)
}

/// Uses the configured position again.
pub fn revoke(request: ApiRequest) -> AnswerFuture<RelocationList> {
    decide(request, false)
}

fn decide(request: ApiRequest, is_applied: bool) -> AnswerFuture<RelocationList> {
    Box::pin(async move {
        let hub = &request.state.hub;
        let named = |sensor: &site::config::Sensor| {
            sensor.id == request.id && matches!(sensor.kind, SensorKind::Radar(_))
        };
        let index = hub.config.sensors.iter().position(named);
        let index = index.ok_or_else(|| Problem::not_found(format!("there is no radar {:?}", request.id)))?;
        if hub.config.fusion.profile == Profile::Reference {
            return Err(problem(&AssociationRefusal::Reference.into()));
        }
        refuse_standing(&request)?;
        let wish = RelocationRequest { radar: SensorIndex(index as u16), is_applied };
        let answer = hub.relocation_requests.submit(wish).map_err(|denied| problem(&denied))?;
        let answered = match tokio::time::timeout(PATIENCE, answer).await {
            Ok(Ok(answered)) => answered,
            Ok(Err(_)) | Err(_) => Err(RequestError::Gone),
        };
        let held = answered.map_err(|denied| problem(&denied))?;
        let access = request.state.access();
        let who = access.token_name(request.credential).unwrap_or("somebody without a token");
        let from = request.client.map_or_else(String::new, |client| format!(" from {client}"));
        let what =
            if is_applied { "moved to where its tracks show it" } else { "put back where it is configured" };
        info!("radar {}: {what}, by {who}{from}", request.id.escape_debug());
        Ok(list(&request, &held))
    })
}

fn list(request: &ApiRequest, active: &[ActiveRelocation]) -> RelocationList {
    let config = &request.state.hub.config;
    let grid = SlotGrid::new(config.fusion.slot);
    let json = |active: &ActiveRelocation| {
        Some(RelocationJson {
            sensor: config.sensors.get(usize::from(active.radar.0))?.id.clone(),
            east_m: rounded(active.to.east_m, 1),
            north_m: rounded(active.to.north_m, 1),
            bearing_deg: rounded(active.to.bearing.to_degrees(), 3),
            since: grid.centre(active.since).into(),
        })
    };
    RelocationList { relocations: active.iter().filter_map(json).collect() }
}
