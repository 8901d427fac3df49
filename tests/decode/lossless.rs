//! Nothing is lost: records that differ in one bit print differently.

use std::collections::HashMap;

use asterix::{cat048, cat129};
use utm_fusion::json::{Place, Record, RecordLine};

use super::octets;

/// Every record that differs in at most one bit from this one: its octets by its line.
fn each_flip_shows<R: Record>(octets: &[u8]) {
    let mut lines: HashMap<String, Vec<u8>> = HashMap::new();
    let mut read = 0;
    for bit in 0..=octets.len() * 8 {
        let mut flipped = octets.to_vec();
        if let Some(octet) = flipped.get_mut(bit / 8) {
            *octet ^= 0x80 >> (bit % 8);
        }
        let Ok((record, length)) = R::decode(&flipped) else { continue };
        read += 1;
        flipped.truncate(length);
        let place = Place { input: None, offset: 0, block: 0 };
        let line = serde_json::to_string(&RecordLine::new(&record, place, None, None)).unwrap();
        if let Some(other) = lines.insert(line.clone(), flipped.clone()) {
            assert_eq!(other, flipped, "{line}");
        }
    }
    assert!(read > octets.len() * 4, "{read} of {} flips could be read", octets.len() * 8);
}

#[test]
fn each_bit_of_a_record_shows() {
    each_flip_shows::<cat048::Record>(&octets(
        "ffffffff00 19c8 48b720 a17fd1973ba71542 00e118e0 0804 3ffb e0050203 4a08eb 48f534c75820 \
        01 01020304050607 40 0783 11223344 4000 8000 a79b0142 01020304 27 10 0fff 0102030f \
        0014 80 0102 00c1 01020304050607 1f 0abc 1e 0def 03aabb 02cc",
    ));
    let start =
        "1907 2009 414952 444954 313233343536373834303935 4652 546040 115f094b 00d61a3c 0004d2 0001c8 0003";
    let end = "16554601 01 0000002a 0783 ffffffff 0064 ffff a1 7f 00 0012cfff6a 0fff1f";
    for risk in ["a9", "a90102"] {
        each_flip_shows::<cat129::Record>(&octets(&format!("ffff80 {start} {risk} {end}")));
        each_flip_shows::<cat129::Record>(&octets(&format!("ffff8100 {start} {risk} {end}")));
    }
}
