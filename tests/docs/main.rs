//! `docs/` keeps its word: every page is in the site, every link leads somewhere, the tutorial runs as it is printed, and
//! the tests that are named exist.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![expect(clippy::disallowed_methods, reason = "it looks at the project's files")]

mod commands;
mod pages;
#[path = "../shared/program.rs"]
#[allow(dead_code, reason = "shared by several tests")]
mod program;
mod recipes;
mod site;
mod trace;
mod tutorial;
