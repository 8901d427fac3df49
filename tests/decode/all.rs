//! Categories and editions without typed records: lines, tables, `--edition`, and lossless decoding.

use std::process::{Command, Output};

use asterix::all::{Category, Definition, categories};
use asterix::{Block, Record, cat129};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use strategies::record_octets;
use utm_fusion::json::{Encoder, Entry, Place, needs_untyped, write_record};

use super::{Temporary, block};

#[path = "../../asterix/tests/common/strategies.rs"]
#[allow(dead_code, unreachable_pub, reason = "a part of it is used here")]
mod strategies;

/// Number of random records per edition.
const RECORDS: usize = 12;

/// Every edition with every reserved expansion field, newest last.
fn definitions() -> Vec<&'static Definition> {
    let editions = |category: &'static Category| {
        category.editions().iter().flat_map(move |edition| {
            let expansions =
                category.expansions().iter().map(move |expansion| format!("{edition}/{expansion}"));
            expansions.chain([(*edition).to_owned()]).map(|edition| category.edition(&edition).unwrap())
        })
    };
    categories().flat_map(editions).collect()
}

/// The line of a record, and the result of `encode` for it.
fn there_and_back(definition: &'static Definition, octets: &[u8]) -> (String, Vec<u8>) {
    let record = definition.record(octets).unwrap();
    let mut line = Vec::new();
    let place = Place { input: None, offset: 3, block: 0 };
    let untyped = needs_untyped(record.definition());
    write_record(&mut line, &Entry::untyped(&record, untyped, place, None), false);
    let line = String::from_utf8(line).unwrap();
    serde_json::from_str::<serde_json::Value>(&line).unwrap();
    let (mut encoder, mut again) = (Encoder::default(), Vec::new());
    encoder.line(&line, &mut again).unwrap_or_else(|error| panic!("{error}: {line}"));
    encoder.finish(&mut again);
    assert_eq!(again[0], definition.category());
    (line, again.split_off(3))
}

/// Records of each profile, and each of them with one bit changed, if that can be read.
#[test]
fn random_records_of_every_edition_come_back() {
    for definition in definitions().into_iter().filter(|definition| definition.category() != 129) {
        let (mut runner, mut read, mut changed) = (TestRunner::deterministic(), 0, 0);
        let strategies: Vec<_> = definition.profiles().map(record_octets).collect();
        while read < RECORDS {
            for (strategy, index) in strategies.iter().zip(0..) {
                let mut octets = strategy.new_tree(&mut runner).unwrap().current();
                if definition.record(&octets).is_err() {
                    continue;
                }
                read += 1;
                let length = definition.record(&octets).unwrap().octets().len();
                octets.truncate(length);
                let (line, again) = there_and_back(definition, &octets);
                assert_eq!(again, octets, "{line}");
                let bit = (read * 7919 + index) % (8 * octets.len());
                octets[bit / 8] ^= 0x80 >> (bit % 8);
                if let Ok(record) = definition.record(&octets) {
                    let other = there_and_back(definition, record.octets());
                    assert_eq!(other.1, record.octets(), "{}", other.0);
                    assert_ne!(other.0, line);
                    changed += 1;
                }
            }
        }
        assert!(changed > RECORDS / 4, "{} {}", definition.category(), definition.name());
    }
}

proptest! {
    /// Random octets as the contents of a block: records that are read are restored.
    #[test]
    fn any_octets_come_back(octets in proptest::collection::vec(any::<u8>(), 0..80), which: prop::sample::Index) {
        let definitions = definitions();
        let definition = definitions[which.index(definitions.len())];
        let whole = [&[definition.category(), 0, 0], octets.as_slice()].concat();
        let block = Block { category: definition.category(), offset: 0, octets: &whole };
        for located in definition.records(block).flatten() {
            if located.record.definition().category() != cat129::Record::CATEGORY {
                let (line, again) = there_and_back(definition, located.record.octets());
                prop_assert_eq!(again, located.record.octets(), "{}", line);
            }
        }
    }
}

fn program(arguments: &[&str], file: &Temporary) -> Output {
    Command::new(env!("CARGO_BIN_EXE_utm-fusion")).args(arguments).arg(&file.0).output().unwrap()
}

fn text(octets: Vec<u8>) -> String {
    String::from_utf8(octets).unwrap()
}

/// The items of the only record in a block. A preceding block identifies the file as ASTERIX.
fn items(arguments: &[&str], category: u8, record: &str) -> String {
    let file = Temporary::new("all-items", &[block(48, &["80 1907"]), block(category, &[record])].concat());
    let output = program(&[&["decode"], arguments].concat(), &file);
    let lines = text(output.stdout);
    assert_eq!(output.status.code(), Some(0), "{lines}{}", text(output.stderr));
    let (_, items) = lines.lines().last().unwrap().split_once(r#""items":"#).unwrap();
    items.strip_suffix('}').unwrap().to_owned()
}

#[test]
fn lines_of_categories_without_types() {
    // A plot and a track of CAT001, distinguished by the first bit of 020.
    assert_eq!(
        items(&[], 1, "fe 1907 20 05004000 0fff 0190 ff10 1000"),
        concat!(
            r#"{"010":{"sac":25,"sic":7},"020":{"typ":0,"sim":0,"ssrpsr":2,"ant":0,"spi":0,"rab":0},"#,
            r#""040":{"rho_m":18520,"theta_deg":90.0},"070":{"v":0,"g":0,"l":0,"mode3a":"7777"},"#,
            r#""090":{"v":0,"g":0,"hgt_flight_level":100.0},"130":[127,8],"141":{"value_s":32.0}}"#
        )
    );
    assert_eq!(
        items(&[], 1, "e8 1907 80 0123 0040ffc0"),
        concat!(
            r#"{"010":{"sac":25,"sic":7},"020":{"typ":1,"sim":0,"ssrpsr":0,"ant":0,"spi":0,"rab":0},"#,
            r#""161":291,"042":{"x_m":1852,"y_m":-1852}}"#
        )
    );
    // Random field sequencing: 041 and a second 020.
    assert_eq!(
        items(&[], 2, "f102 1907 02 40 546040 02 05 0200 03 80"),
        concat!(
            r#"{"010":{"sac":25,"sic":7},"000":2,"020":{"value_deg":90.0},"030":43200.5,"#,
            r#""RFS":[{"041":{"value_s":4.0}},{"020":{"value_deg":180.0}}]}"#
        )
    );
    assert_eq!(
        items(&[], 240, "ebc0 1907 02 00000001 0000400000000010000003e8 0003 0005000005 02 0102030405000000"),
        concat!(
            r#"{"010":{"sac":25,"sic":7},"000":2,"020":1,"#,
            r#""040":{"startaz_deg":0.0,"endaz_deg":90.0,"startrg":16,"celldur_ns":1000},"048":{"c":0,"res":3},"#,
            r#""049":{"nbvb":5,"nbcells":5},"050":[16909060,83886080]}"#
        )
    );
    let video = "01".repeat(64);
    assert_eq!(items(&[], 240, &format!("0120 01 {video}")), format!(r#"{{"051":["{video}"]}}"#));
}

#[test]
fn lines_of_older_editions() {
    // Flight levels are signed since edition 1.32.
    let record = "90 1907 40008000";
    assert_eq!(items(&["--edition", "48:1.31"], 48, record), items(&[], 48, record));
    let high = |edition: &str| items(&["--edition", edition], 48, "04 3ffb");
    assert_eq!(high("48:1.31"), r#"{"090":{"v":0,"g":0,"flight_level":4094.75}}"#);
    assert_eq!(high("48:1.32"), r#"{"090":{"v":0,"g":0,"flight_level":-1.25}}"#);
    // The bit before the value distinguishes air speed and Mach number.
    let speed = |octets: &str| items(&["--cat", "21", "--edition", "0.26"], 21, &format!("0110 {octets}"));
    assert_eq!(speed("4000"), r#"{"150":{"im":0,"as_m_s":1852.0}}"#);
    assert_eq!(speed("8320"), r#"{"150":{"im":1,"as_mach":0.8}}"#);
}

/// The result of `encode` for these lines.
fn encoded(arguments: &[&str], lines: &str) -> Vec<u8> {
    let file = Temporary::new("all-lines", lines.as_bytes());
    let output = program(&[&["encode", "-o", "-"], arguments].concat(), &file);
    assert_eq!(output.status.code(), Some(0), "{lines}{}", text(output.stderr));
    output.stdout
}

/// Blocks of several categories: typed, untyped, and an unknown one.
fn feed() -> Vec<u8> {
    [
        block(48, &["90 1907 40008000"]),
        block(1, &["fe 1907 20 05004000 0fff 0190 ff10 1000", "e8 1907 80 0123 0040ffc0"]),
        block(10, &["d0 1907 01 546040"]),
        block(61, &["0102"]),
        block(10, &[]),
        block(20, &["80 19"]),
        block(21, &["80 1907"]),
    ]
    .concat()
}

#[test]
fn a_line_says_what_encode_needs() {
    let file = Temporary::new("all-feed", &feed());
    for arguments in [
        &["decode"][..],
        &["decode", "--untyped"],
        &["decode", "--edition", "48:1.27/1.11", "--edition", "21:0.23"],
        &["decode", "--untyped", "--edition", "2.1"],
    ] {
        let output = program(arguments, &file);
        assert_eq!(output.status.code(), Some(4));
        assert_eq!(encoded(&[], &text(output.stdout)), feed(), "{arguments:?}");
    }
    let said = |arguments: &[&str]| -> Vec<String> {
        let lines = text(program(arguments, &file).stdout);
        let head = |line: &str| {
            line.split_once(r#""cat":"#)?.1.split_once(r#","items""#).map(|(head, _)| head.to_owned())
        };
        lines.lines().filter_map(head).collect()
    };
    let of = r#""sac":25,"sic":7"#;
    assert_eq!(
        said(&["decode"]),
        [
            format!("48,{of}"),
            format!(r#"1,{of},"edition":"1.4""#),
            format!(r#"1,{of},"edition":"1.4""#),
            format!(r#"10,{of},"edition":"1.1""#),
            format!("21,{of}"),
        ]
    );
    assert_eq!(
        said(&["decode", "--untyped", "--edition", "48:1.31/1.12"])[..2],
        [format!(r#"48,{of},"edition":"1.31/1.12""#), format!(r#"1,{of},"edition":"1.4""#)]
    );
    let last = said(&["decode", "--untyped"]).pop().unwrap();
    assert_eq!(last, format!(r#"21,{of},"edition":"2.6","untyped":true"#));
    // One category, in one of its editions.
    let only = said(&["decode", "--cat", "48", "--edition", "1.30"]);
    assert_eq!(only, [format!(r#"48,{of},"edition":"1.30""#)]);
}

#[test]
fn lines_by_hand_need_no_edition() {
    let line = r#"{"cat":10,"items":{"000":1,"010":{"sac":25,"sic":7},"140":43200.5}}"#;
    assert_eq!(encoded(&[], line), block(10, &["d0 1907 01 546040"]));
    let track = r#"{"cat":1,"items":{"161":291,"020":{"typ":1,"sim":0,"ssrpsr":0,"ant":0,"spi":0,"rab":0}}}"#;
    assert_eq!(encoded(&[], track), block(1, &["60 80 0123"]));
    let level = r#"{"cat":48,"items":{"090":{"v":0,"g":0,"flight_level":4094.75}}}"#;
    assert_eq!(encoded(&["--edition", "48:1.31"], level), block(48, &["04 3ffb"]));
    let speed = r#"{"cat":21,"edition":"0.26","items":{"150":{"as_mach":0.8,"im":1}}}"#;
    assert_eq!(encoded(&[], speed), block(21, &["0110 8320"]));
}

fn complaint(line: &str) -> String {
    Encoder::default().line(line, &mut Vec::new()).unwrap_err().to_string()
}

#[test]
fn wrong_lines_are_told() {
    for (line, told) in [
        (
            r#"{"cat":10,"edition":"1.2","items":{}}"#,
            "`edition`: \"1.2\" is no edition of CAT010 that is known; known are 1.1",
        ),
        (
            r#"{"cat":61,"edition":"1.2","items":{}}"#,
            "`edition`: category 61 has no public definition, and so no editions",
        ),
        (
            r#"{"cat":1,"items":{"161":1}}"#,
            "item 020 must say which profile of its category the record follows",
        ),
        (r#"{"cat":1,"items":{"020":{"typ":2}}}"#, "item 020: typ: 2 does not fit 1 bits"),
        (
            r#"{"cat":7,"items":{"410":9}}"#,
            "item 410 must say which profile of its category the record follows",
        ),
        (r#"{"cat":2,"items":{"RFS":[{"999":1}]}}"#, "item RFS: [0] item 999 is none of this category"),
        (
            r#"{"cat":2,"items":{"RFS":[{"020":{"value_deg":0},"000":1}]}}"#,
            "item RFS: [0] must be an object of one item",
        ),
        (
            r#"{"cat":2,"items":{"RFS":[{"020":{"value_deg":400}}]}}"#,
            "item RFS: [0] 020: value_deg: 400 is out of range",
        ),
        (r#"{"cat":240,"items":{"051":["00"]}}"#, "item 051: [0] must be 64 octets"),
        (r#"{"cat":21,"edition":"0.26","items":{"150":{"im":1,"as_m_s":1}}}"#, "item 150: has no `as_mach`"),
    ] {
        assert_eq!(complaint(line), told);
    }
}

#[test]
fn editions_that_are_none_are_told() {
    let file = Temporary::new("all-none", &feed());
    let told = |arguments: &[&str]| {
        let output = program(&[&["decode"], arguments].concat(), &file);
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0));
        text(output.stderr)
    };
    assert!(
        told(&["--edition", "2.8"])
            .contains(r#"--edition: "2.8" is no edition of CAT021 that is known; known are 0.23, "#)
    );
    assert!(told(&["--edition", "48:1.2"]).contains("each alone or with /1.11 or /1.12 or /1.13"));
    assert!(told(&["--cat", "61", "--edition", "1.0"]).contains("category 61 has no public definition"));
    assert!(
        told(&["--edition", "x:1.0"]).contains("\"x\" is no category: 48:1.31 is edition 1.31 of CAT048")
    );
}

#[test]
fn tables_have_the_columns_of_the_edition() {
    let file = Temporary::new("all-tables", &feed());
    let table = |arguments: &[&str]| {
        text(program(&[&["decode", "--format", "csv"], arguments].concat(), &file).stdout)
    };
    let cat001 = table(&["--cat", "1"]);
    let rows: Vec<Vec<&str>> = cat001.lines().map(|row| row.split(',').collect()).collect();
    let column = |name: &str| {
        rows[0].iter().position(|column| *column == name).unwrap_or_else(|| panic!("{name}: {cat001}"))
    };
    // A plot and a track: columns used by only one of them are empty in the other.
    assert_eq!(rows.len(), 3);
    assert_eq!((rows[1][column("I001_040_rho_m")], rows[2][column("I001_040_rho_m")]), ("18520", ""));
    assert_eq!((rows[1][column("I001_161")], rows[2][column("I001_161")]), ("", "291"));
    assert_eq!((rows[1][column("sac")], rows[2][column("sic")]), ("25", "7"));
    let speeds = Temporary::new("all-speeds", &block(21, &["8110 1907 4000", "8110 1907 8320"]));
    let arguments = ["decode", "--format", "csv", "--cat", "21", "--edition", "0.26"];
    let speeds = text(program(&arguments, &speeds).stdout);
    let rows: Vec<Vec<&str>> = speeds.lines().map(|row| row.split(',').collect()).collect();
    let place = |name: &str| rows[0].iter().position(|column| *column == name).unwrap();
    let (speed, mach) = (place("I021_150_as_m_s"), place("I021_150_as_mach"));
    assert_eq!((rows[1][speed], rows[1][mach]), ("1852", ""));
    assert_eq!((rows[2][speed], rows[2][mach]), ("", "0.8"));
}

#[test]
fn info_counts_and_names_every_category() {
    let file = Temporary::new("all-info", &feed());
    let info: serde_json::Value =
        serde_json::from_slice(&program(&["info", "--json"], &file).stdout).unwrap();
    let categories: Vec<String> =
        info["categories"].as_array().unwrap().iter().map(ToString::to_string).collect();
    assert_eq!(
        categories[0],
        r#"{"category":1,"name":"monoradar target reports, old","blocks":1,"octets":29,"records":2}"#
    );
    assert_eq!(
        categories[1],
        r#"{"category":10,"name":"surface movement reports","blocks":2,"octets":13,"records":1}"#
    );
    let sources: Vec<_> =
        info["sources"].as_array().unwrap().iter().map(|source| &source["category"]).collect();
    assert_eq!(sources, [1, 10, 21, 48]);
    let plots = &info["sources"][0];
    assert_eq!(
        (&plots["records"], &plots["sac"], &plots["items"]["020"], &plots["items"]["161"]),
        (&2.into(), &25.into(), &2.into(), &1.into())
    );
    let errors = info["errors"].as_array().unwrap();
    assert_eq!(
        (errors.len(), &errors[0]["category"], &errors[0]["kind"]),
        (1, &20.into(), &"item_past_end".into())
    );
}

/// Blocks encoded from lines with items can be read, and no line causes a panic: lines of random records, damaged.
#[test]
fn damaged_lines_do_no_harm() {
    let (mut runner, mut taken) = (TestRunner::deterministic(), 0);
    for definition in definitions() {
        let strategies: Vec<_> = definition.profiles().map(record_octets).collect();
        for index in 0..8 {
            let octets = strategies[index % strategies.len()].new_tree(&mut runner).unwrap().current();
            let Ok(record) = definition.record(&octets) else { continue };
            let mut line = Vec::new();
            let place = Place { input: None, offset: 3, block: 0 };
            let untyped = needs_untyped(record.definition());
            write_record(&mut line, &Entry::untyped(&record, untyped, place, None), false);
            for step in 0..20 {
                let mut damaged = line.clone();
                let at = (index * 7919 + step * 104_729) % damaged.len();
                damaged[at] = b"0123456789\"{}[]:,.-n"[step];
                let Ok(damaged) = String::from_utf8(damaged) else { continue };
                let (mut encoder, mut out) = (Encoder::default(), Vec::new());
                if encoder.line(&damaged, &mut out).is_ok() {
                    encoder.finish(&mut out);
                    taken += 1;
                }
            }
        }
    }
    assert!(taken > 200, "{taken}");
}
