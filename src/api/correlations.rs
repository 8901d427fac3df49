//! `/api/v1/correlations`: the correlations that operators have decided.

use std::time::Duration;

use axum::http::StatusCode;
use schemars::JsonSchema;
use serde::Serialize;
use tracing::info;

use super::ask::Ask;
use super::problem::Problem;
use super::route::Later;
use crate::config::{Profile, SensorKind};
use crate::live::{Denied, Named, Player, Wish};
use crate::names::without;
use crate::picture::{Rfc3339, TransponderId};
use fusion::operational::{Correlation, HeldCorrelation, NotCorrelated, Verdict};
use fusion::slots::SlotGrid;
use fusion::{RadarTrackKey, SensorIndex};

/// The engine takes decisions several times per second; without an answer by then the request fails.
const PATIENCE: Duration = Duration::from_secs(2);

/// Decisions of operators that are in force.
#[derive(Serialize, JsonSchema)]
pub struct Correlations {
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
    /// Of the first slot that it applies to.
    since: Rfc3339,
}

/// What is in force.
pub fn all(ask: &Ask) -> Result<Correlations, Problem> {
    Ok(correlations(ask, &ask.state.hub.decider.held()))
}

/// Decides.
pub fn correlate(ask: Ask) -> Later<Correlations> {
    Box::pin(async move {
        let wish = wish(&ask)?;
        refuse(&ask)?;
        let answer = ask.state.hub.decider.ask(wish.clone()).map_err(|denied| problem(&denied))?;
        let answered = match tokio::time::timeout(PATIENCE, answer).await {
            Ok(Ok(answered)) => answered,
            Ok(Err(_)) | Err(_) => Err(Denied::Gone),
        };
        let held = answered.map_err(|denied| problem(&denied))?;
        let who = ask.state.terms().name_of(ask.pass).unwrap_or("somebody without a token").to_owned();
        let from = ask.client.map_or_else(String::new, |client| format!(" from {client}"));
        info!(
            "{} track {} and transponder {}: {}, by {who}{from}",
            ask.query.text("sensor").unwrap_or_default(),
            wish.radar.number,
            wish.transponder.serial.escape_debug(),
            wish.verdict.name(),
        );
        Ok(correlations(&ask, &held))
    })
}

/// The decision in a request.
fn wish(ask: &Ask) -> Result<Wish, Problem> {
    let needed = |name: &str, rule: &str| {
        ask.query.text(name).filter(|text| !text.is_empty()).ok_or_else(|| Problem::parameter(name, rule))
    };
    let id = needed("sensor", "the id of a radar has to be given")?;
    let config = &ask.state.hub.config;
    let is_it =
        |sensor: &crate::config::Sensor| sensor.id == id && matches!(sensor.kind, SensorKind::Radar(_));
    let index = config.sensors.iter().position(is_it);
    let rule = "a radar's track number is 0 to 4095";
    let number = ask.query.value("track", rule, |number: &u16| *number <= 4095)?;
    let number = number.ok_or_else(|| Problem::parameter("track", rule))?;
    let serial = needed("uas", "the serial number of a transponder has to be given")?.to_owned();
    let rule = "a verdict is correlated, decorrelated or automatic";
    let verdict = Verdict::of_name(needed("verdict", rule)?);
    let verdict = verdict.ok_or_else(|| Problem::parameter("verdict", rule))?;
    let index = index.ok_or_else(|| Problem::not_found(format!("there is no radar {id:?}")))?;
    Ok(Wish {
        radar: RadarTrackKey { sensor: SensorIndex(index as u16), number },
        transponder: Named { serial, country: ask.query.text("country").map(str::to_owned) },
        verdict,
    })
}

/// Fails where nothing can be decided.
fn refuse(ask: &Ask) -> Result<(), Problem> {
    if ask.state.hub.config.fusion.profile == Profile::Reference {
        return Err(problem(&Denied::NotCorrelated(NotCorrelated::Reference)));
    }
    refuse_standing(ask)
}

/// Fails where a replay stands still.
pub(super) fn refuse_standing(ask: &Ask) -> Result<(), Problem> {
    let conflict = |detail: &str| Err(Problem::new(StatusCode::CONFLICT, detail));
    match ask.state.options.player.as_ref().map(Player::state) {
        Some(state) if !state.playing => conflict("a replay that stands still decides nothing: let it go on"),
        _ => Ok(()),
    }
}

/// Why something is not decided.
pub(super) fn problem(denied: &Denied) -> Problem {
    let status = match denied {
        Denied::NotCorrelated(NotCorrelated::NoRadarTrack | NotCorrelated::NoTransponder) => {
            StatusCode::NOT_FOUND
        }
        Denied::NotCorrelated(NotCorrelated::Reference) | Denied::Ambiguous(_) | Denied::NotJudged => {
            StatusCode::CONFLICT
        }
        Denied::Busy | Denied::Gone | Denied::Unheard => {
            return Problem::unavailable(denied.to_string(), Vec::new()).retry_after_s(1);
        }
    };
    Problem::new(status, denied.to_string())
}

fn correlations(ask: &Ask, held: &[HeldCorrelation]) -> Correlations {
    let hub = &ask.state.hub;
    let grid = SlotGrid::new(hub.config.fusion.slot);
    let correlation = |&HeldCorrelation { correlation, since }: &HeldCorrelation| {
        let Correlation { radar, transponder, verdict } = correlation;
        CorrelationJson {
            sensor: hub.maker.sensor(radar.sensor).to_owned(),
            track_number: radar.number,
            uas_id: TransponderId::new(transponder),
            verdict: verdict.name(),
            since: grid.centre(since).into(),
        }
    };
    Correlations { correlations: held.iter().map(correlation).collect() }
}
