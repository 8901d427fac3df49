//! One short name per aircraft, the same in the map, the table, the alerts and the conflicts.

use std::fs;

use super::browser::Browser;
use super::service::{self, Service};
use super::{BADGE, DRAWN, ROWS, SOON, fresh_folder, installed};

const NAMES: &str = "[...document.querySelectorAll('#table-body td.number')].map(cell => cell.textContent)";

#[test]
fn serials_with_one_ending_have_different_names() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-naming");
    service::simulate(&folder, "event");
    let service = Service::replay_in("operational", &folder, 0);
    service.order("pause");
    service.seek("09:02:00");
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} > 5"), SOON + SOON);
    browser
        .wait("!document.getElementById('welcome').hidden && document.getElementById('legend').open", SOON);
    browser.wait(&format!("new Set({NAMES}).size === {NAMES}.length"), SOON);
    browser.wait(DRAWN, SOON);
    fs::write(folder.join("first-view.png"), browser.screenshot()).unwrap();
    browser.run("document.getElementById('welcome-close').click()");
    browser.run("document.querySelector('#table-body tr:not(.spacer)').click()");
    let first = "document.querySelector('#table-body tr:not(.spacer) td.number').textContent";
    browser.wait(&format!("document.querySelector('#detail h2').textContent.startsWith({first})"), SOON);
    browser.wait(DRAWN, SOON);
    fs::write(folder.join("detail.png"), browser.screenshot()).unwrap();
    assigned_name_stays_while_the_aircraft_is_shown(&mut browser);
    browser.resize(390, 844, true);
    browser.wait(DRAWN, SOON);
    let share = "(() => { const height = id => document.querySelector(id).getBoundingClientRect().height; \
        return Math.round(100 * height('#sheet') / height('main')); })()";
    assert!((65..=68).contains(&browser.number(share)), "the details are a sheet of two thirds");
    let small = "[...document.querySelectorAll('#detail button')].filter(node => node.getBoundingClientRect().height < 36).length";
    assert_eq!(browser.number(small), 0, "buttons are too small for a finger");
    fs::write(folder.join("phone.png"), browser.screenshot()).unwrap();
    browser.run("location.reload()");
    // The page before may still answer.
    browser.wait("document.getElementById('welcome').hidden", SOON);
    browser.wait(&format!("document.readyState === 'complete' && {BADGE} === 'REPLAY paused'"), SOON);
    browser.wait("document.getElementById('welcome').hidden", SOON);
}

fn assigned_name_stays_while_the_aircraft_is_shown(browser: &mut Browser) {
    let names = browser.text(
        "import('./names.js').then(({nameTracks, shortName}) => { \
            const track = (id, serial) => ({id, serial, source: 'fused', name: id, properties: {}}); \
            const [a, b, c] = [track('1', 'AAA00002'), track('2', 'BBA00002'), track('3', 'CCC00003')]; \
            const d = track('4', 'DDD00003'); \
            const show = (...tracks) => { \
                nameTracks(tracks, new Set(tracks.map(({serial}) => serial))); \
                return tracks.map(shortName).join(); }; \
            return [show(a, b, c), show(a, b, c, d), show(a, d)].join(' '); })",
    );
    assert_eq!(names, "AA00002,BA00002,00003 AA00002,BA00002,00003,D00003 AA00002,D00003");
}

/// A recording across midnight: a typed time is the one in the recording, and another time is an error.
#[test]
fn typed_time_is_found_across_midnight_or_refused() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-typed");
    service::simulate(&folder, "crossing");
    let service = Service::replay(&folder, 0);
    service.order("pause");
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    browser.wait(&format!("{BADGE} === 'REPLAY paused'"), SOON);
    let times = browser.text(
        "import('./replay.js').then(({Replay}) => { \
            const made = Object.create(Replay.prototype); \
            const asked = []; \
            Object.assign(made, {time: Date.parse('2026-03-14T23:58:00Z'), seek: time => asked.push(new Date(time).toISOString()), \
                state: {start: '2026-03-14T23:55:00.125Z', end: '2026-03-15T00:05:00Z'}}); \
            for (const text of ['00:01:00', '23:56', '2026-03-15 00:02:03', '23:55:00', '12:00:00', '25:00', 'x']) made.seekTyped(text); \
            return asked.join(' '); })",
    );
    assert_eq!(
        times,
        "2026-03-15T00:01:00.000Z 2026-03-14T23:56:00.000Z 2026-03-15T00:02:03.000Z 2026-03-14T23:55:00.000Z"
    );
    let type_time = |text: &str| {
        format!(
            "(() => {{ document.getElementById('replay-time').value = '{text}'; \
                document.getElementById('replay-seek').requestSubmit(); }})()"
        )
    };
    let error = "document.getElementById('replay-error').textContent";
    browser.run(&type_time("12:00:00"));
    browser
        .wait(&format!("{error}.startsWith('Not in the recording, which is from 2026-03-14 09:00:')"), SOON);
    browser.run(&type_time("09:01:30"));
    browser.wait(
        &format!("{error} === '' && document.getElementById('utc').textContent.startsWith('09:01:3')"),
        SOON,
    );
}
