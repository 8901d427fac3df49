//! The test range: each parameter of the error model measured from arriving data; output files; the command.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![expect(clippy::disallowed_methods, reason = "files that the command wrote, and how long it took")]

mod animals;
mod attacks;
mod common;
mod continuity;
mod errors;
mod faults;
mod files;
mod measurement;
mod motion;
mod network;
mod others;
#[path = "../shared/program.rs"]
#[allow(dead_code, reason = "shared by several tests")]
mod program;
mod radar;
mod random;
mod scenarios;
mod seduction;
mod several;
mod statistics;
mod streams;
mod transponder;
mod udp;
mod velocity;
