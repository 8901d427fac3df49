//! Checks of the README: its commands run as printed, its figures are those of the evaluation, and its links are valid.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![expect(clippy::disallowed_methods, reason = "it looks at the project's files")]

use std::env;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

#[path = "shared/program.rs"]
#[allow(dead_code, reason = "shared by several tests")]
mod program;

use program::Scratch;

const README: &str = include_str!("../README.md");
const EVALUATION: &str = include_str!("../docs/EVALUATION.md");
const VALIDATION: &str = include_str!("../docs/VALIDATION.md");

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The text between two marks.
fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    let (_, rest) = text.split_once(from).unwrap_or_else(|| panic!("{from:?} is not there"));
    rest.split_once(to).unwrap_or_else(|| panic!("{to:?} is not there")).0
}

#[test]
fn its_commands_run_as_printed() {
    let commands = between(between(README, "## Five commands", "##"), "```sh\n", "```");
    assert_eq!(commands.lines().count(), 5);
    // A clone of which files are only read: the commands write elsewhere.
    let clone = Scratch::new();
    for folder in ["testdata", "config"] {
        std::os::unix::fs::symlink(root().join(folder), clone.path(folder)).unwrap();
    }
    let program = Path::new(env!("CARGO_BIN_EXE_utm-fusion")).parent().unwrap().to_path_buf();
    let path = env::split_paths(&env::var_os("PATH").unwrap()).collect::<Vec<_>>();
    let path = env::join_paths(std::iter::once(program).chain(path)).unwrap();
    for line in commands.lines() {
        let mut shell = Command::new("sh");
        shell.args(["-c", line]).current_dir(clone.path("")).env("PATH", &path).stdin(Stdio::null());
        let output = shell.output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{line}\n{stderr}");
        assert!(output.stdout.len() > 100, "{line}\n{stderr}");
    }
    assert!(fs::read_to_string(clone.path("fused.csv")).unwrap().lines().count() > 500);
}

/// Each site file in the README's commands has the default profile.
#[test]
fn its_sites_have_the_default_profile() {
    let names = README.split([' ', '\n']).filter(|word| word.ends_with(".toml"));
    let files: Vec<_> = names.map(|name| root().join(name)).filter(|path| path.exists()).collect();
    assert!(files.len() >= 2, "{files:?}");
    for file in files {
        let check = Command::new(env!("CARGO_BIN_EXE_utm-fusion")).arg("check").arg(&file).output().unwrap();
        let shown = String::from_utf8_lossy(&check.stdout).into_owned();
        assert!(shown.contains("profile = \"operational\""), "{}\n{shown}", file.display());
    }
}

#[test]
fn it_is_short() {
    let words = README.split_whitespace().count();
    assert!(words <= 900, "{words} words");
}

/// Each figure of the README and of VALIDATION.md is the one written by the evaluation, rounded.
#[test]
fn its_figures_are_those_of_the_evaluation() {
    let (_, table) = EVALUATION.split_once("\nScenario `bias`").expect("the table of `bias`");
    let cells = |row: &str| -> Vec<f64> {
        let line = table.lines().find(|line| line.starts_with(row)).unwrap();
        let cells = line.split('|').skip(2).map(str::trim);
        cells.filter_map(|cell| cell.split(' ').next()?.parse().ok()).collect()
    };
    let (pu, error) = (cells("| PU, 4 Hz ref. (%) |"), cells("| mean ePos (m) |"));
    // Radar, `reference`, its change, `operational`, its change, and the three columns of the paper.
    let rows = [("radar alone", 0), ("`reference`", 1), ("`operational`", 3)];
    for (name, document) in [("README.md", README), ("VALIDATION.md", VALIDATION)] {
        for (row, column) in rows {
            let shown = format!("| {:.1} % | {:.1} m |", pu[column], error[column]);
            let start = format!("| {row}");
            let mut lines = document.lines().filter(|line| line.starts_with(&start));
            assert!(lines.any(|line| line.contains(&shown)), "{name}: {row} is not {shown}");
        }
        let paper = format!("{:.0} %", pu[6]);
        assert!(
            document.contains(&paper) && document.contains("scenario `paper`"),
            "{name}: the paper's {paper}"
        );
    }
}

#[test]
fn complete_loop_of_the_engine_is_short() {
    let example = include_str!("../fusion/examples/embed.rs");
    let code = |line: &&str| !line.trim().is_empty() && !line.trim().starts_with("//");
    assert!(example.lines().filter(code).count() <= 40);
}

#[test]
fn its_links_lead_somewhere() {
    for (folder, document) in [
        ("", README),
        ("", include_str!("../CONTRIBUTING.md")),
        ("", include_str!("../CHANGELOG.md")),
        ("docs", VALIDATION),
        ("docs", include_str!("../docs/COMMANDS.md")),
    ] {
        let targets: Vec<&str> =
            document.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
        assert!(targets.len() > 3);
        for target in targets.into_iter().filter(|target| !target.starts_with("http")) {
            let file = target.split('#').next().unwrap();
            assert!(root().join(folder).join(file).exists(), "{target}");
        }
    }
    let picture = fs::metadata(root().join("docs/images/map.png")).unwrap().len();
    assert!((20_000..300_000).contains(&picture), "{picture} octets");
}
