//! The site: its table of contents lists every page once, and all relative links and anchors are valid.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::pages::{anchors, links, pages, root};

const PARTS: [&str; 4] = ["# Tutorial", "# How to", "# Reference", "# Explanation"];

#[test]
fn the_summary_names_every_page_once() {
    let docs = root().join("docs");
    let summary = fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    let parts: Vec<&str> = summary.lines().filter(|line| line.starts_with("# ")).skip(1).collect();
    assert_eq!(parts, PARTS);
    let named = links(&summary);
    let unique: BTreeSet<PathBuf> = named.iter().map(|page| docs.join(page)).collect();
    assert_eq!(unique.len(), named.len(), "a page is named twice");
    let there: BTreeSet<PathBuf> =
        pages(&docs).into_iter().filter(|page| !page.ends_with("SUMMARY.md")).collect();
    assert_eq!(unique, there);
}

/// The reason why a link of a page is not valid.
fn complaint(page: &Path, link: &str) -> Option<String> {
    let (file, anchor) = link.split_once('#').map_or((link, None), |(file, anchor)| (file, Some(anchor)));
    let target = if file.is_empty() { page.to_path_buf() } else { page.parent().unwrap().join(file) };
    if !target.exists() {
        return Some("there is no such file".to_owned());
    }
    let anchor = anchor?;
    let text = fs::read_to_string(&target).ok()?;
    (!anchors(&text).iter().any(|known| known == anchor)).then(|| format!("it has {:?}", anchors(&text)))
}

#[test]
fn every_link_leads_somewhere() {
    let mut all = pages(&root().join("docs"));
    for folder in ["", "asterix", "fusion", "remote-id", "wireshark", "clients", "fuzz"] {
        let readme = root().join(folder).join("README.md");
        all.extend(readme.exists().then_some(readme));
    }
    all.extend(["CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md"].map(|page| root().join(page)));
    let (mut wrong, mut count) = (Vec::new(), 0);
    for page in &all {
        let text = fs::read_to_string(page).unwrap();
        for link in links(&text).iter().filter(|link| !link.contains("://")) {
            count += 1;
            if let Some(why) = complaint(page, link) {
                wrong.push(format!("{}: {link}: {why}", page.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(count > 250, "{count} links");
    // Invalid links are detected.
    let page = root().join("docs/CAT129.md");
    assert!(complaint(&page, "CAT063.md").is_some() && complaint(&page, "CODEC.md#slow").is_some());
    assert!(
        complaint(&page, "CODEC.md#speed").is_none() && complaint(&page, "#what-goes-out-cat129").is_none()
    );
}
