//! Partial failures of the service: the page shows what failed, since when and why, hides unknown values, and continues with the
//! rest.

use std::time::Duration;

use super::browser::Browser;
use super::service::{self, Service};
use super::{BADGE, ROWS, SOON, fresh_folder, installed, paused};

/// Requests with a period of ten seconds take longer.
const LATER: Duration = SOON.saturating_mul(2);

const BANNER: &str = "document.getElementById('failures').innerText";
const ALERTS: &str = "document.getElementById('alert-count').textContent";
const COUNTS: &str =
    "[...document.querySelectorAll('#sources .count')].map(count => count.textContent).join()";
const SENSORS: &str = "document.getElementById('sensors').innerText.replaceAll('\\n', ' ')";
const SINCE: &str = r"not known since \d\d:\d\d:\d\d UTC";
/// Number of colours on the map; its background is one.
const COLOURS: &str = "(() => { const canvas = document.getElementById('canvas'); \
    const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height); \
    return new Set(new Uint32Array(data.buffer)).size; })()";

#[test]
fn failed_request_is_named_and_the_rest_continues() {
    let Some((_, service, mut browser)) = paused("map-failures", "reference") else { return };

    // Only the sensors fail: tracks are drawn and counted, sensors are not.
    browser.fail(&[("/api/v1/sensors", 500, "{}")]);
    browser.open(&service.url());
    browser.wait(&format!("/^Sensors: {SINCE} [(]HTTP 500[)]$/.test({BANNER}.trim())"), LATER);
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} > 2 && {COLOURS} > 20"), LATER);
    browser.wait(&format!("/^\\d+,\\d+,\\d+,\\d+$/.test({COUNTS}) && {COUNTS} !== '0,0,0,0'"), LATER);
    browser.wait(&format!("{SENSORS} === '? Sensors' && /^\\d+$/.test({ALERTS})"), LATER);
    // Known again. Ranges are from the radar, whose position was unknown.
    browser.fail(&[]);
    browser.wait("document.getElementById('failures').hidden", LATER);
    browser.wait(&format!("{SENSORS} === '● gamekeeper ● drone-it'"), LATER);
    browser.wait("[...document.querySelectorAll('#table-body td.range')].every(cell => /^\\d+$/.test(cell.textContent))", LATER);
    assert!(browser.number(ROWS) > 2);

    // Later failures, and invalid answers: old values must not be shown as current.
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
    browser.wait("/^Not known since /.test(document.getElementById('alert-note').textContent)", LATER);

    // The live state is unknown too, and a stream that does not start is not an empty sky.
    for (path, badge, banner, counts) in [
        ("/api/v1/info", "LIVE OR REPLAY?", "Service", r"\d+,\d+,\d+,\d+"),
        ("/api/v1/stream", "CONNECTING", "Tracks", "[?],[?],[?],[?]"),
    ] {
        browser.fail(&[(path, 500, "")]);
        browser.run("location.reload()");
        browser.wait(&format!("{BADGE} === '{badge}' && /^{banner}: {SINCE}/.test({BANNER})"), LATER);
        browser.wait(&format!("/^{counts}$/.test({COUNTS})"), LATER);
    }
    assert_eq!(
        browser.text("document.getElementById('table-empty').textContent"),
        "The tracks are not known: the service has not answered yet"
    );
    browser.fail(&[]);
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} > 2"), LATER);
    browser.wait("document.getElementById('failures').hidden", LATER);
}

/// With a broken stream the picture is never shown as current, not even at first.
#[test]
fn broken_stream_marks_the_picture_as_old() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-broken");
    service::fly(&folder, None);
    let service = Service::replay(&folder, 0);
    service.seek("09:01:20");
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    browser.wait(&format!("{BADGE} === 'REPLAY' && {ROWS} > 2"), LATER);
    // The service continues to send, but the data are invalid.
    browser.run(
        "(() => { const parse = JSON.parse; window.isBroken = true; \
            JSON.parse = text => parse(window.isBroken && text.includes('FeatureCollection') ? 'x' : text); })()",
    );
    browser
        .wait(&format!("{BADGE}.startsWith('STALE since ') && /^Tracks.*: {SINCE}/.test({BANNER})"), LATER);
    browser.wait(&format!("{COUNTS} === '?,?,?,?'"), LATER);
    browser.run("window.isBroken = false");
    browser.wait(&format!("{BADGE} === 'REPLAY' && document.getElementById('failures').hidden"), LATER);
    browser.wait(&format!("/^\\d+,\\d+,\\d+,\\d+$/.test({COUNTS})"), LATER);
}
