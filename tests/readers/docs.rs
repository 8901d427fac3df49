//! `/api/docs` in a browser: it is complete, and each internal link has a target.

use std::collections::BTreeSet;
use std::process::{Command, Stdio};

use crate::program::Scratch;
use crate::service::{Demo, is_installed};

/// Content of the page after its script has run.
fn shown(scratch: &Scratch, url: &str) -> String {
    let output = Command::new("chromium")
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--virtual-time-budget=10000",
        ])
        .arg(format!("--user-data-dir={}", scratch.path("profile").display()))
        .args(["--timeout=30000", "--dump-dom", url])
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output()
        .unwrap();
    String::from_utf8(output.stdout).unwrap()
}

/// Values of an attribute, in order.
fn values<'a>(page: &'a str, attribute: &str) -> Vec<&'a str> {
    page.split(&format!(" {attribute}=\"")).skip(1).map(|rest| rest.split('"').next().unwrap()).collect()
}

#[test]
fn the_page_of_the_api_shows_every_route_event_and_type() {
    if !is_installed("chromium", "--version") {
        return;
    }
    let (scratch, demo) = (Scratch::new(), Demo::start());
    let page = shown(&scratch, &format!("http://{}/api/docs", demo.address));
    let ids = values(&page, "id");
    let known: BTreeSet<&str> = ids.iter().copied().collect();
    assert_eq!(known.len(), ids.len(), "an id is there once");
    for id in ["get-api-v1-tracks", "post-api-v1-correlations", "event-alert", "type-trackproperties", "find"]
    {
        assert!(known.contains(id), "{id}: {page}");
    }
    let links: Vec<&str> =
        values(&page, "href").into_iter().filter_map(|link| link.strip_prefix('#')).collect();
    assert!(links.len() > 200, "{}", links.len());
    links.iter().for_each(|link| assert!(known.contains(link), "#{link}"));
    // Tables label their columns and rows, and scrollable ones can be reached by keyboard.
    let tables = page.matches("<table").count();
    assert_eq!(tables, page.matches("<caption").count());
    assert_eq!(tables, page.matches("role=\"region\" tabindex=\"0\" aria-label=\"").count());
    assert!(!page.contains("could not be read"));
}
