//! One air picture of drone traffic: radar plots (ASTERIX CAT048) and transponder reports (CAT129) in, fused CAT129 out.

pub mod api;
pub mod areas;
pub mod commands;
pub mod config;
pub mod current;
pub mod evaluate;
pub mod ingest;
pub mod json;
pub mod live;
pub mod normalise;
pub mod picture;
pub mod pipeline;
pub mod publish;
pub mod simulate;
pub mod state;
pub mod store;
pub mod survey;
