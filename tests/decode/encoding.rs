//! `encode` with hand-written and generated lines, valid and invalid.

use std::fs;
use std::process::Command;

use utm_fusion::json::{Encoder, LineError};

use super::{Temporary, block, octets};

/// The result of `encode` for these lines.
fn encoded(lines: &[&str]) -> Vec<u8> {
    let (mut encoder, mut out) = (Encoder::default(), Vec::new());
    for line in lines {
        encoder.line(line, &mut out).unwrap();
    }
    encoder.finish(&mut out);
    out
}

/// The error for this line.
fn complaint(line: &str) -> String {
    let (mut encoder, mut out) = (Encoder::default(), Vec::new());
    encoder.line(line, &mut out).unwrap_err().to_string()
}

/// The error for a line of CAT048 with these items.
fn wrong(items: &str) -> String {
    complaint(&format!(r#"{{"cat":48,"items":{{{items}}}}}"#))
}

#[test]
fn a_line_by_hand_is_a_block() {
    let line = r#"{"cat":48,"items":{"040":{"rho_m":1852,"theta_deg":90},"010":{"sac":25,"sic":200},"140":37230.25}}"#;
    let one = block(48, &["d0 19c8 48b720 01004000"]);
    assert_eq!(encoded(&[line]), one);
    assert_eq!(
        encoded(&[line, line]),
        [one.clone(), one].concat(),
        "lines that name no block are a block each"
    );
}

#[test]
fn members_come_in_any_order_and_with_escapes() {
    let line = r#"{"items":{"\u0034\u0038":1},"cat":48}"#;
    assert_eq!(complaint(line), "category 048 has no item 48");
    let line = r#"{"items":{"140":37230.25,"070":{"mode_3a":"\u0037777","l":0,"g":1,"v":0},"\u0030\u0031\u0030":{"sic":200,"sac":25}},"cat":48}"#;
    assert_eq!(encoded(&[line]), block(48, &["c8 19c8 48b720 4fff"]));
}

#[test]
fn lines_of_the_same_block_are_one() {
    let line = |block: u32, input: &str, sic: u32| {
        format!(r#"{{"block":{block},{input}"cat":48,"items":{{"010":{{"sac":1,"sic":{sic}}}}}}}"#)
    };
    let file = r#""input":"a","#;
    let lines = [line(0, "", 1), line(0, "", 2), line(9, "", 3), line(9, file, 4)];
    assert_eq!(
        encoded(&lines.each_ref().map(String::as_str)),
        [block(48, &["80 0101", "80 0102"]), block(48, &["80 0103"]), block(48, &["80 0104"])].concat()
    );
}

#[test]
fn numbers_go_to_the_nearest_count_and_texts_are_filled_up() {
    let line = r#"{"cat":48,"items":{"090":{"v":0,"g":1,"flight_level":-1.3},"240":"ROT415","110":{"height_m":-12}}}"#;
    assert_eq!(encoded(&[line]), block(48, &["05 41 08 7ffb 48f534c75820 3ffe"]));
}

#[test]
fn a_longer_fspec_is_kept_if_it_says_the_same() {
    let line =
        |fspec: &str| format!(r#"{{"cat":48,"fspec":"{fspec}","items":{{"010":{{"sac":1,"sic":2}}}}}}"#);
    assert_eq!(encoded(&[&line("8100")]), block(48, &["8100 0102"]));
    for fspec in ["80ff", "40", "81", "8100ff", "xx", ""] {
        let told = "`fspec` does not announce the items of this line; leave it out to have the shortest one";
        assert_eq!(complaint(&line(fspec)), told);
    }
}

#[test]
fn mistakes_are_named() {
    for (items, told) in [
        (r#""041":1"#, "category 048 has no item 041"),
        (r#""040":{"rho_m":1}"#, "item 040: has no `theta_deg`"),
        (
            r#""040":{"rho_m":1,"theta_deg":1,"rho_nm":1}"#,
            "item 040: `rho_nm` is unknown here; known are rho_m, theta_deg",
        ),
        (r#""040":{"rho_m":500000,"theta_deg":1}"#, "item 040: rho_m: 500000 is out of range"),
        (r#""040":{"rho_m":"1","theta_deg":1}"#, "item 040: rho_m: must be a number"),
        (r#""040":7"#, "item 040: must be an object"),
        (r#""010":{"sac":256,"sic":1}"#, "item 010: sac: 256 does not fit 8 bits"),
        (r#""010":{"sac":-1,"sic":1}"#, "item 010: sac: must be a whole number"),
        (
            r#""070":{"v":0,"g":0,"l":0,"mode_3a":"8000"}"#,
            "item 070: mode_3a: must be a text of 4 digits to the base 8",
        ),
        (r#""220":"4A08E""#, "item 220: must be a text of 6 digits to the base 16"),
        (r#""240":"rot""#, "item 240: must be capital letters, digits and spaces, at most 8"),
        (r#""030":[]"#, "item 030: must be an array of one code or more"),
        (r#""030":[128]"#, "item 030: a code must be 0 to 127"),
        (r#""020":{"typ":1}"#, "item 020: has no `sim`"),
        (r#""020":{"typ":1,"sim":0,"rdp":0,"spi":0,"rab":0,"more":"0101"}"#, "item 020: has no `tst`"),
        (
            r#""250":[{"data":"00","bds1":4,"bds2":0}]"#,
            "item 250: [0] data: must be a text of 14 digits to the base 16",
        ),
        (r#""120":{"xyz":1}"#, "item 120: `xyz` is unknown here; known are cal, rds"),
        (r#""SP":"0501""#, "item SP: its first octet must be its length, 2"),
        (r#""SP":{"uf":1}"#, "item SP: must be a text of hexadecimal octets"),
        (r#""RE":{"md5":{"sum":{}}}"#, "item RE: md5: sum: has no `m5`"),
        (r#""140":1,"140":2"#, "item 140: is there twice"),
        (r#""140":1,"041":1,"140":2"#, "category 048 has no item 041"),
        (r#""010":{"sac":1,"sic":1,"sac":2}"#, "item 010: `sac` is there twice"),
        (r#""010":{"sac":1,"sic":1,"x":1,"x":2}"#, "item 010: `x` is unknown here; known are sac, sic"),
    ] {
        assert_eq!(wrong(items), told);
    }
    let status = r#""cnf":0,"rad":0,"dou":0,"mah":0,"cdm":0,"tre":0,"gho":0,"sup":0,"tcc":0"#;
    let more = format!(r#""170":{{{status},"more":"{}00"}}"#, "01".repeat(14));
    assert_eq!(wrong(&more), "item 170: would have 17 octets; 16 are the most");
    let too_many = vec![r#"{"data":"00000000000000","bds1":4,"bds2":0}"#; 256].join(",");
    assert_eq!(wrong(&format!(r#""250":[{too_many}]"#)), "item 250: has more than 255 parts");
    for (line, told) in [
        (r#"{"items":{}}"#, "has `items` but no `cat`"),
        (r#"{"cat":61,"items":{}}"#, "category 61 is not known; give the octets of its block as `hex`"),
        (r#"{"cat":48}"#, "has neither `items` nor `hex`, so there is nothing to encode"),
        (r#"{"cat":61,"hex":"3e0"}"#, "`hex` must be a text of hexadecimal octets"),
        (
            r#"{"cat":129,"items":{"120":{"certification_category":0,"air_risk_category":0,"airspace_encounter_category":0}}}"#,
            "item 120: air_risk_category: must be 1 or more",
        ),
        (r#"{"cat":129,"items":{"020":"AIRR"}}"#, "item 020: must be 3 ASCII characters"),
    ] {
        assert_eq!(complaint(line), told);
    }
    assert!(complaint("[1]").starts_with("is not a line that `decode` prints: "));
}

#[test]
fn record_too_large_for_its_block_is_left_out_alone() {
    let sp = format!("ff{}", "00".repeat(254));
    let line = format!(r#"{{"block":0,"cat":48,"items":{{"SP":"{sp}"}}}}"#);
    let (mut encoder, mut out) = (Encoder::default(), Vec::new());
    for _ in 0..253 {
        encoder.line(&line, &mut out).unwrap();
    }
    assert_eq!(encoder.line(&line, &mut out), Err(LineError::BlockTooLong(3 + 254 * 259)));
    let other = r#"{"block":0,"cat":34,"items":{}}"#;
    assert_eq!(encoder.line(other, &mut out), Err(LineError::OtherCategory { record: 34, block: 48 }));
    assert!(out.is_empty());
    encoder.finish(&mut out);
    assert_eq!(out.len(), 3 + 253 * 259);
}

#[test]
fn octets_that_fit_no_block_leave_nothing_behind() {
    let hex = "00".repeat(usize::from(u16::MAX));
    let line = format!(r#"{{"error":{{}},"offset":3,"block":0,"cat":48,"hex":"{hex}"}}"#);
    let (mut encoder, mut out) = (Encoder::default(), Vec::new());
    assert_eq!(encoder.line(&line, &mut out), Err(LineError::BlockTooLong(3 + 65_535)));
    encoder.finish(&mut out);
    assert!(out.is_empty());
}

#[test]
fn the_command_names_bad_lines_and_encodes_the_others() {
    let lines = "{\"cat\":48,\"items\":{\"010\":{\"sac\":1,\"sic\":1}}}\n\nnonsense\n{\"cat\":48,\"items\":{\"999\":1}}\n\
        {\"cat\":48,\"items\":{\"010\":{\"sac\":1,\"sic\":2}}}";
    let input = Temporary::new("bad-lines", lines.as_bytes());
    let output = Temporary::new("bad-lines-out", &[]);
    let run = |output: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_utm-fusion"));
        command.arg("encode").arg(&input.0).args(["-o", output]).output().unwrap()
    };
    let done = run(output.0.to_str().unwrap());
    assert_eq!(done.status.code(), Some(1));
    let told = String::from_utf8(done.stderr).unwrap();
    let name = input.0.display();
    assert!(told.contains(&format!("{name}: line 3: is not a line that `decode` prints: ")), "{told}");
    assert!(told.contains(&format!("{name}: line 4: category 048 has no item 999\n")), "{told}");
    assert!(told.ends_with("2 lines of 5 left out\n"), "{told}");
    assert_eq!(fs::read(&output.0).unwrap(), octets("300006 800101 300006 800102"));
    assert_eq!(run("-").stdout, octets("300006 800101 300006 800102"));
    assert_eq!(run("/").status.code(), Some(1));
}

#[test]
fn an_item_has_as_many_codes_as_there_are() {
    let codes: Vec<u8> = (0..=127).chain(0..=127).collect();
    let octets = encoded(&[&format!(
        r#"{{"cat":48,"items":{{"030":{codes:?},"170":{{"cnf":0,"rad":0,"dou":0,"mah":0,"cdm":0}}}}}}"#
    )]);
    let block = asterix::blocks(&octets).next().unwrap().unwrap();
    let read = block.records::<asterix::cat048::Record>().next().unwrap().unwrap().record;
    assert!(read.warnings.unwrap().codes().eq(codes), "{octets:02x?}");
    assert!(read.track_status.is_some());
}
