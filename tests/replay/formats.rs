//! Guarantees for readers of the output files.

use std::collections::BTreeMap;

use asterix::{DataSource, TimeOfDay, blocks, cat129, encode_block};
use fusion::time::{SECOND, Time};
use serde_json::{Map, Value};

use super::common::{SLOT_NS, Scratch, bundled, datagrams, demo, pcap, ran};

/// Sixty transponders at the demonstration site that report each second: more per slot than fit into a datagram.
fn crowd() -> Vec<u8> {
    let start = Time::from_nanos(1_781_999_980 * SECOND);
    let report = |index: u32, second: u32| {
        let record = cat129::Record {
            data_source: Some(DataSource { sac: 0, sic: 0 }),
            serial_number: format!("{index:012}").into_bytes().try_into().ok(),
            time_of_day: TimeOfDay::from_count((86_380 + second) * 128),
            position: cat129::Position::new(53.05 + f64::from(index) * 1e-4, 10.3 + f64::from(second) * 1e-4),
            altitude_amsl: cat129::Altitude::from_metres(100.0),
            ..cat129::Record::default()
        };
        let mut block = Vec::new();
        encode_block(&[record], &mut block).unwrap();
        (Time::from_nanos(start.nanos() + i64::from(second) * SECOND), block)
    };
    let reports: Vec<_> =
        (0..6).flat_map(|second| (1..=60).map(move |index| report(index, second))).collect();
    pcap(reports.iter().map(|(time, block)| (*time, block.as_slice())))
}

#[test]
fn the_datagrams_are_those_the_service_would_send() {
    let scratch = Scratch::new();
    let crowd = scratch.file("crowd.pcap", crowd());
    let mut inputs: Vec<_> = bundled().into_iter().map(|flight| (flight.capture(), flight)).collect();
    inputs.push((crowd, demo()));
    let mut shared = 0;
    for (input, flight) in &inputs {
        let file = scratch.file("out.pcap", flight.output(&[input], "pcap"));
        let sent = datagrams(&file);
        let payloads: Vec<_> = sent.iter().flat_map(|datagram| datagram.payload.clone()).collect();
        assert!(payloads == flight.output(&[input], "ast"), "{}", input.display());

        for datagram in &sent {
            assert!(datagram.payload.len() <= 1400);
            // Sent 6.25 s after the slot opened; its content is for the slot's centre.
            let opened = datagram.received.unwrap().nanos() - 25 * SLOT_NS;
            assert_eq!(opened % SLOT_NS, 0);
            let centre = Time::from_nanos(opened + SLOT_NS / 2).since_midnight() * 128 / SECOND;
            for block in blocks(&datagram.payload) {
                let record = block.unwrap().records::<cat129::Record>().next().unwrap().unwrap().record;
                assert_eq!(i64::from(record.time_of_day.unwrap().count()), centre);
            }
        }
        for pair in sent.windows(2) {
            assert!(pair[0].received <= pair[1].received);
            if pair[0].received == pair[1].received {
                shared += 1;
                let next = blocks(&pair[1].payload).next().unwrap().unwrap().octets.len();
                assert!(pair[0].payload.len() + next > 1400, "no more datagrams than needed");
            }
        }
    }
    assert!(shared > 0, "no slot needed two datagrams");
}

fn no_null(value: &Value) -> bool {
    match value {
        Value::Null => false,
        Value::Array(items) => items.iter().all(no_null),
        Value::Object(fields) => fields.values().all(no_null),
        _ => true,
    }
}

fn number(fields: &Map<String, Value>, key: &str) -> f64 {
    fields.get(key).and_then(Value::as_f64).unwrap_or_else(|| panic!("no number {key} in {fields:?}"))
}

fn text<'a>(fields: &'a Map<String, Value>, key: &str) -> &'a str {
    fields.get(key).and_then(Value::as_str).unwrap_or_else(|| panic!("no text {key} in {fields:?}"))
}

/// Checks a track against the API's field list and its line of the CSV output.
fn assert_track(track: &Map<String, Value>, line: &str) {
    let columns: Vec<_> = line.split(',').collect();
    let column = |index: usize| columns[index].parse::<f64>().unwrap();
    let source = columns[2];
    assert_eq!((text(track, "id"), text(track, "source")), (columns[1], source));
    assert!(text(track, "id").chars().all(|c| c.is_ascii_alphanumeric() || "-._".contains(c)), "{line}");
    assert_eq!(number(track, "track_number"), column(3));
    let time: jiff::Timestamp = text(track, "time").parse().unwrap();
    assert_eq!(time.as_microsecond() as f64 / 1e6, column(0));
    assert_eq!(text(track, "time").len(), "2026-06-21T00:00:00.125Z".len(), "RFC 3339 with milliseconds");
    let first_seen: jiff::Timestamp = text(track, "first_seen").parse().unwrap();
    assert!(first_seen <= time);

    assert!((number(track, "lat") - column(6)).abs() < 2e-9 && number(track, "lat").abs() <= 90.0);
    assert!((number(track, "lng") - column(7)).abs() < 2e-9 && number(track, "lng").abs() <= 180.0);
    let undulation = number(track, "geoid_separation");
    assert_eq!(track.contains_key("alt"), !columns[8].is_empty());
    assert_eq!(track.contains_key("alt_msl"), !columns[8].is_empty());
    if !columns[8].is_empty() {
        assert!((number(track, "alt_msl") - column(8)).abs() < 0.001);
        assert!((number(track, "alt") - number(track, "alt_msl") - undulation).abs() < 0.0015);
    }
    assert_eq!(track["interpolated"], source != "radar");
    assert_eq!(track["extrapolated"], false);

    assert_eq!(track.contains_key("uas_id"), source != "radar");
    if let Some(uas) = track.get("uas_id") {
        assert!(!text(uas.as_object().unwrap(), "serial_number").trim().is_empty());
    }
    let kinds: &[&str] = match source {
        "fused" => &["radar", "transponder"],
        alone => &[alone],
    };
    let contributors = track["contributors"].as_array().unwrap();
    let contributors: Vec<_> = contributors.iter().map(|part| part.as_object().unwrap()).collect();
    assert_eq!(contributors.iter().map(|part| text(part, "kind")).collect::<Vec<_>>(), kinds);
    let weights: f64 = contributors.iter().map(|part| number(part, "weight")).sum();
    assert!((weights - 1.0).abs() < 0.001);
    for part in &contributors {
        let column = if part["kind"] == "radar" { 4 } else { 5 };
        assert_eq!(part["track_number"].to_string(), columns[column]);
        assert!(!text(part, "sensor").is_empty());
    }
    let why: Vec<_> = ["distance_m", "threshold_m", "ratio", "within", "co_present"]
        .map(|key| contributors[0].get(key).and_then(Value::as_f64))
        .into();
    match why[..] {
        [Some(distance_m), Some(threshold_m), Some(ratio), Some(within), Some(co_present)] => {
            assert_eq!(source, "fused");
            assert!(distance_m <= threshold_m && (60.0..=300.0).contains(&threshold_m), "{line}");
            assert!((0.9..=1.0).contains(&ratio) && (ratio - within / co_present).abs() < 0.0001, "{line}");
            assert!((4.0..=100.0).contains(&co_present));
        }
        _ => assert!(source != "fused" && why.iter().all(Option::is_none), "{line}"),
    }
}

#[test]
fn every_line_of_json_is_a_track_of_the_api() {
    for flight in bundled() {
        let json = String::from_utf8(flight.output(&[&flight.capture()], "ndjson")).unwrap();
        let csv = flight.csv();
        assert_eq!(json.lines().count(), csv.len());
        // Time of the last point and of the first detection, by id.
        let mut last: BTreeMap<String, [String; 2]> = BTreeMap::new();
        for (line, csv) in json.lines().zip(&csv) {
            let track: Value = serde_json::from_str(line).unwrap();
            assert!(no_null(&track), "{line}");
            let track = track.as_object().unwrap();
            assert_track(track, csv);
            let now = ["time", "first_seen"].map(|key| text(track, key).to_owned());
            if let Some([time, first_seen]) = last.insert(text(track, "id").to_owned(), now.clone()) {
                let [before, at] = [&time, &now[0]].map(|time| time.parse::<jiff::Timestamp>().unwrap());
                assert!(before < at, "an id is published once per slot: {line}");
                assert_eq!(first_seen, now[1], "{line}");
            }
        }
    }
}

#[test]
fn a_feature_collection_holds_every_point() {
    for flight in bundled() {
        let octets = flight.output(&[&flight.capture()], "geojson");
        let collection: Value = serde_json::from_slice(&octets).unwrap();
        assert!(no_null(&collection));
        assert_eq!(collection["type"], "FeatureCollection");
        let (features, csv) = (collection["features"].as_array().unwrap(), flight.csv());
        assert_eq!(features.len(), csv.len());
        for (feature, line) in features.iter().zip(&csv) {
            assert_eq!(feature["type"], "Feature");
            assert_eq!(feature["geometry"]["type"], "Point");
            let properties = feature["properties"].as_object().unwrap();
            assert_track(properties, line);
            let coordinates = feature["geometry"]["coordinates"].as_array().unwrap();
            let wanted = ["lng", "lat", "alt"].map(|key| properties.get(key).cloned());
            assert_eq!(*coordinates, wanted.into_iter().flatten().collect::<Vec<_>>(), "longitude first");
        }
    }
}

/// A north marker, and an empty capture.
#[test]
fn without_a_point_every_format_is_still_valid() {
    let flight = demo();
    let marker: &[u8] = &[34, 0, 6, 0x80, 70, 41];
    let scratch = Scratch::new();
    for (received, code) in [(vec![], 1), (vec![(Time::from_nanos(1_781_999_970 * SECOND), marker)], 0)] {
        let input = scratch.file("in.pcap", pcap(received));
        let output = |extension: &str| {
            let file = scratch.path(format!("out.{extension}"));
            let ran = ran(flight.replay(&[&input]).arg("-o").arg(&file));
            assert_eq!(ran.code, code, "{extension}: {}", ran.stderr);
            std::fs::read(file).unwrap()
        };
        for (extension, empty) in [
            ("ast", ""),
            ("ndjson", ""),
            ("csv", "time,id,source,track_number,radar_track,transponder,lat,lon,alt_msl,flags\n"),
        ] {
            assert_eq!(output(extension), empty.as_bytes(), "{extension}");
        }
        let collection: Value = serde_json::from_slice(&output("geojson")).unwrap();
        assert_eq!(collection, serde_json::json!({ "type": "FeatureCollection", "features": [] }));
        output("pcap");
        assert!(datagrams(&scratch.path("out.pcap")).is_empty());
        let summary = ran(&mut flight.replay(&[&input]));
        assert!(summary.text().contains("output     no point in "), "{}", summary.text());
    }
}

#[test]
fn unmeasured_point_of_poor_accuracy_is_in_no_file() {
    let flight = demo();
    let written = |max_accuracy_m: &str| {
        let mut replay = flight.replay(&[&flight.capture()]);
        replay.env("UTM_FUSION__OUTPUT__MAX_ACCURACY_M", max_accuracy_m);
        replay.args(["--profile", "operational", "-o", "-", "--output-format", "ndjson"]);
        let ran = ran(&mut replay);
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        ran.text().lines().map(str::to_owned).collect::<Vec<_>>()
    };
    let (all, few) = (written("10000"), written("10"));
    let track = |line: &String| serde_json::from_str::<Map<String, Value>>(line).unwrap();
    let is_poor = |line: &&String| number(&track(line), "accuracy_h_m") > 10.0;
    let is_measured = |line: &&String| {
        let track = track(line);
        track["interpolated"] == false && track["extrapolated"] == false
    };
    let expected: Vec<&String> = all.iter().filter(|line| is_measured(line) || !is_poor(line)).collect();
    assert_eq!(few.iter().collect::<Vec<_>>(), expected);
    assert!(few.len() < all.len(), "some are left out");
    assert!(few.iter().any(|line| is_poor(&line)), "measured, however poorly");
    assert!(few.iter().any(|line| !is_measured(&line)), "not measured, but known well");
}

/// Compares the columns of CSV that only `operational` has with those of Parquet, which another test compares with
/// NDJSON.
#[test]
fn csv_of_operational_has_identity_speed_and_accuracy() {
    let flight = demo();
    let mut replay = flight.replay(&[&flight.capture()]);
    replay.args(["--profile", "operational", "-o", "-", "--output-format"]);
    let (csv, ndjson) = (ran(replay.arg("csv")), {
        let mut replay = flight.replay(&[&flight.capture()]);
        ran(replay.args(["--profile", "operational", "-o", "-", "--output-format", "ndjson"]))
    });
    let mut reader = csv::Reader::from_reader(&csv.stdout[..]);
    let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let base = [
        "time",
        "id",
        "source",
        "track_number",
        "radar_track",
        "transponder",
        "lat",
        "lon",
        "alt_msl",
        "flags",
    ];
    assert_eq!(names[..10], base);
    let at = |name: &str| names.iter().position(|known| known == name).unwrap_or_else(|| panic!("no {name}"));
    let (serial, speed, accuracy) = (at("serial_number"), at("speed_m_s"), at("accuracy_h_m"));
    let records: Vec<_> = reader.records().map(|record| record.unwrap()).collect();
    let lines: Vec<Value> = String::from_utf8(ndjson.stdout)
        .unwrap()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert!(records.len() == lines.len() && records.len() > 100);
    for (record, track) in records.iter().zip(&lines) {
        assert_eq!(record[1], *track["id"].as_str().unwrap());
        assert_eq!(record[serial], *track["uas_id"]["serial_number"].as_str().unwrap_or_default());
        assert!((record[speed].parse::<f64>().unwrap() - track["speed"].as_f64().unwrap()).abs() < 0.011);
        assert!(
            (record[accuracy].parse::<f64>().unwrap() - track["accuracy_h_m"].as_f64().unwrap()).abs()
                < 0.011
        );
    }
}
