//! The tutorial: its commands run in order, page by page, in one folder and one shell, and print what the pages show.

use std::fmt::Write;
use std::fs;
use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

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
    for (index, step) in steps.iter().enumerate() {
        let _ = writeln!(script, "set -e\n{{\n{}}} > {index}.printed 2>&1", here(&step.commands));
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
    println!("{} blocks in {:.1} s", steps.len(), begun.elapsed().as_secs_f64());
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
