//! What the engine says of a generated flight, a slot at a time.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// The tracks of each slot.
pub fn slots(folder: &Path) -> Vec<Vec<Value>> {
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/scenarios/crossing.toml");
    let flight = folder.join("flight");
    let lines = folder.join("tracks.ndjson");
    run(&["simulate".as_ref(), scenario.as_ref(), "--out".as_ref(), flight.as_ref()]);
    let (capture, site) = (flight.join("capture.pcap"), flight.join("site.toml"));
    run(&[
        "replay".as_ref(),
        capture.as_ref(),
        "--config".as_ref(),
        site.as_ref(),
        "-o".as_ref(),
        lines.as_ref(),
    ]);

    let mut slots: Vec<Vec<Value>> = Vec::new();
    for line in std::fs::read_to_string(lines).unwrap().lines() {
        let track: Value = serde_json::from_str(line).unwrap();
        match slots.last_mut() {
            Some(slot) if slot[0]["time"] == track["time"] => slot.push(track),
            _ => slots.push(vec![track]),
        }
    }
    slots
}

fn run(arguments: &[&std::ffi::OsStr]) {
    let output = Command::new(env!("CARGO_BIN_EXE_utm-fusion")).args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}
