//! A new alert while the attention list is closed: the title, a screen reader and a toast announce it with the text of the service.

use super::browser::Browser;
use super::service::{self, Service};
use super::{ROWS, SOON, fresh_folder, installed, paused};

const TOAST: &str = "document.getElementById('toast')";
/// Records every announcement from here on; each is replaced after 5 s.
const LISTEN: &str = "window.said = []; \
    new MutationObserver(() => window.said.push(document.getElementById('alert-announcement').textContent)) \
        .observe(document.getElementById('alert-announcement'), {childList: true, characterData: true, subtree: true})";

#[test]
fn new_alert_is_announced_while_panel_is_closed() {
    let Some((_, service, mut browser)) = paused("map-news", "reference") else { return };
    browser.open(&service.url());
    browser.wait(&format!("{ROWS} > 2"), SOON);
    browser.wait("/^[(]\\d+!?[)] /.test(document.title)", SOON);
    browser.click("#alerts-close");
    assert_eq!(browser.text(&format!("String({TOAST}.hidden)")), "true", "what was there before is no news");

    // The radar falls silent.
    browser.run(LISTEN);
    service.seek("09:02:50");
    let text = "fetch('api/v1/alerts').then(answer => answer.json()).then(({alerts}) => \
        alerts.find(({severity}) => severity === 'critical')?.text ?? '')";
    browser.wait(&format!("({text}).then(text => text !== '')"), SOON);
    let text = browser.text(text);
    // The duration in the text changes; the text before it identifies the alert.
    let begin = &text[..text.find(" for ").unwrap()];
    assert!(begin.starts_with("gamekeeper outage: "), "{text}");
    browser.wait(
        &format!("!{TOAST}.hidden && {TOAST}.checkVisibility() && {TOAST}.innerText.includes({begin:?})"),
        SOON,
    );
    browser
        .wait(&format!("/^[(]\\d+!?[)] /.test(document.title) && document.title.includes({begin:?})"), SOON);
    browser.wait(
        &format!(
            "window.said.some(said => said.startsWith('New alert, critical: ') && said.includes({begin:?}))"
        ),
        SOON,
    );
    let live = "document.getElementById('alert-announcement').getAttribute('role')";
    assert_eq!(browser.text(live), "status");
    assert_eq!(browser.number("Number(document.getElementById('alerts').hidden)"), 1, "nobody has opened it");

    // The toast opens the panel, which has the service's text; then the alert counts as seen.
    browser.run("document.getElementById('toast-open').click()");
    browser.wait(&format!("{TOAST}.hidden && document.activeElement.id === 'alerts'"), SOON);
    browser.wait(&format!("document.getElementById('alert-list').innerText.includes({begin:?})"), SOON);
    browser.wait(&format!("!document.title.includes({begin:?})"), SOON);
    assert_eq!(browser.complaints(), Vec::<String>::new(), "errors in the console");
}

/// An alert that comes and goes every second is announced once, unless it becomes more severe. Its end is announced.
#[test]
fn flapping_alert_is_announced_once() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-flapping");
    service::fly(&folder, None);
    let service = Service::replay(&folder, 0);
    service.order("pause");
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    browser.wait("/^\\d+$/.test(document.getElementById('alert-count').textContent)", SOON);
    let told = "import('./news.js').then(({News}) => { \
        const news = new News({open: () => {}, changed: () => {}, told: () => {}, acknowledge: () => {}}); \
        const toast = document.getElementById('toast'); \
        const alert = (n, severity = 'warning') => ({id: `sensor-${n}`, kind: 'sensor', sensor: 'north', severity, text: `north ${severity}`}); \
        const seen = []; \
        const look = () => seen.push(toast.hidden ? '-' : toast.querySelector('ul').innerText.replaceAll('\\n', ' ')); \
        look(); \
        news.note(alert(1), false); look(); \
        news.over(alert(1)); look(); \
        document.getElementById('toast-close').click(); news.seen(); look(); \
        for (let n = 2; n < 30; n++) { news.note(alert(n), false); news.over(alert(n)); } look(); \
        news.note(alert(30, 'critical'), false); look(); \
        news.note({...alert(31), sensor: 'south', text: 'south'}, true); look(); \
        return seen.join(' | ').replaceAll(/[(]over at [0-9:]+ UTC[)]/g, '(over)'); })";
    assert_eq!(
        browser.text(told).to_lowercase(),
        "- | warning north warning | warning north warning (over) | - | - | critical north critical | critical north critical"
    );
}
