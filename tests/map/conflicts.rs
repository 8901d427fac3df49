//! A conflict of two drones, as the operator sees it.

use std::collections::BTreeSet;
use std::fs;

use serde_json::Value;

use super::browser::Browser;
use super::service::{self, Service};
use super::{BADGE, DRAWN, ROWS, SOON, fresh_folder, installed};

const LIST: &str = "document.getElementById('alert-list').innerText";
/// Number of conflicts that are listed beside the alerts.
const OTHERS: &str = "(document.getElementById('other-conflicts').hidden ? 0 : Number(document.getElementById('other-count').textContent))";
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
    browser
        .wait(&format!("/come close in|are too close/.test({LIST}) && {LIST}.includes('in height')"), SOON);
    let others = without_alert(&service);
    browser.wait(&format!("{OTHERS} === {others}"), SOON);
    // The map has a line.
    browser.wait(DRAWN, SOON);
    let pixels = "document.getElementById('canvas').toDataURL()";
    let with_line = browser.text(pixels);
    conflict_line_leads_to_closest_approach(&mut browser);
    browser.run("import('./conflicts.js').then(({ Conflicts }) => { Conflicts.prototype.draw = () => {}; })");
    browser.press("l");
    browser.press("l");
    browser.wait(DRAWN, SOON);
    assert_ne!(browser.text(pixels), with_line);
    missing_conflicts_are_explained(&mut browser, others);
    // One click selects one of the two drones, and shows it in the middle of the map.
    browser.run("document.querySelector('#alert-list .situation').click()");
    browser.wait("!document.getElementById('detail').hidden && location.hash.includes('c=')", SOON);

    service.seek(&shown_at(calm));
    browser.wait(&format!("!/come close in|are too close/.test({LIST}) && {OTHERS} === 0"), SOON);
}

/// Number of conflicts with a level that no alert covers.
fn without_alert(service: &Service) -> usize {
    let alerts = service.get("/api/v1/alerts?kind=conflict");
    let covered: Vec<&Value> =
        alerts["alerts"].as_array().unwrap().iter().map(|alert| &alert["tracks"]).collect();
    let is_covered = |conflict: &&Value| {
        covered.iter().any(|tracks| {
            let tracks = tracks.as_array().unwrap();
            tracks.contains(&conflict["a"]) && tracks.contains(&conflict["b"])
        })
    };
    let conflicts = service.get("/api/v1/conflicts?level=advisory");
    let conflicts = conflicts["conflicts"].as_array().unwrap();
    assert!(conflicts.iter().any(|conflict| is_covered(&conflict)), "{conflicts:?}");
    conflicts.iter().filter(|conflict| !is_covered(conflict)).count()
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
fn missing_conflicts_are_explained(browser: &mut Browser, others: usize) {
    let reason = "document.getElementById('conflict-reason').innerText";
    let none = r#"{"computed": false, "reason": "it is switched off", "conflicts": []}"#;
    browser.fail(&[("/conflicts", 200, none)]);
    browser.wait(&format!("{OTHERS} === 0 && {reason}.includes('not known now: it is switched off')"), SOON);
    browser.fail(&[("/conflicts", 500, "{}")]);
    browser.wait(&format!("{OTHERS} === 0 && {reason}.includes('HTTP 500')"), SOON);
    browser.fail(&[]);
    browser.wait(&format!("{OTHERS} === {others} && {reason} === ''"), SOON);
}
