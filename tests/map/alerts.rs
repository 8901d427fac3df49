//! An operator handles alerts. Two drones converge: the warning is shown, sounded, acknowledged and logged. A drone enters a
//! closed zone and raises an alarm; another one, which is allowed there, raises none.

use std::time::{Duration, Instant};

use serde_json::Value;

use super::browser::Browser;
use super::encounter::{self, ALLOWED, DESK, GUEST, NOT_ALLOWED, PLACE, RADIUS_M};
use super::service::Service;
use super::{BADGE, ROWS, SOON, fresh_folder, installed};

const LIST: &str = "document.getElementById('alert-list').innerText";
const SAID: &str = "document.getElementById('alert-said').innerText";
const TITLE: &str = "document.title";
/// Records the frequency of every tone from here on, in Hz.
const LISTEN: &str = "window.notes = []; \
    window.OscillatorNode = class extends OscillatorNode { \
        constructor(context, options) { super(context, options); notes.push(options.frequency); } }; 0";
/// Counts notes that only one of the two tones contains.
const OF_WARNING: &str = "notes.filter(hz => hz === 660).length";
const OF_CRITICAL: &str = "notes.filter(hz => hz === 1175).length";

#[test]
fn operator_handles_the_conflict_of_two_drones() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-alerts");
    let service = encounter::paused(&folder, true);
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&format!("{}#sound=1", service.url()));
    browser.wait("document.getElementById('sign-in').open", SOON);
    browser.run(LISTEN);
    sign_in(&mut browser, GUEST);
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} === 2"), SOON);
    blocked_sound_is_reported(&mut browser);
    sound_switch_plays_the_warning(&mut browser);

    service.order("play");
    warning_appears_and_sounds(&mut browser, &service);
    service.order("pause");
    read_only_token_cannot_acknowledge(&mut browser);
    a_click_acknowledges(&mut browser, &service);

    service.order("play");
    let allowed = allowed_aircraft_raises_no_alarm(&service);
    critical_alert_sounds_until_handled(&mut browser, &service);
    service.order("pause");
    assert!(allowed, "both were never inside at once");
    shelved_ones_are_folded_away(&mut browser, &service);
    ended_alerts_are_in_the_history(&mut browser, &service);
    assert_eq!(complaints(&browser), Vec::<&String>::new(), "errors in the console");
}

/// Browser complaints, except about answers to requests without a token.
pub fn complaints(browser: &Browser) -> Vec<&String> {
    browser.complaints().iter().filter(|complaint| !complaint.contains("401 (Unauthorized)")).collect()
}

pub fn sign_in(browser: &mut Browser, token: &str) {
    browser.run(&format!("document.getElementById('token').value = '{token}'"));
    browser.run("document.getElementById('sign-in-form').requestSubmit()");
}

/// The user has not interacted with the page yet.
fn blocked_sound_is_reported(browser: &mut Browser) {
    let blocked = "!document.getElementById('sound-blocked').hidden";
    browser.wait(&format!("{blocked} && document.getElementById('sound').checked"), SOON);
    browser.wait("document.getElementById('sound-state').textContent.includes('blocks')", SOON);
    assert_eq!(browser.number(OF_WARNING), 0);
    browser.click("#sound-blocked");
    browser.wait(&format!("!({blocked}) && {OF_WARNING} === 1"), SOON);
}

fn sound_switch_plays_the_warning(browser: &mut Browser) {
    browser.press("a");
    browser.wait("document.getElementById('alerts').hidden", SOON);
    browser.press("a");
    browser.wait("document.activeElement.id === 'alerts'", SOON);
    browser.click("#sound");
    browser.wait("!location.hash.includes('sound')", SOON);
    browser.click("#sound");
    browser.wait(&format!("location.hash.includes('sound=1') && {OF_WARNING} === 2"), SOON);
    browser.press("a");
    browser.wait("document.getElementById('alerts').hidden", SOON);
}

/// Active alerts that are neither acknowledged nor shelved.
fn waiting(service: &Service) -> Vec<Value> {
    let answer = service.get("/api/v1/alerts");
    let is_quiet = |alert: &&Value| alert["acknowledged"].is_object() || alert["shelved"].is_object();
    answer["alerts"].as_array().unwrap().iter().filter(|alert| !is_quiet(alert)).cloned().collect()
}

/// The conflict of the two drones.
fn conflict(service: &Service) -> Value {
    let answer = service.get("/api/v1/alerts?kind=conflict");
    answer["alerts"][0].clone()
}

fn warning_appears_and_sounds(browser: &mut Browser, service: &Service) {
    let toast = "document.getElementById('toast')";
    browser.wait(&format!("!{toast}.hidden && {toast}.innerText.includes('come close in')"), SOON + SOON);
    browser.wait(&format!("{OF_WARNING} > 2"), SOON);
    assert_eq!(conflict(service)["severity"], "warning");
    browser.wait(&format!("/^[(]\\d+!?[)] /.test({TITLE}) && {TITLE}.includes('come close in')"), SOON);
}

fn read_only_token_cannot_acknowledge(browser: &mut Browser) {
    browser.click("#toast-open");
    browser.wait(&format!("{LIST}.includes('come close in')"), SOON);
    browser.wait("document.getElementById('alert-bar').innerText.includes('control')", SOON);
    browser.wait("document.querySelector('#alert-list .acts button').ariaDisabled === 'true'", SOON);
    browser.run(&format!("{}.click()", button("come close in", "Acknowledge")));
    browser.wait(&format!("{SAID}.includes('may only read')"), SOON);
    browser.click("#alert-bar-token");
    browser.wait("document.getElementById('sign-in').open", SOON);
    sign_in(browser, DESK);
    browser.wait("document.getElementById('alert-bar').hidden", SOON);
}

/// The button labelled `words` of the alert that contains `text`.
fn button(text: &str, words: &str) -> String {
    format!(
        "[...[...document.querySelectorAll('#alerts li')].find(item => item.innerText.includes('{text}')) \
            .querySelectorAll('button')].find(button => button.innerText === '{words}')"
    )
}

fn a_click_acknowledges(browser: &mut Browser, service: &Service) {
    let before = waiting(service).len();
    browser.wait(&format!("{TITLE}.startsWith('({before}')"), SOON);
    browser.run(&format!("{}.id = 'this-one'", button("come close in", "Acknowledge")));
    browser.click("#this-one");
    browser.wait(&format!("/acknowledged by desk at 09:00:\\d\\d/.test({LIST})"), SOON);
    let seen = conflict(service);
    assert_eq!(seen["acknowledged"]["by"], "desk", "{seen}");
    assert_eq!(waiting(service).len(), before - 1);
    let title = if before > 1 { format!("({}", before - 1) } else { String::new() };
    browser.wait(&format!("{TITLE}.startsWith('{title}')"), SOON);
    let lines = service.logged("alert acknowledged");
    assert!(lines.len() == 1 && lines[0].contains("desk") && lines[0].contains("come close"), "{lines:?}");
}

/// While both drones are inside, the zone has one alert, about the drone that is not allowed. Returns whether both ever were
/// inside.
fn allowed_aircraft_raises_no_alarm(service: &Service) -> bool {
    let is_inside = |track: &Value| {
        let position = |name: &str| track["properties"][name].as_f64().unwrap();
        let east = (position("lng") - PLACE.0) * 111_300.0 * PLACE.1.to_radians().cos();
        let north = (position("lat") - PLACE.1) * 111_300.0;
        east.hypot(north) < RADIUS_M - 20.0
    };
    let end = Instant::now() + SOON + SOON;
    while Instant::now() < end {
        let tracks = service.get("/api/v1/tracks");
        let inside = tracks["features"].as_array().unwrap().iter().filter(|track| is_inside(track)).count();
        let alerts = service.get("/api/v1/alerts?kind=area");
        let alerts = alerts["alerts"].as_array().unwrap();
        let texts: Vec<_> = alerts.iter().filter_map(|alert| alert["text"].as_str()).collect();
        assert!(texts.iter().all(|text| !text.starts_with(&ALLOWED[7..])), "{texts:?}");
        if inside == 2 && alerts.len() == 1 {
            assert!(texts[0].starts_with(&NOT_ALLOWED[7..]) && texts[0].contains("Hospital"), "{texts:?}");
            assert_eq!(alerts[0]["severity"], "critical");
            return true;
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    false
}

fn critical_alert_sounds_until_handled(browser: &mut Browser, service: &Service) {
    // The volume is entered, which is more severe than the acknowledged alert.
    browser.wait(&format!("{LIST}.includes('are too close')"), SOON);
    // Paused, because on a slow machine the encounter would end before the actions.
    service.order("pause");
    assert!(conflict(service).get("acknowledged").is_none());
    browser.wait(&format!("/^[(]\\d+![)] /.test({TITLE})"), SOON);
    let heard = browser.number(OF_CRITICAL);
    browser.wait(&format!("{OF_CRITICAL} >= {heard} + 4"), SOON); // two per tone
    for _ in 0..waiting(service).len() {
        browser.run("[...document.querySelectorAll('#alert-list button')].find(button => button.innerText === 'Acknowledge' && !button.hidden).focus()");
        let before = browser.number("document.querySelectorAll('#alert-list [data-seen=true]').length");
        browser.run("document.activeElement.click()"); // as Enter does
        browser.wait(
            &format!("document.querySelectorAll('#alert-list [data-seen=true]').length > {before}"),
            SOON,
        );
        browser.wait("document.getElementById('alerts').contains(document.activeElement)", SOON);
    }
    browser.wait(&format!("!{TITLE}.startsWith('(')"), SOON);
    let heard = browser.number(OF_CRITICAL);
    std::thread::sleep(Duration::from_secs(6)); // longer than its repetition interval
    assert_eq!(browser.number(OF_CRITICAL), heard, "it sounds although all is acknowledged");
}

fn shelved_ones_are_folded_away(browser: &mut Browser, service: &Service) {
    browser.run(&format!("{}.click()", button("Hospital", "Shelve, note…")));
    browser.wait("document.activeElement.closest('.alert-form') !== null", SOON);
    browser.type_text("ambulance, agreed by phone");
    browser.run(&format!("{}.click()", button("Hospital", "15 min")));
    browser.wait("document.getElementById('shelved-count').innerText === '1' && !document.getElementById('alert-shelved').open", SOON);
    browser.wait(&format!("!{LIST}.includes('Hospital')"), SOON);
    let alerts = service.get("/api/v1/alerts?kind=area,area-predicted");
    let shelved = &alerts["alerts"][0]["shelved"];
    assert_eq!((&shelved["by"], &shelved["note"]), (&"desk".into(), &"ambulance, agreed by phone".into()));
    browser.click("#alert-shelved summary");
    browser.wait("document.getElementById('shelved-list').innerText.includes('by desk at 09:00:')", SOON);
    browser.run(&format!("{}.click()", button("Hospital", "Unshelve")));
    browser.wait(
        &format!("document.getElementById('alert-shelved').hidden && {LIST}.includes('Hospital')"),
        SOON,
    );
}

fn ended_alerts_are_in_the_history(browser: &mut Browser, service: &Service) {
    service.order("play");
    let end = Instant::now() + SOON + SOON;
    // Another alert may have come and gone before it.
    loop {
        let alerts = service.get("/api/v1/alerts?kind=conflict");
        let mut ended = alerts["ended"].as_array().into_iter().flatten();
        if ended.any(|alert| alert["acknowledged"]["by"] == "desk") {
            break;
        }
        assert!(Instant::now() < end, "the conflict that was acknowledged does not end: {alerts}");
        std::thread::sleep(Duration::from_millis(200));
    }
    browser.run("document.querySelector('#alert-history summary').click()");
    let history = "document.getElementById('history-list').innerText";
    browser.wait(&format!("{history}.includes('were closest') && {history}.includes('Hospital')"), SOON);
    browser.wait(&format!("{history}.includes('acknowledged by desk')"), SOON);
    browser.run("(() => { const kind = document.getElementById('history-kind'); kind.value = 'conflict'; kind.dispatchEvent(new Event('change')); })()");
    browser.wait(&format!("{history}.includes('were closest') && !{history}.includes('Hospital')"), SOON);
    browser.run("(() => { const since = document.getElementById('history-since'); since.value = '2026-03-14T10:00'; since.dispatchEvent(new Event('change')); })()");
    browser.wait(&format!("{history}.includes('None that is remembered')"), SOON);
}
