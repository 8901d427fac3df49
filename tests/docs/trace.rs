//! TRACE.md and SECURITY-MODEL.md: the tests that they name exist, and every row of the trace names its evidence.

use std::collections::BTreeMap;
use std::fs;

use crate::pages::{parts, root};

/// The tests named on a page as `file::name` in backticks.
fn named(page: &str) -> Vec<(String, String)> {
    let (prose, _) = parts(page);
    let code = prose.iter().flat_map(|line| line.split('`').skip(1).step_by(2));
    let test = |code: &str| {
        let (file, name) = code.split_once(".rs::")?;
        Some((format!("{file}.rs"), name.to_owned()))
    };
    code.filter_map(test).collect()
}

/// Whether the text has a test with this name: a function with a test attribute.
fn has_test(text: &str, name: &str) -> bool {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let is_it = |line: &str| {
        ["fn ", "async fn "].iter().any(|start| {
            line.strip_prefix(start)
                .and_then(|rest| rest.strip_prefix(name))
                .is_some_and(|rest| rest.starts_with('('))
        })
    };
    let is_test = |at: usize| {
        let above =
            lines[..at].iter().rev().take_while(|line| line.starts_with("#[") || line.starts_with("//"));
        above.into_iter().any(|line| line.starts_with("#[test]") || line.starts_with("#[tokio::test"))
    };
    lines.iter().enumerate().any(|(at, line)| is_it(line) && is_test(at))
}

#[test]
fn every_test_that_is_named_exists() {
    let mut files = BTreeMap::new();
    for page in ["TRACE.md", "SECURITY-MODEL.md"] {
        let text = fs::read_to_string(root().join("docs").join(page)).unwrap();
        let tests = named(&text);
        assert!(tests.len() > 25, "{page} names {} tests", tests.len());
        for (file, name) in tests {
            let text = files.entry(file.clone()).or_insert_with(|| {
                fs::read_to_string(root().join(&file)).unwrap_or_else(|_| panic!("{page}: {file}?"))
            });
            assert!(has_test(text, &name), "{page}: {file} has no test {name}");
        }
    }
    // Functions that are no tests are not accepted.
    let here = include_str!("trace.rs");
    assert!(
        has_test(here, "every_test_that_is_named_exists")
            && !has_test(here, "named")
            && !has_test(here, "every")
    );
}

/// Each rule has a test, is stated to have none, or is stated to be departed from with the page that gives the reason.
#[test]
fn every_rule_has_a_test_or_a_statement() {
    let text = fs::read_to_string(root().join("docs/TRACE.md")).unwrap();
    let is_row = |line: &&str| line.starts_with("| ") && !line.ends_with("| shown by |");
    let rows = text.lines().filter(is_row);
    let (mut count, mut without) = (0, 0);
    for row in rows {
        let shown = row.trim_end_matches(" |").rsplit(" | ").next().unwrap();
        let (none, departs) = (shown.starts_with("none"), shown.contains("departs: see ["));
        assert!(none || departs || shown.contains(".rs::"), "{row}");
        count += 1;
        without += usize::from(none);
    }
    println!("{count} rules, {without} without a test");
    assert!(count > 100 && without > 0);
}
