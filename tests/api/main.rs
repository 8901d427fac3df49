//! Tests of the HTTP API over a simulated flight: in process, and over loopback sockets where needed.

#![expect(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests read scenarios, and may fail")]

mod alerts;
mod auth;
mod closed_sets;
mod common;
mod conflicts;
mod connections;
mod correlations;
mod cueing;
mod documents;
mod gzip;
mod history;
mod integrity;
mod limits;
mod now;
mod ogc;
mod operational;
mod rate;
mod registration;
mod relocations;
mod remote_id;
mod render;
mod replay;
mod routes;
mod schema;
mod stream;
mod tls;
mod tracks;
mod websocket;
mod zones;
