//! TRACE.md, SECURITY-MODEL.md and ASSURANCE.md: the tests that they name exist, and every row names its evidence.

use std::collections::BTreeMap;
use std::fs;

use crate::pages::{pages, parts, root};

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

/// Whether the text has a test with this name that is run: a function with a test attribute, and not ignored.
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
        let above: Vec<&&str> = lines[..at]
            .iter()
            .rev()
            .take_while(|line| line.starts_with("#[") || line.starts_with("//"))
            .collect();
        let has = |attribute: &str| above.iter().any(|line| line.starts_with(attribute));
        (has("#[test]") || has("#[tokio::test")) && !has("#[ignore")
    };
    lines.iter().enumerate().any(|(at, line)| is_it(line) && is_test(at))
}

#[test]
fn every_test_that_is_named_exists() {
    let mut files = BTreeMap::new();
    for page in ["TRACE.md", "SECURITY-MODEL.md", "ASSURANCE.md"] {
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
    // Functions that are no tests, and ignored tests, are not accepted.
    assert!(!has_test("#[test]\n#[ignore = \"slow\"]\nfn measured() {", "measured"));
    let here = include_str!("trace.rs");
    assert!(
        has_test(here, "every_test_that_is_named_exists")
            && !has_test(here, "named")
            && !has_test(here, "every")
    );
}

/// The names of tests in commands of the documents: `cargo test … NAME`, and in SCALING.md TEST `NAME`.
fn filters(page: &str) -> Vec<String> {
    let (prose, _) = parts(page);
    let mut found = Vec::new();
    for line in prose {
        let pieces: Vec<&str> = line.split('`').collect();
        for (index, code) in pieces.iter().enumerate().filter(|(index, _)| index % 2 == 1) {
            if pieces[index - 1].ends_with("TEST ") {
                found.push((*code).to_owned());
            }
            let Some((_, arguments)) = code.split_once("cargo test ") else { continue };
            let mut words = arguments.split(' ').peekable();
            while let Some(word) = words.next() {
                match word {
                    "-p" | "--test" | "--features" | "--example" => _ = words.next(),
                    option if option.starts_with('-') => {}
                    filter => found.push(filter.rsplit("::").next().unwrap_or(filter).to_owned()),
                }
            }
        }
    }
    found
}

#[test]
fn commands_of_the_documents_select_tests() {
    let mut code = Vec::new();
    let mut folders = vec![root().to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap().flatten() {
            let (path, name) = (entry.path(), entry.file_name());
            if path.is_dir() && name != "target" && !name.to_string_lossy().starts_with('.') {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                code.push(fs::read_to_string(&path).unwrap());
            }
        }
    }
    let mut count = 0;
    for page in pages(&root().join("docs")).into_iter().chain([root().join("CONTRIBUTING.md")]) {
        for filter in filters(&fs::read_to_string(&page).unwrap()) {
            // A name is selected by any part of it; a module by its own.
            let selects = |line: &str| {
                let line = line.trim_start().trim_start_matches("pub ").trim_start_matches("async ");
                (line.starts_with("fn ") && line.contains(&*filter))
                    || line.starts_with(&format!("mod {filter}"))
            };
            let is_there = code.iter().any(|text| text.lines().any(selects));
            assert!(is_there, "{}: no test is selected by {filter}", page.display());
            count += 1;
        }
    }
    assert!(count > 10, "{count} names");
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

/// Each hazard has mitigations with evidence, and states what remains.
#[test]
fn assurance_argues_from_each_hazard_to_its_tests() {
    let text = fs::read_to_string(root().join("docs/ASSURANCE.md")).unwrap();
    let hazards: Vec<&str> = text.split("\n## H").skip(1).collect();
    assert!(hazards.len() >= 5, "{} hazards", hazards.len());
    let mut mitigations = 0;
    for hazard in hazards {
        let name = hazard.lines().next().unwrap();
        assert!(hazard.contains("\nEffect: ") && hazard.contains("\n**Remains.** "), "H{name}");
        let rows =
            hazard.lines().filter(|line| line.starts_with("| ") && *line != "| mitigation | evidence |");
        for row in rows {
            assert!(!named(row).is_empty(), "H{name}: {row}");
            mitigations += 1;
        }
    }
    assert!(mitigations > 30, "{mitigations} mitigations");
}
