//! What all requests share: the hub, the log of events, who may ask, and what is counted.

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

use super::door::Door;
use super::filter::Filter;
use super::log::Log;
use super::payload::Payload;
use super::problem::Problem;
use super::rate::{Limiter, Who};
use super::render::Renderer;
use super::seats::Seats;
use super::shown::Shown;
use super::terms::Terms;
use super::tokens::Tickets;
use super::trails::{Trail, Trails};
use crate::basemap::Basemap;
use crate::config::{PictureKind, Tiles};
use crate::current::Current;
use crate::history::Store;
use crate::live::{Condition, Hub, Level, Player, PublishedPicture};
use crate::notices::Notices;
use crate::sinks::SinkMeter;
use crate::state::StateHealth;
use fusion::time::Time;

/// While a replay plays, slots come four times per second; a longer silence is a fault.
const NO_SLOT: Duration = Duration::from_secs(5);

/// Limits, clock and sources. The defaults admit a load test from one address.
#[derive(Clone, Debug)]
pub struct Options {
    /// Open streams.
    pub streams: usize,
    /// Open streams from one address.
    pub streams_per_address: usize,
    /// Open connections; fewer where the system allows only few open files.
    pub connections: usize,
    /// Of these, connections reserved for this machine, so that an operator always gets in.
    pub reserved: usize,
    /// A connection that has not sent a request's headers by then is closed.
    pub header_timeout: Duration,
    /// A connection whose peer acknowledges nothing for this duration is closed.
    pub stuck_timeout: Duration,
    /// A WebSocket whose client does not take a message for this duration, or answers no ping, is closed; as often it is pinged.
    pub patience: Duration,
    /// Tells the time.
    pub clock: fn() -> Time,
    /// Where tracks were; `None`: no history is kept.
    pub history: Option<Store>,
    /// Health of the files of `[state] dir`; `None`: no state is kept.
    pub state: Option<StateHealth>,
    /// Who hears of alerts elsewhere.
    pub notices: Notices,
    /// Whom the picture goes to elsewhere.
    pub sinks: SinkMeter,
    /// The recording that is replayed; `None`: the service is live.
    pub player: Option<Player>,
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
            clock: crate::live::now,
            history: None,
            state: None,
            notices: Notices::default(),
            sinks: SinkMeter::default(),
            player: None,
        }
    }
}

/// A picture with trails.
struct Trailed {
    frame: Arc<PublishedPicture>,
    kind: PictureKind,
    seconds: u32,
    payload: Payload,
}

/// What all requests share; cheap to clone.
#[derive(Clone)]
pub struct ApiState(Arc<Inner>);

/// What requests share; the rest of it has methods.
pub struct Inner {
    pub(super) hub: Hub,
    pub(super) options: Options,
    pub(super) log: Log,
    terms: Current<Terms>,
    pub(super) tickets: Tickets,
    pub(super) door: Door,
    pub(super) seats: Seats,
    limiter: Limiter,
    /// Writes the answers.
    pub(super) renderer: Renderer,
    trails: Mutex<Trails>,
    /// The picture with trails that was written last; identical requests share it.
    trailed: Mutex<Option<Trailed>>,
    /// The base map of the page.
    pub(super) basemap: Option<Basemap>,
    /// What the page may load.
    policy: HeaderValue,
    /// Responses by status.
    answered: Mutex<BTreeMap<u16, u64>>,
    /// When the last slot came.
    slot_came: Mutex<Option<Instant>>,
    closing: watch::Sender<bool>,
}

impl Deref for ApiState {
    type Target = Inner;

    fn deref(&self) -> &Inner {
        &self.0
    }
}

impl ApiState {
    /// The state of a hub; `connections`: how many may be open.
    pub(super) fn new(hub: Hub, options: Options, terms: Terms, connections: usize) -> Self {
        Self(Arc::new(Inner {
            log: Log::default(),
            terms: terms.into(),
            tickets: Tickets::default(),
            limiter: Limiter::default(),
            door: Door::new(connections, options.reserved),
            seats: Seats::new(options.streams, options.streams_per_address),
            renderer: Renderer::default(),
            trails: Mutex::default(),
            trailed: Mutex::default(),
            basemap: hub.config.map.pmtiles.as_deref().and_then(open),
            policy: policy(hub.config.http.tiles.as_ref()),
            answered: Mutex::default(),
            slot_came: Mutex::default(),
            closing: watch::Sender::default(),
            hub,
            options,
        }))
    }

    /// Replaces the terms; a stream whose token is no longer known ends within a second.
    pub fn set_terms(&self, terms: Terms) {
        self.terms.replace(terms);
    }

    /// Shows what is published by now, ends the streams with an event, and the connections after their answers.
    pub fn close(&self) {
        self.closing.send_replace(true);
    }

    pub(super) fn terms(&self) -> Arc<Terms> {
        self.terms.get()
    }

    /// A request of that address or token, unless it asks too often.
    pub(super) fn limit(&self, who: Who) -> Result<(), Problem> {
        self.charge(who, 1)
    }

    /// Charges a request that costs as much as `weight` usual ones.
    pub(super) fn charge(&self, who: Who, weight: u32) -> Result<(), Problem> {
        self.limiter.take(who, weight, self.terms().limit, self.now())
    }

    /// Requests that were refused because of that.
    pub(super) fn limited(&self) -> u64 {
        self.limiter.refused()
    }

    pub(super) fn policy(&self) -> HeaderValue {
        self.policy.clone()
    }

    pub(super) fn trails(&self) -> MutexGuard<'_, Trails> {
        self.trails.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The trail of each track over the last `seconds` before `now`. The lock is released before the trails are put together.
    pub(super) fn last_trails(&self, seconds: u32, now: Time) -> HashMap<Arc<str>, Trail> {
        let last = self.trails().last(seconds, now);
        Trail::all(&last)
    }

    /// The unfiltered picture with trails of that length. Identical requests in a row share one answer.
    pub(super) fn with_trails(&self, shown: &Shown, kind: PictureKind, seconds: u32) -> Payload {
        let filter = Filter::default();
        let mut trailed = self.trailed.lock().unwrap_or_else(PoisonError::into_inner);
        let is_same = |last: &&Trailed| {
            Arc::ptr_eq(&last.frame, &shown.frame) && (last.kind, last.seconds) == (kind, seconds)
        };
        if let Some(last) = trailed.as_ref().filter(is_same) {
            return last.payload.clone();
        }
        let payload = shown.with_trails(&filter, &self.last_trails(seconds, shown.time()));
        *trailed = Some(Trailed { frame: shown.frame.clone(), kind, seconds, payload: payload.clone() });
        payload
    }

    pub(super) fn now(&self) -> Time {
        (self.options.clock)()
    }

    pub(super) fn is_closing(&self) -> bool {
        *self.closing.borrow()
    }

    /// Until [`ApiState::close`].
    pub(super) async fn closed(&self) {
        // The sender lives as long as this does.
        let _ = self.closing.subscribe().wait_for(|closing| *closing).await;
    }

    /// `<start>-<number>`: an event's id tells the runs of the service apart.
    pub(super) fn event_id(&self, number: u64) -> String {
        format!("{}-{number}", self.start_ms())
    }

    /// The number in an event's id of this run.
    pub(super) fn number_of(&self, id: &str) -> Option<u64> {
        let (start, number) = id.split_once('-')?;
        (start.parse() == Ok(self.start_ms())).then(|| number.parse().ok())?
    }

    /// When the service started, milliseconds since the epoch.
    fn start_ms(&self) -> i64 {
        self.hub.started.nanos().div_euclid(1_000_000).max(0)
    }

    pub(super) fn note_slot(&self) {
        *self.slot_came.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
    }

    /// How long ago the last slot came.
    pub(super) fn slot_age(&self) -> Option<Duration> {
        self.slot_came.lock().unwrap_or_else(PoisonError::into_inner).map(|came| came.elapsed())
    }

    /// The service's condition; a replay's pace is its player's.
    pub(super) fn condition(&self) -> Condition {
        let mut condition = self.hub.condition();
        let player = self.options.player.as_ref().map(Player::state);
        // One that stands still, or goes slowly, is as it should be.
        if let Some((state, age)) = player.filter(|state| state.playing).zip(self.slot_age())
            && age > NO_SLOT.div_f64(state.speed.min(1.0))
        {
            condition.add(Level::NotReady, format!("no slot has been shown for {} s", age.as_secs()));
        }
        condition
    }

    /// Whether a token is asked for.
    pub(super) fn needs_token(&self) -> bool {
        self.terms().tokens.is_some()
    }

    pub(super) fn count_answer(&self, status: u16) {
        *self.answered.lock().unwrap_or_else(PoisonError::into_inner).entry(status).or_default() += 1;
    }

    pub(super) fn answered(&self) -> BTreeMap<u16, u64> {
        self.answered.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// The base map; where it cannot be read the map has no ground, and the service runs all the same.
fn open(path: &Path) -> Option<Basemap> {
    let failed = |error: &std::io::Error| error!("no base map: {}: {error}", path.display());
    Basemap::open(path).inspect_err(failed).ok()
}

/// What the page may load: nothing but from here, and pictures from the server of the tiles where there is one.
fn policy(tiles: Option<&Tiles>) -> HeaderValue {
    let tiles = tiles.map_or(String::new(), |tiles| format!("img-src 'self' {}; ", tiles.origin()));
    let policy = format!("default-src 'self'; {tiles}frame-ancestors 'none'; base-uri 'none'");
    HeaderValue::try_from(policy).expect("an origin is of lower-case letters, digits and -.:[]")
}

impl fmt::Debug for ApiState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ApiState").field("streams", &self.seats.taken()).finish_non_exhaustive()
    }
}
