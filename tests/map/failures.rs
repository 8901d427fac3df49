//! When a part of the service fails: the page says which, since when and why, counts nothing that it does not know, and
//! goes on with the rest.

use std::time::Duration;

use super::browser::Browser;
use super::service::{self, Service};
use super::{BADGE, ROWS, SOON, fresh_folder, installed, paused};

/// What is asked for each ten seconds takes its time.
const LATER: Duration = SOON.saturating_mul(2);

const BANNER: &str = "document.getElementById('failures').innerText";
const ALERTS: &str = "document.getElementById('alert-count').textContent";
const COUNTS: &str =
    "[...document.querySelectorAll('#sources .count')].map(count => count.textContent).join()";
const SENSORS: &str = "document.getElementById('sensors').innerText.replaceAll('\\n', ' ')";
const SINCE: &str = r"not known since \d\d:\d\d:\d\d UTC";
/// How many colours are on the map: its ground is one.
const COLOURS: &str = "(() => { const canvas = document.getElementById('canvas'); \
    const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height); \
    return new Set(new Uint32Array(data.buffer)).size; })()";

#[test]
fn what_fails_is_named_and_the_rest_goes_on() {
    let Some((_, service, mut browser)) = paused("map-failures", "reference") else { return };

    // The sensors alone: the tracks are drawn and counted, the sensors are not.
    browser.fail(&[("/api/v1/sensors", 500, "{}")]);
    browser.open(&service.url());
    browser.wait(&format!("/^Sensors: {SINCE} [(]HTTP 500[)]$/.test({BANNER}.trim())"), LATER);
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} > 2 && {COLOURS} > 20"), LATER);
    browser.wait(&format!("/^\\d+,\\d+,\\d+$/.test({COUNTS}) && {COUNTS} !== '0,0,0'"), LATER);
    browser.wait(&format!("{SENSORS} === '? Sensors' && /^\\d+$/.test({ALERTS})"), LATER);
    // Known again: ranges are from the radar, whose place was not known.
    browser.fail(&[]);
    browser.wait("document.getElementById('failures').hidden", LATER);
    browser.wait(&format!("{SENSORS} === '● gamekeeper ● drone-it'"), LATER);
    browser.wait("[...document.querySelectorAll('#table-body td.range')].every(cell => /^\\d+$/.test(cell.textContent))", LATER);
    assert!(browser.number(ROWS) > 2);

    // Later, and with answers that are no answers: what was known is not taken for what is.
    browser.fail(&[
        ("/api/v1/sensors", 503, r#"{"title": "Service Unavailable", "detail": "not now"}"#),
        ("/api/v1/alerts", 200, "nonsense"),
        ("/api/v1/info", 200, "[]"),
    ]);
    for line in [
        format!("^Sensors: {SINCE} [(]HTTP 503: not now[)]$"),
        format!("^Alerts: {SINCE} [(]the answer is not JSON[)]$"),
        format!("^Service: {SINCE} [(]the answer has no profile[)]$"),
    ] {
        browser.wait(&format!("/{line}/m.test({BANNER})"), LATER);
    }
    browser.wait(&format!("{ALERTS} === '?' && document.title.startsWith('(?) ')"), LATER);
    browser.wait(&format!("{SENSORS} === '? gamekeeper ? drone-it' && {ROWS} > 2"), LATER);
    browser.run("document.getElementById('alerts-button').click()");
    browser.wait("/^Not known since /.test(document.getElementById('alert-note').textContent)", LATER);

    // Whether it is live is not known either, and a stream that does not come is no empty sky.
    for (path, badge, banner, counts) in [
        ("/api/v1/info", "LIVE OR REPLAY?", "Service", r"\d+,\d+,\d+"),
        ("/api/v1/stream", "CONNECTING", "Tracks", "[?],[?],[?]"),
    ] {
        browser.fail(&[(path, 500, "")]);
        browser.run("location.reload()");
        browser.wait(&format!("{BADGE} === '{badge}' && /^{banner}: {SINCE}/.test({BANNER})"), LATER);
        browser.wait(&format!("/^{counts}$/.test({COUNTS})"), LATER);
    }
    assert_eq!(
        browser.text("document.getElementById('table-empty').textContent"),
        "The tracks are not known"
    );
    browser.fail(&[]);
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} > 2"), LATER);
    browser.wait("document.getElementById('failures').hidden", LATER);
}

/// A broken stream is no picture of now, from the first moment on.
#[test]
fn what_is_shown_is_old_while_the_stream_is_broken() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-broken");
    service::fly(&folder, None);
    let service = Service::replay(&folder, 0);
    service.seek("09:01:20");
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    browser.wait(&format!("{BADGE} === 'REPLAY' && {ROWS} > 2"), LATER);
    // The service sends on, but what it sends makes no sense.
    browser.run(
        "(() => { const parse = JSON.parse; window.isBroken = true; \
            JSON.parse = text => parse(window.isBroken && text.includes('FeatureCollection') ? 'x' : text); })()",
    );
    browser
        .wait(&format!("{BADGE}.startsWith('STALE since ') && /^Tracks.*: {SINCE}/.test({BANNER})"), LATER);
    browser.wait(&format!("{COUNTS} === '?,?,?'"), LATER);
    browser.run("window.isBroken = false");
    browser.wait(&format!("{BADGE} === 'REPLAY' && document.getElementById('failures').hidden"), LATER);
    browser.wait(&format!("/^\\d+,\\d+,\\d+$/.test({COUNTS})"), LATER);
}
