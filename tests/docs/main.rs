//! Checks of `docs/`: every page is in the site, links are valid, the tutorial runs as printed, and the named tests exist.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![expect(clippy::disallowed_methods, reason = "it looks at the project's files")]

mod commands;
mod log;
mod pages;
#[path = "../shared/program.rs"]
#[allow(dead_code, reason = "shared by several tests")]
mod program;
mod recipes;
mod site;
mod trace;
mod tutorial;
