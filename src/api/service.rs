//! How the service is: `/healthz`, `/readyz`, `/api/v1/status`, `/api/v1/info`.

use std::time::Duration;

use serde_json::{Map, Value, json};

use super::ask::{Answer, Ask, JSON, json};
use super::auth::Scope;
use super::problem::Problem;
use super::{ApiState, replay};
use crate::config::Config;
use crate::json::rounded;
use crate::live::{Condition, Level, Player, Status};
use crate::pipeline::Tally;

/// Of a replay that is playing slots come four times a second; after this silence something is wrong.
const NO_SLOT: Duration = Duration::from_secs(5);

/// Alive.
pub fn health(_: &Ask) -> Answer {
    json(JSON, &json!({ "status": "ok" }))
}

/// Lines are joined and the picture is of now, or 503 with what is wrong.
pub fn ready(ask: &Ask) -> Answer {
    let condition = ask.state.condition();
    if condition.level() < Level::NotReady {
        return json(JSON, &json!({ "status": "ready" }));
    }
    let reasons = condition.reasons(Level::NotReady).into_iter().map(str::to_owned).collect();
    Err(Problem::unavailable("the service is not ready", reasons).retry_after_s(1))
}

impl ApiState {
    /// The service's condition; a replay's pace is its player's.
    pub(super) fn condition(&self) -> Condition {
        let mut condition = self.hub().condition();
        let player = self.options().player.as_ref().map(Player::state);
        // One that stands still, or goes slowly, is as it should be.
        if let Some((state, age)) = player.filter(|state| state.playing).zip(self.slot_age())
            && age > NO_SLOT.div_f64(state.speed.min(1.0))
        {
            condition.add(Level::NotReady, format!("no slot has been shown for {} s", age.as_secs()));
        }
        condition
    }
}

/// Health with reasons, latency, counters.
pub fn status(ask: &Ask) -> Answer {
    let hub = ask.state.hub();
    let now = ask.state.now();
    let condition = ask.state.condition();
    let level = condition.level();
    let mut answer = json!({
        "time": now.to_string(),
        // There is a picture or there is none: whether it can be used is what `ready` says.
        "state": level.min(Level::Degraded).name(),
        "ready": level < Level::NotReady,
        "reasons": condition.reasons(Level::Degraded),
        "started": hub.started.to_string(),
        "uptime_s": rounded(now.seconds_since(hub.started).max(0.0), 3),
        "seq": ask.state.log().latest().1.map_or(0, |shown| shown.frame.seq),
        "streams": ask.state.seats().taken(),
    });
    if let Some(lateness) = hub.lateness() {
        answer["late_s"] = json!(rounded(lateness.late.as_secs_f64(), 3));
    }
    if let Some(status) = &hub.status() {
        describe(&mut answer, status, &hub.config);
    }
    json(JSON, &answer)
}

fn describe(answer: &mut Value, status: &Status, config: &Config) {
    if let Some(lateness_s) = status.lateness_s {
        // From the opening of a slot until it is due; lateness comes on top.
        let due_after_s = config.fusion.latency().as_secs_f64();
        let quantiles = |above_s: f64| {
            let [p50, p95, p99] = lateness_s.map(|late_s| rounded(above_s + late_s, 6));
            json!({ "p50": p50, "p95": p95, "p99": p99 })
        };
        answer["latency_s"] = quantiles(due_after_s);
        answer["lateness_s"] = quantiles(0.0);
    }
    answer["failed_sends"] = json!(status.failed_sends);
    answer["tally"] = tally(&status.tally, config);
}

fn tally(tally: &Tally, config: &Config) -> Value {
    let name = |index: usize| config.sensors.get(index).map(|sensor| sensor.id.as_str());
    let by_sensor = |counts: &std::collections::BTreeMap<fusion::SensorIndex, u64>| -> Value {
        counts
            .iter()
            .filter_map(|(sensor, count)| Some((name(sensor.0.into())?.to_owned(), json!(count))))
            .collect::<Map<_, _>>()
            .into()
    };
    let faults: Vec<Value> = tally
        .faults
        .iter()
        .map(|((category, reason), count)| json!({ "category": category, "reason": reason, "count": count }))
        .collect();
    let refused: Vec<Value> = tally
        .refused
        .iter()
        .map(|((sensor, reason), count)| {
            json!({ "sensor": sensor.and_then(|s| name(s.0.into())), "reason": reason, "count": count })
        })
        .collect();
    let skipped: Vec<Value> = tally
        .skipped
        .iter()
        .map(|(category, count)| json!({ "category": category, "count": count }))
        .collect();
    json!({
        "received": tally.received,
        "octets": tally.octets,
        "duplicates": tally.duplicates,
        "accepted": by_sensor(&tally.accepted),
        "service": by_sensor(&tally.service),
        "faults": faults,
        "refused": refused,
        "skipped": skipped,
        "several_records": tally.several_records,
        "unknown_sources": tally.unknown_sources.values().sum::<u64>(),
        "restarts": tally.restarts,
        "clock_behind": tally.clock_behind,
        "dropped": tally.dropped(),
    })
}

/// Version, site and the settings that a reader of the picture should know.
pub fn info(ask: &Ask) -> Answer {
    let hub = ask.state.hub();
    let (config, fusion) = (&hub.config, &hub.config.fusion);
    let replay = replay::state(ask.state.options().player.as_ref());
    let auth = if ask.state.needs_token() { "tokens" } else { "none" };
    let mut info = json!({
            "name": "utm-fusion",
            "version": env!("CARGO_PKG_VERSION"),
            "site": { "name": config.site.name, "sac": config.site.sac, "sic": config.site.sic },
            "geoid_separation": rounded(hub.maker.geoid_undulation_m(), 3),
            "profile": fusion.profile.name(),
            "slot_s": fusion.slot.as_secs_f64(),
            "latency_s": fusion.latency().as_secs_f64(),
            "started": hub.started.to_string(),
            "mode": if replay.is_some() { "replay" } else { "live" },
            "auth": auth,
            "control": ask.state.terms().may(ask.pass, Scope::Control),
            "settings": {
                "motion": fusion.motion.name(),
                "window_s": fusion.window().as_secs_f64(),
                "max_future_s": fusion.max_future.as_secs_f64(),
                "max_gap_s": fusion.max_gap.as_secs_f64(),
                "threshold_m": fusion.threshold_m,
                "ratio_min": fusion.ratio_min,
                "min_samples": fusion.min_samples,
                "weight_radar": fusion.weight_radar,
                "weight_transponder": fusion.weight_transponder,
                "radar_only_min_s": fusion.radar_only_min_s,
                "suppress_s": fusion.suppress().as_secs_f64(),
            },
    });
    if let Some(tiles) = &config.http.tiles {
        info["tiles"] = json!({ "url": tiles.url, "attribution": tiles.attribution });
    }
    if let Some(replay) = replay {
        info["replay"] = replay;
    }
    json(JSON, &info)
}
