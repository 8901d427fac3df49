//! Programs that read the service: Prometheus with the bundled rules and dashboard, the clients in Node.js and Python, and
//! Wireshark. A test reports itself as skipped if its program is not installed, and stops the processes it started.

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
