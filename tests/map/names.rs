//! Accessible names of buttons contain their visible text, which users of voice control speak.

use super::{FUSED_ROW, ROWS, SOON, paused};

/// Visible buttons, or those of the open dialog, whose accessible name lacks a visible word or is empty.
const MISNAMED: &str = "(() => { \
    const words = text => text.toLowerCase().match(/[\\p{L}\\p{N}]+/gu) ?? []; \
    const shown = node => [...node.childNodes].map(child => { \
        if (child.nodeType === Node.TEXT_NODE) return child.data; \
        if (child.nodeType !== Node.ELEMENT_NODE || child.matches('.visually-hidden, [aria-hidden=true]')) return ''; \
        return shown(child); }).join(' '); \
    const dialog = document.querySelector('dialog[open]'); \
    const buttons = [...(dialog ?? document).querySelectorAll('button, a[href], summary, [role=button]')].filter(node => node.checkVisibility()); \
    if (buttons.length < (dialog ? 1 : 10)) return 'only ' + buttons.length + ' buttons'; \
    return buttons \
        .filter(node => { const name = words(node.computedName).join(' '); return !name || !name.includes(words(shown(node)).join(' ')); }) \
        .map(node => `${node.id || node.outerHTML}: named '${node.computedName}', shows '${shown(node)}'`).join('; '); })()";

#[test]
fn every_button_is_named_by_the_words_it_shows() {
    let Some((_, service, mut browser)) = paused("map-names", "operational") else { return };
    browser.open(&service.url());
    browser.wait(&format!("{ROWS} > 2"), SOON);
    assert_eq!(browser.text("document.getElementById('layers-button').computedName"), "Layers");
    for (state, begin, end) in [
        ("the page", "0", "0"),
        (
            "a filter",
            "document.querySelector('#sources button').click()",
            "document.getElementById('filter-clear').click()",
        ),
        (
            "layers",
            "document.getElementById('layers').showPopover()",
            "document.getElementById('layers').hidePopover()",
        ),
        (
            "a sensor",
            "document.querySelector('#sensors button').click()",
            "document.getElementById('sensor-panel').hidePopover()",
        ),
        ("a track", &format!("{FUSED_ROW}?.click()"), "0"),
        (
            "a toast",
            "document.getElementById('toast').hidden = false",
            "document.getElementById('toast').hidden = true",
        ),
        ("help", "document.getElementById('help').showModal()", "document.getElementById('help').close()"),
        (
            "the token",
            "document.getElementById('sign-in').showModal()",
            "document.getElementById('sign-in').close()",
        ),
    ] {
        browser.run(begin);
        assert_eq!(browser.text(MISNAMED), "", "{state}");
        browser.run(end);
    }
    browser.resize(390, 844, true);
    browser.run("document.getElementById('more-button').click()");
    browser.wait("document.getElementById('theme-button').checkVisibility()", SOON);
    assert_eq!(browser.text(MISNAMED), "", "a phone");
}
