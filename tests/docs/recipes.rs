//! The recipes with `curl` in the guides run as printed against a live service with a flight.

use std::fs;
use std::net::{Ipv4Addr, TcpListener};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::pages::{Fenced, parts, root};
use crate::program::Scratch;

/// Pages whose recipes are run; the tutorial has its own test.
const PAGES: [&str; 4] = ["API.md", "OPERATIONS.md", "ALERTS.md", "COMMANDS.md"];

/// A running service, which is stopped on drop.
struct Served(Child);

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The lines of a page that begin with `curl`, with their places.
fn recipes() -> Vec<(String, String)> {
    let mut recipes = Vec::new();
    for page in PAGES {
        let text = fs::read_to_string(root().join("docs").join(page)).unwrap();
        let fenced = parts(&text).1.into_iter().filter(|fenced| fenced.language == "sh");
        let lines = fenced.flat_map(|Fenced { text, line, .. }| {
            text.lines().map(|text| (line, text.to_owned())).collect::<Vec<_>>()
        });
        let indented =
            text.lines().filter_map(|line| line.strip_prefix("    ")).map(|text| (0, text.to_owned()));
        let curl = lines.chain(indented).filter(|(_, text)| text.starts_with("curl "));
        recipes.extend(curl.map(|(line, text)| (format!("{page}:{line}"), text)));
    }
    recipes
}

/// The output of a command.
fn printed(command: &str) -> String {
    let output = Command::new("sh").args(["-c", command]).stdin(Stdio::null()).output().unwrap();
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn recipes_are_taken_as_printed() {
    if printed("curl --version").is_empty() {
        return println!("skipped: curl is not installed");
    }
    let scratch = Scratch::new();
    let port = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap().local_addr().unwrap().port();
    let service = Command::new(env!("CARGO_BIN_EXE_utm-fusion"))
        .args(["demo", "--http", &port.to_string()])
        .current_dir(scratch.path(""))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    let _served = Served(service.unwrap());
    // Waits for an identity and a radar track, which the recipes need.
    let begun = Instant::now();
    let (identity, sensor, track) = loop {
        assert!(begun.elapsed() < Duration::from_secs(60), "nothing is fused");
        std::thread::sleep(Duration::from_millis(500));
        let tracks = printed(&format!("curl -s 'localhost:{port}/api/v1/tracks?source=fused&limit=1'"));
        let Ok(tracks) = serde_json::from_str::<serde_json::Value>(&tracks) else { continue };
        let fused = &tracks["features"][0]["properties"];
        let parts = fused["contributors"].as_array().into_iter().flatten();
        let Some(radar) = parts.into_iter().find(|part| part["kind"] == "radar") else { continue };
        let Some(identity) = fused["uas_id"].get("serial_number").or(fused["uas_id"].get("serial")) else {
            panic!("{fused}");
        };
        break (
            identity.as_str().unwrap().to_owned(),
            radar["sensor"].as_str().unwrap().to_owned(),
            radar["track_number"].to_string(),
        );
    };
    let recipes = recipes();
    assert!(recipes.len() >= 10, "{recipes:?}");
    for (place, recipe) in recipes {
        let asked = recipe
            .replace("127.0.0.1:8080", &format!("127.0.0.1:{port}"))
            .replace("localhost:8080", &format!("localhost:{port}"))
            .replace("SERIAL", &identity)
            .replace("1581F6GKB23C003", &identity)
            .replace("sensor=north", &format!("sensor={sensor}"))
            .replace("relocations/north", &format!("relocations/{sensor}"))
            .replace("track=134", &format!("track={track}"));
        // The part after a pipe formats the answer.
        let asked = asked.split(" | ").next().unwrap().trim_end();
        let asked = asked.replacen("curl ", "curl --max-time 3 -s -o answer -w '%{http_code}' ", 1);
        let status = printed(&format!("cd {} && {asked}", scratch.path("").display()));
        let answer = fs::read_to_string(scratch.path("answer")).unwrap_or_default();
        // The radar of this flight stands where it should.
        let is_right = asked.contains("/relocations/") && answer.contains("do not contradict its position");
        assert!(status.starts_with('2') || is_right, "{place}: {recipe}\n{asked}\n{status} {answer}");
    }
}
