//! The HTTP API over a simulated flight: in process, and over sockets on loopback where those matter.

#![allow(clippy::unwrap_used, reason = "a test may fail")]

mod auth;
mod common;
mod documents;
mod limits;
mod routes;
mod stream;
mod tracks;
