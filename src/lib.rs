//! One air picture of drone traffic: radar plots (ASTERIX CAT048) and transponder reports (CAT129) in, fused CAT129 out.
//!
//! This package puts the service together: [`commands`] has the subcommands, [`app`] a running process. The other crates' modules
//! are exported under their own names.

pub mod app;
pub mod commands;

pub use api;
#[cfg(feature = "cluster")]
pub use cluster;
pub use input::{capture, gateways, json, normalise, pipeline, survey};
pub use lab::{evaluate, simulate};
pub use picture::{self, conflicts, decode, formats};
pub use service::{clock, current, history, integrity, live, net, notices, record, sinks, state};
pub use site::{areas, config, territory};
