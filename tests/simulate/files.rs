//! The six files are consistent, and the service accepts them without warnings.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use asterix::{Record, blocks, cat048, cat129};
use utm_fusion::capture::Capture;

use crate::common::{Scratch, between, files, kept_path, ran, utm_fusion};

/// Key of a row of `labels.csv`: time in 1/128 s, sensor, number.
type Key = (i64, String, u32);

/// Keys of all records in these octets; `sensors` names the sources of CAT048 by SIC.
fn keys(octets: &[u8], start_s: i64, sensors: &BTreeMap<u8, &str>) -> Vec<Key> {
    // The time of day nearest to the start of the flight: a flight is shorter than half a day.
    let instant = |count: u32| {
        let day = 86_400 * 128;
        let start = start_s * 128;
        let since = i64::from(count) - start.rem_euclid(day);
        start + (since + day / 2).rem_euclid(day) - day / 2
    };
    let mut keys = Vec::new();
    for block in blocks(octets).map(Result::unwrap) {
        match block.category {
            cat048::Record::CATEGORY => keys.extend(block.records::<cat048::Record>().map(|located| {
                let record = located.unwrap().record;
                let sensor = sensors[&record.data_source.unwrap().sic].to_owned();
                let number = u32::from(record.track_number.unwrap().number());
                (instant(record.time_of_day.unwrap().count()), sensor, number)
            })),
            cat129::Record::CATEGORY => keys.extend(block.records::<cat129::Record>().map(|located| {
                let record = located.unwrap().record;
                let serial = record.serial_number.unwrap();
                let number = str::from_utf8(&serial).unwrap().parse().unwrap();
                (instant(record.time_of_day.unwrap().count()), "drone-it".to_owned(), number)
            })),
            34 => {}
            category => panic!("category {category}"),
        }
    }
    keys.sort();
    keys
}

fn captured(path: &Path) -> Vec<u8> {
    Capture::open(path).unwrap().flat_map(|datagram| datagram.unwrap().payload).collect()
}

#[test]
fn simulated_files_are_consistent() {
    let sensors = BTreeMap::from([(200, "gamekeeper"), (201, "rotating")]);
    for (name, start_s, seed) in [("single", 1_773_478_800, 1), ("crossing", 1_773_478_800, 2)] {
        let scratch = Scratch::new();
        let directory = scratch.path(name);
        files(&kept_path(name), seed, &directory);

        // Labels and records correspond one to one.
        let mut labels: Vec<Key> = fs::read_to_string(directory.join("labels.csv"))
            .unwrap()
            .lines()
            .skip(1)
            .map(|line| {
                let fields: Vec<&str> = line.split(',').collect();
                assert_eq!(fields.len(), 5, "{line}");
                let (seconds, fraction) = fields[0].split_once('.').unwrap();
                let tenths_of_us: i64 = fraction.parse().unwrap();
                assert_eq!(
                    (fraction.len(), tenths_of_us % 78_125),
                    (7, 0),
                    "{line} is no multiple of 1/128 s"
                );
                let time = seconds.parse::<i64>().unwrap() * 128 + tenths_of_us / 78_125;
                (time, fields[1].to_owned(), fields[2].parse().unwrap())
            })
            .collect();
        assert!(labels.is_sorted_by_key(|label| label.0));
        labels.sort();
        assert!(labels.windows(2).all(|pair| pair[0] != pair[1]), "a label tells of one record");
        let capture = keys(&captured(&directory.join("capture.pcap")), start_s, &sensors);
        assert!(capture == labels, "{name}: {} records, {} labels", capture.len(), labels.len());

        // The raw files hold the same records as the capture.
        let radar = fs::read(directory.join("radar.ast")).unwrap();
        let transponder = fs::read(directory.join("transponder.ast")).unwrap();
        let mut raw = [keys(&radar, start_s, &sensors), keys(&transponder, start_s, &sensors)].concat();
        raw.sort();
        assert!(raw == capture, "{name}: {} records in the raw files, {} captured", raw.len(), capture.len());
        let [mut a, mut b] = [[radar, transponder].concat(), captured(&directory.join("capture.pcap"))];
        a.sort_unstable();
        b.sort_unstable();
        assert!(a == b, "{name}: other octets in the capture");

        // The truth has every drone ten times per second.
        let truth = fs::read_to_string(directory.join("truth.csv")).unwrap();
        let drones = if name == "single" { 1 } else { 10 };
        assert_eq!(truth.lines().count(), 1 + drones * 3001);
        assert_eq!(truth.lines().next(), Some("time,id,lat,lon,alt_msl,vn,ve,vd"));
    }
}

/// Number of records that the service accepts from these files, by sensor; and the lines about dropped records.
fn replayed(directory: &Path, inputs: &[&str]) -> (BTreeMap<String, u64>, Vec<String>) {
    let mut command = utm_fusion("replay");
    command.args(inputs.iter().map(|input| directory.join(input)));
    command.args(["--date", "2026-03-14", "--config"]).arg(directory.join("site.toml"));
    let (code, summary, errors) = ran(&mut command);
    assert_eq!(code, 0, "{errors}");
    let mut accepted = BTreeMap::new();
    let mut dropped = Vec::new();
    for line in summary.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["sensor", id, _, count, "plots" | "reports"] => {
                accepted.insert(id.to_owned(), count.parse().unwrap());
            }
            ["sensor", id, _, count, "plots;", messages, "service", "messages"] => {
                accepted.insert(id.to_owned(), count.parse().unwrap());
                assert!(messages.parse::<u64>().unwrap() > 0, "{line}");
            }
            ["sensor" | "dropped" | "noted", ..] => dropped.push(words[1..].join(" ")),
            _ => {}
        }
    }
    (accepted, dropped)
}

fn labelled(directory: &Path) -> BTreeMap<String, u64> {
    let mut labels = BTreeMap::new();
    for line in fs::read_to_string(directory.join("labels.csv")).unwrap().lines().skip(1) {
        *labels.entry(line.split(',').nth(1).unwrap().to_owned()).or_default() += 1;
    }
    labels
}

#[test]
fn service_accepts_every_record() {
    // In a raw file, the first service message precedes the first plot, and therefore the first known time.
    let untimed = "1 records of no sensor: no_time".to_owned();
    for name in ["single", "crossing"] {
        let scratch = Scratch::new();
        let directory = scratch.path(name);
        files(&kept_path(name), 3, &directory);
        let (code, shown, errors) = ran(utm_fusion("check").arg("--config").arg(directory.join("site.toml")));
        assert_eq!(code, 0, "{shown}{errors}");
        let labels = labelled(&directory);
        assert_eq!(labels.len(), 2);
        assert_eq!(replayed(&directory, &["capture.pcap"]), (labels.clone(), Vec::new()), "{name}");
        let raw = replayed(&directory, &["radar.ast", "transponder.ast"]);
        assert_eq!(raw, (labels, vec![untimed.clone()]), "{name}");
    }
}

#[test]
fn flight_over_midnight_has_no_refused_records() {
    let scratch = Scratch::new();
    let directory = scratch.path("midnight");
    files(&kept_path("midnight"), 1, &directory);
    // No sent record is refused; only network effects are reported.
    let (accepted, dropped) = replayed(&directory, &["capture.pcap"]);
    let labels = labelled(&directory);
    for (sensor, sent) in &labels {
        // Two lines, each with a loss of 1 %.
        between("share that arrives", 0.99, accepted[sensor] as f64 / *sent as f64, 1.0);
    }
    for line in &dropped {
        let expected = line.contains("repeated datagrams")
            || line.contains("which is not used")
            || line.contains("CAT048 records of SAC 99 SIC 98, which no sensor has");
        assert!(expected, "{line}");
    }
    let (accepted, dropped) = replayed(&directory, &["radar.ast", "transponder.ast"]);
    assert_eq!((accepted, dropped.len()), (labels, 1), "{dropped:?}");
    // Track numbers wrap around.
    let labels = fs::read_to_string(directory.join("labels.csv")).unwrap();
    let of_first = labels.lines().filter(|line| line.contains(",gamekeeper,"));
    let numbers: Vec<u32> = of_first.map(|line| line.split(',').nth(2).unwrap().parse().unwrap()).collect();
    assert!(numbers[0] >= 4080 && numbers.contains(&4095) && !numbers.contains(&0));
    assert!((1..1000).contains(&numbers[numbers.len() - 1]));
    // Both days occur.
    let midnight = 1_773_532_800;
    for file in ["truth.csv", "labels.csv"] {
        let times: Vec<i64> = fs::read_to_string(directory.join(file))
            .unwrap()
            .lines()
            .skip(1)
            .map(|line| line.split_once('.').unwrap().0.parse().unwrap())
            .collect();
        assert!(times.is_sorted() && times[0] < midnight - 110 && times[times.len() - 1] > midnight + 110);
    }
}
