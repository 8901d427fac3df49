//! The HTTP API over a simulated flight: in process, and over sockets on loopback where those matter.

#![expect(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests read scenarios, and may fail")]

mod alerts;
mod auth;
mod closed_sets;
mod common;
mod conflicts;
mod correlations;
mod documents;
mod door;
mod gzip;
mod history;
mod integrity;
mod limits;
mod now;
mod operational;
mod rate;
mod registration;
mod remote_id;
mod render;
mod replay;
mod routes;
mod schema;
mod stream;
mod tls;
mod tracks;
mod websocket;
