//! Use of the crate in a program without the standard library, with `core` and `alloc` only. `scripts/no-std` shows that the
//! crate itself needs no more.

#![no_std]
#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

extern crate alloc;

use alloc::string::ToString;
use alloc::vec::Vec;

use utm_asterix::cat021::Edition;
use utm_asterix::cat129::{Altitude, Position, Record};
use utm_asterix::{AnyRecord, DataSource, TimeOfDay, blocks, encode_block};

#[test]
fn a_record_is_built_written_and_read() {
    let source = DataSource { sac: 25, sic: 7 };
    let record =
        Record::builder(source, *b"PL", TimeOfDay::from_seconds(43_200.0), Position::new(54.5, 15.0))
            .altitude_amsl(Altitude::from_metres(120.0))
            .build()
            .unwrap();
    let mut octets = Vec::new();
    encode_block(core::slice::from_ref(&record), &mut octets).unwrap();
    let block = blocks(&octets).next().unwrap().unwrap();
    let read = block.any_records(Edition::default()).unwrap().next().unwrap().unwrap().record;
    assert_eq!(read, AnyRecord::Cat129(record));
    let fault = blocks(&octets[..10]).next().unwrap().unwrap_err();
    assert_eq!(fault.to_string(), "CAT129 at octet 0: the block runs past the end of the datagram");
}
