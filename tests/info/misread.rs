//! Sources in an unusual edition, and the truncated times of old radars.

use std::fs;

use serde_json::{Value, json as value};

use super::{Temporary, block, info, json, shared};

/// A CAT021 record of an edition before 1.0: I021/010, 040, 030, 130 of 32 bits each, 080.
const OLD: &str = "f8 19c9 0040 5a0000 ffffffff ffffffff 3c6444";

fn text(name: &str, octets: &[u8]) -> String {
    let file = Temporary::new(name, octets);
    info(&[&file.0], false, false).0
}

#[test]
fn old_cat021_is_named_with_the_editions_that_read_it() {
    let octets = block(21, &[OLD.to_owned()]).repeat(5);
    let found = json("old-021", &octets);
    assert_eq!(
        found["misread"][0],
        value!({
            "category": 21, "sac": 25, "sic": 201, "blocks": 5, "misread": 5, "read_in": ["0.24", "0.25", "0.26"],
            "known": ["0.23", "0.24", "0.25", "0.26", "2.1", "2.2", "2.3", "2.4", "2.5", "2.6", "2.7"],
        })
    );
    assert_eq!(found.get("editions"), None, "none of 2.1 to 2.7 is named beside it");
    let text = text("old-021-text", &octets);
    let line = "CAT021 of 25/201: 5 of 5 blocks misread; editions 0.24 to 0.26 fit: decode --edition 21:0.26";
    assert!(text.contains(line), "{text}");
}

#[test]
fn category_that_no_edition_reads_is_named_as_unknown() {
    // An FSPEC with more octets than in any edition of CAT062.
    let octets = block(62, &["ffffffffff80 19c9 0102".to_owned()]).repeat(4);
    let text = text("old-062", &octets);
    let line = "no edition from 1.16 to 1.21 fits: perhaps one before 1.16, or another format";
    assert!(text.contains(line), "{text}");
}

#[test]
fn few_damaged_blocks_say_nothing_of_editions() {
    let good = block(48, &[super::plot(7, 36_000.0, 1)]);
    let bad = block(48, &["ffffffff80 1907".to_owned()]);
    let found = json("damaged", &[good.repeat(5), bad.repeat(4)].concat());
    assert_eq!(found.get("misread"), None);
}

#[test]
fn truncated_time_of_cat001_is_completed_by_cat002() {
    // I001/010, 020 of a track, 141; I002/010, 000, 020, 030 at 12:43:46.179.
    let report = |truncated: u16| block(1, &[format!("c140 19c9 80 {truncated:04x}")]);
    let service = block(2, &["f0 19c9 02 50 598117".to_owned()]);
    let found = json("truncated", &[report(0x7f00), service, report(0x800d), report(0x8200)].concat());
    let of = |category: u8| {
        let sources = found["sources"].as_array().unwrap();
        sources.iter().find(|source| source["category"] == category).unwrap().clone()
    };
    let reports = of(1);
    assert_eq!((&reports["records"], &reports["without_time"]), (&value!(3), &value!(1)));
    let times: Vec<&Value> = ["first", "last"].iter().map(|key| &reports[*key]).collect();
    assert_eq!(times, ["12:43:44.101", "12:43:48.000"]);
}

#[test]
fn field_case_framings_and_editions_are_named() {
    let Some(folder) = shared::recordings().map(|data| data.join("field-cases/52-croatia-gps")) else {
        return;
    };
    let of = |name: &str| text(name, &fs::read(folder.join(name)).unwrap());
    let cases = [
        ("parsegps.gps", "15 blocks with 663 octets"),
        ("body.ast", "15 blocks with 663 octets"),
        ("cat_001_002.pcap", "187 octets"),
        ("asterix.pcap", "no edition from 1.16 to 1.21 fits"),
    ];
    for (name, expected) in cases {
        let text = of(name);
        assert!(text.contains(expected), "{name}: {text}");
        assert!(name == "asterix.pcap" || text.contains("no errors"), "{name}: {text}");
    }
    assert!(of("parsegps.gps").contains("GPS recording"));
}
