//! The badge and an empty map show the worst condition, whether the service or the page finds it.

use std::fs;

use super::browser::Browser;
use super::service::{self, Service};
use super::{BADGE, DRAWN, ROWS, SOON, fresh_folder, installed};

const LEVEL: &str = "document.getElementById('badge').dataset.level";
const EMPTY: &str = "document.getElementById('map-empty')";
/// Delays the stream of the page by 40 s, as a proxy can, and lets its other requests through.
const DELAYED: &str = "(() => { const add = EventSource.prototype.addEventListener; \
    window.delay = 40000; \
    const shift = text => new Date(Date.parse(text) - window.delay).toISOString(); \
    EventSource.prototype.addEventListener = function (name, take) { \
        return add.call(this, name, event => { \
            const data = JSON.parse(event.data); \
            for (const key of ['time', 'published_at']) if (data[key] && data.seq !== undefined) data[key] = shift(data[key]); \
            take({data: JSON.stringify(data)}); }); }; })()";

#[test]
fn service_without_input_shows_no_data() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-no-data");
    service::simulate(&folder, "crossing");
    let service = Service::without_input(&folder);
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    browser.wait(&format!("{BADGE}.startsWith('NO DATA') && {LEVEL} === 'critical'"), SOON + SOON);
    let ready = browser.number("fetch('readyz').then(answer => answer.status)");
    assert_eq!(ready, 503, "the page and the probe disagree");
    browser.wait(
        &format!("!{EMPTY}.hidden && /^No data: nothing received from gamekeeper/.test({EMPTY}.textContent)"),
        SOON,
    );
    let listed = "document.getElementById('table-empty').textContent";
    browser.wait(&format!("{listed} === {EMPTY}.textContent"), SOON);
    browser.wait(DRAWN, SOON);
    fs::write(folder.join("no-data.png"), browser.screenshot()).unwrap();
    // Once heard, a sensor that fell silent is named with the time.
    browser.fail(&[("/api/v1/sensors", 200, SILENT)]);
    browser.wait(
        &format!("{EMPTY}.textContent === 'No data: radar silent since 2026-03-14 03:15:20 UTC'"),
        SOON + SOON,
    );
    browser.wait(&format!("{BADGE} === 'NO DATA since 03:15:20'"), SOON);
    sensor_without_a_state_is_not_known(&mut browser);
    misplaced_radar_has_a_button(&mut browser);
}

/// A radar whose tracks contradict its position can be moved, and an answer that refuses it is shown.
fn misplaced_radar_has_a_button(browser: &mut Browser) {
    let refusal = r#"{"status": 409, "title": "Conflict", "detail": "there is nothing to apply"}"#;
    browser.fail(&[("/api/v1/sensors", 200, MISPLACED), ("/api/v1/relocations/north", 409, refusal)]);
    let light = "document.querySelector('#sensors [data-id=north] button')";
    // A light opens the panel only while it is closed.
    browser.run("document.getElementById('sensor-panel').hidePopover()");
    browser.wait(&format!("{light}?.getAttribute('aria-label') === 'Sensor north: degraded'"), SOON + SOON);
    browser.run(&format!("{light}.click()"));
    let panel = "document.getElementById('sensor-panel')";
    let says = "31 m west, 14 m north ± 7 m: contradicts its position";
    browser.wait(&format!("{panel}.textContent.includes({says:?})"), SOON);
    let button = format!("{panel}.querySelector('button.decide')");
    browser.wait(&format!("{button}?.textContent === 'Apply this position'"), SOON);
    browser.run(&format!("{button}.focus(), {button}.click()"));
    browser.wait(&format!("{panel}.textContent.includes('there is nothing to apply')"), SOON);
    assert_eq!(browser.text(&format!("String(document.activeElement === {button})")), "true");
    let moved = MISPLACED.replace("\"place\"", "\"relocated\"").leak();
    browser.fail(&[("/api/v1/sensors", 200, moved), ("/api/v1/relocations/north/revoke", 409, refusal)]);
    browser.wait(&format!("{button}?.textContent === 'Use the configured position again'"), SOON + SOON);
    browser.run(&format!("{panel}.hidePopover()"));
}

const MISPLACED: &str = r#"{"type": "FeatureCollection", "time": "2026-03-14T03:15:42Z", "unknown": [], "features": [
    {"type": "Feature", "geometry": null, "properties": {"id": "north", "kind": "radar", "sac": 1, "sic": 1, "state": "degraded",
    "reasons": ["its tracks contradict its position"], "lines": [], "registration": {"mode": "apply", "applied": false, "place":
    {"east_m": -31.2, "north_m": 14.1, "east_sigma_m": 7.3, "north_sigma_m": 7.2, "contradicts": true}}}}]}"#;

/// A camera has neither SAC nor SIC, and no state before its first report.
fn sensor_without_a_state_is_not_known(browser: &mut Browser) {
    browser.fail(&[("/api/v1/sensors", 200, CAMERA)]);
    let light = "document.querySelector('#sensors [data-id=mast] button')";
    browser.wait(&format!("{light}?.getAttribute('aria-label') === 'Sensor mast: not known'"), SOON + SOON);
    browser.run(&format!("{light}.click()"));
    let terms = "[...document.querySelectorAll('#sensor-panel dt')].map(term => term.textContent).join()";
    browser.wait(&format!("{terms} === 'Kind,State'"), SOON);
    browser.wait("!document.getElementById('sensor-panel').textContent.includes('undefined')", SOON);
}

const CAMERA: &str = r#"{"type": "FeatureCollection", "time": "2026-03-14T03:15:41Z", "unknown": [], "features": [
    {"type": "Feature", "geometry": null, "properties": {"id": "mast", "kind": "camera"}}]}"#;

const SILENT: &str = r#"{"type": "FeatureCollection", "time": "2026-03-14T03:15:41Z", "unknown": [], "features": [
    {"type": "Feature", "geometry": null, "properties": {"id": "radar", "kind": "radar", "sac": 25, "sic": 200,
        "state": "outage", "reasons": ["nothing received for 21 s"], "lines": [], "last_seen": "2026-03-14T03:15:20Z"}}]}"#;

#[test]
fn degraded_service_and_delayed_stream_are_not_live() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-condition");
    let service = Service::demo();
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    browser.wait(&format!("/^LIVE −\\d+\\.\\d\\d s$/.test({BADGE}) && {ROWS} > 0"), SOON + SOON);
    browser.wait(&format!("{LEVEL} === 'ok' && {EMPTY}.hidden"), SOON);

    let faulty = r#"{"state": "degraded", "ready": true, "reasons": ["sensor x: degraded"]}"#;
    browser.fail(&[("/api/v1/status", 200, faulty)]);
    browser.wait(&format!("/^DEGRADED −\\d+\\.\\d\\d s$/.test({BADGE}) && {LEVEL} === 'warning'"), SOON);
    browser.wait("document.getElementById('badge').title.includes('sensor x: degraded')", SOON);
    browser.fail(&[]);
    browser.wait(&format!("{BADGE}.startsWith('LIVE')"), SOON);

    // A stream that arrives 40 s late is late, whatever the service reports and however wrong the display's clock is.
    browser.run("(() => { const now = Date.now; Date.now = () => now() - 40000; })()");
    browser.run(DELAYED);
    browser.press("n");
    browser.press("n");
    browser.wait(&format!("/^LATE (39|4\\d) s$/.test({BADGE})"), SOON);
    browser.wait("document.body.classList.contains('stale')", SOON);
    browser.wait(DRAWN, SOON);
    fs::write(folder.join("late.png"), browser.screenshot()).unwrap();
    browser.run("window.delay = 0");
    browser.wait(&format!("{BADGE}.startsWith('LIVE') && !document.body.classList.contains('stale')"), SOON);

    // The banner dates from the last picture, not from the first.
    std::thread::sleep(std::time::Duration::from_secs(4));
    let clock = "Date.parse(`1970-01-01T${document.getElementById('utc').textContent.slice(0, 8)}Z`)";
    let before = browser.number(clock);
    drop(service);
    let since = "Date.parse(`1970-01-01T${/not known since (\\S+)/.exec(document.getElementById('failures').innerText)?.[1]}Z`)";
    browser.wait(&format!("{BADGE}.startsWith('STALE since') && {since} >= {before} - 2000"), SOON);
}
