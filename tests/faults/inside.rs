//! A test that needs a machine of its own: it runs once more in a process with namespaces, or limits, of its own.

use std::process::{Command, Stdio};

/// Set in that process.
const INSIDE: &str = "UTM_FUSION_TESTS_INSIDE";

/// Whether this process is the one with `command` around it. Where it is not, the test of that name is run in one, unless
/// the system does not permit it, which is said.
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
