//! `replay --at now`, and short latencies.

use std::fs;

use asterix::cat129::FusionReport;
use asterix::cat129::fusion_report::Flags;
use asterix::{blocks, cat129};
use fusion::time::{SECOND, Time};
use serde_json::Value;

use super::common::{EXTENSIONS, SLOT_NS, Scratch, bundled, datagrams, demo, ran};

/// Output of `replay` for a bundled flight, with these arguments and environment variables.
fn written(
    flight: &super::common::Flight,
    arguments: &[&str],
    variables: &[(&str, &str)],
    extension: &str,
) -> Vec<u8> {
    let scratch = Scratch::new();
    let file = scratch.path(format!("out.{extension}"));
    let mut command = flight.replay(&[&flight.capture()]);
    command.args(["--profile", "operational"]).args(arguments).envs(variables.iter().copied());
    let ran = ran(command.arg("-o").arg(&file));
    assert_eq!(ran.code, 0, "{}: {}", flight.name, ran.stderr);
    fs::read(file).unwrap()
}

const NOW: [&str; 2] = ["--at", "now"];

#[test]
fn every_format_has_the_points_of_now() {
    let flight = demo();
    let of = |extension| written(&flight, &NOW, &[], extension);
    let text = |extension| String::from_utf8(of(extension)).unwrap();
    let lines: Vec<Value> = text("ndjson").lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(lines.len() > 200, "{} points", lines.len());
    let ellipse = |line: &Value, key: &str| line["accuracy_ellipse"][key].as_f64().unwrap();
    for line in &lines {
        assert_eq!((&line["extrapolated"], &line["interpolated"]), (&Value::Bool(true), &Value::Bool(false)));
        let (major_m, minor_m) = (ellipse(line, "major_m"), ellipse(line, "minor_m"));
        let circle_m = line["accuracy_h_m"].as_f64().unwrap();
        // The radius of the equivalent circle lies between the two axes.
        assert!(minor_m - 0.02 <= circle_m && circle_m <= major_m + 0.02, "{line}");
        assert!((0.0..180.0).contains(&ellipse(line, "azimuth_deg")));
    }
    assert_eq!(text("csv").lines().count(), lines.len() + 1);
    let collection: Value = serde_json::from_str(&text("geojson")).unwrap();
    assert_eq!(collection["features"].as_array().unwrap().len(), lines.len());
    let scratch = Scratch::new();
    let sent = datagrams(&scratch.file("out.pcap", of("pcap")));
    let payloads: Vec<u8> = sent.iter().flat_map(|datagram| datagram.payload.clone()).collect();
    assert!(payloads == of("ast"));
    let mut records = 0;
    for datagram in &sent {
        // Sent when its slot opens; its content is for the slot's centre.
        let opens = datagram.received.unwrap().nanos();
        assert_eq!(opens % SLOT_NS, 0);
        let centre = Time::from_nanos(opens + SLOT_NS / 2).since_midnight() * 128 / SECOND;
        for block in blocks(&datagram.payload) {
            for located in block.unwrap().records::<cat129::Record>() {
                let record = located.unwrap().record;
                assert_eq!(i64::from(record.time_of_day.unwrap().count()), centre);
                let report = record.special_purpose.as_ref().and_then(FusionReport::read).unwrap();
                assert!(report.flags.contains(Flags::EXTRAPOLATED));
                records += 1;
            }
        }
    }
    assert_eq!(records, lines.len());
}

#[test]
fn lagged_output_is_identical_with_and_without_now() {
    let off = ("UTM_FUSION__FUSION__NOW", "false");
    for flight in bundled() {
        for latency_s in ["6.25", "3.25", "1", "0"] {
            let latency = ("UTM_FUSION__FUSION__LATENCY_S", latency_s);
            for extension in if latency_s == "6.25" { &EXTENSIONS[..] } else { &EXTENSIONS[..1] } {
                // The flights' sites use the other profile, which has no such picture.
                let profile = ("UTM_FUSION__FUSION__PROFILE", "operational");
                let with = written(&flight, &[], &[profile, latency], extension);
                let without = written(&flight, &[], &[profile, latency, off], extension);
                assert!(!with.is_empty() && with == without, "{}: {extension} at {latency_s} s", flight.name);
            }
        }
    }
}

#[test]
fn picture_of_now_is_independent_of_replay_speed() {
    let flight = demo();
    let of = |arguments: &[&str]| written(&flight, &[&NOW, arguments].concat(), &[], "ndjson");
    let all = of(&[]);
    assert!(all == of(&["--speed", "400"]));
    let some = of(&["--start", "+20s", "--end", "+40s"]);
    let times = |octets: &[u8]| {
        let text = String::from_utf8(octets.to_vec()).unwrap();
        let time =
            |line: &str| serde_json::from_str::<Value>(line).unwrap()["time"].as_str().unwrap().to_owned();
        text.lines().map(time).collect::<Vec<_>>()
    };
    let (all, some) = (times(&all), times(&some));
    let kept: Vec<_> = all.iter().filter(|time| **time >= some[0] && time <= &some.last().unwrap()).collect();
    assert_eq!(kept.len(), some.len());
    assert!(some.len() > 20 && some.len() < all.len());
}

#[test]
fn picture_of_now_without_its_inputs_is_refused() {
    let flight = demo();
    for (code, arguments, variables, words) in [
        (2, &["--at", "now"][..], &[][..], "--at now: fusion.now is off, or the profile is reference"),
        (2, &["--at", "now", "--profile", "reference"], &[], "or the profile is reference"),
        (2, &["--at", "then"], &[], "lagged"),
        (2, &["--at", "now", "--serve"], &[], "--serve"),
        (3, &[], &[("UTM_FUSION__FUSION__NOW", "true")], "the reference profile has no picture of now"),
        (3, &[], &[("UTM_FUSION__FUSION__LATENCY_S", "0")], "at least one slot in the reference profile"),
        (3, &[], &[("UTM_FUSION__FUSION__LATENCY_S", "3.3")], "set it to 3.25 or 3.5"),
        (
            2,
            &["--profile", "reference"],
            &[("UTM_FUSION__FUSION__PROFILE", "operational"), ("UTM_FUSION__FUSION__LATENCY_S", "0")],
            "the reference profile needs a latency_s of at least one slot",
        ),
    ] {
        let mut command = flight.replay(&[&flight.capture()]);
        let ran = ran(command.args(arguments).envs(variables.iter().copied()));
        assert_eq!(ran.code, code, "{arguments:?} {variables:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(words), "{arguments:?} {variables:?}: {}", ran.stderr);
    }
}
