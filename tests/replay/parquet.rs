//! Parquet: the values of NDJSON in columns, and no truncated file that appears complete.

use std::collections::BTreeMap;
use std::fs;

use jiff::Timestamp;
use parquet::file::reader::SerializedFileReader;
use serde_json::{Value, json};

use super::common::{Scratch, bundled, demo, ran, three_radars};
use super::parquet_file::rows;

/// Columns and the corresponding members of a line.
const MEMBERS: [(&str, &str); 31] = [
    ("id", "/id"),
    ("source", "/source"),
    ("track_number", "/track_number"),
    ("state", "/state"),
    ("latitude_deg", "/lat"),
    ("longitude_deg", "/lng"),
    ("height_ellipsoid_m", "/alt"),
    ("altitude_msl_m", "/alt_msl"),
    ("speed_m_s", "/speed"),
    ("track_deg", "/track"),
    ("vertical_speed_m_s", "/vertical_speed"),
    ("accuracy_h_m", "/accuracy_h_m"),
    ("accuracy_v_m", "/accuracy_v_m"),
    ("interpolated", "/interpolated"),
    ("extrapolated", "/extrapolated"),
    ("uav_probability", "/uav_probability"),
    ("aircraft_type", "/aircraft_type"),
    ("serial_number", "/uas_id/serial_number"),
    ("registration_id", "/uas_id/registration_id"),
    ("utm_id", "/uas_id/utm_id"),
    ("specific_session_id", "/uas_id/specific_session_id"),
    ("icao24", "/aircraft/icao24"),
    ("callsign", "/aircraft/callsign"),
    ("emitter_category", "/aircraft/emitter_category"),
    ("manufacturer", "/uas_id/manufacturer"),
    ("model", "/uas_id/model"),
    ("registration_country", "/uas_id/registration_country"),
    ("integrity", "/integrity"),
    ("integrity_index", "/integrity_index"),
    ("protection_level_m", "/protection_level_m"),
    ("offset_m", "/offset_m"),
];

/// Columns of times.
const INSTANTS: [&str; 5] = ["time", "first_seen", "last_measurement", "radar_time", "transponder_time"];

/// Expected row for a line.
fn expected(line: &Value) -> BTreeMap<String, Value> {
    let instant = |text: &Value| {
        let time: Timestamp = text.as_str().unwrap().parse().unwrap();
        json!(time.as_millisecond())
    };
    let mut row = BTreeMap::new();
    let mut add = |column: &str, value: Option<Value>| {
        if let Some(value) = value {
            row.insert(column.to_owned(), value);
        }
    };
    for (column, member) in MEMBERS {
        add(column, line.pointer(member).cloned());
    }
    for (column, member) in [("major_m", "major_m"), ("minor_m", "minor_m"), ("azimuth_deg", "azimuth_deg")] {
        add(&format!("ellipse_{column}"), line.pointer(&format!("/accuracy_ellipse/{member}")).cloned());
    }
    for member in ["time", "first_seen", "last_measurement"] {
        add(member, line.get(member).map(instant));
    }
    let joined = |list: Option<&Value>, text: fn(&Value) -> &Value| {
        let names: Vec<_> = list?.as_array()?.iter().map(|item| text(item).as_str().unwrap()).collect();
        Some(json!(names.join("+")))
    };
    add("reasons", joined(line.get("reasons"), |reason| reason));
    add("linked", joined(line.get("linked"), |link| &link["id"]));
    add("uncooperative", Some(json!(line.get("uncooperative").is_some())));
    for part in line["contributors"].as_array().unwrap() {
        let kind = part["kind"].as_str().unwrap();
        add(kind, part.get("sensor").cloned());
        let number = if kind == "radar" { "radar_track" } else { "transponder_number" };
        add(number, part.get("track_number").cloned());
        add(&format!("{kind}_time"), part.get("time").map(instant));
        if kind == "radar" {
            add("radar_height_measured", part.get("height_measured").cloned());
            for member in ["distance_m", "threshold_m", "ratio", "log_likelihood_ratio"] {
                add(member, part.get(member).cloned());
            }
            if part.get("distance_m").is_some() {
                add("manual", Some(json!(part.get("manual").is_some())));
            }
        }
    }
    row
}

#[test]
fn a_row_has_the_numbers_of_its_line() {
    let mut flights = bundled();
    flights.push(three_radars());
    let mut seen = BTreeMap::<String, usize>::new();
    for flight in &flights {
        let inputs = [flight.capture()];
        let inputs = inputs.each_ref().map(std::path::PathBuf::as_path);
        for profile in ["reference", "operational"] {
            let scratch = Scratch::new();
            let [table, lines] = ["parquet", "ndjson"].map(|extension| {
                let file = scratch.path(format!("out.{extension}"));
                let ran = ran(flight.replay(&inputs).args(["--profile", profile]).arg("-o").arg(&file));
                assert_eq!(ran.code, 0, "{}", ran.stderr);
                fs::read(file).unwrap()
            });
            let lines: Vec<Value> = String::from_utf8(lines)
                .unwrap()
                .lines()
                .map(|line| serde_json::from_str(line).unwrap())
                .collect();
            let mut rows = rows(table);
            for row in &mut rows {
                for (_, cell) in row.iter_mut().filter(|(column, _)| INSTANTS.contains(&column.as_str())) {
                    // Lines have milliseconds.
                    *cell = json!(cell.as_i64().unwrap().div_euclid(1000));
                }
            }
            assert_eq!(rows.len(), lines.len());
            for (row, line) in rows.iter().zip(&lines) {
                assert_eq!(row, &expected(line), "{}", flight.name);
                for column in row.keys() {
                    *seen.entry(column.clone()).or_default() += 1;
                }
            }
        }
    }
    for column in ["threshold_m", "log_likelihood_ratio", "integrity", "serial_number", "radar_time"] {
        assert!(seen.get(column).is_some_and(|&rows| rows > 100), "{column} is hardly ever there: {seen:?}");
    }
}

#[test]
fn a_file_that_is_cut_is_not_read() {
    let flight = demo();
    let whole = flight.output(&[&flight.capture()], "parquet");
    let reads = |octets: &[u8]| SerializedFileReader::new(bytes::Bytes::copy_from_slice(octets)).is_ok();
    assert!(reads(&whole));
    for cut in 0..whole.len() {
        assert!(!reads(&whole[..cut]), "{cut} octets of {}", whole.len());
    }
}

#[test]
fn full_disk_is_reported() {
    let flight = demo();
    for format in ["parquet", "mcap"] {
        let ran =
            ran(flight.replay(&[&flight.capture()]).args(["-o", "/dev/full", "--output-format", format]));
        assert_eq!(ran.code, 1);
        assert!(
            ran.stderr.contains("/dev/full: cannot be written: No space left on device"),
            "{}",
            ran.stderr
        );
    }
}
