//! State shared by all requests: hub, log of events, access, and counters.

use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::ops::Deref;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::http::HeaderValue;
use tokio::sync::watch;
use tokio::time::Instant;
use tracing::error;

use super::access::AccessSettings;
use super::connection_limit::ConnectionLimit;
use super::event_log::EventLog;
use super::filter::TrackFilter;
use super::payload::Payload;
use super::problem::Problem;
use super::rate::{BucketOwner, RateLimiter};
use super::render::Renderer;
use super::slot_json::SlotJson;
use super::stream_limit::StreamLimit;
use super::tokens::Tickets;
use super::trails::{RecentTrail, Trails};
use crate::pmtiles::Basemap;
use fusion::time::Time;
use service::current::Current;
use service::history::HistoryStore;
use service::live::{Condition, Hub, Player, PublishedPicture, ServiceLevel, ZoneRequests};
use service::notices::Notices;
use service::sinks::SinkMeter;
use service::state::StateHealth;
use site::config::{PictureKind, Tiles};

/// Maximum time without a slot while a replay plays; a longer silence is a fault.
const NO_SLOT: Duration = Duration::from_secs(5);

/// Limits, clock and sources. The defaults allow a load test from one address.
#[derive(Clone, Debug)]
pub struct Options {
    /// Maximum number of open streams.
    pub streams: usize,
    /// Maximum number of open streams per client address.
    pub streams_per_address: usize,
    /// Maximum number of open connections; fewer if the system allows only few open files.
    pub connections: usize,
    /// Number of these connections reserved for this machine, so that an operator always gets in.
    pub reserved: usize,
    /// Timeout for receiving the headers of a request.
    pub header_timeout: Duration,
    /// Timeout for a connection whose peer acknowledges no data.
    pub stuck_timeout: Duration,
    /// Interval of pings on a WebSocket. A client that does not take a message or answer a ping within this time is disconnected.
    pub patience: Duration,
    /// Clock.
    pub clock: fn() -> Time,
    /// History; `None` if none is kept.
    pub history: Option<HistoryStore>,
    /// Health of the files of `[state] dir`; `None` if no state is kept.
    pub state: Option<StateHealth>,
    /// Zones of operators; `None` if they cannot be activated here.
    pub zones: Option<ZoneRequests>,
    /// Receivers of notices of alerts, for the metrics.
    pub notices: Notices,
    /// Receivers of the picture, for the metrics.
    pub sinks: SinkMeter,
    /// Player of the replayed recording; `None` if the service is live.
    pub player: Option<Player>,
    /// Base map of a site whose configuration names none.
    pub basemap: Option<Arc<Basemap>>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            streams: 2_000,
            streams_per_address: 1_200,
            connections: 4_000,
            reserved: 16,
            header_timeout: Duration::from_secs(10),
            stuck_timeout: Duration::from_secs(60),
            patience: Duration::from_secs(15),
            clock: service::live::now,
            history: None,
            state: None,
            zones: None,
            notices: Notices::default(),
            sinks: SinkMeter::default(),
            player: None,
            basemap: None,
        }
    }
}

/// A picture with trails.
struct CachedTrails {
    frame: Arc<PublishedPicture>,
    kind: PictureKind,
    seconds: u32,
    payload: Payload,
}

/// State shared by all requests; cheap to clone.
#[derive(Clone)]
pub struct ApiState(Arc<ApiStateInner>);

/// Fields of the shared state. Private ones are accessed by methods.
pub struct ApiStateInner {
    pub(super) hub: Hub,
    pub(super) options: Options,
    pub(super) log: EventLog,
    access: Current<AccessSettings>,
    pub(super) tickets: Tickets,
    pub(super) connection_limit: ConnectionLimit,
    pub(super) stream_limit: StreamLimit,
    limiter: RateLimiter,
    /// Threads that make answers.
    pub(super) renderer: Renderer,
    trails: Mutex<Trails>,
    /// Last picture with trails, shared by identical requests.
    cached_trails: Mutex<Option<CachedTrails>>,
    /// Base map of the page.
    pub(super) basemap: Option<Arc<Basemap>>,
    /// Content security policy of the page.
    policy: HeaderValue,
    /// Number of responses, by status.
    answered: Mutex<BTreeMap<u16, u64>>,
    /// Time of arrival of the last slot.
    slot_came: Mutex<Option<Instant>>,
    closing: watch::Sender<bool>,
}

impl Deref for ApiState {
    type Target = ApiStateInner;

    fn deref(&self) -> &ApiStateInner {
        &self.0
    }
}

impl ApiState {
    /// State of a hub; `connections` is the maximum number of open ones.
    pub(super) fn new(hub: Hub, mut options: Options, access: AccessSettings, connections: usize) -> Self {
        Self(Arc::new(ApiStateInner {
            log: EventLog::default(),
            access: access.into(),
            tickets: Tickets::default(),
            limiter: RateLimiter::default(),
            connection_limit: ConnectionLimit::new(connections, options.reserved),
            stream_limit: StreamLimit::new(options.streams, options.streams_per_address),
            renderer: Renderer::default(),
            trails: Mutex::default(),
            cached_trails: Mutex::default(),
            basemap: hub.config.map.pmtiles.as_deref().map_or(options.basemap.take(), open),
            policy: policy(hub.config.http.tiles.as_ref()),
            answered: Mutex::default(),
            slot_came: Mutex::default(),
            closing: watch::Sender::default(),
            hub,
            options,
        }))
    }

    /// Replaces the access settings. A stream whose token is no longer accepted ends within a second.
    pub fn set_access(&self, access: AccessSettings) {
        self.access.replace(access);
    }

    /// Sends what is published so far, ends the streams with an event, and closes connections after their answers.
    pub fn close(&self) {
        self.closing.send_replace(true);
    }

    pub(super) fn access(&self) -> Arc<AccessSettings> {
        self.access.get()
    }

    /// Counts a request of an address or a token; fails above the limit.
    pub(super) fn limit(&self, owner: BucketOwner) -> Result<(), Problem> {
        self.charge(owner, 1)
    }

    /// Counts an expensive request as `weight` usual ones.
    pub(super) fn charge(&self, owner: BucketOwner, weight: u32) -> Result<(), Problem> {
        self.limiter.charge(owner, weight, self.access().limit, self.now())
    }

    /// Number of requests refused by the limit.
    pub(super) fn limited(&self) -> u64 {
        self.limiter.refused()
    }

    pub(super) fn policy(&self) -> HeaderValue {
        self.policy.clone()
    }

    pub(super) fn trails(&self) -> MutexGuard<'_, Trails> {
        self.trails.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Trail of each track over the last `seconds` before `now`. The lock is released before the trails are put together.
    pub(super) fn last_trails(&self, seconds: u32, now: Time) -> HashMap<Arc<str>, RecentTrail> {
        let last = self.trails().last(seconds, now);
        RecentTrail::all(&last)
    }

    /// Unfiltered picture with trails of this length. Consecutive identical requests share one answer.
    pub(super) fn with_trails(&self, slot: &SlotJson, kind: PictureKind, seconds: u32) -> Payload {
        let filter = TrackFilter::default();
        let mut cached_trails = self.cached_trails.lock().unwrap_or_else(PoisonError::into_inner);
        let is_same = |last: &&CachedTrails| {
            Arc::ptr_eq(&last.frame, &slot.frame) && (last.kind, last.seconds) == (kind, seconds)
        };
        if let Some(last) = cached_trails.as_ref().filter(is_same) {
            return last.payload.clone();
        }
        let payload = slot.with_trails(&filter, &self.last_trails(seconds, slot.time()));
        *cached_trails =
            Some(CachedTrails { frame: slot.frame.clone(), kind, seconds, payload: payload.clone() });
        payload
    }

    pub(super) fn now(&self) -> Time {
        (self.options.clock)()
    }

    pub(super) fn is_closing(&self) -> bool {
        *self.closing.borrow()
    }

    /// Waits for [`ApiState::close`].
    pub(super) async fn closed(&self) {
        // `self` owns the sender, so the channel stays open.
        let _ = self.closing.subscribe().wait_for(|closing| *closing).await;
    }

    /// Event id `<start>-<number>`, which distinguishes the runs of the service.
    pub(super) fn event_id(&self, number: u64) -> String {
        format!("{}-{number}", self.start_ms())
    }

    /// Number in the event id, if the id is of this run.
    pub(super) fn number_of(&self, id: &str) -> Option<u64> {
        let (start, number) = id.split_once('-')?;
        (start.parse() == Ok(self.start_ms())).then(|| number.parse().ok())?
    }

    /// Start of the service, in milliseconds since the epoch.
    fn start_ms(&self) -> i64 {
        self.hub.started.nanos().div_euclid(1_000_000).max(0)
    }

    pub(super) fn note_slot(&self) {
        *self.slot_came.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
    }

    /// Time since the last slot.
    pub(super) fn slot_age(&self) -> Option<Duration> {
        self.slot_came.lock().unwrap_or_else(PoisonError::into_inner).map(|came| came.elapsed())
    }

    /// Condition of the service; for a replay it depends on the state of the player.
    pub(super) fn condition(&self) -> Condition {
        let mut condition = self.hub.condition();
        let player = self.options.player.as_ref().map(Player::state);
        // A paused or slow replay is in order.
        if let Some((state, age)) = player.filter(|state| state.playing).zip(self.slot_age())
            && age > NO_SLOT.div_f64(state.speed.min(1.0))
        {
            condition.add(ServiceLevel::NotReady, format!("no slot has been shown for {} s", age.as_secs()));
        }
        condition
    }

    /// Whether a token is required.
    pub(super) fn needs_token(&self) -> bool {
        self.access().tokens.is_some()
    }

    pub(super) fn count_answer(&self, status: u16) {
        *self.answered.lock().unwrap_or_else(PoisonError::into_inner).entry(status).or_default() += 1;
    }

    pub(super) fn answered(&self) -> BTreeMap<u16, u64> {
        self.answered.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Opens the base map. If it cannot be read, the service runs without one.
fn open(path: &Path) -> Option<Arc<Basemap>> {
    let failed = |error: &std::io::Error| error!("no base map: {}: {error}", path.display());
    Basemap::open(path).inspect_err(failed).ok().map(Arc::new)
}

/// Content security policy: the page loads from this service only, and images from the tile server if there is one.
fn policy(tiles: Option<&Tiles>) -> HeaderValue {
    let tiles = tiles.map_or(String::new(), |tiles| format!("img-src 'self' {}; ", tiles.origin()));
    let policy = format!("default-src 'self'; {tiles}frame-ancestors 'none'; base-uri 'none'");
    HeaderValue::try_from(policy).expect("an origin is of lower-case letters, digits and -.:[]")
}

impl fmt::Debug for ApiState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ApiState").field("streams", &self.stream_limit.open_streams()).finish_non_exhaustive()
    }
}
