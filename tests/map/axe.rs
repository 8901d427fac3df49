//! Every view of the page against the rules of axe-core (WCAG 2 and good practice): light and dark, desktop and phone.
//!
//! `UTM_FUSION_AXE` names the file `axe.min.js` of the npm package `axe-core`. Without it the test reports itself as skipped and
//! passes.

use std::fs;

use super::browser::Browser;
use super::{DRAWN, FUSED_ROW, ROWS, SOON, encounter, fresh_folder, installed, paused};

const ROW: &str = "document.querySelector('#table-body tr:not(.spacer)').click()";

/// Views, with the script that opens each after the page was loaded.
const VIEWS: [(&str, &str); 21] = [
    ("the page of a first visit", "0"),
    ("the page", "document.getElementById('welcome-close').click()"),
    ("legend", "document.getElementById('legend').open = true"),
    (
        "heights",
        "location.hash = '#colour=height&layers=labels,trails,ellipses,raw'; document.getElementById('legend').open = true",
    ),
    ("no attention list", "document.getElementById('alerts-button').click()"),
    ("toast", "document.getElementById('toast').hidden = false"),
    ("track", ROW),
    ("layers", "document.getElementById('layers').showPopover()"),
    ("tools", "document.getElementById('tools').showPopover()"),
    ("filter", "document.getElementById('filter-panel').showPopover()"),
    ("filtered", "document.querySelector('#sources button').click()"),
    ("sensor", "document.querySelector('#sensors button').click()"),
    ("zone", "document.getElementById('zone-button').click()"),
    (
        "zones of operators", // none can be active in a replay
        "document.getElementById('zone-button').click(); import('./activezones.js').then(({ ActiveZones }) => { \
            const zones = new ActiveZones(() => {}, () => {}); \
            zones.setControl(true); \
            const fair = { name: 'Fair', activated_by: 'desk', activated_at: '2026-03-14T09:01:20Z' }; \
            zones.take({ available: true, zones: [fair] }); })",
    ),
    ("measure", "document.getElementById('measure-button').click()"),
    ("history", "document.getElementById('past').hidden = false"),
    ("help", "document.getElementById('help').showModal()"),
    ("token", "document.getElementById('sign-in').showModal()"),
    ("menu", "document.getElementById('more-button').click()"),
    ("sheet", "document.getElementById('sheet-button').click()"),
    ("symbols on one another", "for (let i = 0; i < 8; i++) document.getElementById('zoom-out').click()"),
];

const OPEN: &str = "document.getElementById('alerts').hidden = false;";

/// Views while two drones are too close and one is in a closed zone: scripts that run after `OPEN`, half a second before the
/// check.
const OF_ALERTS: [(&str, &str); 10] = [
    (
        "alerts", // none is shelved any more
        "for (const button of document.querySelectorAll('#shelved-list .acts button:nth-child(2)')) button.click()",
    ),
    ("an alert's form", "document.querySelector('#alert-list [aria-expanded]').click()"),
    ("a situation on the map", "document.querySelector('#alert-list .situation').click()"),
    (
        "conflicts without an alert",
        "document.getElementById('other-conflicts').hidden = false; document.getElementById('other-conflicts').open = true",
    ),
    (
        "the details of a conflict's track",
        "document.querySelector('#alert-list .situation').click(); document.getElementById('alerts-close').click()",
    ),
    ("alerts that ended", "document.getElementById('alert-history').open = true"),
    (
        "a reader who may only look",
        "document.getElementById('alert-bar').hidden = false; \
            document.getElementById('alert-bar-words').textContent = 'You may only look'; \
            for (const button of document.querySelectorAll('#alert-list .acts button')) button.ariaDisabled = 'true'",
    ),
    (
        "what went wrong",
        "document.getElementById('sound-blocked').hidden = false; \
            document.getElementById('alert-said').textContent = 'HTTP 409: the alert has ended'; \
            document.getElementById('conflict-reason').textContent = 'Not known now: no answer'",
    ),
    (
        "an alert that is acknowledged",
        "document.querySelector('#alert-list li[data-seen=false] .acts button:not([hidden])')?.click()",
    ),
    (
        "one that is shelved",
        "document.querySelector('#alert-list .own')?.requestSubmit(); document.getElementById('alert-shelved').open = true",
    ),
];

#[test]
fn no_view_breaks_a_rule_of_accessibility() {
    let Some(axe) = axe() else { return };
    let Some((_, service, mut browser)) = paused("map-axe", "operational") else { return };
    let broken = broken(&mut browser, &axe, &service.url(), &VIEWS.map(|(view, act)| (view, act.to_owned())));
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn no_view_of_alerts_breaks_accessibility() {
    let Some(axe) = axe() else { return };
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-axe-alerts");
    let service = encounter::paused(&folder, false);
    service.seek("09:00:28");
    let mut browser = Browser::start(&program, &folder.join("profile"));
    let wait = "await new Promise(done => setTimeout(done, 500));";
    let listed = format!("while (!document.querySelector('#alerts li')) {wait}");
    let views =
        OF_ALERTS.map(|(view, act)| (view, format!("(async () => {{ {OPEN} {listed} {act}; {wait} }})()")));
    let broken = broken(&mut browser, &axe, &service.url(), &views);
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn no_view_of_a_decision_breaks_accessibility() {
    let Some(axe) = axe() else { return };
    let Some((_, service, mut browser)) = paused("map-axe-decisions", "operational") else { return };
    browser.open(&service.url());
    service.order("play");
    // A pair may be separated at any time; then another fused track is selected.
    let part = decide("Not one aircraft");
    browser.wait(&format!("Boolean({part} ?? ({FUSED_ROW}?.click(), null))"), SOON);
    browser.run(&format!("{part}.click()"));
    browser.wait(&format!("Boolean({})", decide("Decide automatically")), SOON);
    service.order("pause");
    let find = format!(
        "(async () => {{ for (const row of document.querySelectorAll('#table-body tr:not(.spacer)')) {{ \
            row.click(); \
            for (let i = 0; i < 10 && !{}; i++) await new Promise(done => setTimeout(done, 100)); \
            if ({}) return; }} \
            throw new Error('no track has a decision'); }})()",
        decide("Decide automatically"),
        decide("Decide automatically"),
    );
    let broken = broken(&mut browser, &axe, &service.url(), &[("a pair that was parted", find)]);
    assert!(broken.is_empty(), "{broken:#?}");
}

/// The button with these words in the details of a track.
fn decide(words: &str) -> String {
    format!("[...document.querySelectorAll('#detail .decide')].find(one => one.textContent === {words:?})")
}

fn axe() -> Option<String> {
    let Some(file) = std::env::var_os("UTM_FUSION_AXE") else {
        println!("skipped: UTM_FUSION_AXE names no axe.min.js");
        return None;
    };
    Some(fs::read_to_string(file).unwrap())
}

/// Violations in these views, light and dark, desktop and phone.
fn broken(browser: &mut Browser, axe: &str, url: &str, views: &[(&str, String)]) -> Vec<String> {
    let mut broken = Vec::new();
    for (width, height, is_phone) in [(1280, 800, false), (390, 844, true)] {
        browser.resize(width, height, is_phone);
        for theme in ["light", "dark"] {
            for (view, act) in views {
                browser.open("about:blank");
                browser.open(&format!("{url}#theme={theme}"));
                browser.wait(&format!("{ROWS} > 1"), SOON);
                browser.run(&format!("{axe};0"));
                browser.run(act);
                browser.wait(DRAWN, SOON);
                let found = browser.text(
                    "axe.run(document, {resultTypes: ['violations']}).then(({violations}) => violations \
                        .map(({id, nodes}) => `${id}: ${nodes.map(({target}) => target.join(' ')).join(', ')}`).join('; '))",
                );
                if !found.is_empty() {
                    broken.push(format!("{width} pixels, {theme}, {view}: {found}"));
                }
            }
        }
    }
    broken
}
