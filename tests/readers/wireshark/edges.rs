//! CAT129 datagrams at the limits of the format, and beyond.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A block of these records.
pub fn block(records: &[u8]) -> Vec<u8> {
    let length = (3 + records.len() as u16).to_be_bytes();
    [&[129], &length[..], records].concat()
}

/// A record of these items, given by field reference number.
fn record(items: &[(u8, &[u8])]) -> Vec<u8> {
    let mut fspec = vec![0_u8; items.iter().map(|(frn, _)| usize::from(frn - 1) / 7 + 1).max().unwrap_or(1)];
    for (frn, _) in items {
        fspec[usize::from(frn - 1) / 7] |= 0x80 >> ((frn - 1) % 7);
    }
    let last = fspec.len() - 1;
    fspec[..last].iter_mut().for_each(|octet| *octet |= 1);
    items.iter().fold(fspec, |record, (_, octets)| [&record, *octets].concat())
}

/// Special purpose field of the service: fused, track 10,007, radar track and transponder 1, 1.2 m and 2.5 m.
const OURS: [u8; 22] =
    [22, b'U', b'F', 1, 1, 0, 0, 0x27, 0x17, 0, 1, 0, 0, 0, 1, 0, 12, 0, 25, 0b0010_1101, 127, 0];

/// A record with every item; I129/120 has one octet or three.
pub fn full(long: bool) -> Vec<u8> {
    let risk: &[u8] = if long { &[0b1010_1001, 0xab, 0xcd] } else { &[0b0101_0011] };
    record(&[
        (1, &[25, 7]),
        (2, &[1, 2]),
        (3, b"ABC"),
        (4, b"X-1"),
        (5, b"SN 0123\"456\\"),
        (6, b"DE"),
        (7, &[0x54, 0x60, 0x40]),
        (8, &[0x13, 0x60, 0xb6, 0x0b, 0xfa, 0xaa, 0xaa, 0xab]),
        (9, &[0x00, 0x04, 0xd2]),
        (10, &[0xff, 0xff, 0xfd]),
        (11, &[0, 3]),
        (12, risk),
        (13, &OURS),
        (14, &[0x00, 0x12, 0xcf, 0xff, 0x6a]),
        (15, &[0x0f, 0xff, 0x1f]),
    ])
}

/// A record with every item, one of them replaced.
fn with(frn: u8, octets: &[u8]) -> Vec<u8> {
    block(&record(&[(1, &[25, 7]), (frn, octets)]))
}

/// The service's special purpose field, with octets replaced from this offset on.
fn ours_with(at: usize, octets: &[u8]) -> Vec<u8> {
    let mut field = OURS;
    field[at..at + octets.len()].copy_from_slice(octets);
    with(13, &field)
}

/// All cases, one datagram each.
pub fn all() -> Vec<Vec<u8>> {
    let source = record(&[(1, &[0, 255])]);
    let mut datagrams = vec![
        block(&full(false)),
        block(&full(true)),
        block(&record(&[])),
        block(&[]),
        // Minimum and maximum values.
        with(7, &[0; 3]),
        with(7, &[0xa8, 0xbf, 0xff]),
        with(7, &[0xa8, 0xc0, 0]),
        with(7, &[0xff; 3]),
        with(8, &[0x80, 0, 0, 0, 0x7f, 0xff, 0xff, 0xff]),
        with(8, &[0x20, 0, 0, 0, 0xc0, 0, 0, 0]),
        // Halfway between two numbers of eight decimals, on either side of 0.
        with(8, &[0, 8, 0, 0, 0xff, 0xf8, 0, 0]),
        with(9, &[0x80, 0, 0]),
        with(10, &[0x7f, 0xff, 0xff]),
        with(11, &[0, 0]),
        with(11, &[0xff, 0xff]),
        with(12, &[0]),
        with(12, &[0xff]),
        with(12, &[0xff, 0, 0xff]),
        with(14, &[0x80, 0, 0x07, 0xff, 0xff]),
        with(14, &[0x7f, 0xff, 0xf8, 0, 0]),
        with(15, &[0x08, 0, 0]),
        with(15, &[0xf7, 0xff, 0xff]),
        // Octets that are not texts.
        with(3, &[0, 0, 0]),
        with(4, b"\xc3\xa9 "),
        with(5, b"<&\"'>~ \x7f\x1f\x80\xff\0"),
        with(6, b"  "),
        // Special purpose fields of other systems, of another version, and with limits of the service's own.
        with(13, &[1]),
        with(13, &[4, 1, 2, 3]),
        with(13, &[22, b'U', b'F', 2, 1, 0, 0, 0, 9, 0, 1, 0, 0, 0, 1, 0, 12, 0, 25, 0, 127, 0]),
        with(13, &[4, b'U', b'F', 1]),
        ours_with(4, &[7]),
        ours_with(5, &[0xff; 16]),
        ours_with(5, &[0; 17]),
        ours_with(20, &[254, 0xff]),
        // With a complete serial number after it, and only a serial number.
        with(13, &[&[42, b'U', b'F', 2], &OURS[4..], &b"1581F4FKD2291000A4  "[..]].concat()),
        with(13, &[&[24, b'U', b'F', 3][..], b"1581F4FKD2291000A4B2"].concat()),
        // FSPECs that are longer than necessary.
        block(&[0x81, 0x00, 25, 7]),
        block(&[0x81, 1, 1, 1, 1, 1, 1, 0, 25, 7]),
        block(&[0x81, 1, 1, 1, 1, 1, 1, 1, 0, 25, 7]),
        block(&[0x81, 1, 1, 1, 1, 1, 1, 1, 0x80, 25, 7]),
        block(&[0x81, 1, 1]),
        block(&[1; 9]),
        // Undefined items.
        block(&[0x81, 1, 0x40, 25, 7]),
        block(&[0x81, 1, 1, 1, 1, 1, 1, 2, 25, 7]),
        // Several records, several blocks.
        block(&[full(false), source.clone(), full(false)].concat()),
        block(&[source.clone(), full(true)].concat()),
        [block(&source), block(&full(true)), block(&source)].concat(),
        [block(&source), with(13, &[0]), block(&source)].concat(),
        [with(13, &[200, 1]), block(&[full(false), vec![0x80, 1]].concat())].concat(),
        // Invalid blocks.
        vec![129, 0, 2],
        [block(&source), vec![129, 0, 99, 0x80]].concat(),
        [block(&source), vec![129]].concat(),
        [block(&full(false)), vec![129, 0]].concat(),
    ];
    // Cut off at every octet.
    for long in [false, true] {
        let full = full(long);
        datagrams.extend((1..full.len()).map(|length| block(&full[..length])));
    }
    // Records with every item, with random octets replaced.
    let mut random = ChaCha8Rng::seed_from_u64(129);
    for _ in 0..400 {
        let mut record = full(random.random());
        for _ in 0..random.random_range(1..6) {
            let at = random.random_range(0..record.len());
            record[at] = random.next_u32() as u8;
        }
        datagrams.push(block(&record));
    }
    datagrams
}
