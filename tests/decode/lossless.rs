//! Lossless decoding: `decode` prints everything that was read, and `encode` restores the same octets.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use asterix::{Record, cat034, cat048, cat065, cat129};
use proptest::prelude::*;
use utm_fusion::commands::{Outcome, decode, encode};
use utm_fusion::json::{Encoder, Entry, Named, Place, write_record};

use super::{Temporary, block, octets};

pub(super) const CAT034: &str = "fffe 1907 02 48b720 40 0200 9c a2 60 50 4080 9c 5a d4 20 30 02 2fff 0801 0100020040008000 03 \
    0069255555d55555 ff80 02aa 02bb";
pub(super) const CAT048: &str = "ffffffff00 19c8 48b720 a17fd1973ba71542 00e118e0 0804 3ffb fe18040b1cf60afd 4a08eb 48f534c75820 \
    02 01020304050607 40 00000000000000 05 0783 0100ff80 4000 8000 a79b0142 01020304 27 10 0fff 0102030f 0014 \
    c0 83fe 01 000100020003 20fd 30010203040506 5f 0abc 1e 0def 03aabb 10 ac 80a2 0730 000100 2180 32c0010100";
pub(super) const CAT065: &str = "ff06 1907 01 03 48b720 02 7a 10 02aa 02bb";
pub(super) const CAT129: &str = "ffff80 1907 2009 414952 444954 313233343536373834303935 4652 546040 115f094b 00d61a3c 0004d2 \
    0001c8 0003 a90102 16554601 01 0000002a 0783 ffffffff 0064 ffff a1 7f 00 0012cfff6a 0fff1f";

/// Every record that differs from this one in at most one bit prints differently, and is restored.
fn each_flip_shows<R: Record<Edition: Default + Named>>(hex: &str) {
    let octets = octets(hex);
    let mut lines: HashMap<Vec<u8>, Vec<u8>> = HashMap::new();
    let mut read = 0;
    for bit in 0..=octets.len() * 8 {
        let mut flipped = octets.clone();
        if let Some(octet) = flipped.get_mut(bit / 8) {
            *octet ^= 0x80 >> (bit % 8);
        }
        let Ok((record, length)) = R::decode(&flipped, R::Edition::default()) else { continue };
        read += 1;
        flipped.truncate(length);
        let mut line = Vec::new();
        let place = Place { input: None, offset: 3, block: 0 };
        let entry = Entry::typed(&record, R::Edition::default(), &flipped, place, None);
        write_record(&mut line, &entry, false);
        let (mut encoder, mut again) = (Encoder::default(), Vec::new());
        encoder.line(std::str::from_utf8(&line).unwrap(), &mut again).unwrap();
        encoder.finish(&mut again);
        assert_eq!(again[0], R::CATEGORY);
        assert_eq!(again[3..], flipped, "{}", String::from_utf8_lossy(&line));
        if let Some(other) = lines.insert(line, flipped.clone()) {
            assert_eq!(other, flipped);
        }
    }
    assert!(read > octets.len() * 4, "{read} of {} flips could be read", octets.len() * 8);
}

#[test]
fn each_bit_of_a_record_shows_and_comes_back() {
    each_flip_shows::<cat034::Record>(CAT034);
    each_flip_shows::<cat048::Record>(CAT048);
    each_flip_shows::<cat065::Record>(CAT065);
    each_flip_shows::<cat129::Record>(CAT129);
    each_flip_shows::<cat129::Record>(&CAT129.replace("a90102", "a9").replace("ffff80", "ffff8100"));
}

/// The result of `decode` followed by `encode` for a file.
pub fn there_and_back(file: &Path) -> Vec<u8> {
    let mut lines = Vec::new();
    decode::run(&decode::Args { inputs: vec![file.to_owned()], ..decode::Args::default() }, &mut lines)
        .unwrap();
    let input = Temporary::new("lines", &lines);
    let output = Temporary::new("again", &[]);
    let args = encode::Args { input: input.0.clone(), output: output.0.clone(), ..encode::Args::default() };
    assert_eq!(encode::run(&args).unwrap(), Outcome::Done);
    fs::read(&output.0).unwrap()
}

/// Blocks of all categories, known and unknown, and one without a record.
fn feed() -> Vec<u8> {
    [
        block(34, &[CAT034, CAT034]),
        block(48, &[CAT048]),
        block(48, &["80 0101", "80 0102"]),
        block(61, &["0102"]),
        block(65, &[CAT065]),
        block(129, &[CAT129]),
        block(48, &[]),
    ]
    .concat()
}

#[test]
fn a_file_of_all_categories_comes_back() {
    assert_eq!(there_and_back(&Temporary::new("feed", &feed()).0), feed());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    /// Any damage after the first blocks, which remain intact so that the format is still recognised.
    #[test]
    fn a_damaged_file_comes_back(
        damage in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4_u8), 1..6),
    ) {
        let (first, mut rest) = (block(48, &["80 0101"]).repeat(4), feed());
        for (index, octet, how) in damage {
            let at = index.index(rest.len());
            match how {
                0 => rest[at] = octet,
                1 => rest[at] ^= 1 << (octet % 8),
                2 => rest.insert(at, octet),
                _ => {
                    rest.remove(at);
                }
            }
        }
        let file = [first, rest].concat();
        prop_assert_eq!(there_and_back(&Temporary::new("damaged", &file).0), file);
    }

    /// Octets lost, added or zeroed, gaps of any size, and truncated files.
    #[test]
    fn a_file_with_holes_comes_back(
        holes in proptest::collection::vec((any::<prop::sample::Index>(), 1..3_usize, 0..100_000_usize), 1..4),
        cut in any::<prop::sample::Index>(),
    ) {
        let first = block(48, &["80 0101"]).repeat(4);
        let mut rest = feed().repeat(20);
        for (index, how, length) in holes {
            let at = index.index(rest.len());
            match how {
                1 => {
                    rest.splice(at..at, std::iter::repeat_n(0, length));
                }
                _ => {
                    rest.drain(at..(at + length % 17).min(rest.len()));
                }
            }
        }
        rest.truncate(cut.index(rest.len() + 1));
        let file = [first, rest].concat();
        prop_assert!(there_and_back(&Temporary::new("holes", &file).0) == file);
    }
}

/// The example of the README: `decode | encode` of a capture with hostile datagrams gives a raw file from which each record can
/// be read again.
#[test]
fn records_of_a_capture_are_read_again_from_its_raw_file() {
    let capture = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo/capture.pcap");
    let records = |file: &Path| {
        let mut lines = Vec::new();
        decode::run(&decode::Args { inputs: vec![file.to_owned()], ..decode::Args::default() }, &mut lines)
            .unwrap();
        let lines = String::from_utf8(lines).unwrap();
        let items = |line: &str| line.split_once(r#","items":"#).map(|(_, items)| items.to_owned());
        lines.lines().filter_map(items).collect::<Vec<_>>()
    };
    let wanted = records(&capture);
    let again = records(&Temporary::new("raw", &there_and_back(&capture)).0);
    assert_eq!(wanted.len(), 1341);
    let mut left = wanted.iter();
    // In the same order; octets that could not be read may resemble a further record.
    let found = again
        .iter()
        .filter(|record| left.as_slice().first() == Some(record) && left.next().is_some())
        .count();
    assert_eq!(found, wanted.len());
}
