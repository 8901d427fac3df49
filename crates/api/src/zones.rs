//! `/api/v1/zones`: zones that operators have activated.

use std::time::Duration;

use axum::http::StatusCode;
use schemars::JsonSchema;
use serde::Serialize;

use super::alerts::operator_name;
use super::geometry::{FeatureCollection, GeoJsonGeometry, UnnamedFeature};
use super::problem::Problem;
use super::request::{AnswerFuture, ApiRequest};
use input::json::rounded;
use picture::Rfc3339;
use service::live::{ZoneAction, ZoneRequest, ZoneRequestError};
use service::state::{MAX_ZONES, OperatorZone, ZoneRefusal};

/// Timeout for the owner of the zones, which writes a file before it answers.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(5);

/// Zones that operators have activated.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Zones")]
pub struct ZoneList {
    /// Whether a zone can be activated here. A replay, a demo, and a picture of other nodes have no zones of operators.
    available: bool,
    /// The active zones, by name.
    #[schemars(length(max = MAX_ZONES))]
    zones: Vec<ZoneJson>,
}

/// A zone that an operator has activated.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Zone")]
pub struct ZoneJson {
    name: String,
    /// Name of the token, or the name that the operator gave.
    activated_by: String,
    /// Time of the activation.
    activated_at: Rfc3339,
    /// Lower limit, in metres above mean sea level; left out if it is the ground.
    #[serde(skip_serializing_if = "Option::is_none")]
    floor_m: Option<f64>,
    /// Upper limit, in metres above mean sea level; left out if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    ceiling_m: Option<f64>,
}

/// Body of an activation: GeoJSON with one polygon, or with one MultiPolygon.
pub type ZoneBody = FeatureCollection<UnnamedFeature<GeoJsonGeometry, ZoneLimits>>;

/// Heights of a zone, for the documents; the service reads the GeoJSON as a file of areas.
#[derive(Serialize, JsonSchema)]
pub struct ZoneLimits {
    /// Ignored: the path has the name.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    /// Lower limit, in metres above mean sea level; default: from the ground up.
    #[serde(skip_serializing_if = "Option::is_none")]
    floor_m: Option<f64>,
    /// Upper limit, in metres above mean sea level; default: no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    ceiling_m: Option<f64>,
}

impl From<&OperatorZone> for ZoneJson {
    fn from(zone: &OperatorZone) -> Self {
        let OperatorZone { name, floor_m, ceiling_m, activated_by, activated_at, .. } = zone;
        Self {
            name: name.clone(),
            activated_by: activated_by.clone(),
            activated_at: (*activated_at).into(),
            floor_m: floor_m.map(|metres| rounded(metres, 1)),
            ceiling_m: ceiling_m.map(|metres| rounded(metres, 1)),
        }
    }
}

/// The active zones.
pub fn all(request: &ApiRequest) -> Result<ZoneList, Problem> {
    let zones = request.state.options.zones.as_ref();
    Ok(ZoneList {
        available: zones.is_some(),
        zones: zones
            .iter()
            .flat_map(|zones| zones.in_force().iter().map(ZoneJson::from).collect::<Vec<_>>())
            .collect(),
    })
}

/// Activates a zone, or replaces the zone of that name.
pub fn activate(request: ApiRequest) -> AnswerFuture<ZoneJson> {
    Box::pin(async move {
        let geojson = request.body.to_vec();
        change(&request, ZoneAction::Activate(geojson)).await
    })
}

/// Revokes a zone.
pub fn revoke(request: ApiRequest) -> AnswerFuture<ZoneJson> {
    Box::pin(async move { change(&request, ZoneAction::Revoke).await })
}

async fn change(request: &ApiRequest, action: ZoneAction) -> Result<ZoneJson, Problem> {
    let by = operator_name(request, request.query.text("by").map(str::to_owned))?;
    let Some(zones) = &request.state.options.zones else {
        let detail = "zones are activated at the live service of one machine; a replay, a demo and a node of a cluster have none";
        return Err(Problem::new(StatusCode::CONFLICT, detail));
    };
    let answer = zones
        .submit(ZoneRequest { name: request.id.clone(), action, by })
        .map_err(|error| problem(&error))?;
    let answered = match tokio::time::timeout(ANSWER_TIMEOUT, answer).await {
        Ok(Ok(answered)) => answered.map_err(ZoneRequestError::from),
        Ok(Err(_)) | Err(_) => Err(ZoneRequestError::Gone),
    };
    answered.map(|zone| ZoneJson::from(&zone)).map_err(|error| problem(&error))
}

fn problem(error: &ZoneRequestError) -> Problem {
    let status = match error {
        ZoneRequestError::Refused(ZoneRefusal::Name) => return Problem::parameter("id", error.to_string()),
        ZoneRequestError::Refused(ZoneRefusal::Invalid(_)) => StatusCode::BAD_REQUEST,
        ZoneRequestError::Refused(ZoneRefusal::Unknown) => StatusCode::NOT_FOUND,
        ZoneRequestError::Refused(ZoneRefusal::Full) => StatusCode::CONFLICT,
        ZoneRequestError::Refused(ZoneRefusal::DiskFull) => StatusCode::INSUFFICIENT_STORAGE,
        ZoneRequestError::Refused(ZoneRefusal::Unwritten(_)) => {
            return Problem::unavailable(error.to_string(), Vec::new());
        }
        ZoneRequestError::Busy | ZoneRequestError::Gone => {
            return Problem::unavailable(error.to_string(), Vec::new()).retry_after_s(1);
        }
    };
    Problem::new(status, error.to_string())
}
