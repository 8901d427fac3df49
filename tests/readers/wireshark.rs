//! `wireshark/cat129.lua`: its items match the codec, and Wireshark shows the values that `decode` prints. Tests of generated
//! files always run; the others report themselves as skipped if tshark is not installed.

mod edges;
mod generate;
mod pdml;
#[path = "../captures/writer.rs"]
#[allow(dead_code, reason = "shared with the tests of captures")]
mod writer;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::program::{Scratch, utm_fusion};
use crate::service::is_installed;
use pdml::{Packet, RemoteIdOutcome, Shown, packets, tshark};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_items_are_those_of_the_codec() {
    let dissector = "wireshark/cat129.lua";
    let kept = fs::read_to_string(root().join(dissector)).unwrap();
    for (path, made) in
        [(dissector, generate::dissector(&kept)), ("asterix/definitions/cat129.ast", generate::definition())]
    {
        let path = root().join(path);
        if std::env::var_os("UPDATE").is_some() {
            fs::write(&path, &made).unwrap();
        }
        let kept = fs::read_to_string(&path).unwrap_or_default();
        assert!(kept == made, "{} is not up to date: UPDATE=1 makes it anew", path.display());
    }
}

/// The definition describes the same octets as an independent transcription of the specification.
#[test]
fn the_definition_is_that_of_another_transcription() {
    let Some(shared) = std::env::var_os("UTM_FUSION_SHARED_DATA") else {
        return println!("skipped: UTM_FUSION_SHARED_DATA is not set");
    };
    let theirs = fs::read_to_string(Path::new(&shared).join("../asterix/cat129-1.2.ast")).unwrap();
    // Description of the octets, without titles, tables, ranges and remarks.
    let octets = |text: &str| -> Vec<String> {
        let known = ["element ", "spare ", "explicit ", "signed ", "unsigned ", "string ", "-"];
        let is_item = |line: &str| {
            let number = line.split(' ').next().unwrap();
            number == "SP" || number.len() == 3 && number.bytes().all(|digit| digit.is_ascii_digit())
        };
        let lines = text.split_once("\nitems\n").unwrap().1.lines().map(str::trim);
        lines
            .filter(|line| known.iter().any(|known| line.starts_with(known)) || is_item(line))
            .map(|line| match line.split('"').collect::<Vec<_>>()[..] {
                [before, unit, ..] if !is_item(line) => format!("{before}{unit}"),
                [before, ..] => before.to_owned(),
                [] => String::new(),
            })
            .collect()
    };
    assert_eq!(octets(&generate::definition()), octets(&theirs));
}

/// A record or a fault, by name, in a form common to both programs.
#[derive(Clone, Debug, PartialEq)]
enum Event {
    Record(BTreeMap<String, Meaning>),
    Fault(String, usize),
}

#[derive(Clone, Debug)]
enum Meaning {
    Number(f64),
    Text(String),
    Octets(String),
}

impl PartialEq for Meaning {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            // Both values are nearest to the same few decimals.
            (Self::Number(one), Self::Number(other)) => (one - other).abs() <= 1e-12 * one.abs(),
            (Self::Text(one), Self::Text(other)) | (Self::Octets(one), Self::Octets(other)) => one == other,
            _ => false,
        }
    }
}

/// Output of `decode` for CAT129. In a capture made by `PcapWriter`, faults have offsets in their frames.
fn decoded(capture: &Path) -> Vec<Event> {
    let output = utm_fusion("decode").arg(capture).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let frames = frames(&fs::read(capture).unwrap());
    let event = |line: &str| {
        let line: Value = serde_json::from_str(line).unwrap();
        if line.get("cat").is_some_and(|category| category != 129) {
            return None;
        }
        if let Some(error) = line.get("error") {
            let at = error["offset"].as_u64().unwrap() as usize;
            let frame = frames.iter().rfind(|frame| **frame <= at).unwrap();
            return Some(Event::Fault(error["kind"].as_str().unwrap().to_owned(), at - frame));
        }
        let mut said = BTreeMap::new();
        if let Some(fspec) = line.get("fspec") {
            said.insert("fspec".to_owned(), Meaning::Octets(fspec.as_str().unwrap().to_owned()));
        }
        flatten(&mut said, String::new(), line.get("items")?);
        Some(Event::Record(said))
    };
    String::from_utf8(output.stdout).unwrap().lines().filter_map(event).collect()
}

/// Offsets of the frames in a classic little-endian pcap.
fn frames(pcap: &[u8]) -> Vec<usize> {
    let (mut frames, mut at) = (Vec::new(), 24);
    while at < pcap.len() {
        frames.push(at + 16);
        at += 16 + u32::from_le_bytes(pcap[at + 8..at + 12].try_into().unwrap()) as usize;
    }
    frames
}

/// Values below this one, by path: `080.latitude_deg`.
fn flatten(out: &mut BTreeMap<String, Meaning>, place: String, value: &Value) {
    let meaning = match value {
        Value::Object(members) => match members.get("hex").and_then(Value::as_str) {
            Some(octets) => Meaning::Octets(octets.to_owned()),
            None => {
                for (name, member) in members {
                    let name = name.to_lowercase();
                    let place = if place.is_empty() { name } else { format!("{place}.{name}") };
                    flatten(out, place, member);
                }
                return;
            }
        },
        Value::Null => return,
        Value::Number(number) => Meaning::Number(number.as_f64().unwrap()),
        Value::String(octets) if place == "sp" => {
            // For an unknown field, Wireshark shows the octets after its length.
            if octets.len() > 2 {
                out.insert("sp.octets".to_owned(), Meaning::Octets(octets[2..].to_owned()));
            }
            return;
        }
        Value::String(octets) if place == "120.undescribed" => Meaning::Octets(octets.clone()),
        Value::String(text) => Meaning::Text(text.clone()),
        other => panic!("{place}: {other}"),
    };
    assert!(out.insert(place, meaning).is_none());
}

/// Display of Wireshark, in the terms of `decode`'s output for the same place.
fn shown(said: &RemoteIdOutcome, decoded: Option<&Event>) -> Event {
    let fields = match said {
        RemoteIdOutcome::Fault(name, at) => return Event::Fault(name.clone(), *at),
        RemoteIdOutcome::Record(fields) => fields,
    };
    let of = |field: &Shown| {
        let printed = match decoded {
            Some(Event::Record(printed)) => printed.get(&field.name),
            _ => None,
        };
        let meaning = match printed {
            // Wireshark always shows it; `decode` prints it only if it is longer than necessary.
            None if field.name == "fspec" => return None,
            Some(Meaning::Octets(_)) => Meaning::Octets(field.octets.clone()),
            Some(Meaning::Text(_)) => Meaning::Text(field.show.clone()),
            _ => Meaning::Number(field.show.parse().unwrap_or(f64::NAN)),
        };
        Some((field.name.clone(), meaning))
    };
    Event::Record(fields.iter().filter_map(of).collect())
}

/// Compares both programs on a capture. Returns the events of `decode`, and the packets of Wireshark.
fn compare(scratch: &Scratch, capture: &Path, arguments: &[&str]) -> (Vec<Event>, Vec<Packet>) {
    let (decoded, packets) = (decoded(capture), packets(scratch, capture, arguments));
    let said: Vec<&RemoteIdOutcome> = packets.iter().flat_map(|packet| &packet.said).collect();
    for (index, said) in said.iter().enumerate() {
        let event = decoded.get(index);
        assert_eq!(Some(&shown(said, event)), event, "{index}: {said:?}");
    }
    assert_eq!(said.len(), decoded.len());
    (decoded, packets)
}

fn values(events: &[Event]) -> usize {
    let of = |event: &Event| match event {
        Event::Record(said) => said.len(),
        Event::Fault(..) => 0,
    };
    events.iter().map(of).sum()
}

/// Half a minute of three drones: the datagrams of the sensors, and the output of the service.
fn flight(scratch: &Scratch) -> (PathBuf, PathBuf) {
    let demo = root().join("testdata/demo");
    let (config, sent, fused) =
        (demo.join("site.toml"), demo.join("capture.pcap"), scratch.path("fused.pcap"));
    let mut replay = utm_fusion("replay");
    replay.arg("--config").args([&config, &sent]).arg("-o").arg(&fused);
    assert!(replay.output().unwrap().status.success());
    (sent, fused)
}

#[test]
fn every_value_of_a_flight_is_that_of_decode() {
    if !is_installed("tshark", "--version") {
        return;
    }
    let scratch = Scratch::new();
    let (sent, fused) = flight(&scratch);
    let (reports, _) = compare(&scratch, &sent, &[]);
    let (points, packets) = compare(&scratch, &fused, &[]);
    println!(
        "{} records of transponders, {} points: {} values",
        reports.len(),
        points.len(),
        values(&reports) + values(&points)
    );
    assert!(reports.len() > 50 && points.len() > 500);

    // Fields can be used as filters, which select the datagrams with such records.
    let is = |place: &'static str, holds: fn(f64) -> bool| {
        move |event: &Event| match event {
            Event::Record(said) => matches!(said.get(place), Some(Meaning::Number(value)) if holds(*value)),
            Event::Fault(..) => false,
        }
    };
    let (is_fused, is_north) =
        (is("sp.uf.source", |source| source == 1.0), is("080.latitude_deg", |latitude| latitude > 53.088));
    let mut left = &points[..];
    let mut expected = 0;
    for packet in &packets {
        let (here, rest) = left.split_at(packet.said.len());
        left = rest;
        expected += usize::from(here.iter().any(&is_fused) && here.iter().any(&is_north));
    }
    let filter = "cat129.sp.uf.source == \"Fused\" and cat129.080.latitude_deg > 53.088";
    let found = tshark(&scratch, &fused, &["-Y", filter]).lines().count();
    assert_eq!(found, expected);
    assert!((1..packets.len()).contains(&found), "{found} of {}", packets.len());
    let lines = tshark(&scratch, &fused, &["-c", "1"]);
    assert!(lines.contains("ASTERIX") && lines.contains("CAT129 track "), "{lines}");
}

/// Datagrams go from port 8048 to 8049. Only this option assigns port 8049 to the dissector.
const PORT: &[&str] = &["-o", "cat129.ports:8049"];

fn capture(scratch: &Scratch, datagrams: &[Vec<u8>]) -> PathBuf {
    let mut pcap = writer::PcapWriter::new(false, false, 101);
    for (index, datagram) in datagrams.iter().enumerate() {
        pcap.record(1_700_000_000 + index as u32, 0, &writer::ipv4(writer::UDP, 0, &writer::udp(datagram)));
    }
    scratch.file("capture.pcap", &pcap.octets)
}

#[test]
fn every_edge_is_what_decode_makes_of_it() {
    if !is_installed("tshark", "--version") {
        return;
    }
    let scratch = Scratch::new();
    let datagrams = edges::all();
    let (events, packets) = compare(&scratch, &capture(&scratch, &datagrams), PORT);
    let noted =
        |name: &str| packets.iter().filter(|packet| packet.notes.iter().any(|note| note == name)).count();
    for note in ["spare_set", "several_records", "time_past_day"] {
        assert!(noted(note) > 0, "{note}");
    }
    let kinds = [
        "block_too_short",
        "block_past_end",
        "fspec_past_end",
        "fspec_too_long",
        "reserved_frn",
        "item_past_end",
        "length_zero",
    ];
    for kind in kinds {
        let of = |event: &&Event| matches!(event, Event::Fault(name, _) if name == kind);
        let count = events.iter().filter(of).count();
        let found = tshark(
            &scratch,
            &scratch.path("capture.pcap"),
            &[PORT, &["-Y", &format!("cat129.{kind}")]].concat(),
        );
        assert!(count > 0 && found.lines().count() > 0, "{kind}: {count}");
    }
    println!(
        "{} datagrams, {} records and faults, {} values",
        datagrams.len(),
        events.len(),
        values(&events)
    );
}

#[test]
fn dissector_coexists_with_those_of_other_categories() {
    if !is_installed("tshark", "--version") {
        return;
    }
    let scratch = Scratch::new();
    let (uas, radar) = (edges::block(&edges::full(false)), [48, 0, 6, 0x80, 25, 200]);
    let random = [0x81, 0, 9, 1, 2, 3, 4];
    let datagrams = [[&radar[..], &uas, &uas].concat(), radar.to_vec(), uas.clone(), random.to_vec()];
    let file = capture(&scratch, &datagrams);
    let has = |packet: &Packet, name: &str| packet.protocols.iter().any(|protocol| protocol == name);

    // On other ports, datagrams that consist of CAT129 blocks to their end are recognised, and no others.
    let of = packets(&scratch, &file, &[]);
    let ours: Vec<bool> = of.iter().map(|packet| has(packet, "cat129")).collect();
    assert_eq!(ours, [true, false, true, false]);
    assert!(has(&of[0], "asterix"), "{:?}", of[0].protocols);
    assert_eq!((of[0].said.len(), of[2].said.len()), (2, 1));

    // On an ASTERIX port all blocks are recognised, each category by its own dissector.
    for arguments in [PORT, &["-d", "udp.port==8049,cat129"]] {
        let of = packets(&scratch, &file, arguments);
        let shown: Vec<(bool, bool)> =
            of.iter().map(|packet| (has(packet, "cat129"), has(packet, "asterix"))).collect();
        assert_eq!(shown, [(true, true), (false, true), (true, false), (true, false)]);
        assert!(matches!(&of[3].said[..], [RemoteIdOutcome::Fault(name, _)] if name == "block_past_end"));
    }
}

/// Octets that were sent but not captured are not a fault of the sender.
#[test]
fn truncated_frame_is_marked() {
    if !is_installed("tshark", "--version") {
        return;
    }
    let scratch = Scratch::new();
    let frame = writer::ipv4(writer::UDP, 0, &writer::udp(&edges::block(&edges::full(false))));
    let mut pcap = writer::PcapWriter::new(false, false, 101);
    pcap.record_of(1_700_000_000, 0, &frame[..frame.len() - 20], frame.len());
    let of = packets(&scratch, &scratch.file("capture.pcap", &pcap.octets), PORT);
    assert!(of[0].said.is_empty(), "{:?}", of[0].said);
    assert_eq!(of[0].notes, ["not_captured"]);
}
