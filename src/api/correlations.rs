//! `/api/v1/correlations`: which radar track is which transponder, as an operator says.

use std::future::Future;
use std::pin::Pin;
use std::time::Duration;

use axum::http::StatusCode;
use serde::Serialize;
use tracing::info;

use super::ask::{Answer, Ask, JSON, json};
use super::problem::Problem;
use crate::config::{Profile, SensorKind};
use crate::live::{Denied, Player, Wish};
use crate::picture::Who;
use fusion::operational::{Correlation, HeldCorrelation, NotCorrelated, Verdict};
use fusion::slots::SlotGrid;
use fusion::{RadarTrackKey, SensorIndex};

/// The engine looks up several times a second; who does not hear of it by then is told so.
const PATIENCE: Duration = Duration::from_secs(2);

/// An answer that the engine has to be waited for.
pub(super) type Later = Pin<Box<dyn Future<Output = Answer> + Send>>;

/// What is in force.
#[derive(Serialize)]
struct Correlations<'a> {
    correlations: Vec<CorrelationJson<'a>>,
}

#[derive(Serialize)]
struct CorrelationJson<'a> {
    sensor: &'a str,
    track_number: u16,
    uas_id: Who,
    verdict: &'static str,
    since: String,
}

/// What is in force.
pub fn all(ask: &Ask) -> Answer {
    shown(ask, &ask.state.hub().decider.held())
}

/// Decides.
pub fn correlate(ask: Ask) -> Later {
    Box::pin(async move {
        let wish = wish(&ask)?;
        refuse(&ask)?;
        let answer = ask.state.hub().decider.ask(wish.clone()).map_err(|denied| problem(&denied))?;
        let answered = match tokio::time::timeout(PATIENCE, answer).await {
            Ok(Ok(answered)) => answered,
            Ok(Err(_)) | Err(_) => Err(Denied::Gone),
        };
        let held = answered.map_err(|denied| problem(&denied))?;
        let who = ask.state.terms().name_of(ask.pass).unwrap_or("somebody without a token").to_owned();
        let from = ask.client.map_or_else(String::new, |client| format!(" from {client}"));
        info!(
            "{} track {} and transponder {}: {}, by {who}{from}",
            ask.text("sensor").unwrap_or_default(),
            wish.radar.number,
            wish.serial.escape_debug(),
            wish.verdict.name(),
        );
        shown(&ask, &held)
    })
}

/// What is asked for.
fn wish(ask: &Ask) -> Result<Wish, Problem> {
    let needed = |name: &str, rule: &str| {
        ask.text(name).filter(|text| !text.is_empty()).ok_or_else(|| Problem::parameter(name, rule))
    };
    let id = needed("sensor", "the id of a radar has to be given")?;
    let config = &ask.state.hub().config;
    let is_it =
        |sensor: &crate::config::Sensor| sensor.id == id && matches!(sensor.kind, SensorKind::Radar(_));
    let index = config.sensors.iter().position(is_it);
    let rule = "a radar's track number is 0 to 4095";
    let number = ask.value("track", rule, |number: &u16| *number <= 4095)?;
    let number = number.ok_or_else(|| Problem::parameter("track", rule))?;
    let serial = needed("uas", "the serial number of a transponder has to be given")?.to_owned();
    let rule = "a verdict is correlated, decorrelated or automatic";
    let verdict = Verdict::of_name(needed("verdict", rule)?);
    let verdict = verdict.ok_or_else(|| Problem::parameter("verdict", rule))?;
    let index = index.ok_or_else(|| Problem::not_found(format!("there is no radar {id:?}")))?;
    Ok(Wish {
        radar: RadarTrackKey { sensor: SensorIndex(index as u16), number },
        serial,
        country: ask.text("country").map(str::to_owned),
        verdict,
    })
}

/// Where nothing can be decided.
fn refuse(ask: &Ask) -> Result<(), Problem> {
    let conflict = |detail: &str| Err(Problem::new(StatusCode::CONFLICT, detail));
    if ask.state.hub().config.fusion.profile == Profile::Reference {
        return Err(problem(&Denied::NotCorrelated(NotCorrelated::Reference)));
    }
    match ask.state.options().player.as_ref().map(Player::state) {
        Some(state) if !state.playing => conflict("a replay that stands still decides nothing: let it go on"),
        _ => Ok(()),
    }
}

fn problem(denied: &Denied) -> Problem {
    let status = match denied {
        Denied::NotCorrelated(NotCorrelated::NoRadarTrack | NotCorrelated::NoTransponder) => {
            StatusCode::NOT_FOUND
        }
        Denied::NotCorrelated(NotCorrelated::Reference) | Denied::Ambiguous(_) => StatusCode::CONFLICT,
        Denied::Busy | Denied::Gone => {
            return Problem::unavailable(denied.to_string(), Vec::new()).retry_after_s(1);
        }
    };
    Problem::new(status, denied.to_string())
}

fn shown(ask: &Ask, held: &[HeldCorrelation]) -> Answer {
    let hub = ask.state.hub();
    let grid = SlotGrid::new(hub.config.fusion.slot);
    let correlation = |&HeldCorrelation { correlation, since }: &HeldCorrelation| {
        let Correlation { radar, transponder, verdict } = correlation;
        CorrelationJson {
            sensor: hub.maker.sensor(radar.sensor),
            track_number: radar.number,
            uas_id: Who::new(transponder),
            verdict: verdict.name(),
            since: grid.centre(since).to_string(),
        }
    };
    json(JSON, &Correlations { correlations: held.iter().map(correlation).collect() })
}
