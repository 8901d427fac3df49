//! `evaluate` from the user's point of view: metrics computed by hand, all formats, messages, exit codes. Also GOSPA
//! compared with another implementation.

#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

mod by_hand;
mod common;
mod encounter;
mod files;
mod formats;
mod gospa;
mod identity;
mod integrity;
#[path = "../shared/program.rs"]
#[allow(dead_code, reason = "shared by several tests")]
mod program;
mod require;
#[path = "../shared/mod.rs"]
#[allow(dead_code, reason = "shared by several tests")]
mod shared;
mod silence;
mod table_1;
mod trials;
