//! Shared helpers: running the program, and places in whole metres.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

pub(crate) use crate::program::{Scratch, utm_fusion};

/// Start of the test flights: 2026-03-14T09:00:00Z, seconds UTC.
pub(crate) const START_S: f64 = 1_773_478_800.0;

/// Radii of curvature of WGS-84 at the equator, metres: of the meridian, a (1 - e²), and of the equator itself.
const MERIDIAN_M: f64 = 6_335_439.327_292_829;
const EQUATOR_M: f64 = 6_378_137.0;

/// Latitude of a place at this distance north of the equator, degrees.
pub(crate) fn north(metres: f64) -> f64 {
    (metres / MERIDIAN_M).to_degrees()
}

/// Longitude of a place on the equator at this distance east of longitude 0, degrees.
pub(crate) fn east(metres: f64) -> f64 {
    (metres / EQUATOR_M).to_degrees()
}

/// Centre of the slot with this number after the start, seconds UTC.
pub(crate) fn centre_s(slot: i64) -> f64 {
    START_S + slot as f64 * 0.25 + 0.125
}

/// Exit code and output of a program.
pub(crate) struct Ran {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Ran {
    /// The single JSON object in the standard output.
    pub(crate) fn json(&self) -> Value {
        assert_eq!(self.code, 0, "{}", self.stderr);
        serde_json::from_str(&self.stdout).unwrap()
    }
}

pub(crate) fn ran(command: &mut Command) -> Ran {
    let output = command.output().unwrap();
    Ran {
        code: output.status.code().unwrap(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// `evaluate --truth TRUTH OUTPUT`.
pub(crate) fn evaluate(truth: &Path, output: &Path) -> Command {
    let mut command = utm_fusion("evaluate");
    command.arg("--truth").arg(truth).arg(output);
    command
}

/// Number in the output of `--json`, at a path of member names.
pub(crate) fn number(json: &Value, way: &str) -> f64 {
    let at = way.split('.').fold(json, |json, name| match name.parse::<usize>() {
        Ok(index) => &json[index],
        Err(_) => &json[name],
    });
    at.as_f64().unwrap_or_else(|| panic!("{way}: {at}"))
}

/// Checks a number in the output of `--json`.
pub(crate) fn assert_near(json: &Value, way: &str, expected: f64) {
    let found = number(json, way);
    // Places are written with nine decimals: 0.1 mm.
    assert!((found - expected).abs() < 1e-3, "{way}: {found} is not {expected}");
}
