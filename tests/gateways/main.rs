//! Translation of other receivers' formats: through the program, through sockets, and with hostile input.
#![expect(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    reason = "a test that cannot go on fails; its files are its own"
)]

mod adsb;
mod corpus;
mod flights;
mod lines;
mod live;
#[path = "../shared/program.rs"]
mod program;
mod recorded;
mod remote_id;
#[path = "../shared/mod.rs"]
#[allow(dead_code, reason = "of all captures, some are looked for by name")]
mod shared;

use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// Standard output and standard error of the program.
fn run(arguments: &[&str]) -> (String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_utm-fusion")).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
}

/// Lines that `decode` prints for a capture.
fn decode(path: &Path) -> Vec<Value> {
    let (lines, _) = run(&["decode", path.to_str().unwrap()]);
    lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Text of a gzip file.
fn unzip(path: &Path) -> String {
    let mut text = String::new();
    let file = std::fs::File::open(path).unwrap();
    std::io::Read::read_to_string(&mut flate2::read::GzDecoder::new(file), &mut text).unwrap();
    text
}
