//! How the service is: `/healthz`, `/readyz`, `/api/v1/status`, `/api/v1/info`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};

use super::ask::Ask;
use super::basemap;
use super::problem::Problem;
use super::replay::{self, Replay};
use super::tokens::Scope;
use crate::config::{Auth, Config, Motion, Profile};
use crate::json::rounded;
use crate::live::{Level, Status};
use crate::names::{configured, without};
use crate::picture::Rfc3339;
use crate::state::StateHealth;
use fusion::SensorIndex;

/// Answer to a probe.
#[derive(Clone, Copy)]
enum ProbeState {
    Ok,
    Ready,
}

fusion::interface_names!(ProbeState { Ok = "ok", Ready = "ready" });

/// Where the picture comes from.
#[derive(Clone, Copy)]
enum Mode {
    Live,
    Replay,
}

fusion::interface_names!(Mode { Live = "live", Replay = "replay" });

/// That it is alive, or ready.
#[derive(Serialize, JsonSchema)]
pub struct Health {
    #[schemars(extend("enum" = ProbeState::NAMES))]
    status: &'static str,
}

/// Alive.
pub fn health(_: &Ask) -> Result<Health, Problem> {
    Ok(Health { status: ProbeState::Ok.name() })
}

/// Lines are joined and the picture is of now, or 503 with what is wrong.
pub fn ready(ask: &Ask) -> Result<Health, Problem> {
    let condition = ask.state.condition();
    if condition.level() < Level::NotReady {
        return Ok(Health { status: ProbeState::Ready.name() });
    }
    let reasons = condition.reasons(Level::NotReady).into_iter().map(str::to_owned).collect();
    Err(Problem::unavailable("the service is not ready", reasons).retry_after_s(1))
}

/// Health with reasons, latency, counters.
#[derive(Serialize, JsonSchema)]
pub struct ServiceStatus {
    time: Rfc3339,
    #[schemars(extend("enum" = without(&Level::NAMES, Level::NotReady.name())))]
    state: &'static str,
    /// Whether the picture can be used.
    ready: bool,
    /// Why it is not ok.
    reasons: Vec<String>,
    started: Rfc3339,
    uptime_s: f64,
    /// Number of the latest slot.
    seq: u64,
    /// Open streams.
    streams: usize,
    /// How much later than configured the picture is, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    late_s: Option<f64>,
    /// Files of the state directory that cannot be written: a restart would lose what they hold.
    state_failing: Vec<String>,
    #[serde(flatten)]
    counted: Option<Counted>,
}

/// What the engine tells once per second.
#[derive(Serialize, JsonSchema)]
struct Counted {
    /// From the opening of a slot to its publication, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    latency_s: Option<Quantiles>,
    /// From when a slot was due to its publication, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    lateness_s: Option<Quantiles>,
    failed_sends: u64,
    tally: Tally,
}

#[derive(Serialize, JsonSchema)]
struct Quantiles {
    p50: f64,
    p95: f64,
    p99: f64,
}

/// Counts since the start.
#[derive(Serialize, JsonSchema)]
struct Tally {
    /// Datagrams.
    received: u64,
    octets: u64,
    duplicates: u64,
    /// Reports, by sensor, in the order of the configuration.
    #[schemars(with = "BTreeMap<String, u64>")]
    accepted: Map<String, Value>,
    /// Service messages, by sensor.
    #[schemars(with = "BTreeMap<String, u64>")]
    service: Map<String, Value>,
    faults: Vec<Fault>,
    refused: Vec<Refused>,
    skipped: Vec<Skipped>,
    several_records: u64,
    unknown_sources: u64,
    restarts: u64,
    clock_behind: u64,
    dropped: u64,
}

/// Unreadable blocks and records.
#[derive(Serialize, JsonSchema)]
struct Fault {
    category: Option<u8>,
    reason: &'static str,
    count: u64,
}

/// Records without a report.
#[derive(Serialize, JsonSchema)]
struct Refused {
    sensor: Option<String>,
    reason: &'static str,
    count: u64,
}

/// Blocks of categories that are not used.
#[derive(Serialize, JsonSchema)]
struct Skipped {
    category: u8,
    count: u64,
}

/// Health with reasons, latency, counters.
pub fn status(ask: &Ask) -> Result<ServiceStatus, Problem> {
    let hub = &ask.state.hub;
    let now = ask.state.now();
    let condition = ask.state.condition();
    let level = condition.level();
    Ok(ServiceStatus {
        time: now.into(),
        // There is a picture or there is none: whether it can be used is what `ready` says.
        state: level.min(Level::Degraded).name(),
        ready: level < Level::NotReady,
        reasons: condition.reasons(Level::Degraded).into_iter().map(str::to_owned).collect(),
        started: hub.started.into(),
        uptime_s: rounded(now.seconds_since(hub.started).max(0.0), 3),
        seq: ask.state.log.latest().1.map_or(0, |shown| shown.frame.seq),
        streams: ask.state.seats.taken(),
        late_s: hub.lateness().map(|lateness| rounded(lateness.late.as_secs_f64(), 3)),
        state_failing: ask.state.options.state.as_ref().map(state_failing).unwrap_or_default(),
        counted: hub.status().as_ref().map(|status| Counted::new(status, &hub.config)),
    })
}

fn state_failing(health: &StateHealth) -> Vec<String> {
    let files = health.all().into_iter();
    files.filter_map(|(name, file)| file.failing.map(|_| name)).collect()
}

impl Counted {
    fn new(status: &Status, config: &Config) -> Self {
        // From the opening of a slot until it is due; lateness comes on top.
        let due_after_s = config.fusion.latency().as_secs_f64();
        let quantiles = |above_s: f64| {
            let [p50, p95, p99] = status.lateness_s?.map(|late_s| rounded(above_s + late_s, 6));
            Some(Quantiles { p50, p95, p99 })
        };
        Self {
            latency_s: quantiles(due_after_s),
            lateness_s: quantiles(0.0),
            failed_sends: status.failed_sends,
            tally: Tally::new(&status.tally, config),
        }
    }
}

impl Tally {
    fn new(tally: &crate::pipeline::Tally, config: &Config) -> Self {
        let name =
            |sensor: SensorIndex| config.sensors.get(usize::from(sensor.0)).map(|sensor| sensor.id.clone());
        let by_sensor = |counts: &BTreeMap<SensorIndex, u64>| {
            counts.iter().filter_map(|(&sensor, &count)| Some((name(sensor)?, count.into()))).collect()
        };
        let fault = |(&(category, reason), &count)| Fault { category, reason, count };
        let refused = |(&(sensor, reason), &count): (&(Option<SensorIndex>, _), _)| Refused {
            sensor: sensor.and_then(name),
            reason,
            count,
        };
        Self {
            received: tally.received,
            octets: tally.octets,
            duplicates: tally.duplicates,
            accepted: by_sensor(&tally.accepted),
            service: by_sensor(&tally.service),
            faults: tally.faults.iter().map(fault).collect(),
            refused: tally.refused.iter().map(refused).collect(),
            skipped: tally.skipped.iter().map(|(&category, &count)| Skipped { category, count }).collect(),
            several_records: tally.several_records,
            unknown_sources: tally.unknown_sources.values().sum(),
            restarts: tally.restarts,
            clock_behind: tally.clock_behind,
            dropped: tally.dropped(),
        }
    }
}

/// Name of the service.
const NAME: &str = "utm-fusion";

/// Version, site and the settings that a reader of the picture should know.
#[derive(Serialize, JsonSchema)]
pub struct Info {
    #[schemars(extend("const" = NAME))]
    name: &'static str,
    version: &'static str,
    site: Site,
    /// Geoid above ellipsoid at the site, metres.
    geoid_separation: f64,
    #[schemars(extend("enum" = configured::<Profile>()))]
    profile: &'static str,
    slot_s: f64,
    /// From the opening of a slot until it is due, seconds.
    latency_s: f64,
    /// Whether there is a picture at=now as well.
    now: bool,
    /// Whether the picture is made by several machines (`/api/v1/cluster`).
    cluster: bool,
    started: Rfc3339,
    #[schemars(extend("enum" = Mode::NAMES))]
    mode: &'static str,
    #[schemars(extend("enum" = configured::<Auth>()))]
    auth: &'static str,
    /// Whether the token in use has the scope `control`.
    control: bool,
    settings: Settings,
    /// Where the page gets its map from.
    #[serde(skip_serializing_if = "Option::is_none")]
    tiles: Option<Tiles>,
    /// The base map, from `/api/v1/basemap`.
    #[serde(skip_serializing_if = "Option::is_none")]
    basemap: Option<basemap::About>,
    /// How far back the history goes at most, hours; absent where none is kept.
    #[serde(skip_serializing_if = "Option::is_none")]
    history_hours: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    replay: Option<Replay>,
}

#[derive(Serialize, JsonSchema)]
struct Site {
    name: String,
    sac: u8,
    sic: u8,
}

/// As configured in `[fusion]`.
#[derive(Serialize, JsonSchema)]
struct Settings {
    #[schemars(extend("enum" = configured::<Motion>()))]
    motion: &'static str,
    window_s: f64,
    max_future_s: f64,
    max_gap_s: f64,
    /// Rows of slant range and association distance, metres.
    threshold_m: Vec<(f64, f64)>,
    ratio_min: f64,
    min_samples: u32,
    weight_radar: f64,
    weight_transponder: f64,
    radar_only_min_s: f64,
    suppress_s: f64,
}

#[derive(Serialize, JsonSchema)]
struct Tiles {
    url: String,
    attribution: String,
}

/// Version, site and settings.
pub fn info(ask: &Ask) -> Result<Info, Problem> {
    let hub = &ask.state.hub;
    let (config, fusion) = (&hub.config, &hub.config.fusion);
    let replay = replay::state(ask.state.options.player.as_ref());
    let tiles = config.http.tiles.as_ref();
    Ok(Info {
        name: NAME,
        version: env!("CARGO_PKG_VERSION"),
        site: Site { name: config.site.name.clone(), sac: config.site.sac, sic: config.site.sic },
        geoid_separation: rounded(hub.maker.geoid_undulation_m(), 3),
        profile: fusion.profile.name(),
        slot_s: fusion.slot.as_secs_f64(),
        latency_s: fusion.latency().as_secs_f64(),
        now: fusion.now,
        cluster: hub.config.cluster.is_some(),
        started: hub.started.into(),
        mode: if replay.is_some() { Mode::Replay } else { Mode::Live }.name(),
        auth: if ask.state.needs_token() { "tokens" } else { "none" },
        control: ask.state.terms().may(ask.pass, Scope::Control),
        settings: Settings {
            motion: fusion.motion.name(),
            window_s: fusion.window().as_secs_f64(),
            max_future_s: fusion.max_future.as_secs_f64(),
            max_gap_s: fusion.max_gap.as_secs_f64(),
            threshold_m: fusion.threshold_m.clone(),
            ratio_min: fusion.ratio_min,
            min_samples: fusion.min_samples,
            weight_radar: fusion.weight_radar,
            weight_transponder: fusion.weight_transponder,
            radar_only_min_s: fusion.radar_only_min_s,
            suppress_s: fusion.suppress().as_secs_f64(),
        },
        tiles: tiles.map(|tiles| Tiles { url: tiles.url.clone(), attribution: tiles.attribution.clone() }),
        basemap: ask.state.basemap.as_ref().map(Into::into),
        history_hours: ask.state.options.history.as_ref().map(|_| config.state.history_hours),
        replay,
    })
}
