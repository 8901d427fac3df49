//! Conflicts compared with NASA DAIDALUS: closest approaches and intervals inside volumes, and whole encounters through the
//! program. The data is enabled by `UTM_FUSION_SHARED_DATA`.

#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

mod encounters;
mod pairs;
#[path = "../shared/program.rs"]
#[allow(dead_code, reason = "shared by several tests")]
mod program;
mod table;
