//! CAT021, whose editions differ in the layout of I021/271, and layouts introduced with it and with CAT062.

use std::process::Command;

use asterix::cat021::Edition;
use utm_fusion::json::Encoder;

use super::{Temporary, block};

/// 040 and I021/271 with length and width 5, in the layouts up to edition 2.1 and from 2.2 on.
const OLD: &str = "41 01 01 01 01 40 00 03 05";
const NEW: &str = "41 01 01 01 01 40 00 03 50";

/// Output of a command for a file, and its exit code.
fn program(arguments: &[&str], file: &Temporary) -> (String, Option<i32>) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_utm-fusion")).args(arguments).arg(&file.0).output().unwrap();
    (String::from_utf8(output.stdout).unwrap(), output.status.code())
}

/// The result of `encode` for these lines in an edition.
fn encoded(edition: Edition, lines: &str) -> Vec<u8> {
    let (mut encoder, mut out) = (Encoder::new(edition), Vec::new());
    for line in lines.lines() {
        encoder.line(line, &mut out).unwrap();
    }
    encoder.finish(&mut out);
    out
}

#[test]
fn a_line_says_the_edition_that_it_was_read_in() {
    let old = Temporary::new("old", &block(21, &[OLD]));
    let (line, code) = program(&["decode", "--edition", "2.1"], &old);
    assert_eq!(code, Some(0));
    assert!(line.contains(r#""cat":21,"edition":"2.1","items":"#) && line.contains(r#""lw":5}"#), "{line}");
    // The edition in the line overrides that given to `encode`.
    for edition in [Edition::V2_1, Edition::default()] {
        assert_eq!(encoded(edition, &line), block(21, &[OLD]));
    }
    let (line, code) = program(&["decode"], &old);
    assert_eq!(code, Some(4));
    assert!(line.contains(r#""kind":"item_past_end""#) && line.contains(r#""item":"271""#), "{line}");
}

#[test]
fn lines_that_say_no_edition_are_of_the_one_that_is_given() {
    let surface = r#"{"poa":0,"cdtis":0,"b2low":0,"ras":0,"ident":1,"lw":5}"#;
    let line =
        format!(r#"{{"cat":21,"items":{{"040":{{"atp":0,"arc":0,"rc":0,"rab":0}},"271":{surface}}}}}"#);
    assert_eq!(encoded(Edition::V2_1, &line), block(21, &[OLD]));
    assert_eq!(encoded(Edition::V2_6, &line), block(21, &[NEW]));
    let line = line.replace(r#""cat":21,"#, r#""cat":21,"edition":"2.8","#);
    let wrong = Encoder::default().line(&line, &mut Vec::new()).unwrap_err().to_string();
    assert!(wrong.contains(r#""2.8" is no edition of CAT021"#), "{wrong}");
}

#[test]
fn info_names_the_edition_that_fits() {
    let fit = |name: &str, records: &[&str]| {
        let file = Temporary::new(name, &block(21, records));
        let (text, code) = program(&["info"], &file);
        assert_eq!(code, Some(0), "{text}");
        let (_, table) = text.split_once("CAT021 of").unwrap();
        table.lines().nth(1).unwrap().split_whitespace().skip(1).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(fit("fits-old", &[OLD, OLD]), "2.1 1 0 1");
    assert_eq!(fit("fits-new", &[NEW, NEW]), "2.2 or later 1 0 0");
    assert_eq!(fit("fits-any", &["40 00"]), "any 1 0 0");
}

#[test]
fn what_cat062_has_and_no_other_comes_back() {
    // 290 with a primary subfield longer than necessary, and 510 with two units.
    let octets =
        block(62, &["81 02 1907 81 00 02", "81 01 01 08 1907 01 0007 02 0008".replace(' ', "").as_str()]);
    let file = Temporary::new("cat062", &octets);
    let (lines, code) = program(&["decode"], &file);
    assert_eq!(code, Some(0), "{lines}");
    assert!(lines.contains(r#""290":{"primary":"8100","trk_s":0.5}"#), "{lines}");
    assert!(lines.contains(r#""510":[{"unit":1,"track_number":3},{"unit":2,"track_number":4}]"#), "{lines}");
    assert_eq!(encoded(Edition::default(), &lines), octets);
}
