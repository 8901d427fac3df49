//! The HTTP/JSON API: picture, stream and state; described in `docs/API.md`.
//!
//! ```text
//! Hub ──► EventPublisher (one task) ──► EventLog: the last events, encoded once ──► readers, each at its own position
//!                                                └─ the latest slot ──► routes
//! ```
//!
//! Imports go downwards only: `server` and `publisher`, `guard`, the table in [`routes`] from which both the router and the
//! OpenAPI document are made, the handlers, [`ApiState`], and its parts.

mod access;
mod alerts;
mod antimeridian;
mod asyncapi;
mod auth;
mod basemap;
mod client;
mod cluster;
mod conflicts;
mod connection_limit;
mod correlations;
mod cueing;
mod endings;
mod error;
mod event_log;
mod event_text;
mod events;
mod filter;
mod geometry;
mod ground;
mod guard;
mod gzip;
mod gzip_blocks;
mod history;
mod hosts;
mod integrity;
mod learnt;
mod metrics;
mod ogc;
mod openapi;
mod page;
mod payload;
pub mod pmtiles;
mod problem;
mod publisher;
mod query;
mod rate;
mod raw;
mod reader;
mod readsb;
mod relocations;
mod remote_id;
mod render;
mod replay;
mod request;
mod route;
pub mod routes;
mod sensors;
mod server;
mod service;
mod slot_json;
mod state;
mod stream;
mod stream_limit;
mod tls;
mod tokens;
mod track_slice;
mod tracks;
mod trails;
mod uss;
mod validity;
mod websocket;
mod websocket_frames;
mod zones;

use tracing::warn;

use ::service::live::Hub;
use publisher::EventPublisher;
use site::areas::Areas;

pub use access::AccessSettings;
pub use error::StartError;
pub use guard::router;
pub use problem::Problem;
pub use server::{listen, serve};
pub use state::{ApiState, Options};

impl ApiState {
    /// Reads the files that the configuration names, and starts to follow the hub. Needs a tokio runtime.
    ///
    /// # Errors
    /// A file of an area, of the tokens, of the certificate or of its key cannot be used.
    pub fn start(hub: Hub, options: Options) -> Result<Self, StartError> {
        let access = AccessSettings::load(&hub.config, &Areas::load(&hub.config.areas)?)?;
        access.warnings((options.clock)()).iter().for_each(|warning| warn!("{warning}"));
        let connections = server::affordable(options.connections);
        let state = Self::new(hub, options, access, connections);
        tokio::spawn(EventPublisher::new(state.clone()).run());
        Ok(state)
    }
}
