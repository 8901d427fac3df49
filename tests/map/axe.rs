//! Every view of the page against the rules of axe-core (WCAG 2 and good practice): light and dark, on a desk and on a phone.
//!
//! `UTM_FUSION_AXE` names the file `axe.min.js` of the npm package `axe-core`; without it the test says so and passes.

use std::fs;

use super::{DRAWN, ROWS, SOON, paused};

const ROW: &str = "document.querySelector('#table-body tr:not(.spacer)').click()";

/// What is done after the page was loaded.
const VIEWS: [(&str, &str); 18] = [
    ("the page", "0"),
    ("legend", "document.getElementById('legend').open = true"),
    (
        "heights",
        "location.hash = '#colour=height&layers=labels,trails,ellipses,raw'; document.getElementById('legend').open = true",
    ),
    ("alerts", "document.getElementById('alerts-button').click()"),
    ("toast", "document.getElementById('toast').hidden = false"),
    ("track", ROW),
    ("layers", "document.getElementById('layers').showPopover()"),
    ("tools", "document.getElementById('tools').showPopover()"),
    ("filter", "document.getElementById('filter-panel').showPopover()"),
    ("filtered", "document.querySelector('#sources button').click()"),
    ("sensor", "document.querySelector('#sensors button').click()"),
    ("zone", "document.getElementById('zone-button').click()"),
    ("measure", "document.getElementById('measure-button').click()"),
    ("history", "document.getElementById('past').hidden = false"),
    ("help", "document.getElementById('help').showModal()"),
    ("token", "document.getElementById('sign-in').showModal()"),
    ("menu", "document.getElementById('more-button').click()"),
    ("sheet", "document.getElementById('sheet-button').click()"),
];

#[test]
fn no_view_breaks_a_rule_of_accessibility() {
    let Some(file) = std::env::var_os("UTM_FUSION_AXE") else {
        println!("skipped: UTM_FUSION_AXE names no axe.min.js");
        return;
    };
    let axe = fs::read_to_string(file).unwrap();
    let Some((_, service, mut browser)) = paused("map-axe", "operational") else { return };
    let mut broken = Vec::new();
    for (width, height, is_phone) in [(1280, 800, false), (390, 844, true)] {
        browser.resize(width, height, is_phone);
        for theme in ["light", "dark"] {
            for (view, act) in VIEWS {
                browser.open("about:blank");
                browser.open(&format!("{}#theme={theme}", service.url()));
                browser.wait(&format!("{ROWS} > 2"), SOON);
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
    assert!(broken.is_empty(), "{broken:#?}");
}
