//! How fast records become lines of JSON and lines become records.
//!
//! `thrpt: 1 Melem/s` is a million records a second, on one core. CAT048 is an hour of a real radar where
//! `UTM_FUSION_SHARED_DATA` names the folder of recordings, and otherwise the demonstration flight.

#![allow(missing_docs, reason = "criterion's macro makes public items")]
#![allow(clippy::unwrap_used, reason = "a benchmark that meets the unexpected fails")]

use std::hint::black_box;
use std::path::Path;

use asterix::{blocks, cat048};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use utm_fusion::capture::{Capture, CapturedDatagram};
use utm_fusion::json::{Encoder, Entry, Place, write_record};

/// The datagrams of the recording.
fn recording() -> Vec<CapturedDatagram> {
    let path = match std::env::var_os("UTM_FUSION_SHARED_DATA") {
        Some(folder) => Path::new(&folder).join("cat048-barcelona/capture.ast"),
        None => {
            eprintln!(
                "UTM_FUSION_SHARED_DATA names no folder of recordings: the demonstration flight stands in"
            );
            Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo/capture.pcap")
        }
    };
    Capture::open(&path).unwrap().map(Result::unwrap).collect()
}

/// Decodes every CAT048 record and appends its line.
fn decode(datagrams: &[CapturedDatagram], out: &mut Vec<u8>) -> u64 {
    let mut records = 0;
    for CapturedDatagram { payload, origin, .. } in datagrams {
        for block in blocks(payload).flatten().filter(|block| block.category == 48) {
            for located in block.records::<cat048::Record>().flatten() {
                let octets = &payload[located.offset..located.offset + located.length];
                let place = Place {
                    input: None,
                    offset: origin + located.offset as u64,
                    block: origin + block.offset as u64,
                };
                write_record(out, &Entry::typed(&located.record, (), octets, place, None), false);
                records += 1;
            }
        }
    }
    records
}

fn lines(criterion: &mut Criterion) {
    let datagrams = recording();
    let mut out = Vec::new();
    let records = decode(&datagrams, &mut out);
    println!("lines: {records} records, {} octets of JSON", out.len());
    let text = String::from_utf8(out.clone()).unwrap();
    let mut group = criterion.benchmark_group("ndjson");
    group.throughput(Throughput::Elements(records));
    group.bench_function("decode", |bencher| {
        bencher.iter(|| {
            out.clear();
            decode(&datagrams, &mut out);
            black_box(&out);
        });
    });
    group.bench_function("encode", |bencher| {
        bencher.iter(|| {
            out.clear();
            let mut encoder = Encoder::default();
            for line in text.lines() {
                encoder.line(line, &mut out).unwrap();
            }
            encoder.finish(&mut out);
            black_box(&out);
        });
    });
    group.finish();
}

criterion_group!(benches, lines);
criterion_main!(benches);
