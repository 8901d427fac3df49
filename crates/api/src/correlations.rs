//! `/api/v1/correlations`: correlations decided by operators.

use std::time::Duration;

use axum::http::StatusCode;
use schemars::JsonSchema;
use serde::Serialize;
use tracing::info;

use super::problem::Problem;
use super::request::{AnswerFuture, ApiRequest};
use fusion::operational::{ActiveAssociation, AssociationRefusal, ManualAssociation, Verdict};
use fusion::slots::SlotGrid;
use fusion::{RadarTrackKey, SensorIndex};
use input::names::without;
use picture::{Rfc3339, TransponderId};
use service::live::{CorrelationRequest, Player, RequestError, TransponderName};
use site::config::{Profile, SensorKind};

/// Timeout for the engine, which takes decisions several times per second.
pub(super) const PATIENCE: Duration = Duration::from_secs(2);

/// Operator decisions in force.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Correlations")]
pub struct CorrelationList {
    correlations: Vec<CorrelationJson>,
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Correlation")]
struct CorrelationJson {
    /// Id of the radar.
    sensor: String,
    track_number: u16,
    uas_id: TransponderId,
    #[schemars(extend("enum" = without(&Verdict::NAMES, Verdict::Automatic.name())))]
    verdict: &'static str,
    /// Time of the first slot to which the decision applies.
    since: Rfc3339,
}

/// Decisions in force.
pub fn all(request: &ApiRequest) -> Result<CorrelationList, Problem> {
    Ok(correlations(request, &request.state.hub.correlation_requests.in_force()))
}

/// Records a decision.
pub fn correlate(request: ApiRequest) -> AnswerFuture<CorrelationList> {
    Box::pin(async move {
        let wish = wish(&request)?;
        refuse(&request)?;
        let answer =
            request.state.hub.correlation_requests.submit(wish.clone()).map_err(|denied| problem(&denied))?;
        let answered = match tokio::time::timeout(PATIENCE, answer).await {
            Ok(Ok(answered)) => answered,
            Ok(Err(_)) | Err(_) => Err(RequestError::Gone),
        };
        let held = answered.map_err(|denied| problem(&denied))?;
        let who = request
            .state
            .access()
            .token_name(request.credential)
            .unwrap_or("somebody without a token")
            .to_owned();
        let from = request.client.map_or_else(String::new, |client| format!(" from {client}"));
        info!(
            "{} track {} and transponder {}: {}, by {who}{from}",
            request.query.text("sensor").unwrap_or_default(),
            wish.radar.number,
            wish.transponder.serial.escape_debug(),
            wish.verdict.name(),
        );
        Ok(correlations(&request, &held))
    })
}

/// Decision in the body of a request.
fn wish(request: &ApiRequest) -> Result<CorrelationRequest, Problem> {
    let needed = |name: &str, rule: &str| {
        request.query.text(name).filter(|text| !text.is_empty()).ok_or_else(|| Problem::parameter(name, rule))
    };
    let id = needed("sensor", "the id of a radar has to be given")?;
    let config = &request.state.hub.config;
    let is_it =
        |sensor: &site::config::Sensor| sensor.id == id && matches!(sensor.kind, SensorKind::Radar(_));
    let index = config.sensors.iter().position(is_it);
    let rule = "a radar's track number is 0 to 4095";
    let number = request.query.value("track", rule, |number: &u16| *number <= 4095)?;
    let number = number.ok_or_else(|| Problem::parameter("track", rule))?;
    let serial = needed("uas", "the serial number of a transponder has to be given")?.to_owned();
    let rule = "a verdict is correlated, decorrelated or automatic";
    let verdict = Verdict::of_name(needed("verdict", rule)?);
    let verdict = verdict.ok_or_else(|| Problem::parameter("verdict", rule))?;
    let index = index.ok_or_else(|| Problem::not_found(format!("there is no radar {id:?}")))?;
    Ok(CorrelationRequest {
        radar: RadarTrackKey { sensor: SensorIndex(index as u16), number },
        transponder: TransponderName { serial, country: request.query.text("country").map(str::to_owned) },
        verdict,
    })
}

/// Fails if no decision is possible.
fn refuse(request: &ApiRequest) -> Result<(), Problem> {
    if request.state.hub.config.fusion.profile == Profile::Reference {
        return Err(problem(&RequestError::NotCorrelated(AssociationRefusal::Reference)));
    }
    refuse_standing(request)
}

/// Fails if a replay is paused.
pub(super) fn refuse_standing(request: &ApiRequest) -> Result<(), Problem> {
    let conflict = |detail: &str| Err(Problem::new(StatusCode::CONFLICT, detail));
    match request.state.options.player.as_ref().map(Player::state) {
        Some(state) if !state.playing => conflict("a replay that stands still decides nothing: let it go on"),
        _ => Ok(()),
    }
}

/// Problem for a refused decision.
pub(super) fn problem(denied: &RequestError) -> Problem {
    let status = match denied {
        RequestError::NotCorrelated(AssociationRefusal::NoRadarTrack | AssociationRefusal::NoTransponder) => {
            StatusCode::NOT_FOUND
        }
        RequestError::NotCorrelated(AssociationRefusal::Reference)
        | RequestError::Ambiguous(_)
        | RequestError::NotJudged
        | RequestError::NotContradicted
        | RequestError::NotRelocated
        | RequestError::NotRelocatedHere => StatusCode::CONFLICT,
        RequestError::Busy | RequestError::Gone | RequestError::Unheard => {
            return Problem::unavailable(denied.to_string(), Vec::new()).retry_after_s(1);
        }
    };
    Problem::new(status, denied.to_string())
}

fn correlations(request: &ApiRequest, held: &[ActiveAssociation]) -> CorrelationList {
    let hub = &request.state.hub;
    let grid = SlotGrid::new(hub.config.fusion.slot);
    let correlation = |&ActiveAssociation { correlation, since }: &ActiveAssociation| {
        let ManualAssociation { radar, transponder, verdict } = correlation;
        CorrelationJson {
            sensor: hub.maker.sensor(radar.sensor).to_owned(),
            track_number: radar.number,
            uas_id: TransponderId::new(transponder),
            verdict: verdict.name(),
            since: grid.centre(since).into(),
        }
    };
    CorrelationList { correlations: held.iter().map(correlation).collect() }
}
