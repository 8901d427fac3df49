//! A conflict of two drones, as the operator sees it.

use std::collections::BTreeSet;
use std::fs;

use serde_json::Value;

use super::browser::Browser;
use super::service::{self, Service};
use super::{BADGE, DRAWN, ROWS, SOON, fresh_folder, installed};

const LISTED: &str = "document.querySelectorAll('#conflict-rows tr').length";
const IS_HIDDEN: &str = "document.getElementById('conflicts').hidden";
/// Time from the slot shown to the slot of its conflicts, in milliseconds.
const AHEAD_MS: i64 = 6250;

#[test]
fn conflict_is_listed_drawn_and_removed() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-conflicts");
    service::simulate(&folder, "crossing");
    let site = fs::read_to_string(folder.join("site.toml")).unwrap();
    assert_eq!(site.matches("enabled = false").count(), 1, "{site}");
    fs::write(folder.join("site.toml"), site.replace("enabled = false", "enabled = true")).unwrap();
    let conflicts: Vec<Value> =
        service::conflicts(&folder).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let warned = conflicts.iter().find(|conflict| conflict["level"] == "warning").unwrap();
    let time = |conflict: &Value| conflict["time"].as_str().unwrap().parse::<jiff::Timestamp>().unwrap();
    let shown_at = |time: jiff::Timestamp| {
        let shown = time - jiff::SignedDuration::from_millis(AHEAD_MS - 1000);
        shown.strftime("%H:%M:%S").to_string()
    };
    let shown = shown_at(time(warned));
    // A time without conflicts for some seconds, at which the map shows several tracks.
    let is_level = |conflict: &&Value| {
        ["advisory", "warning", "violation"].iter().any(|level| conflict["level"] == *level)
    };
    let seconds: BTreeSet<i64> =
        conflicts.iter().filter(is_level).map(|conflict| time(conflict).as_second()).collect();
    let is_calm = |second: &i64| (-3..=3).all(|beside| !seconds.contains(&(second + beside)));
    let (first, last) = (*seconds.first().unwrap(), *seconds.last().unwrap());
    let calm = (first..last).find(is_calm).expect("a calm time between conflicts");
    let calm = jiff::Timestamp::from_second(calm).unwrap();

    let service = Service::replay_with("operational", &folder, &[]);
    service.order("pause");
    service.seek(&shown);
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} > 2"), SOON);
    browser.wait(&format!("!{IS_HIDDEN} && {LISTED} > 0"), SOON);
    let row = "document.querySelector('#conflict-rows tr').textContent";
    browser.wait(&format!("/(warning|violation)drone/.test({row}) && {row}.includes('in height')"), SOON);
    // With the list open, the same picture has an additional line.
    browser.wait(DRAWN, SOON);
    let pixels = "document.getElementById('canvas').toDataURL()";
    let with_line = browser.text(pixels);
    conflict_line_leads_to_closest_approach(&mut browser);
    browser.run("import('./conflicts.js').then(({ Conflicts }) => { Conflicts.prototype.draw = () => {}; })");
    browser.press("l");
    browser.press("l");
    browser.wait(DRAWN, SOON);
    assert_ne!(browser.text(pixels), with_line);
    missing_conflicts_are_explained(&mut browser);
    // One click selects one of the two drones.
    browser.run("document.querySelector('#conflict-rows button').click()");
    browser.wait("!document.getElementById('detail').hidden", SOON);

    service.seek(&shown_at(calm));
    browser.wait(IS_HIDDEN, SOON);
}

/// Selecting the conflict shows both drones on the screen.
fn conflict_line_leads_to_closest_approach(browser: &mut Browser) {
    let ends = "import('./conflicts.js').then(async ({ Conflicts }) => { \
        const { draw } = Conflicts.prototype; \
        const ends = []; \
        Conflicts.prototype.draw = function (context, view, ...rest) { \
            context.lineTo = (x, y) => { \
                ends.push(view.contains(x, y)); \
                CanvasRenderingContext2D.prototype.lineTo.call(context, x, y); }; \
            draw.call(this, context, view, ...rest); \
            delete context.lineTo; }; \
        document.getElementById('fit').click(); \
        for (let frame = 0; frame < 3; frame++) await new Promise(requestAnimationFrame); \
        Conflicts.prototype.draw = draw; \
        return ends.length > 0 && ends.every(Boolean); })";
    browser.wait(ends, SOON);
}

/// The reason is shown whether the service stops computing conflicts or does not answer.
fn missing_conflicts_are_explained(browser: &mut Browser) {
    let reason = "document.getElementById('conflict-reason').innerText";
    let gone = format!(
        "!{IS_HIDDEN} && {LISTED} === 0 && document.getElementById('conflict-count').innerText === '?'"
    );
    let none = r#"{"computed": false, "reason": "it is switched off", "conflicts": []}"#;
    browser.fail(&[("/conflicts", 200, none)]);
    browser.wait(&format!("{gone} && {reason}.includes('Not known now: it is switched off')"), SOON);
    browser.fail(&[("/conflicts", 500, "{}")]);
    browser.wait(&format!("{gone} && {reason}.includes('HTTP 500')"), SOON);
    browser.fail(&[]);
    browser.wait(&format!("{LISTED} > 0 && {reason} === ''"), SOON);
}
