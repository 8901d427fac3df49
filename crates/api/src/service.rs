//! State of the service: `/healthz`, `/readyz`, `/api/v1/status`, `/api/v1/info`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};

use super::basemap;
use super::problem::Problem;
use super::replay::{self, ReplayState};
use super::request::ApiRequest;
use super::tokens::Scope;
use fusion::SensorIndex;
use input::json::rounded;
use input::names::{configured, without};
use picture::Rfc3339;
use service::live::{ServiceLevel, Status};
use service::state::StateHealth;
use site::config::{Auth, Config, Motion, Profile};

/// Answer to a probe.
#[derive(Clone, Copy)]
enum ProbeState {
    Ok,
    Ready,
}

fusion::interface_names!(ProbeState { Ok = "ok", Ready = "ready" });

/// Source of the picture.
#[derive(Clone, Copy)]
enum Mode {
    Live,
    ReplayState,
}

fusion::interface_names!(Mode { Live = "live", ReplayState = "replay" });

/// Liveness or readiness of the service.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Health")]
pub struct ProbeAnswer {
    #[schemars(extend("enum" = ProbeState::NAMES))]
    status: &'static str,
}

/// Answer of the liveness probe.
pub fn health(_: &ApiRequest) -> Result<ProbeAnswer, Problem> {
    Ok(ProbeAnswer { status: ProbeState::Ok.name() })
}

/// Answer of the readiness probe: inputs are joined and the picture is current, or 503 with the reasons.
pub fn ready(request: &ApiRequest) -> Result<ProbeAnswer, Problem> {
    let condition = request.state.condition();
    if condition.level() < ServiceLevel::NotReady {
        return Ok(ProbeAnswer { status: ProbeState::Ready.name() });
    }
    let reasons = condition.reasons(ServiceLevel::NotReady).into_iter().map(str::to_owned).collect();
    Err(Problem::unavailable("the service is not ready", reasons).retry_after_s(1))
}

/// State with reasons, latency and counters.
#[derive(Serialize, JsonSchema)]
pub struct ServiceStatus {
    time: Rfc3339,
    #[schemars(extend("enum" = without(&ServiceLevel::NAMES, ServiceLevel::NotReady.name())))]
    state: &'static str,
    /// Whether the picture can be used.
    ready: bool,
    /// Reasons why the state is not ok.
    reasons: Vec<String>,
    started: Rfc3339,
    uptime_s: f64,
    /// Sequence number of the latest slot.
    seq: u64,
    /// Number of open streams.
    streams: usize,
    /// Delay of the picture beyond the configured latency, in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    late_s: Option<f64>,
    /// Files of the state directory that cannot be written. A restart would lose their contents.
    state_failing: Vec<String>,
    #[serde(flatten)]
    counters: Option<EngineCounters>,
}

/// Counters that the engine reports once per second.
#[derive(Serialize, JsonSchema)]
struct EngineCounters {
    /// Time from the start of a slot to its publication, in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    latency_s: Option<QuantilesJson>,
    /// Time from a slot's due time to its publication, in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    lateness_s: Option<QuantilesJson>,
    failed_sends: u64,
    tally: TallyJson,
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Quantiles")]
struct QuantilesJson {
    p50: f64,
    p95: f64,
    p99: f64,
}

/// Counters since the start.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Tally")]
struct TallyJson {
    /// Number of datagrams received.
    received: u64,
    octets: u64,
    duplicates: u64,
    /// Number of reports, by sensor, in the order of the configuration.
    #[schemars(with = "BTreeMap<String, u64>")]
    accepted: Map<String, Value>,
    /// Number of service messages, by sensor.
    #[schemars(with = "BTreeMap<String, u64>")]
    service: Map<String, Value>,
    faults: Vec<FaultCount>,
    refused: Vec<RefusedCount>,
    skipped: Vec<SkippedCount>,
    several_records: u64,
    unknown_sources: u64,
    restarts: u64,
    clock_behind: u64,
    dropped: u64,
}

/// Unreadable blocks and records.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Fault")]
struct FaultCount {
    category: Option<u8>,
    reason: &'static str,
    count: u64,
}

/// Records without a report.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Refused")]
struct RefusedCount {
    sensor: Option<String>,
    reason: &'static str,
    count: u64,
}

/// Blocks of categories that are not used.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Skipped")]
struct SkippedCount {
    category: u8,
    count: u64,
}

/// State with reasons, latency and counters.
pub fn status(request: &ApiRequest) -> Result<ServiceStatus, Problem> {
    let hub = &request.state.hub;
    let now = request.state.now();
    let condition = request.state.condition();
    let level = condition.level();
    Ok(ServiceStatus {
        time: now.into(),
        // `state` depends on whether a picture exists; `ready` on whether it can be used.
        state: level.min(ServiceLevel::Degraded).name(),
        ready: level < ServiceLevel::NotReady,
        reasons: condition.reasons(ServiceLevel::Degraded).into_iter().map(str::to_owned).collect(),
        started: hub.started.into(),
        uptime_s: rounded(now.seconds_since(hub.started).max(0.0), 3),
        seq: request.state.log.latest().1.map_or(0, |slot| slot.frame.seq),
        streams: request.state.stream_limit.open_streams(),
        late_s: hub.lateness().map(|lateness| rounded(lateness.late.as_secs_f64(), 3)),
        state_failing: request.state.options.state.as_ref().map(state_failing).unwrap_or_default(),
        counters: hub.status().as_ref().map(|status| EngineCounters::new(status, &hub.config)),
    })
}

fn state_failing(health: &StateHealth) -> Vec<String> {
    let files = health.all().into_iter();
    files.filter_map(|(name, file)| file.failing.map(|_| name)).collect()
}

impl EngineCounters {
    fn new(status: &Status, config: &Config) -> Self {
        // Time from the start of a slot to its due time; the lateness is added to it.
        let due_after_s = config.fusion.latency().as_secs_f64();
        let quantiles = |above_s: f64| {
            let [p50, p95, p99] = status.lateness_s?.map(|late_s| rounded(above_s + late_s, 6));
            Some(QuantilesJson { p50, p95, p99 })
        };
        Self {
            latency_s: quantiles(due_after_s),
            lateness_s: quantiles(0.0),
            failed_sends: status.failed_sends,
            tally: TallyJson::new(&status.tally, config),
        }
    }
}

impl TallyJson {
    fn new(tally: &input::pipeline::Tally, config: &Config) -> Self {
        let name =
            |sensor: SensorIndex| config.sensors.get(usize::from(sensor.0)).map(|sensor| sensor.id.clone());
        let by_sensor = |counts: &BTreeMap<SensorIndex, u64>| {
            counts.iter().filter_map(|(&sensor, &count)| Some((name(sensor)?, count.into()))).collect()
        };
        let fault = |(&(category, reason), &count)| FaultCount { category, reason, count };
        let refused = |(&(sensor, reason), &count): (&(Option<SensorIndex>, _), _)| RefusedCount {
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
            skipped: tally
                .skipped
                .iter()
                .map(|(&category, &count)| SkippedCount { category, count })
                .collect(),
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

/// Version, site, and settings that clients of the picture need.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Info")]
pub struct ServiceInfo {
    #[schemars(extend("const" = NAME))]
    name: &'static str,
    version: &'static str,
    site: SiteIdentity,
    /// Height of the geoid above the ellipsoid at the site, in metres.
    geoid_separation: f64,
    #[schemars(extend("enum" = configured::<Profile>()))]
    profile: &'static str,
    slot_s: f64,
    /// Time from the start of a slot to its due time, in seconds.
    latency_s: f64,
    /// Whether the picture `at=now` is available.
    now: bool,
    /// Whether a cluster makes the picture (`/api/v1/cluster`).
    cluster: bool,
    started: Rfc3339,
    #[schemars(extend("enum" = Mode::NAMES))]
    mode: &'static str,
    #[schemars(extend("enum" = configured::<Auth>()))]
    auth: &'static str,
    /// Whether the token in use has the scope `control`.
    control: bool,
    settings: FusionSettings,
    /// Server of raster map tiles for the page.
    #[serde(skip_serializing_if = "Option::is_none")]
    tiles: Option<TileServer>,
    /// Base map, served by `/api/v1/basemap`.
    #[serde(skip_serializing_if = "Option::is_none")]
    basemap: Option<basemap::BasemapInfo>,
    /// Maximum length of the history, in hours; left out if no history is kept.
    #[serde(skip_serializing_if = "Option::is_none")]
    history_hours: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    replay: Option<ReplayState>,
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Site")]
struct SiteIdentity {
    name: String,
    sac: u8,
    sic: u8,
}

/// Settings of `[fusion]`.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Settings")]
struct FusionSettings {
    #[schemars(extend("enum" = configured::<Motion>()))]
    motion: &'static str,
    window_s: f64,
    max_future_s: f64,
    max_gap_s: f64,
    /// Rows of slant range and association distance, in metres.
    threshold_m: Vec<(f64, f64)>,
    ratio_min: f64,
    min_samples: u32,
    weight_radar: f64,
    weight_transponder: f64,
    radar_only_min_s: f64,
    suppress_s: f64,
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Tiles")]
struct TileServer {
    url: String,
    attribution: String,
}

/// Version, site and settings.
pub fn info(request: &ApiRequest) -> Result<ServiceInfo, Problem> {
    let hub = &request.state.hub;
    let (config, fusion) = (&hub.config, &hub.config.fusion);
    let replay = replay::state(request.state.options.player.as_ref());
    let tiles = config.http.tiles.as_ref();
    Ok(ServiceInfo {
        name: NAME,
        version: env!("CARGO_PKG_VERSION"),
        site: SiteIdentity { name: config.site.name.clone(), sac: config.site.sac, sic: config.site.sic },
        geoid_separation: rounded(hub.maker.geoid_undulation_m(), 3),
        profile: fusion.profile.name(),
        slot_s: fusion.slot.as_secs_f64(),
        latency_s: fusion.latency().as_secs_f64(),
        now: fusion.now,
        cluster: hub.config.cluster.is_some(),
        started: hub.started.into(),
        mode: if replay.is_some() { Mode::ReplayState } else { Mode::Live }.name(),
        auth: if request.state.needs_token() { "tokens" } else { "none" },
        control: request.state.access().may(request.credential, Scope::Control),
        settings: FusionSettings {
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
        tiles: tiles
            .map(|tiles| TileServer { url: tiles.url.clone(), attribution: tiles.attribution.clone() }),
        basemap: request.state.basemap.as_deref().map(Into::into),
        history_hours: request.state.options.history.as_ref().map(|_| config.state.history_hours),
        replay,
    })
}
