//! `clients`: the types match the documents, and the programs work with the running service; so do the dashboards of
//! `docs/API.md`.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::Duration;

use crate::generate::Documents;
use crate::program::Scratch;
use crate::service::{Demo, Ending, get, is_installed};

/// Timeout of a program that reads a few seconds of the stream.
const PATIENCE: Duration = Duration::from_secs(60);

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_types_are_those_of_the_documents() {
    let demo = Demo::start();
    let documents =
        Documents::new(&get(demo.address, "/openapi.json"), &get(demo.address, "/api/v1/asyncapi.json"));
    for (path, made) in [
        ("clients/typescript/types.d.ts", documents.typescript()),
        ("clients/python/utm_fusion_client/models.py", documents.python()),
    ] {
        let path = root().join(path);
        if std::env::var_os("UPDATE").is_some() {
            std::fs::write(&path, &made).unwrap();
        }
        let kept = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(kept == made, "{} is not up to date: UPDATE=1 makes it anew", path.display());
    }
}

/// Output of a program up to the line with this text.
fn says(command: &mut Command, text: &str) -> String {
    // Node makes an inherited pipe non-blocking for all of its writers.
    let command = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    let output = BufReader::new(child.stdout.take().unwrap());
    // Ending the process ends the reader below.
    let _process = Ending(child);
    let (lines, heard) = mpsc::channel();
    std::thread::spawn(move || output.lines().map_while(Result::ok).try_for_each(|line| lines.send(line)));
    let mut said = String::new();
    while !said.contains(text) {
        let line = heard.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("{text} is not said: {said}"));
        said += &(line + "\n");
    }
    said
}

#[test]
fn the_client_for_javascript_does_what_it_says() {
    if !is_installed("node", "--version") {
        return;
    }
    let demo = Demo::start();
    let check = root().join("clients/typescript/check.mjs");
    says(Command::new("node").arg(check).arg(format!("http://{}", demo.address)), "ok");
}

#[test]
fn the_client_for_python_does_what_it_says() {
    if !is_installed("python3", "--version") {
        return;
    }
    let demo = Demo::start();
    let check = root().join("clients/python/check.py");
    says(python().arg(check).arg(format!("http://{}", demo.address)), "ok");
}

/// Python that finds the client and leaves no compiled files.
fn python() -> Command {
    let mut command = Command::new("python3");
    command.env("PYTHONPATH", root().join("clients/python")).env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

/// The dashboard of `docs/API.md` in this language, with the address of the demo, as a file.
fn dashboard(scratch: &Scratch, language: &str, name: &str, demo: &Demo) -> PathBuf {
    let text = std::fs::read_to_string(root().join("docs/API.md")).unwrap();
    let block = text.split(&format!("```{language}\n")).nth(1).unwrap().split("```").next().unwrap();
    assert!(block.lines().count() <= 10, "{block}");
    let code = block
        .replace("http://127.0.0.1:8080", &format!("http://{}", demo.address))
        .replace("./clients/", &format!("{}/clients/", root().display()));
    assert_ne!(code, block);
    scratch.file(name, code)
}

#[test]
fn the_dashboards_of_the_documentation_run() {
    let (scratch, demo) = (Scratch::new(), Demo::start());
    if is_installed("node", "--version") {
        let file = dashboard(&scratch, "js", "dashboard.mjs", &demo);
        says(Command::new("node").arg(file), "fused");
    }
    if is_installed("python3", "--version") {
        let file = dashboard(&scratch, "python", "dashboard.py", &demo);
        says(python().arg(file), "fused");
    }
}
