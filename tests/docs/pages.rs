//! The pages of `docs/` and their parts.

use std::fs;
use std::path::{Path, PathBuf};

/// Folder of the project.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every page in a folder and its subfolders, sorted by name.
pub fn pages(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(pages(&path));
        } else if path.extension().is_some_and(|extension| extension == "md") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// A fenced block.
#[derive(Debug)]
pub struct Fenced {
    /// Language of the block: `sh`.
    pub language: String,
    /// Text of the block.
    pub text: String,
    /// Line of the page on which the block begins, counted from 1.
    pub line: usize,
}

/// The lines of a page without code, and its fenced blocks.
pub fn parts(page: &str) -> (Vec<&str>, Vec<Fenced>) {
    let (mut prose, mut blocks, mut open) = (Vec::new(), Vec::<Fenced>::new(), false);
    for (index, line) in page.lines().enumerate() {
        match line.trim_start().strip_prefix("```") {
            Some(_) if open => open = false,
            Some(language) => {
                open = true;
                blocks.push(Fenced { language: language.to_owned(), text: String::new(), line: index + 1 });
            }
            None if open => {
                let block = blocks.last_mut().unwrap();
                block.text += line;
                block.text.push('\n');
            }
            None => prose.push(line),
        }
    }
    assert!(!open, "a block of code has no end");
    (prose, blocks)
}

/// Targets of the links of a page.
pub fn links(page: &str) -> Vec<String> {
    let (prose, _) = parts(page);
    let of = |line: &&str| -> Vec<String> {
        // The text of a link may be code; its target is not.
        let line = line.replace("`](", "](");
        let targets = without_code(&line);
        targets.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0.to_owned())).collect()
    };
    prose.iter().flat_map(of).collect()
}

/// A line without inline code, except in the texts of links.
fn without_code(line: &str) -> String {
    line.replace("[`", "[").split('`').step_by(2).collect::<Vec<_>>().join("")
}

/// The anchors of a page: its headings as browsers address them.
pub fn anchors(page: &str) -> Vec<String> {
    let (prose, _) = parts(page);
    let headings =
        prose.iter().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    let mut anchors: Vec<String> = Vec::new();
    for heading in headings {
        let anchor: String = heading
            .chars()
            .filter_map(|c| match c {
                c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c.to_ascii_lowercase()),
                c if c.is_whitespace() => Some('-'),
                _ => None,
            })
            .collect();
        // A repeated anchor gets a number.
        let same = anchors.iter().filter(|known| **known == anchor).count();
        anchors.push(if same == 0 { anchor } else { format!("{anchor}-{same}") });
    }
    anchors
}
