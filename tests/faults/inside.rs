//! Runs a test again in its own process, with its own namespaces or limits.

use std::process::{Command, Stdio};

/// Environment variable that is set in that process.
const INSIDE: &str = "UTM_FUSION_TESTS_INSIDE";

/// Whether this process already runs inside `command`. Otherwise, runs the test of this name in such a process; if the
/// system does not permit that, prints a message.
pub(crate) fn is_inside(command: &[&str], test: &str) -> bool {
    if std::env::var_os(INSIDE).is_some() {
        return true;
    }
    let around = |program: &str| {
        let mut around = Command::new(command[0]);
        around.args(&command[1..]).arg(program);
        around
    };
    let tried = around("true").stdout(Stdio::null()).stderr(Stdio::null()).status();
    if !tried.is_ok_and(|status| status.success()) {
        eprintln!("skipped: {test}: `{}` is not possible here", command.join(" "));
        return false;
    }
    let this = std::env::current_exe().unwrap();
    let status = around(this.to_str().unwrap())
        .args([test, "--exact", "--nocapture"])
        .env(INSIDE, "1")
        .status()
        .unwrap();
    assert!(status.success(), "{test} failed inside `{}`", command.join(" "));
    false
}

/// Runs a command that must succeed.
pub(crate) fn must(command: &str) {
    let mut words = command.split_whitespace();
    let status = Command::new(words.next().unwrap()).args(words).status();
    assert!(status.is_ok_and(|status| status.success()), "{command}");
}
