//! Past pictures on a live service, with simulated answers from the history.

use super::browser::Browser;
use super::service::Service;
use super::{BADGE, ROWS, SOON, fresh_folder, installed};

/// A past picture with one track that does not exist now.
const SNAPSHOT: &str = r#"{"type":"FeatureCollection","time":"2026-03-14T08:00:00.125Z","site":"demo","numberMatched":1,"numberReturned":1,
    "features":[{"type":"Feature","id":"U-77","geometry":{"type":"Point","coordinates":[-0.58,52.51]},
    "properties":{"id":"U-77","source":"radar","track_number":77,"time":"2026-03-14T08:00:00.125Z","lat":52.51,"lng":-0.58,"alt_msl":99.0}}]}"#;

#[test]
fn the_past_is_shown_as_such_and_left_again() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-past");
    let service = Service::demo();
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    browser.wait(&format!("{BADGE}.startsWith('LIVE') && {ROWS} > 0"), SOON + SOON);
    browser.fail(&[("/api/v1/snapshot", 200, SNAPSHOT)]);
    browser.run("document.getElementById('past-button').click()");
    browser.wait(&format!("{BADGE} === 'PAST 08:00:00'"), SOON);
    browser.wait("document.body.classList.contains('past')", SOON);
    browser.wait(
        &format!("{ROWS} === 1 && document.querySelector('#table-body td.number').textContent === 'R 77'"),
        SOON,
    );
    // The stream continues but is not shown.
    std::thread::sleep(std::time::Duration::from_secs(3));
    browser.wait(&format!("{ROWS} === 1 && {BADGE} === 'PAST 08:00:00'"), SOON);
    browser.fail(&[("/api/v1/snapshot", 404, r#"{"detail":"the history has no picture of that time"}"#)]);
    browser.run("document.getElementById('past-back').click()");
    browser.wait("document.getElementById('past-error').textContent === 'Not shown: HTTP 404: the history has no picture of that time'", SOON);
    browser.fail(&[]);
    browser.run("document.getElementById('past-live').click()");
    browser.wait(&format!("{BADGE}.startsWith('LIVE') && {ROWS} > 1"), SOON);
    browser.wait("!document.body.classList.contains('past') && document.getElementById('past').hidden", SOON);
}
