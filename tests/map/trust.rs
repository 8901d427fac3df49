//! A distrusted transponder, as the operator sees it.

use std::fs;

use super::browser::Browser;
use super::service::{self, Service};
use super::{BADGE, DRAWN, ROWS, SOON, fresh_folder, installed};

/// Counts pixels in the critical colour away from the symbols, because the ring is dashed.
const RING: &str = "(() => { const canvas = document.getElementById('canvas'); \
    const {width, height} = canvas; \
    const {data} = canvas.getContext('2d').getImageData(0, 0, width, height); \
    const probe = document.createElement('span'); \
    probe.style.color = 'var(--critical)'; document.body.append(probe); \
    const [r, g, b] = getComputedStyle(probe).color.match(/\\d+/g).map(Number); probe.remove(); \
    let count = 0; \
    for (let at = 0; at < data.length; at += 4) \
        if (Math.abs(data[at] - r) + Math.abs(data[at + 1] - g) + Math.abs(data[at + 2] - b) < 60) count += 1; \
    return count; })()";

#[test]
fn distrusted_transponder_is_marked() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-trust");
    service::fly(&folder, None);
    // An earlier operator verdict.
    let word = r#"{"slot":0,"serial":"000000000001","country":"GB","verdict":"distrusted"}"#;
    fs::write(folder.join("kept.decisions.jsonl"), format!("{word}\n")).unwrap();
    fs::write(folder.join("kept.numbers.json"), "{\"version\":1,\"numbers\":[]}\n").unwrap();
    let kept = folder.join("kept");
    let service = Service::replay_with("operational", &folder, &["--state", kept.to_str().unwrap()]);
    service.order("pause");
    service.seek("09:01:20");
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} > 2"), SOON);

    let failed = "document.querySelectorAll('#table-body td[data-trust=failed]')";
    browser.wait(&format!("{failed}.length === 1 && {failed}[0].textContent === '✕'"), SOON);
    browser.wait("document.getElementById('flagged').textContent.trim() === '1 flagged'", SOON);
    browser.wait(DRAWN, SOON);
    assert!(browser.number(RING) > 20, "no ring is drawn");
    browser.wait("document.getElementById('alert-count').textContent > 0", SOON);

    // Only flagged tracks.
    browser.run("document.getElementById('flagged').click()");
    browser.wait(&format!("{ROWS} === 1 && location.hash.includes('flagged=1')"), SOON);
    browser.run(&format!("{failed}[0].click()"));
    let said = "document.getElementById('detail').textContent";
    browser.wait(&format!("{said}.includes('failed: its position is not to be used')"), SOON);
    browser.wait(&format!("{said}.includes('An operator has said: distrusted')"), SOON);
    assert_eq!(browser.number("document.querySelectorAll('#trust-distrusted').length"), 0);

    // A paused replay refuses decisions, with a message.
    browser.run("document.getElementById('trust-trusted').click()");
    browser.wait(&format!("{said}.includes('HTTP 409: a replay that stands still decides nothing')"), SOON);
    service.order("play");
    browser.wait(&format!("{BADGE} === 'REPLAY'"), SOON);
    browser.run("document.getElementById('trust-trusted').click()");
    browser.wait(&format!("{said}.includes('Decided; it shows with the next slots.')"), SOON);
    browser.wait(&format!("{said}.includes('An operator has said: trusted')"), SOON);
    browser.wait(&format!("{failed}.length === 0 && {said}.includes('verified')"), SOON);
}

/// Number of buttons for decisions on a radar track that is fused with an aircraft's ADS-B, which has no identity of a drone.
const DECISIONS: &str = "import('./detail.js').then(({Detail}) => { \
    const radar = {kind: 'radar', sensor: 'gamekeeper', track_number: 7, log_likelihood_ratio: 9}; \
    const properties = {id: 'U-7', lat: 52, lng: 0, aircraft: {icao24: '3c0001'}, contributors: [radar]}; \
    const last = {id: 'U-7', name: '7', source: 'fused', time: 0, serial: '3c0001', properties}; \
    const detail = Object.assign(Object.create(Detail.prototype), {last, picture: {time: 0}, \
        info: {profile: 'operational', control: true}, verdicts: {section: () => null}, \
        decisions: [{sensor: 'gamekeeper', track_number: 8, uas_id: {serial_number: 'X'}, verdict: 'correlated'}]}); \
    return detail.content('U-7', false).flatMap(part => [...part.querySelectorAll('.decide')]).length; })";

#[test]
fn fused_aircraft_without_a_drone_identity_has_details() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-ads-b");
    let service = Service::demo();
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    browser.wait(&format!("{ROWS} > 0"), SOON + SOON);
    assert_eq!(browser.number(DECISIONS), 0);
}
