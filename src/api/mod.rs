//! The HTTP/JSON API: the picture, the stream of it, the state of everything; `docs/API.md` describes it.
//!
//! ```text
//! Hub ──► Keeper (one task) ──► Log: the last events, their octets made once ──► readers, each at its own place
//!                                └─ the latest slot ──► routes
//! ```
//!
//! [`routes`] is the one table that both the router and the OpenAPI document are made of.

mod ask;
mod auth;
mod client;
mod correlations;
mod door;
mod endings;
mod filter;
mod guard;
mod gzip;
mod history;
mod hosts;
mod keeper;
mod log;
mod metrics;
mod openapi;
mod page;
mod problem;
mod rate;
mod raw;
mod readsb;
mod replay;
pub mod routes;
mod schemas;
mod seats;
mod server;
mod service;
mod shown;
mod sites;
mod stream;
mod terms;
mod tls;
mod tracks;
mod trails;
mod uss;
mod validity;

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::http::HeaderValue;
use tokio::sync::watch;
use tokio::time::Instant;
use tracing::warn;

use crate::areas::{AreaError, Areas};
use crate::current::Current;
use crate::history::Store;
use crate::live::{Hub, Player};
use auth::Tickets;
use door::Door;
use fusion::time::Time;
use keeper::Keeper;
use log::Log;
use rate::{Limiter, Who};
use seats::Seats;
use trails::Trails;

pub use guard::router;
pub use problem::Problem;
pub use server::{listen, serve};
pub use terms::Terms;

/// Where the service says no. The defaults let a load test from one address through.
#[derive(Clone, Debug)]
pub struct Options {
    /// Open streams.
    pub streams: usize,
    /// Open streams from one address.
    pub streams_per_address: usize,
    /// Open connections; fewer where the system allows only few open files.
    pub connections: usize,
    /// So many of them are for this machine alone: whoever looks after the service gets in.
    pub reserved: usize,
    /// A connection that has not sent a request's headers by then is closed.
    pub header_timeout: Duration,
    /// Octets sent and not acknowledged for so long, or a reader that takes none, end the connection.
    pub stuck_timeout: Duration,
    /// Tells the time.
    pub clock: fn() -> Time,
    /// Where tracks were; `None`: no history is kept.
    pub history: Option<Store>,
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
            clock: crate::live::now,
            history: None,
            player: None,
        }
    }
}

/// Why the API cannot start.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StartError {
    /// A file of `[[areas]]`.
    #[error(transparent)]
    Area(#[from] AreaError),
    /// The tokens.
    #[error("{}: {problem}", file.display())]
    Tokens {
        /// Their file.
        file: PathBuf,
        /// What is wrong with it, and what to do.
        problem: String,
    },
    /// The certificate or the key.
    #[error("{}: {problem}", file.display())]
    Tls {
        /// The file of the one that cannot be used.
        file: PathBuf,
        /// What is wrong with it, and what to do.
        problem: String,
    },
}

/// What all requests share; cheap to clone.
#[derive(Clone)]
pub struct ApiState(Arc<Inner>);

struct Inner {
    hub: Hub,
    options: Options,
    log: Log,
    terms: Current<Terms>,
    tickets: Tickets,
    door: Door,
    seats: Seats,
    limiter: Limiter,
    trails: Mutex<Trails>,
    /// What the page may load.
    policy: HeaderValue,
    /// Responses by status.
    answered: Mutex<BTreeMap<u16, u64>>,
    /// When the last slot came.
    slot_came: Mutex<Option<Instant>>,
    closing: watch::Sender<bool>,
}

impl ApiState {
    /// Reads what the configuration names, and begins to follow the hub; within a tokio runtime.
    ///
    /// # Errors
    /// The file of an area, of the tokens, of the certificate or of its key cannot be used.
    pub fn start(hub: Hub, options: Options) -> Result<Self, StartError> {
        let terms = Terms::load(&hub.config, &Areas::load(&hub.config.areas)?)?;
        terms.warnings((options.clock)()).iter().for_each(|warning| warn!("{warning}"));
        let (closing, closed) = watch::channel(false);
        let state = Self(Arc::new(Inner {
            log: Log::default(),
            terms: terms.into(),
            tickets: Tickets::default(),
            limiter: Limiter::default(),
            door: Door::new(server::affordable(options.connections), options.reserved),
            seats: Seats::new(options.streams, options.streams_per_address),
            trails: Mutex::default(),
            policy: guard::policy(hub.config.http.tiles.as_ref()),
            answered: Mutex::default(),
            slot_came: Mutex::default(),
            closing,
            hub,
            options,
        }));
        tokio::spawn(Keeper::new(state.clone()).run(closed));
        Ok(state)
    }

    /// Other terms from now on; a stream whose token is no longer known ends within a second.
    pub fn set_terms(&self, terms: Terms) {
        self.0.terms.replace(terms);
    }

    /// Shows what is published by now, ends the streams with an event, and the connections after their answers.
    pub fn close(&self) {
        self.0.closing.send_replace(true);
    }

    fn hub(&self) -> &Hub {
        &self.0.hub
    }

    fn options(&self) -> &Options {
        &self.0.options
    }

    fn log(&self) -> &Log {
        &self.0.log
    }

    fn terms(&self) -> Arc<Terms> {
        self.0.terms.get()
    }

    /// A request of that address or token, unless it asks too often.
    fn limit(&self, who: Who) -> Result<(), Problem> {
        self.0.limiter.take(who, self.terms().limit, self.now())
    }

    /// Requests that were refused because of that.
    fn limited(&self) -> u64 {
        self.0.limiter.refused()
    }

    fn door(&self) -> &Door {
        &self.0.door
    }

    fn seats(&self) -> &Seats {
        &self.0.seats
    }

    fn policy(&self) -> HeaderValue {
        self.0.policy.clone()
    }

    fn trails(&self) -> MutexGuard<'_, Trails> {
        self.0.trails.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now(&self) -> Time {
        (self.0.options.clock)()
    }

    fn is_closing(&self) -> bool {
        *self.0.closing.borrow()
    }

    /// Until [`ApiState::close`].
    async fn closed(&self) {
        // The sender lives as long as this does.
        let _ = self.0.closing.subscribe().wait_for(|closing| *closing).await;
    }

    /// `<start>-<number>`: an event's id tells the runs of the service apart.
    fn event_id(&self, number: u64) -> String {
        format!("{}-{number}", self.start_ms())
    }

    /// The number in an event's id of this run.
    fn number_of(&self, id: &str) -> Option<u64> {
        let (start, number) = id.split_once('-')?;
        (start.parse() == Ok(self.start_ms())).then(|| number.parse().ok())?
    }

    /// When the service started, milliseconds since the epoch.
    fn start_ms(&self) -> i64 {
        self.hub().started.nanos().div_euclid(1_000_000).max(0)
    }

    fn note_slot(&self) {
        *self.0.slot_came.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
    }

    /// How long ago the last slot came.
    fn slot_age(&self) -> Option<Duration> {
        self.0.slot_came.lock().unwrap_or_else(PoisonError::into_inner).map(|came| came.elapsed())
    }

    fn count_answer(&self, status: u16) {
        *self.0.answered.lock().unwrap_or_else(PoisonError::into_inner).entry(status).or_default() += 1;
    }

    fn answered(&self) -> BTreeMap<u16, u64> {
        self.0.answered.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl fmt::Debug for ApiState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ApiState").field("streams", &self.seats().taken()).finish_non_exhaustive()
    }
}
