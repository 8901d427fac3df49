//! The commands of the guides run as printed, on a small flight in place of the reader's recordings. If a command does not end by
//! itself or uses ports, only its options are checked; the tutorial and `tests/live` run such commands.

use std::env;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::pages::{pages, parts, root};
use crate::program::Scratch;

const FLIGHT: &str = "name = \"small\"\nduration_s = 20\n[airspace]\nradius_m = 300\n[drones]\nmultirotors = 3\nequipped = 2\n";
/// Folders into which the guides simulate.
const FOLDERS: [&str; 4] = [".", "DIR", "city", "legs"];
/// Options and subcommands of commands that do not end by themselves or use ports.
const ENDLESS: [&str; 9] =
    [" run ", " record ", " demo", " cluster ", "--serve", "--udp", "--loop", "--to-inputs", "--network"];

/// The commands of the guides that run the program, with their places, except those of the tutorial, which has its own test.
fn commands() -> Vec<(String, String)> {
    let mut found = Vec::new();
    let is_guide = |page: &Path| page.parent() == Some(&root().join("docs"));
    for page in pages(&root().join("docs")).into_iter().filter(|page| is_guide(page)) {
        let text = fs::read_to_string(&page).unwrap();
        let name = page.file_name().unwrap().to_string_lossy().into_owned();
        for fenced in parts(&text).1.into_iter().filter(|fenced| fenced.language == "sh") {
            // A line that ends in a backslash is continued.
            let joined = fenced.text.replace("\\\n", " ");
            let of_program = |line: &&str| line.starts_with("utm-fusion ") || line.contains("| utm-fusion ");
            let lines = joined.lines().filter(of_program).map(without_comment);
            found.extend(lines.map(|line| (format!("{name}:{}", fenced.line), line)));
        }
    }
    found
}

/// The command without comment, background operator and formatting of its output.
fn without_comment(line: &str) -> String {
    let command = line.split(" #").next().unwrap_or_default();
    let command = command.split(" | jq").next().unwrap_or_default();
    command.trim_end().trim_end_matches('&').trim_end().to_owned()
}

/// The command with the small flight in place of a scenario, which must exist.
fn on_the_flight(command: &str) -> String {
    let words = command.split(' ').map(|word| {
        if word.starts_with("config/scenarios/") {
            assert!(root().join(word).exists(), "{command}: no {word}");
            return "small.toml";
        }
        word
    });
    // An existing file is not overwritten.
    words.collect::<Vec<_>>().join(" ").replace("--config-out site.toml", "--config-out new.toml")
}

#[test]
fn commands_of_the_guides_run_as_printed() {
    let scratch = Scratch::new();
    let program = Path::new(env!("CARGO_BIN_EXE_utm-fusion")).parent().unwrap().to_path_buf();
    let path = env::split_paths(&env::var_os("PATH").unwrap()).collect::<Vec<_>>();
    let path = env::join_paths(std::iter::once(program).chain(path)).unwrap();
    let ran = |command: &str| -> Output {
        let mut shell = Command::new("sh");
        shell.args(["-c", command]).current_dir(scratch.path("")).env("PATH", &path).stdin(Stdio::null());
        shell.output().unwrap()
    };
    scratch.file("small.toml", FLIGHT);
    for folder in FOLDERS {
        assert!(ran(&format!("utm-fusion simulate small.toml --out {folder}")).status.success());
    }
    for to in ["mixed.pcap", "radar.pcap", "before.pcap"] {
        fs::copy(scratch.path("capture.pcap"), scratch.path(to)).unwrap();
    }
    for prepared in [
        "utm-fusion replay capture.pcap --config site.toml -o out.csv",
        "echo '{\"cat\":10, \"items\":{\"010\":{\"sac\":25, \"sic\":7}, \"000\":1, \"140\":43200.5}}' | utm-fusion encode - -o surface.ast",
    ] {
        assert!(ran(prepared).status.success(), "{prepared}");
    }
    let commands = commands();
    let (mut run, mut parsed) = (0, 0);
    for (place, command) in &commands {
        // The recording of the reader's service, named by a variable.
        if command.contains('$') {
            continue;
        }
        let is_endless = ENDLESS.iter().any(|word| format!("{command} ").contains(word));
        let asked = on_the_flight(command) + if is_endless { " --help" } else { "" };
        *(if is_endless { &mut parsed } else { &mut run }) += 1;
        let output = ran(&asked);
        let stderr = String::from_utf8_lossy(&output.stderr);
        // A flight of 20 s may miss a threshold.
        let is_done =
            output.status.success() || asked.contains("--require") && output.status.code() == Some(5);
        assert!(is_done, "{place}: {asked}: {:?}\n{stderr}", output.status.code());
    }
    assert!(run >= 25 && parsed >= 8, "only {run} run, {parsed} parsed: {commands:?}");
}
