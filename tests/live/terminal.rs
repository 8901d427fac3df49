//! Display of `demo` in a terminal, and its final lines.

use std::num::NonZero;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::common::{Scratch, utm_fusion};

/// Output of the program in a terminal of this size, which `script` of util-linux provides.
#[cfg(target_os = "linux")]
fn in_terminal(rows: u16, columns: u16, arguments: &str) -> Vec<u8> {
    let program = env!("CARGO_BIN_EXE_utm-fusion");
    let command = format!("stty rows {rows} cols {columns}; exec '{program}' {arguments}");
    let mut script = Command::new("script");
    script.args(["-q", "-e", "-c", &command, "/dev/null"]).env("TERM", "xterm").env("SHELL", "/bin/sh");
    let output = script.stdin(Stdio::null()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    output.stdout
}

#[cfg(target_os = "linux")]
fn cells(number: u16) -> NonZero<u16> {
    NonZero::new(number).unwrap()
}

/// One table, repainted in place in any size; no line is broken by the terminal.
#[cfg(target_os = "linux")]
#[test]
fn demo_repaints_one_table_in_any_terminal() {
    for (rows, columns) in [(24, 80), (8, 40), (50, 132)] {
        let written = in_terminal(rows, columns, "demo --duration 1s");
        // The terminal below keeps 200 lines of scrollback, so that lines which scroll away are checked, too.
        let text = String::from_utf8(written.clone()).unwrap();
        let paintings = text.matches(" track  source").count();
        assert!(paintings > 100, "{paintings} paintings");
        let mut terminal = vt100::Parser::new(cells(rows), cells(columns), 200);
        let mut wrapped = 0;
        for part in written.split_inclusive(|&octet| octet == b'\n') {
            terminal.process(part);
            wrapped += (0..rows).filter(|&row| terminal.screen().row_wrapped(row)).count();
        }
        assert_eq!(wrapped, 0, "{rows} × {columns}");
        let mut lines = Vec::new();
        terminal.screen_mut().set_scrollback(usize::MAX);
        // One page at a time, from the oldest line on.
        let mut back = terminal.screen().scrollback();
        loop {
            terminal.screen_mut().set_scrollback(back);
            let page: Vec<String> = terminal.screen().rows(0, columns).collect();
            lines.extend(page.into_iter().take(if back == 0 { rows.into() } else { back.min(rows.into()) }));
            if back == 0 {
                break;
            }
            back -= back.min(rows.into());
        }
        let tables = lines.iter().filter(|line| line.starts_with(" track  source")).count();
        assert_eq!(tables, 1, "{rows} × {columns}: {lines:#?}");
        let first = lines.iter().position(|line| line.starts_with("crossing  2026-")).unwrap();
        assert_eq!(first, 0, "nothing is left of earlier tables: {lines:#?}");
    }
}

/// The last lines are the scores of `evaluate` for the same flight, each beside that of the input.
#[test]
fn demo_ends_with_the_scores_of_evaluate() {
    let scratch = Scratch::new();
    let ran = |command: &mut Command| {
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let shown = ran(&mut utm_fusion("demo"));
    assert!(!shown.contains('\x1b'), "no terminal, no control characters");

    // One of the transponders reports false positions, and is flagged.
    assert!(shown.contains("FAILED, ") && shown.contains("flagged    0000000000"), "{shown}");
    let found = shown.lines().find(|line| line.starts_with("The transponder of drone D")).unwrap();
    assert!(found.contains(" lied from 2026-") && found.contains(" s later it was flagged."), "{found}");

    let kept = include_str!("../../config/scenarios/crossing.toml");
    let scenario = scratch.file("crossing.toml", kept.replace("equipped = 8", "equipped = 8\nspoofed = 1"));
    let flight = scratch.path("flight");
    let file = |name: &str| flight.join(name);
    ran(utm_fusion("simulate").arg(scenario).arg("--out").arg(&flight));
    let fused = file("fused.ndjson");
    ran(utm_fusion("replay")
        .arg(file("capture.pcap"))
        .arg("--config")
        .arg(file("site.toml"))
        .arg("-o")
        .arg(&fused));
    let mut evaluate = utm_fusion("evaluate");
    evaluate.arg(&fused).arg("--truth").arg(file("truth.csv")).arg("--labels").arg(file("labels.csv"));
    evaluate.arg("--capture").arg(file("capture.pcap")).arg("--config").arg(file("site.toml")).arg("--json");
    let scores: Value = serde_json::from_str(&ran(&mut evaluate)).unwrap();

    // Slots with false positions have a row of their own; the mean over all slots lies between the two.
    let metres = |row: &str| -> [f64; 2] {
        let line = shown.lines().find_map(|line| line.strip_prefix(row)).unwrap_or_else(|| panic!("{shown}"));
        let numbers: Vec<f64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        [numbers[0], numbers[2]]
    };
    let (honest, lying) = (metres("while its transponder spoke"), metres("while it sent false positions"));
    for (index, stream) in ["fused", "transponder"].into_iter().enumerate() {
        let mean = scores[stream]["all"]["epos_covered"]["mean_m"].as_f64().unwrap();
        assert!(honest[index] < mean && mean < lying[index], "{stream}: {mean}\n{shown}");
    }
    assert!(honest[0] < honest[1], "{shown}");

    for (row, group, error, share, alone) in [
        ("while its transponder was silent", "all", "epos_gap", "pu_gap_percent", "radar"),
        ("drones without a transponder", "unequipped", "epos", "pu_percent", "radar"),
    ] {
        let line =
            shown.lines().find(|line| line.starts_with(row)).unwrap_or_else(|| panic!("{row}: {shown}"));
        // Metres and percent: of the output, and of the input alone.
        let words: Vec<&str> = line[row.len()..].split_whitespace().collect();
        let numbers: Vec<f64> = words.iter().filter_map(|word| word.parse().ok()).collect();
        assert_eq!((numbers.len(), words.last()), (4, Some(&alone)), "{line}");
        for (stream, told) in [("fused", &numbers[..2]), (alone, &numbers[2..])] {
            let score = &scores[stream][group];
            let expected = [score[error]["mean_m"].as_f64().unwrap(), score[share].as_f64().unwrap()];
            // Rounded as displayed; the files round positions to millimetres.
            assert!((told[0] - expected[0]).abs() < 0.06, "{line}: {expected:?}");
            assert!((told[1] - expected[1]).abs() <= 0.51, "{line}: {expected:?}");
        }
    }
}

/// Lines of a demonstration without a terminal: exit code 0, and no control characters.
fn demonstrated(scenario: &str) -> Vec<String> {
    let output = utm_fusion("demo").args(["--scenario", scenario]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let shown = String::from_utf8(output.stdout).unwrap();
    assert!(!shown.contains('\x1b') && output.stderr.is_empty(), "{shown}");
    shown.lines().map(str::to_owned).collect()
}

/// Rows of the last table: source, name and the whole line.
fn rows<'a>(shown: &'a [String]) -> Vec<(&'a str, &'a str, &'a str)> {
    let table = shown.iter().rposition(|line| line.starts_with(" track  source")).unwrap();
    let rows = shown[table + 1..].iter().take_while(|line| !line.is_empty());
    let row = |line: &'a str| match line.split_whitespace().collect::<Vec<_>>()[..] {
        [_, source, who, ..] => (source, who, line),
        _ => panic!("{line}"),
    };
    rows.map(|line| row(line)).collect()
}

/// Number of aircraft in the summary with an address, and with a serial number that begins like this.
fn aircraft(shown: &[String], serial: &str) -> (usize, usize) {
    let count =
        |of: &str| shown.iter().filter(|line| line.starts_with("aircraft") && line.contains(of)).count();
    (count(" (address "), count(&format!(" (serial {serial}")))
}

/// Number of reports of a sensor that were used.
fn used(shown: &[String], sensor: &str) -> u64 {
    let begins = format!("sensor     {sensor}: ");
    let line = shown.iter().find_map(|line| line.strip_prefix(&begins)).unwrap_or_else(|| panic!("{sensor}"));
    line.split(' ').next().unwrap().parse().unwrap()
}

/// Mean error in metres, and availability in percent, of aircraft whose transponders were received.
fn while_heard(shown: &[String]) -> (f64, u64) {
    let row = "while its transponder spoke";
    let line = shown.iter().find(|line| line.starts_with(row)).unwrap();
    let words: Vec<&str> = line[row.len()..].split_whitespace().collect();
    let [metres, "m", percent, "%", ..] = words[..] else { panic!("{line}") };
    (metres.parse().unwrap(), percent.parse().unwrap())
}

/// Callsigns of the simulated aeroplanes and helicopters: a G, and four letters.
fn is_callsign(who: &str) -> bool {
    who.len() == 5 && who.starts_with('G') && who.bytes().all(|octet| octet.is_ascii_uppercase())
}

#[test]
fn airfield_demo_shows_aeroplanes_and_drones() {
    let shown = demonstrated("airfield");
    // Two that pass, two in the circuit, one that meets a drone; and no vehicle on the ground.
    assert_eq!(aircraft(&shown, "SMTR7"), (5, 5), "{shown:#?}");
    let rows = rows(&shown);
    assert!(rows.iter().all(|(source, ..)| *source == "transponder"), "{rows:#?}");
    let crewed = rows.iter().filter(|(_, who, _)| is_callsign(who)).count();
    let drones = rows.iter().filter(|(_, who, _)| who.starts_with("SMTR7")).count();
    assert_eq!((crewed, drones, rows.len()), (5, 5, 10), "{rows:#?}");
    assert!(rows.iter().filter(|(_, who, _)| is_callsign(who)).all(|(.., row)| row.contains(" m")));
    assert!(used(&shown, "adsb (adsb)") > 1000 && used(&shown, "remote-id (remote-id)") > 1000);
    assert!(shown.iter().any(|line| line.contains(" slots: 0 fused, 0 radar, ")));
    let (error_m, percent) = while_heard(&shown);
    assert!(error_m < 15.0 && percent >= 99, "{shown:#?}");
}

#[test]
fn event_demo_shows_tracks_of_every_sensor_kind() {
    let shown = demonstrated("event");
    let rows = rows(&shown);
    let of_source = |wanted: &str| rows.iter().filter(|(source, ..)| *source == wanted).count();
    assert!(of_source("transponder") > 10, "{rows:#?}");
    assert!(rows.iter().any(|(_, who, _)| is_callsign(who)), "a helicopter: {rows:#?}");
    assert!(rows.iter().any(|(_, who, _)| who.starts_with("SMTR7000")), "a drone by Remote ID: {rows:#?}");
    assert!(rows.iter().any(|(_, who, _)| who.starts_with("0000")), "one by CAT129: {rows:#?}");
    let (crewed, drones) = aircraft(&shown, "SMTR7000");
    assert!(crewed == 3 && drones >= 2, "{crewed} {drones} {shown:#?}");
    for sensor in [
        "gamekeeper (radar)",
        "drone-it (transponder)",
        "adsb (adsb)",
        "remote-id (remote-id)",
        "camera (camera)",
    ] {
        assert!(used(&shown, sensor) > 100, "{sensor}");
    }
    let output = shown.iter().find(|line| line.starts_with("output")).unwrap();
    let fused = output.split(" slots: ").nth(1).unwrap().split(' ').next().unwrap();
    assert!(fused.parse::<u64>().unwrap() > 1000, "{output}");
    let (error_m, percent) = while_heard(&shown);
    assert!(error_m < 15.0 && percent >= 95, "{shown:#?}");
}
