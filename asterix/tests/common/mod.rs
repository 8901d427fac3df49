//! Helpers of the tests: hand-written octets, and short ways to decode them.
#![allow(dead_code, unreachable_pub, missing_docs, reason = "each test file uses a part of it")]

pub mod recordings;
pub mod strategies;

use utm_asterix::{Block, Fault, Record, blocks, cat034, cat048, encode_block};

/// The octets of a hexadecimal text; white space is ignored.
pub fn hex(text: &str) -> Vec<u8> {
    let digits: Vec<u32> = text.chars().filter_map(|digit| digit.to_digit(16)).collect();
    digits.chunks(2).map(|pair| (pair[0] << 4 | pair[1]) as u8).collect()
}

/// A block with these contents.
pub fn block(category: u8, contents: &[u8]) -> Vec<u8> {
    let length = u16::try_from(contents.len() + 3).unwrap().to_be_bytes();
    [&[category, length[0], length[1]], contents].concat()
}

/// The records of the only block in `octets`, and the fault that ended it.
pub fn read<R: Record<Edition: Default>>(octets: &[u8]) -> (Vec<R>, Option<Fault>) {
    read_in(R::Edition::default(), octets)
}

/// The records of the only block in `octets`, read in an edition, and the fault that ended it.
pub fn read_in<R: Record>(edition: R::Edition, octets: &[u8]) -> (Vec<R>, Option<Fault>) {
    let walked: Vec<Result<Block<'_>, Fault>> = blocks(octets).collect();
    let [Ok(block)] = walked.as_slice() else { panic!("not one block: {walked:?}") };
    assert_eq!(block.category, R::CATEGORY);
    read_block_in(edition, block)
}

/// The records of a block, and the fault that ended it. Checks that the records are contiguous.
pub fn read_block<R: Record<Edition: Default>>(block: &Block<'_>) -> (Vec<R>, Option<Fault>) {
    read_block_in(R::Edition::default(), block)
}

/// The records of a block, read in an edition, and the fault that ended it. Checks that the records are contiguous.
pub fn read_block_in<R: Record>(edition: R::Edition, block: &Block<'_>) -> (Vec<R>, Option<Fault>) {
    let mut next = block.offset + 3;
    let (mut records, mut fault) = (Vec::new(), None);
    for result in block.records_in::<R>(edition) {
        assert_eq!(fault, None, "something came after a fault");
        match result {
            Ok(located) => {
                assert_eq!(located.offset, next);
                next += located.length;
                records.push(located.record);
            }
            Err(found) => fault = Some(found),
        }
    }
    assert!(fault.is_some() || next == block.offset + block.octets.len(), "octets were left over");
    (records, fault)
}

/// Ends of the records in a block of CAT034 or CAT048, relative to its CAT octet.
pub fn record_ends(block: &Block<'_>) -> Vec<usize> {
    fn of<R: Record<Edition: Default>>(block: &Block<'_>) -> Vec<usize> {
        let located =
            block.records_in::<R>(R::Edition::default()).map(|located| located.expect("a whole record"));
        located.map(|located| located.offset + located.length - block.offset).collect()
    }
    match block.category {
        34 => of::<cat034::Record>(block),
        _ => of::<cat048::Record>(block),
    }
}

/// The octets of one record.
pub fn encode(record: &impl Record) -> Vec<u8> {
    let mut out = Vec::new();
    record.encode_into(&mut out);
    out
}

/// Decodes the block, compares it with `record`, and encodes it again.
pub fn check<R: Record<Edition: Default> + PartialEq + std::fmt::Debug>(octets: &str, record: &R) {
    let octets = hex(octets);
    let (records, fault) = read::<R>(&octets);
    assert_eq!(fault, None);
    assert_eq!(records.as_slice(), std::slice::from_ref(record));
    let mut out = Vec::new();
    encode_block(&records, &mut out).unwrap();
    assert_eq!(out, octets);
}

/// A plot of a 3D drone radar: CAT048 with 010, 140, 020, 040, 161, 030, 110 and SP.
pub const DRONE_PLOT: &str = "30 0019 f1114904
    1907 546000 20 0100 4000 0007 2730 3ffe 02fe";

/// Every item of CAT048.
pub const EVERY_ITEM: &str = "30 0073 fffffffe
    1481 384040 e180 30a6ba34 e804 fffb fe1804c9072a0afc
    4a08eb 48f534c75820 02 0011223344556640 0011223344556650 f783 0100ff00 40008000 a740
    01020304 2701fe 0fff 01230456 fffe c0 83fb 01 000a00140bb8 2cf5
    30000000000000 1f 0abc 1f 0fff 03807f 04010203";

/// Every part of the reserved expansion field of CAT048, in a record with 010.
pub const EXPANSION: &str = "30 008f 81010102 1907 86 ff
    fe fe 1234252a 200000e00000 7fd8 8a53 40 2a
    ff80 80 12340805 e00000200000 3fd8 0a53 41 15 1f
    06
    f0 64 00c8 0100 8000
    010000
    fff0 151234 02 0001 0002 32 008040000040010020006000006000a0300050000200
      01 25 83e8 007f429c5e00 c00503e8 01 19070040030009 02 8a
    f0 0102 01 030004 05 20261121
    f8 8a53 4e00 7ffb 3f38 000f4240";

/// Every item of CAT034.
pub const SERVICE_MESSAGE: &str = "22 0036 fffe
    1907 01 546000 40 0200 9c a2 70 a8 5500 9c 5a d4 60 50 02 0805 2fff
    0100020040008000 03 001b200000ff0000 ff80 03aabb 02fe";

/// Every item of CAT065.
pub const SERVICE_STATUS: &str = "41 0013 ff06 1907 01 03 546000 02 96 0a 02aa 02bb";

/// A drone over the Baltic: CAT129 with the mandatory items.
pub const MINIMAL_UAS: &str = "81 0017 87c0 0000 504c 546000 1360b60b 05555555 0004b0";

/// A drone in Paris: CAT129 with all items but 015, 120 and SP.
pub const FULL_UAS: &str =
    "81 0037 bff380 1907 414952 444954 313233343536373834303935 4652 546040 115f094b 00d61a3c
    0004d2 0001c8 0003 0012cfff6a 0fff1f";

/// An output point of the service: CAT129 with 010, 070, 080 and SP.
pub const FUSED_POINT: &str = "81 0028 8384 190a 546000 1360b60b 05555555
    16 5546 01 01 00002717 0007 00000001 0019 ffff 21 7f 00";

/// A light aircraft with 010, 040, 080, 071, 130, 140, 090, 210, 145, 157, 160, 170 and 020.
pub const LIGHT_AIRCRAFT: &str = "15 002c cd117319c0
    1907 0100 546000 2aaaab155555 4a08eb 0400 2114 10 0190 0008 10000000 48f534c75820 01";

/// A track with 010, 070, 105, 100, 185, 040, 080, 290, 130, 510 and 500.
pub const SYSTEM_TRACK: &str = "3e 0036 9f0f110c
    1907 546000 00aaaaab00555555 0000c8ffff38 00c8ff38 002a 1d010180 c00200 0400 010007020008 c000140028fff6";

/// A tracker's report on a sensor: CAT063 with 010, 030, 050 and 060.
pub const SENSOR: &str = "3f 000d b8 1907 546000 0102 4108";

/// A camera's bearing: CAT015 with 010, 000, 020, 145, 161, 170, 627 and 628, angles with their standard deviations.
pub const BEARING: &str = "0f 001b d78101c0 1907 08 0c 546000 002a 02 a0 4000 0123 a0 1555 0123";

/// All of these vectors.
pub const VECTORS: [&str; 12] = [
    DRONE_PLOT,
    EVERY_ITEM,
    EXPANSION,
    SERVICE_MESSAGE,
    SERVICE_STATUS,
    MINIMAL_UAS,
    FULL_UAS,
    FUSED_POINT,
    LIGHT_AIRCRAFT,
    SYSTEM_TRACK,
    SENSOR,
    BEARING,
];
