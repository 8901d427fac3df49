//! `replay` and `check` from the user's point of view: whole flights, output files, messages, exit codes.

#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

mod cameras;
mod common;
mod conflicts;
mod conformance;
mod determinism;
mod formats;
mod heights;
mod hostile;
mod inputs;
mod integrity;
mod masks;
mod mcap;
mod nothing;
mod now;
mod parquet;
#[path = "../shared/parquet.rs"]
mod parquet_file;
#[path = "../shared/program.rs"]
#[allow(dead_code, reason = "shared by several tests")]
mod program;
mod radars;
mod refusals;
mod senders;
#[path = "../shared/mod.rs"]
#[allow(dead_code, reason = "shared by several tests")]
mod shared;
mod system_tracks;
mod usage;
mod zones;
