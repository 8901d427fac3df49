//! Real recordings, which are not part of the project, from the folder that `UTM_FUSION_SHARED_DATA` names.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ffi::OsStr;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use common::recordings::{datagrams, shared_data};
use serde_json::{Value, json};
use utm_asterix::cat021::Edition;
use utm_asterix::cat048::{self, BdsRegister, Capability, PlotCharacteristics};
use utm_asterix::{
    Block, Fault, FaultKind, Record, blocks, cat015, cat021, cat034, cat062, cat063, cat065, cat129,
    encode_block,
};

/// A flag as the independent decoder shows it.
fn bit(flag: bool) -> u8 {
    u8::from(flag)
}

fn plot_characteristics(plot: &PlotCharacteristics) -> Value {
    let mut parts = serde_json::Map::new();
    let mut put = |name: &str, value: Option<Value>| value.map(|value| parts.insert(name.to_owned(), value));
    put("SRL", plot.ssr_run_length.map(|length| json!(length.degrees())));
    put("SRR", plot.ssr_replies.map(|replies| json!(replies.number())));
    put("SAM", plot.ssr_amplitude.map(|amplitude| json!(amplitude.dbm())));
    put("PRL", plot.psr_run_length.map(|length| json!(length.degrees())));
    put("PAM", plot.psr_amplitude.map(|amplitude| json!(amplitude.dbm())));
    put("RPD", plot.range_difference.map(|difference| json!(difference.metres() / 1852.0)));
    put("APD", plot.azimuth_difference.map(|difference| json!(difference.degrees())));
    Value::Object(parts)
}

/// The pulses of low quality, one by one.
fn pulses(low_quality: u16) -> Value {
    let names = ["QA4", "QA2", "QA1", "QB4", "QB2", "QB1", "QC4", "QC2", "QC1", "QD4", "QD2", "QD1"];
    let pulse = |(index, name): (usize, &str)| (name.to_owned(), json!(low_quality >> (11 - index) & 1));
    Value::Object(names.into_iter().enumerate().map(pulse).collect())
}

fn capability(capability: Capability) -> Value {
    json!({
        "COM": capability.communications().code(),
        "STAT": capability.flight_status().code(),
        "SI": bit(capability.is_interrogator_identifier_only()),
        "MSSC": bit(capability.has_specific_services()),
        "ARC": bit(capability.reports_25_ft()),
        "AIC": bit(capability.has_identification()),
        "B1A": bit(capability.bds_10_bit_16()),
        "B1B": capability.bds_10_bits_37_to_40(),
    })
}

/// The items present, in the terms of the independent decoder. All values are multiples of a power of two, also in the
/// specification's units, so they are equal to the last bit.
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
                "SIM": bit(report.is_simulated()),
                "RDP": bit(report.is_chain_2()),
                "SPI": bit(report.is_special_position()),
                "RAB": bit(report.is_field_monitor()),
            }]})
        }),
    );
    put(
        "040",
        record.polar_position.map(|at| json!({"RHO": at.range_m() / 1852.0, "THETA": at.azimuth_deg()})),
    );
    put(
        "070",
        record.mode_3a.map(|code| {
            json!({
                "V": bit(!code.is_validated()),
                "G": bit(code.is_garbled()),
                "L": bit(code.is_not_extracted()),
                "MODE3A": code.to_string(),
            })
        }),
    );
    put(
        "090",
        record.flight_level.map(|level| {
            json!({
                "V": bit(!level.is_validated()),
                "G": bit(level.is_garbled()),
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
    put(
        "200",
        record.track_velocity.map(|at| json!({"GSP": at.speed_m_s() / 1852.0, "HDG": at.heading_deg()})),
    );
    put(
        "170",
        record.track_status.map(|status| {
            json!({"_groups": [{
                "CNF": bit(status.is_tentative()),
                "RAD": status.sensor() as u8,
                "DOU": bit(status.is_doubtful()),
                "MAH": bit(status.is_manoeuvring()),
                "CDM": status.climb_mode() as u8,
            }]})
        }),
    );
    put("130", record.plot_characteristics.as_ref().map(plot_characteristics));
    put(
        "250",
        record.bds_registers.as_ref().map(|registers| {
            let register = |register: &BdsRegister| json!({"MBDATA": register.data(), "BDS1": register.bds1(), "BDS2": register.bds2()});
            registers.iter().map(register).collect()
        }),
    );
    put("080", record.mode_3a_confidence.map(|confidence| pulses(confidence.low_quality())));
    put("230", record.capability.map(capability));
    put("030", record.warnings.as_ref().map(|warnings| json!(warnings.codes().collect::<Vec<_>>())));
    items
}

#[test]
fn an_hour_of_a_terminal_radar_equals_an_independent_decode() {
    let Some(folder) = shared_data() else { return };
    let folder = folder.join("cat048-barcelona");
    let octets = std::fs::read(folder.join("capture.ast")).unwrap();
    let packed = std::fs::read(folder.join("decoded.ndjson.gz")).unwrap();
    let mut expected = BufReader::new(flate2::read::GzDecoder::new(packed.as_slice())).lines();

    let mut occurring = BTreeSet::new();
    let (mut count, mut again) = (0, Vec::with_capacity(octets.len()));
    for block in blocks(&octets) {
        let block = block.unwrap();
        assert_eq!(block.category, cat048::Record::CATEGORY);
        let records: Vec<cat048::Record> = block.records().map(|located| located.unwrap().record).collect();
        encode_block(&records, &mut again).unwrap();
        for record in &records {
            let line: Value = serde_json::from_str(&expected.next().unwrap().unwrap()).unwrap();
            let theirs = line["items"].as_object().unwrap();
            let ours = typed_items(record);
            assert_eq!(theirs.len(), ours.len(), "record {count}");
            for (item, value) in ours {
                assert_eq!(theirs.get(item), Some(&value), "I048/{item} of record {count}");
                occurring.insert(item);
            }
            count += 1;
        }
    }
    assert_eq!(count, 44_085);
    let expected_items = [
        "010", "020", "030", "040", "070", "080", "090", "130", "140", "161", "170", "200", "220", "230",
        "240", "250",
    ];
    assert_eq!(occurring, expected_items.into());
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

/// The number of records in the block, and its fault. A block without a fault encodes to its octets.
fn round_trip(block: &Block<'_>, edition: Edition) -> (usize, Option<Fault>) {
    fn of<R: Record>(block: &Block<'_>, edition: R::Edition) -> (usize, Option<Fault>) {
        let (records, fault) = common::read_block_in::<R>(edition, block);
        let mut again = Vec::new();
        encode_block(&records, &mut again).unwrap();
        assert!(block.contents().starts_with(&again[3..]));
        assert!(fault.is_some() || again == block.octets);
        assert_eq!(block.measure(R::profile(edition)), fault.map_or(Ok(records.len()), Err));
        (records.len(), fault)
    }
    match block.category {
        15 => of::<cat015::Record>(block, ()),
        21 => of::<cat021::Record>(block, edition),
        34 => of::<cat034::Record>(block, ()),
        48 => of::<cat048::Record>(block, ()),
        62 => of::<cat062::Record>(block, ()),
        63 => of::<cat063::Record>(block, ()),
        65 => of::<cat065::Record>(block, ()),
        129 => of::<cat129::Record>(block, ()),
        _ => (0, None),
    }
}

/// The files in a folder and its subfolders.
fn files(folder: &Path) -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                // Wi-Fi and Bluetooth frames hold no UDP datagrams; field cases are damaged or framed differently.
                true if path.ends_with("remote-id-radio") || path.ends_with("field-cases") => {}
                true => folders.push(path),
                false => found.push(path),
            }
        }
    }
    found
}

#[test]
fn every_capture_comes_back_octet_by_octet() {
    let Some(folder) = shared_data() else { return };
    let mut records: BTreeMap<u8, usize> = BTreeMap::new();
    let mut captures = 0;
    for path in files(&folder) {
        let octets = std::fs::read(&path).unwrap();
        let datagrams = match path.extension().and_then(OsStr::to_str) {
            Some("ast" | "raw" | "bin") => vec![octets.as_slice()],
            Some("pcap") => datagrams(&octets).into_iter().map(|(_, datagram)| datagram).collect(),
            _ => continue,
        };
        captures += 1;
        let named = |name: &&str| path.to_string_lossy().contains(name);
        // The second one has six octets of its recorder before each datagram; the third is older than any edition.
        let hostile = ["hostile", "croatia_cat001_cat002", "croatia_cat062_100datagrams"].iter().any(named);
        let is_old = ["cat021-barcelona", "cat021ed2.1"].iter().any(named);
        let edition = if is_old { Edition::V2_1 } else { Edition::default() };
        for datagram in datagrams {
            for block in blocks(datagram) {
                match block {
                    Ok(block) => {
                        let (count, fault) = round_trip(&block, edition);
                        *records.entry(block.category).or_default() += count;
                        assert!(hostile || fault.is_none(), "{}: {fault:?}", path.display());
                    }
                    Err(fault) => assert!(hostile, "{}: {fault}", path.display()),
                }
            }
        }
    }
    eprintln!("{captures} captures, records by category: {records:?}");
    assert!(captures >= 21);
    assert!(records[&21] >= 3782 && records[&62] >= 11_081 && records[&63] >= 2882, "{records:?}");
    assert!(records[&34] >= 34 && records[&48] >= 44_085 + 128 && records[&129] >= 1000, "{records:?}");
}

#[test]
fn damaged_datagrams_are_counted_by_reason() {
    let Some(folder) = shared_data() else { return };
    let pcap = std::fs::read(folder.join("conformance/hostile/capture.pcap")).unwrap();
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    let mut recent: HashMap<&[u8], u64> = HashMap::new();
    for (received_us, datagram) in datagrams(&pcap) {
        // A copy of a datagram within 2 s came over a redundant line and is not counted.
        if recent.get(datagram).is_some_and(|handled| received_us - handled <= 2_000_000) {
            continue;
        }
        recent.insert(datagram, received_us);
        for block in blocks(datagram) {
            let is_new = |block: &Block<'_>| [21, 62, 63].contains(&block.category);
            let fault = match block {
                // The other decoder was not asked for these.
                Ok(block) if is_new(&block) => None,
                Ok(block) => round_trip(&block, Edition::default()).1,
                Err(fault) => Some(fault),
            };
            if let Some(fault) = fault {
                *kinds.entry(fault.kind.name()).or_default() += 1;
            }
        }
    }
    // The counts of an independent decoder.
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
