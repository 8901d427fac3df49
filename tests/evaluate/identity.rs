//! Flights with arbitrary track numbers: the identity of a point's transponder determines its aircraft.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use utm_fusion::evaluate::OutputPoint;
use utm_fusion::evaluate::read::{self, DayReference};

use fusion::time::Time;

use super::common::{Ran, Scratch, evaluate, number, ran, utm_fusion};

/// Drones with CAT129, with Remote ID under a different serial number, with both, and with neither; some report no
/// height. A helicopter with ADS-B, fake identities, some of them before the drones report, and a camera with unrelated
/// track numbers.
const SCENARIO: &str = r#"name = "identities"
duration_s = 100
[airspace]
radius_m = 400
[drones]
multirotors = 7
equipped = 3
[birds]
count = 3
[[radars]]
sees_crewed = true
[crewed]
helicopters = 1
[remote_id]
drones = 4
same_serial = false
altitude_unknown = 0.5
fakes = 6
fakes_after_s = [0.0, 20.0]
[[cameras]]
"#;

const HEAD: &str = "time,sensor,number,id,seduced";

fn text(file: &Path) -> String {
    String::from_utf8(fs::read(file).unwrap()).unwrap()
}

/// Simulates the flight and returns its directory.
fn flown(scratch: &Scratch) -> PathBuf {
    let flight = scratch.path("flight");
    let scenario = scratch.file("identities.toml", SCENARIO);
    let told = ran(utm_fusion("simulate").arg(scenario).arg("--out").arg(&flight));
    assert_eq!(told.code, 0, "{}", told.stderr);
    flight
}

fn replayed(flight: &Path, extension: &str) -> PathBuf {
    let out = flight.join(format!("out.{extension}"));
    let mut replay = utm_fusion("replay");
    replay.arg(flight.join("capture.pcap")).arg("--config").arg(flight.join("site.toml")).arg("-o").arg(&out);
    let told = ran(&mut replay);
    assert_eq!(told.code, 0, "{}", told.stderr);
    out
}

fn scored(flight: &Path, output: &Path) -> Ran {
    let mut command = evaluate(&flight.join("truth.csv"), output);
    command.arg("--labels").arg(flight.join("labels.csv")).arg("--capture").arg(flight.join("capture.pcap"));
    ran(command.arg("--config").arg(flight.join("site.toml")).arg("--json"))
}

/// Aircraft that transmit, from `classes.csv`.
fn transmitters(flight: &Path) -> BTreeSet<String> {
    let classes = text(&flight.join("classes.csv"));
    let rows = classes.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let rows = rows.filter(|cells| cells[1] != "fake" && cells[2..5].iter().any(|name| !name.is_empty()));
    rows.map(|cells| cells[0].to_owned()).collect()
}

fn equipped(scores: &Value) -> BTreeSet<String> {
    let drones = scores["drones"].as_array().unwrap().iter();
    let ids = drones.filter(|drone| drone["equipped"] == true).map(|drone| drone["id"].as_str().unwrap());
    ids.map(str::to_owned).collect()
}

#[test]
fn each_aircraft_is_scored_by_its_own_transponder() {
    let scratch = Scratch::new();
    let flight = flown(&scratch);
    let transmitters = transmitters(&flight);
    assert!((5..8).contains(&transmitters.len()) && transmitters.contains("H1"), "{transmitters:?}");
    for extension in ["ndjson", "geojson"] {
        let told = scored(&flight, &replayed(&flight, extension));
        assert!(!told.stderr.contains("do not state the identity"), "{}", told.stderr);
        let scores = told.json();
        assert_eq!(equipped(&scores), transmitters, "{extension}");
        for drone in scores["drones"].as_array().unwrap() {
            let mean_m = |stream: &str| number(drone, &format!("{stream}.eposh.mean_m"));
            let pu = drone["transponder"]["pu_percent"].as_f64();
            if transmitters.contains(drone["id"].as_str().unwrap()) {
                assert!(pu.unwrap() > 50.0, "{drone}");
                assert!(mean_m("transponder") < 15.0 && mean_m("fused") < 15.0, "{drone}");
            } else {
                assert_eq!(pu, Some(0.0), "{drone}");
            }
        }
        let heights = scores["drones"].as_array().unwrap().iter().map(|drone| &drone["transponder"]);
        let heights =
            heights.filter(|score| score.get("epos").is_some()).map(|score| score.get("eposv").is_some());
        assert_eq!(
            heights.collect::<BTreeSet<_>>(),
            [false, true].into(),
            "{extension}: who says no height has none"
        );
        // Points of fakes are false tracks: each of six identities is present for most of the minute.
        assert!(number(&scores, "transponder.all.false_track_s") > 200.0, "{extension}");
        assert!(number(&scores, "fused.all.false_track_s") > 100.0, "{extension}");
    }
    // Without a configuration, sensors that state identities are the receivers.
    let mut command = evaluate(&flight.join("truth.csv"), &flight.join("out.ndjson"));
    let told = ran(command.arg("--labels").arg(flight.join("labels.csv")).arg("--json"));
    assert_eq!(equipped(&told.json()), transmitters);
}

#[test]
fn format_without_identities_is_reported() {
    let scratch = Scratch::new();
    let flight = flown(&scratch);
    // The records of drones have their serial numbers; those of a helicopter have none.
    let told = scored(&flight, &replayed(&flight, "ast"));
    let scores = told.json();
    assert_eq!(equipped(&scores), transmitters(&flight));
    assert!(number(&scores, "fused.all.false_track_s") > 100.0);
    let told = scored(&flight, &replayed(&flight, "csv"));
    assert!(told.stderr.contains("points do not state the identity of their transponder"), "{}", told.stderr);
    assert_eq!(equipped(&told.json()), transmitters(&flight));
}

#[test]
fn identity_column_exists_with_further_receivers() {
    let scratch = Scratch::new();
    let flight = flown(&scratch);
    let labels = text(&flight.join("labels.csv"));
    assert_eq!(labels.lines().next(), Some("time,sensor,number,id,seduced,identity"));
    let mut names = BTreeSet::new();
    for line in labels.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let [_, sensor, .., id, _, identity] = cells[..] else { panic!("{line}") };
        match sensor {
            "drone-it" => assert_eq!(format!("D{}", identity.parse::<u32>().unwrap()), id, "{line}"),
            "adsb" => assert!(identity.len() == 6 && id == "H1", "{line}"),
            "remote-id" => assert!(identity.starts_with("SMTR7"), "{line}"),
            _ => assert_eq!(identity, "", "{line}"),
        }
        names.insert((sensor, identity));
    }
    assert_eq!(names.iter().filter(|(sensor, _)| *sensor == "remote-id").count(), 4 + 6, "{names:?}");

    let before = scratch.path("before");
    let cat129 = scratch
        .file("cat129.toml", "name = \"a\"\nduration_s = 30\n[drones]\nmultirotors = 2\nequipped = 1\n");
    assert_eq!(ran(utm_fusion("simulate").arg(cat129).arg("--out").arg(&before)).code, 0);
    let labels = text(&before.join("labels.csv"));
    assert!(labels.lines().next() == Some(HEAD) && labels.lines().all(|line| line.split(',').count() == 5));
}

#[test]
fn identity_column_may_be_filled_blank_or_absent() {
    let read = |text: String| {
        let rows = read::labels("labels.csv", text.as_bytes()).unwrap();
        rows.into_iter().map(|row| row.identity).collect::<Vec<_>>()
    };
    let rows =
        |head: &str, ends: [&str; 2]| format!("{HEAD}{head}\n1,a,3,D3,0{}\n2,b,4,,1{}\n", ends[0], ends[1]);
    let there = read(rows(",identity", [",000000000003", ", SMTR70000004 "]));
    assert_eq!(there, [Some("000000000003".to_owned()), Some("SMTR70000004".to_owned())]);
    assert_eq!(read(rows(",identity", [",", ",418007"])), [None, Some("418007".to_owned())]);
    assert_eq!(read(rows("", ["", ""])), [None, None]);
    // Columns are found by name, not by position.
    assert_eq!(read("identity,time,sensor,number,id\nX,1,a,3,D3\n".to_owned()), [Some("X".to_owned())]);
    let short = read::labels("labels.csv", rows(",identity", ["", ",A"]).as_bytes()).unwrap_err();
    assert!(short.to_string().contains("labels.csv:2: 5 cells, and 6 columns are named"), "{short}");
}

#[test]
fn tracks_state_the_identity_of_their_transponder() {
    let read = |name: &str, text: &str| -> Vec<OutputPoint> {
        read::output(name, text.as_bytes().to_vec(), DayReference::Near(Time::default())).unwrap().points
    };
    let line = |more: &str, kind: &str| {
        format!(
            r#"{{"time":"2026-03-14T09:00:00.125Z","source":"{kind}","track_number":1,"lat":0,"lng":0{more},"contributors":[{{"kind":"{kind}","track_number":9}}]}}"#
        )
    };
    for (more, identity) in [
        (r#","uas_id":{"serial_number":"SMTR70000002","model":"UAS"}"#, Some("SMTR70000002")),
        (r#","uas_id":{"registration_id":"FIN87astrdge12k8"}"#, Some("FIN87astrdge12k8")),
        (r#","uas_id":{"utm_id":"00112233"}"#, Some("00112233")),
        (r#","uas_id":{"specific_session_id":"01ff"}"#, Some("01ff")),
        (r#","aircraft":{"icao24":"418007","callsign":"GABCD"}"#, Some("418007")),
        (r#","uas_id":{}"#, None),
        ("", None),
    ] {
        let points = read("out.ndjson", &line(more, "transponder"));
        assert_eq!((points[0].transponder, points[0].identity.as_deref()), (Some(9), identity), "{more}");
    }
    let radar = read("out.ndjson", &line(r#","uas_id":{"serial_number":"A"}"#, "radar"));
    assert_eq!(
        (radar[0].transponder, radar[0].identity.as_deref()),
        (None, None),
        "no transponder, no identity"
    );
    let csv = "time,source,track_number,transponder,identity,lat,lon\n";
    let rows = read("out.csv", &format!("{csv}1,transponder,9,9,SMTR70000002,0,0\n1,transponder,8,8,,0,0\n"));
    assert_eq!(rows[0].identity.as_deref(), Some("SMTR70000002"));
    assert_eq!(rows[1].identity, None);
}
