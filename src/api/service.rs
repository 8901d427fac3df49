//! How the service is: `/healthz`, `/readyz`, `/api/v1/status`, `/api/v1/info`.

use std::time::Duration;

use serde_json::{Map, Value, json};

use super::ask::{Answer, Ask, JSON, json};
use super::auth::Scope;
use super::problem::Problem;
use super::{replay, sites};
use crate::config::Config;
use crate::json::rounded;
use crate::live::{Player, SensorState, Status};
use crate::pipeline::Tally;

/// Slots come four times a second; after this silence something is wrong.
const NO_SLOT: Duration = Duration::from_secs(5);

/// Alive.
pub fn health(_: &Ask) -> Answer {
    json(JSON, &json!({ "status": "ok" }))
}

/// Lines are joined and slots are put out, or 503 with what is missing.
pub fn ready(ask: &Ask) -> Answer {
    let mut reasons = slots_missing(ask);
    match ask.state.hub().status() {
        Some(status) => {
            for line in status.sensors.iter().flat_map(|sensor| &sensor.lines).filter(|line| !line.joined) {
                let reason = format!("line {} is not open", line.name);
                if !reasons.contains(&reason) {
                    reasons.push(reason);
                }
            }
        }
        None => reasons.push("the state of the lines is not known yet".to_owned()),
    }
    if reasons.is_empty() {
        return json(JSON, &json!({ "status": "ready" }));
    }
    Err(Problem::unavailable("the service is not ready", reasons).retry_after_s(1))
}

fn slots_missing(ask: &Ask) -> Vec<String> {
    let age = ask.state.slot_age();
    // A replay that stands still, or goes slowly, is as it should be.
    let longest = match ask.state.options().player.as_ref().map(Player::state) {
        Some(state) if !state.playing && age.is_some() => return Vec::new(),
        Some(state) => NO_SLOT.div_f64(state.speed.min(1.0)),
        None => NO_SLOT,
    };
    match age {
        None => vec!["no slot has been put out yet".to_owned()],
        Some(age) if age > longest => vec![format!("no slot has been put out for {} s", age.as_secs())],
        Some(_) => Vec::new(),
    }
}

/// Health with reasons, latency, counters.
pub fn status(ask: &Ask) -> Answer {
    let hub = ask.state.hub();
    let now = ask.state.now();
    let mut reasons = slots_missing(ask);
    let status = hub.status();
    let troubled =
        status.iter().flat_map(|status| &status.sensors).filter(|s| s.state != SensorState::Operational);
    reasons
        .extend(troubled.map(|s| format!("sensor {}: {}: {}", s.id, s.state.name(), s.reasons.join("; "))));
    reasons.extend(sites::service_alerts(ask));
    let mut answer = json!({
        "time": now.to_string(),
        "state": if reasons.is_empty() { "ok" } else { "degraded" },
        "reasons": reasons,
        "started": hub.started.to_string(),
        "uptime_s": rounded(now.seconds_since(hub.started).max(0.0), 3),
        "seq": ask.state.log().latest().1.map_or(0, |shown| shown.frame.seq),
        "streams": ask.state.seats().taken(),
    });
    if let Some(status) = &status {
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
    let by_sensor = |counts: &std::collections::BTreeMap<crate::normalise::SensorIndex, u64>| -> Value {
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
