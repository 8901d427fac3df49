//! Real recordings, which are not part of the project: `UTM_FUSION_SHARED_DATA` names the folder that holds them.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;

use asterix::{FaultKind, Record, blocks, cat048, encode_block};
use serde_json::{Value, json};

/// The folder, or `None` (and a word about it) where none is named.
fn shared_data() -> Option<PathBuf> {
    let folder = std::env::var_os("UTM_FUSION_SHARED_DATA").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("skipped: UTM_FUSION_SHARED_DATA names no folder of recordings");
    }
    folder
}

/// The items that have types here, in the words of the independent decode.
fn typed_items(record: &cat048::Record) -> BTreeMap<&'static str, Value> {
    let mut items = BTreeMap::new();
    let mut put = |item, value: Option<Value>| value.map(|value| items.insert(item, value));
    put("010", record.data_source.map(|source| json!({"SAC": source.sac, "SIC": source.sic})));
    put("140", record.time_of_day.map(|time| json!(time.seconds())));
    put(
        "020",
        record.target_report.map(|report| {
            json!({"_groups": [{
                "TYP": report.detection() as u8,
                "SIM": u8::from(report.is_simulated()),
                "RDP": report.processing_chain() - 1,
                "SPI": u8::from(report.is_special_position()),
                "RAB": u8::from(report.is_field_monitor()),
            }]})
        }),
    );
    put("040", record.polar_position.map(|at| json!({"RHO": at.range_nm(), "THETA": at.azimuth_deg()})));
    put(
        "070",
        record.mode_3a.map(|code| {
            json!({
                "V": u8::from(!code.is_validated()),
                "G": u8::from(code.is_garbled()),
                "L": u8::from(code.is_not_extracted()),
                "MODE3A": code.to_string(),
            })
        }),
    );
    put(
        "090",
        record.flight_level.map(|level| {
            json!({
                "V": u8::from(!level.is_validated()),
                "G": u8::from(level.is_garbled()),
                "FL": level.flight_level(),
            })
        }),
    );
    put("220", record.aircraft_address.map(|address| json!(address.address())));
    put(
        "240",
        record.aircraft_identification.map(|id| json!(String::from_utf8(id.characters().to_vec()).unwrap())),
    );
    put("161", record.track_number.map(|track| json!({"TRN": track.number()})));
    put("200", record.track_velocity.map(|at| json!({"GSP": at.speed_nm_s(), "HDG": at.heading_deg()})));
    put(
        "170",
        record.track_status.map(|status| {
            json!({"_groups": [{
                "CNF": u8::from(status.is_tentative()),
                "RAD": status.sensor() as u8,
                "DOU": u8::from(status.is_doubtful()),
                "MAH": u8::from(status.is_manoeuvring()),
                "CDM": status.climb_mode() as u8,
            }]})
        }),
    );
    put("030", record.warnings.map(|warnings| json!(warnings.codes().collect::<Vec<_>>())));
    items
}

#[test]
fn an_hour_of_a_terminal_radar_equals_an_independent_decode() {
    let Some(folder) = shared_data() else { return };
    let folder = folder.join("cat048-barcelona");
    let octets = std::fs::read(folder.join("capture.ast")).unwrap();
    let packed = std::fs::read(folder.join("decoded.ndjson.gz")).unwrap();
    let mut expected = BufReader::new(flate2::read::GzDecoder::new(packed.as_slice())).lines();

    let (mut count, mut again) = (0, Vec::with_capacity(octets.len()));
    for block in blocks(&octets) {
        let block = block.unwrap();
        assert_eq!(block.category, cat048::Record::CATEGORY);
        let records: Vec<cat048::Record> = block.records().map(|located| located.unwrap().record).collect();
        encode_block(&records, &mut again).unwrap();
        for record in &records {
            let line: Value = serde_json::from_str(&expected.next().unwrap().unwrap()).unwrap();
            let theirs = line["items"].as_object().unwrap();
            let mut ours = typed_items(record);
            for (item, _) in record.raw_items() {
                ours.insert(item, theirs.get(item).cloned().unwrap_or_default());
            }
            assert_eq!(theirs.len(), ours.len(), "record {count}");
            for (item, value) in ours {
                assert_eq!(theirs.get(item), Some(&value), "I048/{item} of record {count}");
            }
            count += 1;
        }
    }
    assert_eq!(count, 44_085);
    assert!(again == octets, "the octets differ after decoding and encoding");
    assert!(expected.next().is_none());
}

#[test]
fn single_vectors_and_odd_encodings() {
    let Some(folder) = shared_data() else { return };
    for (file, expected) in [
        ("croatia_cat048.raw", 1),
        ("goasterix_sample.ast", 11),
        ("jasterix_cat048ed1.23.bin", 1),
        ("psr3d_nonminimal_fspec.raw", 62),
    ] {
        let octets = std::fs::read(folder.join("cat048-small").join(file)).unwrap();
        let mut count = 0;
        for block in blocks(&octets) {
            let block = block.unwrap();
            if block.category != cat048::Record::CATEGORY {
                continue;
            }
            let (records, fault) = common::read_block::<cat048::Record>(&block);
            assert_eq!(fault, None, "{file}");
            let mut again = Vec::new();
            encode_block(&records, &mut again).unwrap();
            assert_eq!(again, block.octets, "{file}");
            if file.starts_with("psr3d") {
                assert!(records.iter().all(|record| record.height_3d.is_some()), "{file}");
                assert!(records.iter().any(|record| record.fspec_padding > 0), "{file}");
            }
            count += records.len();
        }
        assert_eq!(count, expected, "{file}");
    }
}

#[test]
fn damaged_datagrams_are_counted_by_reason() {
    let Some(folder) = shared_data() else { return };
    let pcap = std::fs::read(folder.join("conformance/hostile/capture.pcap")).unwrap();
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    let mut recent: std::collections::HashMap<&[u8], u64> = std::collections::HashMap::new();
    for (received_us, datagram) in common::datagrams(&pcap) {
        // A copy of a datagram within 2 s came over a redundant line and is not counted again.
        if recent.get(datagram).is_some_and(|handled| received_us - handled <= 2_000_000) {
            continue;
        }
        recent.insert(datagram, received_us);
        for block in blocks(datagram) {
            let fault = match block {
                Ok(block) if block.category == 48 => common::read_block::<cat048::Record>(&block).1,
                Ok(block) if block.category == 129 => common::read_block::<asterix::cat129::Record>(&block).1,
                Ok(block) if block.category == 34 => block.measure(&asterix::cat034::UAP).err(),
                Ok(_) => None,
                Err(fault) => Some(fault),
            };
            if let Some(fault) = fault {
                *kinds.entry(fault.kind.name()).or_default() += 1;
            }
        }
    }
    // As an independent decoder counts them.
    let expected = [
        (FaultKind::BlockTooShort, 9),
        (FaultKind::BlockPastEnd, 33),
        (FaultKind::FspecPastEnd, 3),
        (FaultKind::ItemPastEnd, 3),
        (FaultKind::PrimarySubfieldExtended, 1),
        (FaultKind::NoRepetitionCount, 1),
    ];
    assert_eq!(kinds, expected.map(|(kind, count)| (kind.name(), count)).into());
}
