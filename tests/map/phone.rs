//! The page on a phone: a small header, a large map, and no label under a button.

use std::fs;

use super::browser::Browser;
use super::{DRAWN, ROWS, SOON, paused};

/// Moves a track to the middle of the left button, and reports for each drawn text whether a button, a note or the legend covers
/// it.
const LABELS: &str = "(async () => { \
    const canvas = document.getElementById('canvas'); \
    const {features} = await fetch('api/v1/tracks').then(answer => answer.json()); \
    const {lat, lng} = features[0].properties; \
    const origin = canvas.getBoundingClientRect(); \
    const button = document.getElementById('zoom-out').getBoundingClientRect(); \
    const [x, y] = [button.left + button.width / 2 - origin.left, button.top + button.height / 2 - origin.top]; \
    const scale = 0.1 + Math.random() * 1e-4; \
    const north = (y - origin.height / 2) / scale, east = (origin.width / 2 - x) / scale; \
    const centre = [lat + north / 111300, lng + east / 111300 / Math.cos(lat * Math.PI / 180)]; \
    const texts = []; \
    const fill = CanvasRenderingContext2D.prototype.fillText; \
    CanvasRenderingContext2D.prototype.fillText = function (text, px, py, ...rest) { \
        const {width} = this.measureText(text); \
        const left = px - {left: 0, center: 0.5, right: 1}[this.textAlign] * width; \
        texts.push([text, left, py - 6, left + width, py + 6]); \
        return fill.call(this, text, px, py, ...rest); }; \
    const changed = new Promise(done => addEventListener('hashchange', done, {once: true})); \
    location.hash = `#c=${centre}&z=${scale}`; \
    await changed; \
    for (let frame = 0; frame < 3; frame++) await new Promise(requestAnimationFrame); \
    CanvasRenderingContext2D.prototype.fillText = fill; \
    const over = [...canvas.parentElement.children].filter(node => node !== canvas && node.checkVisibility()) \
        .map(node => node.getBoundingClientRect()).filter(({width}) => width > 0); \
    const hidden = texts.filter(([, left, top, right, bottom]) => over.some(box => \
        left < box.right - origin.left && box.left - origin.left < right && top < box.bottom - origin.top && box.top - origin.top < bottom)); \
    return JSON.stringify({drawn: texts.length, hidden: [...new Set(hidden.map(([text]) => text))]}); })()";

#[test]
fn a_phone_shows_the_map_and_every_label_on_it() {
    let Some((folder, service, mut browser)) = paused("map-phone", "reference") else { return };
    for (width, height) in [(390, 844), (360, 640)] {
        browser.resize(width, height, true);
        browser.open(&service.url());
        browser.run("location.reload()");
        browser.wait(&format!("document.readyState === 'complete' && {ROWS} > 2"), SOON);
        browser.wait("document.getElementById('badge').textContent === 'REPLAY paused'", SOON);
        let head = "Math.ceil(document.querySelector('header').getBoundingClientRect().height)";
        let head = browser.number(head);
        assert!(head * 100 <= u64::from(height) * 8, "the header takes {head} of {height} pixels");
        let wide = browser.number("document.documentElement.scrollWidth");
        assert!(wide <= u64::from(width), "the page is {wide} pixels wide on a screen of {width}");

        // Clock, sensors and tools are in the menu.
        assert_eq!(browser.number("Number(document.getElementById('utc').checkVisibility())"), 0);
        browser.run("document.getElementById('more-button').click()");
        for id in ["utc", "sensors", "layers-button", "theme-button", "help-button"] {
            browser.wait(&format!("document.getElementById('{id}').checkVisibility()"), SOON);
        }
        browser.run("document.getElementById('more-button').click()");

        // The card of the first visit hides what is below it until it is dismissed; it is not shown again.
        if width == 390 {
            browser.click("#welcome-close");
        }
        browser.wait("document.getElementById('welcome').hidden", SOON);

        the_note_of_new_alerts_is_two_lines(&mut browser);
        // A panel that opens or closes meanwhile moves the labels with the next frame.
        let mut labels = serde_json::Value::Null;
        for _ in 0..5 {
            labels = serde_json::from_str(&browser.text(LABELS)).unwrap();
            if labels["hidden"] == serde_json::json!([]) {
                break;
            }
        }
        assert!(labels["drawn"].as_u64() > Some(4), "hardly anything is drawn: {labels}");
        assert_eq!(labels["hidden"], serde_json::json!([]), "labels below buttons");
        browser.wait(DRAWN, SOON);
        fs::write(folder.join(format!("phone-{width}.png")), browser.screenshot()).unwrap();
    }
    assert_eq!(browser.complaints(), Vec::<String>::new(), "errors in the console");
}

/// However long its text is, the note covers no button of the map, and disappears when dismissed.
fn the_note_of_new_alerts_is_two_lines(browser: &mut Browser) {
    let toast = "document.getElementById('toast')";
    browser.run(
        "import('./news.js').then(({News}) => { \
            const news = new News({open: () => {}, changed: () => {}, told: () => {}, acknowledge: () => {}}); \
            for (const n of [1, 2, 3, 4]) news.note({id: `area-${n}`, kind: 'area', track: `U-${n}`, severity: 'critical', since: '', \
                text: 'fused track 20000 (U-20000), serial 000000000002, is inside Hospital (CLOSED1), where flights are prohibited'}, false); })",
    );
    let look = format!(
        "(() => {{ const box = {toast}.getBoundingClientRect(); \
            const buttons = [...document.querySelectorAll('header button, .map-tools button, #sheet-button, #legend summary, #tool-bar button')]; \
            const over = buttons.filter(button => button.checkVisibility()).filter(button => {{ \
                const {{left, top, right, bottom}} = button.getBoundingClientRect(); \
                return left < box.right && box.left < right && top < box.bottom && box.top < bottom; }}); \
            return JSON.stringify({{height: box.height, over: over.map(button => button.id || button.textContent), \
                inside: box.left >= 0 && box.right <= innerWidth && box.bottom <= innerHeight}}); }})()"
    );
    for tool in ["0", "document.getElementById('measure-button').click()"] {
        browser.run(tool);
        browser.wait(&format!("!{toast}.hidden && {toast}.innerText.includes('Show all 4')"), SOON);
        let seen: serde_json::Value = serde_json::from_str(&browser.text(&look)).unwrap();
        assert!(seen["height"].as_f64() < Some(80.0) && seen["inside"] == true, "{seen}");
        assert_eq!(seen["over"], serde_json::json!([]), "the note lies over buttons");
    }
    browser.run("document.getElementById('tool-end').click()");
    browser.click("#toast-close");
    browser.wait(&format!("{toast}.hidden"), SOON);
}
