//! Programs that read the service: Prometheus, whose rules and dashboard are kept here, and the clients in Node.js and Python;
//! and Wireshark, which reads what the service sends.
//! Each test reports itself as skipped where its program is not installed, and ends what it began.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![expect(clippy::disallowed_methods, reason = "files of this project, and the real time")]

mod clients;
mod docs;
mod generate;
#[path = "../shared/program.rs"]
mod program;
mod prometheus;
mod service;
mod wireshark;
