//! Speed of decoding and encoding, compared with a hand-written parser.
//!
//! `thrpt: 5 Melem/s` is five million records per second on one core. CAT048 is an hour of a real radar if
//! `UTM_FUSION_SHARED_DATA` names the folder of recordings, otherwise the demonstration flight.

#![allow(missing_docs, reason = "criterion's macro makes public items")]
#![allow(clippy::unwrap_used, reason = "a benchmark that meets the unexpected fails")]

use std::hint::black_box;
use std::path::Path;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use utm_asterix::cat129::{self, Altitude, GnssAccuracy, HorizontalVelocity, Position, VerticalVelocity};
use utm_asterix::{DataSource, Profile, Record, TimeOfDay, blocks, cat048, encode_block};

#[path = "../tests/common/mod.rs"]
mod common;
mod slice;

fn cat048(criterion: &mut Criterion) {
    let octets = recording();
    let records = decoded::<cat048::Record>(&octets);
    println!("cat048: {} records of {} octets", records.len(), octets.len());
    let mut group = criterion.benchmark_group("cat048");
    group.throughput(Throughput::Elements(records.len() as u64));
    group.bench_function("decode", |bencher| bencher.iter(|| decode::<cat048::Record>(&octets)));
    group.bench_function("slice", |bencher| bencher.iter(|| parse(&octets)));
    group.bench_function("measure", |bencher| bencher.iter(|| measure(&octets, cat048::UAP)));
    encode(&mut group, &records);
    group.finish();
}

fn cat129(criterion: &mut Criterion) {
    let mut octets = Vec::new();
    for count in 0..10_000 {
        // One record per block.
        encode_block(&[uas(count)], &mut octets).unwrap();
    }
    let records = decoded::<cat129::Record>(&octets);
    let mut group = criterion.benchmark_group("cat129");
    group.throughput(Throughput::Elements(records.len() as u64));
    group.bench_function("decode", |bencher| bencher.iter(|| decode::<cat129::Record>(&octets)));
    encode(&mut group, &records);
    group.finish();
}

/// Decodes all records, with their places and faults.
fn decode<R: Record<Edition: Default>>(octets: &[u8]) {
    for block in blocks(octets) {
        for located in block.unwrap().records_in::<R>(R::Edition::default()) {
            black_box(&located);
        }
    }
}

/// Parses all records with the hand-written parser.
fn parse(octets: &[u8]) {
    for block in blocks(octets) {
        let mut rest = block.unwrap().contents();
        while !rest.is_empty() {
            let parsed = slice::Record::parse(rest);
            black_box(&parsed);
            rest = &rest[parsed.unwrap().1..];
        }
    }
}

/// Finds only the ends of records, by the profile.
fn measure(octets: &[u8], profile: &Profile) {
    for block in blocks(octets) {
        black_box(block.unwrap().measure(profile).unwrap());
    }
}

fn encode<R: Record>(group: &mut BenchmarkGroup<'_, WallTime>, records: &[R]) {
    let mut out = Vec::new();
    group.bench_function("encode", |bencher| {
        bencher.iter(|| {
            out.clear();
            for record in records {
                record.encode_into(&mut out);
            }
            black_box(&out);
        });
    });
}

fn decoded<R: Record<Edition: Default>>(octets: &[u8]) -> Vec<R> {
    let records = blocks(octets).flat_map(|block| block.unwrap().records_in(R::Edition::default()));
    records.map(|located| located.unwrap().record).collect()
}

/// Valid blocks of CAT048.
fn recording() -> Vec<u8> {
    if let Some(folder) = std::env::var_os("UTM_FUSION_SHARED_DATA") {
        return std::fs::read(Path::new(&folder).join("cat048-barcelona/capture.ast")).unwrap();
    }
    eprintln!("UTM_FUSION_SHARED_DATA names no folder of recordings: the demonstration flight stands in");
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../testdata/demo/capture.pcap");
    common::recordings::datagrams(&std::fs::read(demo).unwrap())
        .into_iter()
        .flat_map(|(_, datagram)| blocks(datagram).flatten())
        .filter(|block| block.category == cat048::Record::CATEGORY)
        .filter(|block| block.records::<cat048::Record>().all(|located| located.is_ok()))
        .flat_map(|block| block.octets.to_vec())
        .collect()
}

/// The report of a drone after `count` seconds.
fn uas(count: u32) -> cat129::Record {
    let along = f64::from(count);
    cat129::Record {
        data_source: Some(DataSource { sac: 25, sic: 7 }),
        manufacturer: Some(*b"AIR"),
        model: Some(*b"DIT"),
        serial_number: Some(*b"123456784095"),
        registration_country: Some(*b"FR"),
        time_of_day: TimeOfDay::from_seconds(43_200.0 + along),
        position: Position::new(48.8566 + along * 1e-5, 2.3522 - along * 1e-5),
        altitude_amsl: Altitude::from_metres(123.4 + along / 10.0),
        altitude_agl: Altitude::from_metres(45.6 + along / 10.0),
        gnss_accuracy: GnssAccuracy::from_metres(3.0),
        horizontal_velocity: HorizontalVelocity::new(3.0, -1.5),
        vertical_velocity: VerticalVelocity::new(0.1),
        ..cat129::Record::default()
    }
}

criterion_group!(benches, cat048, cat129);
criterion_main!(benches);
