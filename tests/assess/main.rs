//! `assess` from the user's point of view: its figures against a second implementation, the report, comparisons, hostile input.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests read files, and may fail")]

mod coverage;
#[path = "../shared/program.rs"]
mod program;
mod report;
mod second;

use std::path::{Path, PathBuf};
use std::process::Output;

use program::{Scratch, utm_fusion};
use serde_json::Value;

/// A recording with its site and truth.
struct Flight {
    capture: PathBuf,
    site: PathBuf,
    truth: PathBuf,
}

/// Ten drones through one point, eight of them with transponders, and birds, for two minutes.
const SCENARIO: &str = "name = \"assessed\"\nduration_s = 120\n[airspace]\nradius_m = 500\n[drones]\npattern = \"crossing\"\n\
    multirotors = 5\nfixed_wings = 5\nequipped = 8\n[birds]\ncount = 10\n";

/// The bundled demonstration flight.
fn demo() -> Flight {
    let file = |name: &str| Path::new("testdata/demo").join(name);
    Flight { capture: file("capture.pcap"), site: "config/demo.toml".into(), truth: file("truth.csv") }
}

/// Simulates the scenario.
fn simulated(scratch: &Scratch, seed: &str) -> Flight {
    simulated_as(scratch, SCENARIO, seed)
}

/// Simulates a scenario.
fn simulated_as(scratch: &Scratch, scenario: &str, seed: &str) -> Flight {
    let scenario = scratch.file("assessed.toml", scenario);
    let folder = scratch.path(seed);
    let made =
        utm_fusion("simulate").arg(scenario).args(["--seed", seed, "--out"]).arg(&folder).output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let file = |name: &str| folder.join(name);
    Flight { capture: file("capture.pcap"), site: file("site.toml"), truth: file("truth.csv") }
}

/// Runs `assess` on a flight.
fn assess(flight: &Flight, with_truth: bool, more: &[&str]) -> Output {
    let mut command = utm_fusion("assess");
    command.arg(&flight.capture).arg("--config").arg(&flight.site).args(more);
    if with_truth {
        command.arg("--truth").arg(&flight.truth);
    }
    command.output().unwrap()
}

/// The figures of a flight as JSON.
fn figures(flight: &Flight, with_truth: bool, more: &[&str]) -> Value {
    let output = assess(flight, with_truth, more);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A figure by its key.
fn figure<'a>(report: &'a Value, key: &str) -> &'a Value {
    let sections = report["sections"].as_array().unwrap().iter();
    let tables = sections.flat_map(|section| section["tables"].as_array().unwrap());
    let mut figures = tables.flat_map(|table| table["figures"].as_array().unwrap());
    figures.find(|figure| figure["key"] == key).unwrap_or_else(|| panic!("no figure {key}"))
}
