//! The tutorial: its commands run in order, page by page, in one folder and one shell, and print what the pages show.

use std::fmt::Write;
use std::fs;
use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use serde_json::Value;

use crate::pages::{Fenced, pages, parts, root};
use crate::program::Scratch;

/// A block of commands with its place, and the output that the page shows.
struct Step {
    place: String,
    commands: String,
    prints: Option<String>,
}

fn steps() -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    for page in pages(&root().join("docs/tutorial")) {
        let (text, name) = (fs::read_to_string(&page).unwrap(), page.file_name().unwrap().to_owned());
        for Fenced { language, text, line } in parts(&text).1 {
            match language.as_str() {
                "sh" => steps.push(Step {
                    place: format!("{}:{line}", name.display()),
                    commands: text,
                    prints: None,
                }),
                "text" => {
                    let of = steps.last_mut().unwrap();
                    assert!(of.prints.replace(text).is_none(), "{}: printed twice", of.place);
                }
                other => panic!("{}:{line}: what is {other:?}?", name.display()),
            }
        }
    }
    steps
}

/// Whether a line matches that of the page, in which `…` stands for any text.
fn is_line(line: &str, pattern: &str) -> bool {
    let mut parts = pattern.trim_end().split('…');
    let Some(mut rest) = line.strip_prefix(parts.next().unwrap()) else { return false };
    let mut parts = parts.peekable();
    if parts.peek().is_none() {
        return rest.trim_end().is_empty();
    }
    while let Some(part) = parts.next() {
        // The padding of a column.
        let part = part.trim_start();
        if parts.peek().is_none() {
            return rest.trim_end().ends_with(part);
        }
        let Some(at) = rest.find(part) else { return false };
        rest = &rest[at + part.len()..];
    }
    true
}

/// The first line of the page that is missing in the output, in order. A line `…` stands for any lines; the last lines may be
/// left out.
fn missing<'a>(printed: &str, page: &'a str) -> Option<&'a str> {
    let (mut lines, mut skips) = (printed.lines(), false);
    for pattern in page.lines() {
        if pattern == "…" {
            skips = true;
            continue;
        }
        let found = if skips {
            lines.any(|line| is_line(line, pattern))
        } else {
            lines.next().is_some_and(|line| is_line(line, pattern))
        };
        if !found {
            return Some(pattern);
        }
        skips = false;
    }
    None
}

#[test]
fn lines_are_compared() {
    assert!(is_line("a b c", "a … c") && is_line("a b", "a …") && is_line("a", "a") && is_line("a ", "a"));
    assert!(!is_line("a b c", "a … d") && !is_line("b", "a…") && !is_line("ab", "a") && !is_line("a", "…b"));
    assert_eq!(missing("1\n2\n3\n", "1\n…\n3\n"), None);
    assert_eq!(missing("1\n2\n3\n", "1\n3\n"), Some("3"));
    assert_eq!(missing("1\n2\n", "…\n3\n"), Some("3"));
}

/// Stops the processes that the shell of the test has started: its whole process group.
struct Group(u32);

impl Drop for Group {
    fn drop(&mut self) {
        let group = format!("-{}", self.0);
        let _ = Command::new("kill").args(["-KILL", "--", &group]).stderr(Stdio::null()).status();
    }
}

#[test]
fn tutorial_runs_as_printed() {
    use std::os::unix::process::CommandExt;

    if !Command::new("curl")
        .arg("--version")
        .stdout(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
    {
        return println!("skipped: curl is not installed");
    }
    let begun = Instant::now();
    let (scratch, steps) = (Scratch::new(), steps());
    assert!(steps.len() > 15);
    // A free port replaces that of the pages.
    let port = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap().local_addr().unwrap().port();
    let here = |text: &str| text.replace("127.0.0.1:8080", &format!("127.0.0.1:{port}"));

    // One shell, because it knows its background processes; the output of each block goes to a file.
    let mut script = String::new();
    // `locate` writes the usual port into the site file.
    let other_port =
        here("if [ -f site.toml ]; then sed -i 's/127.0.0.1:80\\(80\\)/127.0.0.1:8080/' site.toml; fi");
    for (index, step) in steps.iter().enumerate() {
        let commands = here(&step.commands);
        let _ = writeln!(script, "set -e\n{{\n{commands}}} > {index}.printed 2>&1\n{other_port}");
    }
    let program = Path::new(env!("CARGO_BIN_EXE_utm-fusion")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    let mut shell = Command::new("sh");
    shell.args(["-c", &script]).current_dir(scratch.path("")).env("PATH", path).process_group(0);
    shell.env_remove("RUST_LOG").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = shell.spawn().unwrap();
    let group = Group(child.id());
    let status = child.wait().unwrap();
    drop(group);

    for (index, Step { place, commands, prints }) in steps.iter().enumerate() {
        let printed = fs::read_to_string(scratch.path(format!("{index}.printed")))
            .unwrap_or_else(|_| panic!("{place}: what stands before it failed"));
        if let Some(prints) = prints.as_deref().map(here)
            && let Some(line) = missing(&printed_only(&printed, &prints), &prints)
        {
            panic!("{place}: not printed: {line}\n{commands}printed:\n{printed}");
        }
    }
    let last = steps.len() - 1;
    let printed = fs::read_to_string(scratch.path(format!("{last}.printed"))).unwrap();
    assert!(status.success(), "{printed}");
    let printed_by = |command: &str| {
        let index = steps.iter().position(|step| step.commands.contains(command)).unwrap();
        fs::read_to_string(scratch.path(format!("{index}.printed"))).unwrap()
    };
    let file = |name: &str| fs::read_to_string(scratch.path(name)).unwrap();
    radar_is_where_it_stands(&file("site.toml"), &file("survey/site.toml"));
    scores_are_those_of_a_located_radar(&printed_by("evaluate own.csv"));
    let live = printed_by("api/v1/tracks");
    let live = live.lines().rfind(|line| line.starts_with('{')).unwrap();
    aircraft_are_where_they_fly(&serde_json::from_str(live).unwrap(), &file("flight/truth.csv"));
    println!("{} blocks in {:.1} s", steps.len(), begun.elapsed().as_secs_f64());
}

/// Metres over ground between two places, degrees.
fn apart_m((latitude, longitude): (f64, f64), (other_latitude, other_longitude): (f64, f64)) -> f64 {
    let north_m = (latitude - other_latitude) * 111_250.0;
    let east_m = (longitude - other_longitude) * 111_320.0 * latitude.to_radians().cos();
    north_m.hypot(east_m)
}

fn radar_is_where_it_stands(located: &str, simulated: &str) {
    let key = |site: &str, name: &str| -> f64 {
        let line = site.lines().find(|line| line.starts_with(&format!("{name} = "))).unwrap();
        line.split(['=', '#']).nth(1).unwrap().trim().parse().unwrap()
    };
    let place = |site: &str| (key(site, "latitude_deg"), key(site, "longitude_deg"));
    let off_m = apart_m(place(located), place(simulated));
    assert!(off_m < 40.0, "{off_m} m: {located}");
    // The scenario's bias of azimuths.
    assert!((key(located, "bearing_correction_deg") + 137.0).abs() < 1.5, "{located}");
}

/// The drone without a transponder, D1, is located by the radar alone.
fn scores_are_those_of_a_located_radar(printed: &str) {
    let error_m = |name: &str| -> f64 {
        let line = printed.lines().find(|line| line.starts_with(name)).unwrap();
        line.split_whitespace().rev().nth(2).unwrap().parse().unwrap()
    };
    assert!(error_m("D1 ") < 60.0 && error_m("all equipped") < 15.0, "{printed}");
}

/// The live picture against the truth of the flight, at the picture's time.
fn aircraft_are_where_they_fly(picture: &Value, truth: &str) {
    let time: jiff::Timestamp = picture["time"].as_str().unwrap().parse().unwrap();
    let time_s = time.as_nanosecond() as f64 / 1e9;
    let rows: Vec<Vec<&str>> = truth.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let (mut count, mut fused) = (0, 0);
    for feature in picture["features"].as_array().unwrap() {
        let of = &feature["properties"];
        let Some(serial) = of["uas_id"]["serial_number"].as_str() else { continue };
        let id = format!("D{}", serial.trim_start_matches('0'));
        let value = |row: &Vec<&str>, column: usize| -> f64 { row[column].parse().unwrap() };
        let away_s = |row: &Vec<&str>| (value(row, 0) - time_s).abs();
        let own = rows.iter().filter(|row| row[1] == id);
        let row = own.min_by(|a, b| away_s(a).total_cmp(&away_s(b))).unwrap();
        assert!(away_s(row) < 0.1, "{of}");
        let shown = (of["lat"].as_f64().unwrap(), of["lng"].as_f64().unwrap());
        let off_m = apart_m(shown, (value(row, 2), value(row, 3)));
        assert!(off_m < 60.0, "{off_m} m: {of}");
        count += 1;
        fused += i32::from(of["source"] == "fused");
    }
    assert!(count >= 3 && fused >= 1, "{count} {fused}: {picture}");
}

/// The output without log lines if the page shows none.
fn printed_only(printed: &str, prints: &str) -> String {
    let is_log = |line: &&str| line.contains(" INFO ") || line.contains(" WARN ");
    let shows_logs = prints.lines().any(|line| is_log(&line));
    printed
        .lines()
        .filter(|line| shows_logs || !is_log(line))
        .fold(String::new(), |all, line| all + line + "\n")
}
