//! Decoding and encoding a record allocates only for unusually long items.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use allocation_counter::measure;
use common::{EXPANSION, VECTORS, encode, hex};
use utm_asterix::cat048::BdsRegister;
use utm_asterix::{
    Explicit, Record, Repeated, blocks, cat015, cat021, cat034, cat048, cat062, cat063, cat065, cat129,
    encode_block,
};

/// The number of allocations while the records of these blocks are decoded, the number of records, and the number of allocations
/// while each record is encoded into a vector with enough capacity.
fn count(octets: &[u8]) -> (u64, usize, u64) {
    fn of<R: Record<Edition: Default>>(
        block: &utm_asterix::Block<'_>,
        out: &mut Vec<u8>,
    ) -> (u64, usize, u64) {
        let (mut read, mut records, mut written) = (0, 0, 0);
        let mut walk = block.records_in::<R>(R::Edition::default());
        loop {
            let mut next = None;
            read += measure(|| next = walk.next()).count_total;
            let Some(located) = next else { return (read, records, written) };
            let record = located.unwrap().record;
            out.clear();
            written += measure(|| record.encode_into(out)).count_total;
            records += 1;
        }
    }
    let mut out = Vec::with_capacity(1 << 16);
    let mut sum = (0, 0, 0);
    let mut walk = blocks(octets);
    loop {
        let mut next = None;
        sum.0 += measure(|| next = walk.next()).count_total;
        let Some(block) = next else { return sum };
        let block = block.unwrap();
        let (read, records, written) = match block.category {
            15 => of::<cat015::Record>(&block, &mut out),
            21 => of::<cat021::Record>(&block, &mut out),
            34 => of::<cat034::Record>(&block, &mut out),
            48 => of::<cat048::Record>(&block, &mut out),
            62 => of::<cat062::Record>(&block, &mut out),
            63 => of::<cat063::Record>(&block, &mut out),
            65 => of::<cat065::Record>(&block, &mut out),
            129 => of::<cat129::Record>(&block, &mut out),
            other => panic!("category {other}"),
        };
        sum = (sum.0 + read, sum.1 + records, sum.2 + written);
    }
}

/// A block with a record of these registers and fields.
fn record(registers: usize, special_purpose: usize, reserved_expansion: usize) -> Vec<u8> {
    let contents = |octets| Explicit::new(&vec![7; octets - 1]);
    let record = cat048::Record {
        bds_registers: Repeated::new(&vec![BdsRegister::default(); registers]),
        special_purpose: contents(special_purpose),
        reserved_expansion: contents(reserved_expansion),
        ..cat048::Record::default()
    };
    common::block(48, &encode(&record))
}

#[test]
fn the_counter_counts() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1);
}

#[test]
fn no_record_of_the_vectors_but_the_long_expansion_allocates() {
    for vector in VECTORS {
        let (read, records, written) = count(&hex(vector));
        assert_eq!((read > 0, records, written), (vector == EXPANSION, 1, 0), "{vector}");
    }
}

#[test]
fn four_registers_and_24_octets_of_sp_and_re_are_held_inline() {
    assert_eq!(count(&record(4, 24, 24)), (0, 1, 0));
    assert_eq!(count(&record(5, 24, 24)).0, 1);
    assert_eq!(count(&record(4, 25, 24)).0, 1);
    assert_eq!(count(&record(4, 24, 25)).0, 1);
    // The parts of other repetitive items are stored in the same way.
    let counts = |number: u8| [&[0x01, 0x80, number], vec![9; 2 * usize::from(number)].as_slice()].concat();
    assert_eq!(count(&common::block(34, &counts(4))), (0, 1, 0));
    assert_eq!(count(&common::block(34, &counts(5))).0, 1);
}

#[test]
fn faults_allocate_nothing() {
    for vector in VECTORS.map(hex) {
        let contents = &vector[3..vector.len() - 1];
        let cut = common::block(vector[0], contents);
        let block = blocks(&cut).next().unwrap().unwrap();
        let mut faults = 0;
        let allocations = measure(|| {
            faults = match block.category {
                21 => block
                    .records_in::<cat021::Record>(cat021::Edition::default())
                    .filter(Result::is_err)
                    .count(),
                15 => block.records::<cat015::Record>().filter(Result::is_err).count(),
                34 => block.records::<cat034::Record>().filter(Result::is_err).count(),
                48 => block.records::<cat048::Record>().filter(Result::is_err).count(),
                62 => block.records::<cat062::Record>().filter(Result::is_err).count(),
                63 => block.records::<cat063::Record>().filter(Result::is_err).count(),
                65 => block.records::<cat065::Record>().filter(Result::is_err).count(),
                _ => block.records::<cat129::Record>().filter(Result::is_err).count(),
            };
        });
        assert_eq!(faults, 1);
        // The long expansion field is assembled before its truncation is detected.
        assert_eq!(allocations.count_total > 0, vector == hex(EXPANSION), "{allocations:?}");
    }
}

#[test]
fn a_block_is_written_into_a_vector_with_room() {
    let octets = hex(common::EVERY_ITEM);
    let block = blocks(&octets).next().unwrap().unwrap();
    let records: Vec<cat048::Record> = block.records().map(|located| located.unwrap().record).collect();
    let mut out = Vec::with_capacity(octets.len());
    assert_eq!(measure(|| encode_block(&records, &mut out).unwrap()).count_total, 0);
    assert_eq!(out, octets);
}

#[test]
fn real_records_with_up_to_four_registers_do_not_allocate() {
    let Some(folder) = common::recordings::shared_data() else { return };
    let octets = std::fs::read(folder.join("cat048-barcelona/capture.ast")).unwrap();
    let (mut records, mut long, mut allocating) = (0, 0, 0);
    for block in blocks(&octets) {
        let mut walk = block.unwrap().records::<cat048::Record>();
        loop {
            let mut next = None;
            let allocations = measure(|| next = walk.next()).count_total;
            let Some(located) = next else { break };
            let record = located.unwrap().record;
            let is_long = record.bds_registers.is_some_and(|registers| registers.len() > 4);
            assert_eq!(allocations > 0, is_long, "record {records}");
            records += 1;
            long += usize::from(is_long);
            allocating += usize::from(allocations > 0);
        }
    }
    assert_eq!((records, long, allocating), (44_085, 12, 12));
}
