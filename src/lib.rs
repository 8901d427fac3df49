//! One air picture of drone traffic: radar plots (ASTERIX CAT048) and transponder reports (CAT129) in, fused CAT129 out.

pub mod api;
pub mod app;
pub mod areas;
mod basemap;
pub mod capture;
#[cfg(any(test, feature = "cluster"))]
pub mod cluster;
pub mod commands;
pub mod config;
pub mod conflicts;
pub mod current;
pub mod decode;
pub mod evaluate;
pub mod formats;
pub mod gateways;
mod hex;
pub mod history;
pub mod integrity;
pub mod json;
pub mod live;
mod names;
pub mod net;
pub mod normalise;
pub mod notices;
pub mod picture;
pub mod pipeline;
pub mod record;
pub mod simulate;
pub mod sinks;
pub mod state;
mod statistics;
pub mod survey;
pub mod territory;
mod xml;
