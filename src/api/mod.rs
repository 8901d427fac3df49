//! The HTTP/JSON API: the picture, the stream of it, the state of everything; `docs/API.md` describes it.
//!
//! ```text
//! Hub ──► Keeper (one task) ──► Log: the last events, encoded once ──► readers, each at its own place
//!                                └─ the latest slot ──► routes
//! ```
//!
//! Imports go downwards only: `server` and `keeper`, `guard`, the table in [`routes`] of which both the router and the
//! OpenAPI document are made, the handlers, [`ApiState`], and what that holds.

mod alerts;
mod antimeridian;
mod ask;
mod asyncapi;
mod auth;
mod basemap;
mod client;
mod cluster;
mod conflicts;
mod correlations;
mod door;
mod endings;
mod error;
mod events;
mod filter;
mod geometry;
mod ground;
mod guard;
mod gzip;
mod history;
mod hosts;
mod integrity;
mod keeper;
mod learnt;
mod log;
mod metrics;
mod openapi;
mod page;
mod payload;
mod piece;
mod problem;
mod query;
mod rate;
mod raw;
mod reader;
mod readsb;
mod remote_id;
mod render;
mod replay;
mod route;
pub mod routes;
mod seats;
mod server;
mod service;
mod shown;
mod sites;
mod state;
mod stream;
mod terms;
mod tls;
mod tokens;
mod tracks;
mod trails;
mod uss;
mod validity;
mod websocket;

use tracing::warn;

use crate::areas::Areas;
use crate::live::Hub;
use keeper::Keeper;

pub use error::StartError;
pub use guard::router;
pub use problem::Problem;
pub use server::{listen, serve};
pub use state::{ApiState, Options};
pub use terms::Terms;

impl ApiState {
    /// Reads what the configuration names, and begins to follow the hub; within a tokio runtime.
    ///
    /// # Errors
    /// The file of an area, of the tokens, of the certificate or of its key cannot be used.
    pub fn start(hub: Hub, options: Options) -> Result<Self, StartError> {
        let terms = Terms::load(&hub.config, &Areas::load(&hub.config.areas)?)?;
        terms.warnings((options.clock)()).iter().for_each(|warning| warn!("{warning}"));
        let connections = server::affordable(options.connections);
        let state = Self::new(hub, options, terms, connections);
        tokio::spawn(Keeper::new(state.clone()).run());
        Ok(state)
    }
}
