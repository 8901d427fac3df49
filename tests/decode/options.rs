//! The options of the program.

use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Output, Stdio};

use super::{Temporary, block, octets, pcap};

/// Two radar records, a transponder's record, a bad radar record, another category, a bad block.
fn mixed() -> Vec<u8> {
    [
        block(48, &["80 1907", "80 1908"]),
        block(129, &["80 0000"]),
        block(48, &["40 0000"]),
        block(61, &["0102"]),
        octets("81 0002"),
    ]
    .concat()
}

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_utm-fusion"))
}

fn decode(name: &str, options: &[&str]) -> (Output, Vec<String>) {
    let file = Temporary::new(name, &mixed());
    let output = program().arg("decode").arg(&file.0).args(options).output().unwrap();
    let lines = String::from_utf8(output.stdout.clone()).unwrap().lines().map(str::to_owned).collect();
    (output, lines)
}

#[test]
fn everything_and_a_summary() {
    let (output, lines) = decode("plain", &[]);
    assert_eq!((output.status.code(), lines.len()), (Some(4), 6), "octets of a raw file could not be read");
    let summary = String::from_utf8(output.stderr).unwrap();
    let (unread, errors) = summary.split_once('\n').unwrap();
    assert!(
        unread.ends_with("-plain: 6 octets in 2 places (the first at offset 18) could not be read"),
        "{unread}"
    );
    assert_eq!(errors, "2 errors in the input: 1 block_too_short, 1 item_past_end\n");
}

#[test]
fn one_category() {
    let (output, lines) = decode("cat", &["--cat", "129"]);
    assert_eq!(output.status.code(), Some(4));
    // A block that cannot be read is reported, whatever its first octet.
    assert_eq!(lines.len(), 2, "{lines:?}");
    assert!(lines[0].contains(r#""cat":129"#) && lines[1].contains("block_too_short"), "{lines:?}");
    let (_, lines) = decode("cat61", &["--cat", "61", "--limit", "1"]);
    assert_eq!(lines, [r#"{"time":null,"offset":21,"block":21,"cat":61,"hex":"3d00050102"}"#]);
}

#[test]
fn a_limit() {
    for (limit, count) in [("0", 0), ("1", 1), ("4", 4), ("100", 6)] {
        let (output, lines) = decode(&format!("limit{limit}"), &["--limit", limit]);
        // The bad record is the fourth line.
        let code = if count < 4 { 0 } else { 4 };
        assert_eq!((output.status.code(), lines.len()), (Some(code), count));
    }
}

#[test]
fn errors_only_and_strict() {
    let (output, lines) = decode("errors", &["--errors-only"]);
    assert_eq!((output.status.code(), lines.len()), (Some(4), 2));
    assert!(lines.iter().all(|line| line.starts_with(r#"{"error":"#)), "{lines:?}");
    let (output, lines) = decode("strict", &["--strict"]);
    assert_eq!((output.status.code(), lines.len()), (Some(4), 6));
    let (output, _) = decode("fine", &["--strict", "--limit", "3"]);
    assert_eq!((output.status.code(), output.stderr), (Some(0), Vec::new()));
}

#[test]
fn octets_of_each_record() {
    let (_, lines) = decode("hex", &["--hex"]);
    for (line, hex) in lines.iter().zip(["801907", "801908", "800000", "400000", "3d00050102", "810002"]) {
        assert!(line.ends_with(&format!(r#","hex":"{hex}"}}"#)), "{line}");
    }
}

#[test]
fn several_inputs_are_named() {
    let file = Temporary::new("again", &block(48, &["80 1907"]));
    let output = program().arg("decode").arg(&file.0).arg(&file.0).output().unwrap();
    let name = serde_json::to_string(&file.0).unwrap();
    let line = format!(
        r#"{{"time":null,"input":{name},"offset":3,"block":0,"cat":48,"sac":25,"sic":7,"items":{{"010":{{"sac":25,"sic":7}}}}}}"#
    );
    assert_eq!(String::from_utf8(output.stdout).unwrap(), format!("{line}\n{line}\n"));
}

#[test]
fn standard_input() {
    let mut child = program()
        .args(["decode", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(&mixed()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stdout.lines().count()), (Some(4), 6));
}

/// A capture of a network may hold any octets: unreadable ones are reported, and are an error only on request.
#[test]
fn a_bad_record_in_a_pcap() {
    let (capture, _) = pcap(&[(0, &block(48, &["80 1907"])), (0, &block(48, &["40 0000"]))]);
    let file = Temporary::new("bad", &capture);
    let output = program().arg("decode").arg(&file.0).output().unwrap();
    assert_eq!((output.status.code(), output.stdout.lines().count()), (Some(0), 2));
    assert!(String::from_utf8(output.stderr).unwrap().contains(": 3 octets in 1 place (at offset "));
    let output = program().arg("decode").arg(&file.0).arg("--strict").output().unwrap();
    assert_eq!(output.status.code(), Some(4));
}

/// A lost octet affects its block only: the block is a line, and so is the rest of the block; everything else is read.
#[test]
fn one_lost_octet_of_a_raw_file() {
    let sound = block(48, &["f0 1907 000080 20 0100 0200"]).repeat(1000);
    let mut octets = sound.clone();
    octets.remove(600 * 14 + 7);
    let file = Temporary::new("lost", &octets);
    let output = program().arg("decode").arg(&file.0).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!((output.status.code(), text.lines().count()), (Some(4), 1000));
    let skipped = r#"{"error":{"kind":"skipped","offset":8400,"detail":"13 octets belong to no block"},"offset":8400,"block":8400,"hex":"30000ef0190700"#;
    let lines: Vec<_> = text.lines().filter(|line| line.starts_with(skipped)).collect();
    assert_eq!(lines.len(), 1, "{:?}", text.lines().nth(600));
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("-lost: 13 octets in 1 place (at offset 8400) could not be read\n"), "{told}");
    assert!(told.ends_with("1 error in the input: 1 skipped\n"), "{told}");

    let output = program().arg("info").arg(&file.0).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(4));
    assert!(text.contains("\nunread     13 octets in 1 place (at offset 8400)\n"), "{text}");
    let output = program().arg("info").arg("--json").arg(&file.0).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains(r#""unread":{"octets":13,"places":1,"first_offset":8400}"#), "{text}");
    // A valid file.
    let file = Temporary::new("sound", &sound);
    for command in ["decode", "info"] {
        let output = program().arg(command).arg(&file.0).output().unwrap();
        assert_eq!((output.status.code(), output.stderr), (Some(0), Vec::new()), "{command}");
    }
}

#[test]
fn a_capture_that_is_cut_off_is_printed_up_to_there() {
    let (mut capture, _) = pcap(&[(0, &block(48, &["80 1907"])), (0, &block(48, &["80 1908"]))]);
    capture.pop();
    let file = Temporary::new("cut", &capture);
    let output = program().arg("decode").arg(&file.0).output().unwrap();
    assert_eq!((output.status.code(), output.stdout.lines().count()), (Some(1), 1));
    assert!(String::from_utf8(output.stderr).unwrap().contains("in the middle of a pcap record"));
}

#[test]
fn frames_that_may_have_held_records_are_errors() {
    let (mut capture, origins) = pcap(&[(0, &block(48, &["80 1907"]))]);
    capture[origins[0] - 22] = 0x20; // more fragments
    let file = Temporary::new("fragment", &capture);
    let output = program().arg("decode").arg(&file.0).arg("--strict").output().unwrap();
    assert_eq!((output.status.code(), output.stdout), (Some(4), Vec::new()));
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "1 error in the input: 1 fragmented frame\n");
}

#[test]
fn what_does_not_work_has_a_code() {
    assert_eq!(program().args(["decode", "/nonexistent.ast"]).output().unwrap().status.code(), Some(1));
    assert_eq!(program().args(["decode"]).output().unwrap().status.code(), Some(2));
    assert_eq!(program().args(["decode", "x", "--cat", "256"]).output().unwrap().status.code(), Some(2));
}

#[test]
fn a_closed_pipe_is_quiet() {
    let file = Temporary::new("pipe", &block(48, &["80 1907"]).repeat(50_000));
    let mut child =
        program().arg("decode").arg(&file.0).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut first = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut first).unwrap();
    assert!(first.starts_with(r#"{"time":null"#));
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr), (Some(0), Vec::new()));
}
