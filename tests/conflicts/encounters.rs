//! Encounters of DAIDALUS and of a public F3442 suite, flown through `replay --conflicts` with true states: one CAT129 report
//! a second of each aircraft.
//!
//! `cargo test --workspace --features full --test conflicts encounters -- --nocapture` prints the tables of docs/CONFLICTS.md.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::net::Ipv4Addr;

use asterix::cat129::{Altitude, HorizontalVelocity, Position, Record, VerticalVelocity};
use asterix::{DataSource, TimeOfDay, encode_block};
use fusion::time::{SECOND, Time};
use serde_json::Value;
use utm_fusion::formats::{PcapWriter, UdpFlow};

use crate::program::{Scratch, utm_fusion};
use crate::table::{Row, folder, number, numbers, rows};

/// Time of the first states, whole seconds since 1970: a full hour.
const START_S: f64 = 1_773_478_800.0;
/// Time from a state to the reception of its report, seconds.
const DELAY_S: f64 = 0.05;
/// Tolerance of times: states come once a second.
const STEP_S: f64 = 1.0;
/// Time from the first state of a pair until two evaluations can have raised a level, seconds.
const BEGUN_S: f64 = 5.0;

/// An encounter with an intruder at 309 m/s, faster than the 100 m/s up to which CAT129 reports are admitted.
const TOO_FAST: &str = "H1";

/// A second of a pair: time since the start, level (0 none, 1 advisory, 2 warning, 3 violation), time to the closest approach.
struct Second {
    time_s: f64,
    level: usize,
    has_cpa: bool,
}

type Pair = (String, String);

fn at(seconds: f64) -> Time {
    Time::from_nanos(((START_S + seconds) * SECOND as f64).round() as i64)
}

fn serial(index: usize) -> String {
    format!("ENCOUNTER{index:03}")
}

fn report(row: &Row, index: usize) -> Vec<u8> {
    let [t_s, latitude, longitude, altitude_m] = numbers(row, ["t_s", "lat_deg", "lon_deg", "alt_m"]);
    let [east, north, up] = numbers(row, ["ve_ms", "vn_ms", "vu_ms"]);
    let record = Record {
        registration_country: Some(*b"XX"),
        serial_number: Some(serial(index).as_bytes().try_into().unwrap()),
        time_of_day: TimeOfDay::from_seconds(at(t_s).since_midnight() as f64 / SECOND as f64),
        position: Position::new(latitude, longitude),
        altitude_amsl: Altitude::from_metres(altitude_m),
        horizontal_velocity: HorizontalVelocity::new(east, north),
        vertical_velocity: VerticalVelocity::new(up),
        data_source: Some(DataSource { sac: 0, sic: 0 }),
        ..Record::default()
    };
    let mut octets = Vec::new();
    encode_block(&[record], &mut octets).unwrap();
    octets
}

fn site(first: &Row, volume: &str, warning_s: f64, advisory_s: f64) -> String {
    let [latitude, longitude] = numbers(first, ["lat_deg", "lon_deg"]);
    format!(
        r#"
[site]
name = "encounters"
sac = 25
sic = 1
latitude_deg = {latitude}
longitude_deg = {longitude}
height_amsl_m = 0.0
geoid_undulation_m = 0.0

[[sensors]]
id = "states"
kind = "transponder"
sac = 0
sic = 0
period_s = 1.0
accuracy = {{ horizontal_m = 0.5, vertical_m = 0.5 }}
delay_s = 0.0

[fusion]
profile = "operational"

[conflicts]
enabled = true
advisory = {{ probability = 0.1, time_s = {advisory_s:.1} }}
warning = {{ probability = 0.2, time_s = {warning_s:.1} }}
volumes = [{{ preset = "{volume}" }}]
"#
    )
}

/// Flies the states, in order of time, and returns the seconds of each pair.
fn flown(states: &[&Row], volume: &str, warning_s: f64, advisory_s: f64) -> BTreeMap<Pair, Vec<Second>> {
    let mut names: Vec<&str> = states.iter().map(|row| row["id"].as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let scratch = Scratch::new();
    let flow = UdpFlow { from: Ipv4Addr::LOCALHOST, to: Ipv4Addr::new(239, 192, 129, 1), port: 8129, ttl: 1 };
    let mut capture = Vec::new();
    let mut writer = PcapWriter::new(&mut capture).unwrap();
    for row in states {
        let index = names.binary_search(&row["id"].as_str()).unwrap();
        let time = at(number(row, "t_s").unwrap() + DELAY_S + index as f64 * 1e-3);
        writer.write(flow, time, &report(row, index)).unwrap();
    }
    drop(writer);
    let site = scratch.file("site.toml", site(states[0], volume, warning_s, advisory_s));
    let capture = scratch.file("capture.pcap", capture);
    let [output, conflicts] = ["out.ndjson", "conflicts.ndjson"].map(|name| scratch.path(name));
    let mut replay = utm_fusion("replay");
    replay.arg(capture).arg("--config").arg(site).arg("-o").arg(&output).arg("--conflicts").arg(&conflicts);
    let ran = replay.output().unwrap();
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let lines = |path| -> Vec<Value> {
        let text = String::from_utf8(fs::read(path).unwrap()).unwrap();
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    };
    let mut serials = BTreeMap::<String, String>::new();
    for track in lines(&output) {
        let Some(number) = track["uas_id"]["serial_number"].as_str() else { continue };
        serials.insert(track["id"].as_str().unwrap().to_owned(), number.to_owned());
    }
    let name = |id: &Value| -> Option<String> {
        let number = serials.get(id.as_str()?)?;
        let index: usize = number.strip_prefix("ENCOUNTER")?.parse().ok()?;
        Some(names[index].to_owned())
    };
    let mut seconds = BTreeMap::<Pair, Vec<Second>>::new();
    for line in lines(&conflicts) {
        let (Some(a), Some(b)) = (name(&line["a"]), name(&line["b"])) else { continue };
        let time: jiff::Timestamp = line["time"].as_str().unwrap().parse().unwrap();
        let levels = ["none", "advisory", "warning", "violation"];
        let second = Second {
            time_s: time.as_nanosecond() as f64 / 1e9 - START_S,
            level: levels.iter().position(|level| line["level"] == *level).unwrap(),
            has_cpa: (0.0..=300.0).contains(&line["t_cpa_s"].as_f64().unwrap()),
        };
        seconds.entry((a.clone().min(b.clone()), a.max(b))).or_default().push(second);
    }
    seconds
}

/// Time at which a pair first had at least this level.
fn first(seconds: &[Second], level: usize) -> Option<f64> {
    seconds.iter().find(|second| second.level >= level).map(|second| second.time_s)
}

fn text(time_s: Option<f64>) -> String {
    time_s.map_or_else(|| "-".to_owned(), |time_s| format!("{time_s:.0}"))
}

/// Levels 2 and 3 of DAIDALUS are corrective and warning: 55 and 25 s before the volume.
#[test]
fn do365_encounters_are_warned_of_in_time() {
    let Some(folder) = folder() else { return };
    let folder = folder.join("encounters");
    println!("| encounter | advisory: due, given | warning: due, given | volume: entered, violation |");
    println!("|---|---|---|---|");
    let mut late = Vec::new();
    for name in ["H1", "H0_0_120", "C0_0_120", "C1_0_120", "C1_0_120_W"] {
        let states = rows(&folder.join(format!("{name}_states.csv")));
        let kind = if name == "H1" { "gold" } else { "computed" };
        let alerts = rows(&folder.join(format!("{name}_alerting_{kind}.csv")));
        let volumes = rows(&folder.join(format!("{name}_volumes.csv")));
        let due = |level: f64| {
            let row = alerts.iter().find(|row| number(row, "alert_level").unwrap() >= level)?;
            number(row, "t_s")
        };
        let entered =
            volumes.iter().find(|row| row["do365_enroute_now"] == "1").and_then(|row| number(row, "t_s"));
        let pairs = flown(&states.iter().collect::<Vec<_>>(), "do365-enroute", 25.0, 55.0);
        let seconds: Vec<Second> = pairs.into_values().flatten().collect();
        let given = [1, 2, 3].map(|level| first(&seconds, level));
        let wanted = [due(2.0), due(3.0), entered];
        println!(
            "| {name} | {}, {} | {}, {} | {}, {} |",
            text(wanted[0]),
            text(given[0]),
            text(wanted[1]),
            text(given[1]),
            text(wanted[2]),
            text(given[2])
        );
        for (given, due) in given.into_iter().zip(wanted).take(2) {
            let is_in_time = given.zip(due).is_some_and(|(given, due)| (given - due).abs() <= STEP_S);
            if !is_in_time && name != TOO_FAST {
                late.push(format!("{name}: {given:?} for {due:?}"));
            }
        }
    }
    assert!(late.is_empty(), "{late:?}");
}

/// Pairs whose volume is entered are warned of before; pairs for which DAIDALUS foresees no entry at any second get no level.
#[test]
fn f3442_scenarios_are_warned_of_in_time() {
    let Some(folder) = folder() else { return };
    let folder = folder.join("f3442");
    let all = rows(&folder.join("trajectories.csv.gz"));
    let volumes = rows(&folder.join("volumes.csv.gz"));
    let expected = rows(&folder.join("expected.csv"));
    let scenarios: BTreeSet<&str> = all.iter().map(|row| row["scenario"].as_str()).collect();
    println!("| scenario | pairs entered, warned before | median seconds before | levels | passed |");
    println!("|---|---|---|---|---|");
    let mut failed = Vec::new();
    for scenario in scenarios {
        let mut states: Vec<&Row> = all.iter().filter(|row| row["scenario"] == scenario).collect();
        states.sort_by(|a, b| number(a, "t_s").unwrap().total_cmp(&number(b, "t_s").unwrap()));
        let pairs = flown(&states, "f3442", 25.0, 55.0);
        let criteria = expected.iter().find(|row| scenario.starts_with(&row["scenario"])).unwrap();
        let mut oracle = BTreeMap::<Pair, Vec<&Row>>::new();
        for row in volumes.iter().filter(|row| row["scenario"] == scenario) {
            let (own, other) = (row["own"].clone(), row["traffic"].clone());
            oracle.entry((own.clone().min(other.clone()), own.max(other))).or_default().push(row);
        }
        let (mut entered, mut before_s, mut wrong) = (0, Vec::new(), Vec::new());
        for (pair, rows) in &oracle {
            let seconds = pairs.get(pair).map_or(&[][..], Vec::as_slice);
            let entry = rows.iter().find(|row| row["f3442_now"] == "1").and_then(|row| number(row, "t_s"));
            let begun_s = number(rows[0], "t_s").unwrap();
            if let Some(entry) = entry.filter(|entry| *entry > begun_s + BEGUN_S) {
                entered += 1;
                match first(seconds, 2).filter(|given| *given < entry) {
                    Some(given) => before_s.push(entry - given),
                    None => wrong.push(format!("{pair:?} entered at {entry} s without a warning")),
                }
            }
            let is_never = entry.is_none() && rows.iter().all(|row| row["f3442_in_s"].is_empty());
            if is_never && first(seconds, 2).is_some() {
                wrong.push(format!("{pair:?} has a warning and never a conflict"));
            }
        }
        let levels: BTreeSet<usize> =
            pairs.values().flatten().map(|second| second.level).filter(|level| *level > 0).collect();
        // A recording that begins less than 25 s before the entry begins with a warning. A missing level is no failure in the
        // suite either.
        let begins_late = scenario.contains('@');
        let wanted = criteria["expected_alert_levels"].split(' ');
        let is_seen =
            begins_late || wanted.map(|level| level.parse().unwrap()).all(|level| levels.contains(&level));
        let gap_s: f64 = criteria["max_1hz_gap_s"].parse().unwrap();
        // Within one alert: a second without a level ends it.
        let is_steady = pairs
            .values()
            .flat_map(|seconds| seconds.windows(2))
            .all(|two| two.iter().any(|second| second.level == 0) || two[1].time_s - two[0].time_s <= gap_s);
        let has_cpa = pairs.values().flatten().filter(|second| second.level > 0).all(|second| second.has_cpa);
        let shared = &criteria["shared_intruder"];
        let most = (0..200).map(|second| {
            let holds = |(pair, seconds): &(&Pair, &Vec<Second>)| {
                (pair.0 == *shared || pair.1 == *shared)
                    && seconds.iter().any(|one| one.level > 0 && one.time_s.round() as i32 == second)
            };
            pairs.iter().filter(holds).count()
        });
        let is_shared = shared.is_empty() || most.max() >= criteria["shared_alerts"].parse().ok();
        for (is_met, what) in [
            (is_seen, "levels"),
            (is_steady, "cadence"),
            (has_cpa, "closest approach"),
            (is_shared, "shared intruder"),
        ] {
            if !is_met {
                wrong.push(what.to_owned());
            }
        }
        before_s.sort_by(f64::total_cmp);
        let median = before_s.get(before_s.len() / 2).copied();
        let levels: Vec<String> = levels.iter().map(ToString::to_string).collect();
        let passed = if wrong.is_empty() { "yes" } else { "no" };
        println!(
            "| {scenario} | {entered}, {} | {} | {} | {passed} |",
            before_s.len(),
            text(median),
            levels.join(" ")
        );
        if !wrong.is_empty() {
            failed.push(format!("{scenario}: {wrong:?}"));
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
