//! Operator functions of the map: names, sorting, units, filters, watching, measuring, zones and files.

use super::browser::Browser;
use super::{BADGE, DRAWN, FUSED_ROW, ROWS, SOON, paused};

/// Name in the first row of the table.
const FIRST_NAME: &str = "document.querySelector('#table-body tr:not(.spacer) td.number').textContent";
const FILTERED: &str = "document.getElementById('filtered-text').textContent";

/// Collects saved files in `saved`, by name, instead of writing them to the disk.
const CATCH_FILES: &str = "window.saved = {}; \
    const blobs = new Map(); \
    URL.createObjectURL = blob => { const url = `blob:${blobs.size}`; blobs.set(url, blob); return url; }; \
    HTMLAnchorElement.prototype.click = function () { \
        blobs.get(this.getAttribute('href')).text().then(text => { saved[this.download] = text; }); }; 0";

/// Clicks at this pixel of the map.
fn click(browser: &mut Browser, x: u32, y: u32) {
    browser.run(&format!(
        "(() => {{ const canvas = document.getElementById('canvas'); \
            canvas.setPointerCapture = () => {{}}; \
            const {{left, top}} = canvas.getBoundingClientRect(); \
            for (const type of ['pointerdown', 'pointerup']) canvas.dispatchEvent(new PointerEvent(type, \
                {{pointerId: 1, button: 0, clientX: left + {x}, clientY: top + {y}, bubbles: true}})); }})()"
    ));
}

/// Presses a key on the map that produces no character.
fn key(browser: &mut Browser, key: &str) {
    browser.run(&format!(
        "document.getElementById('canvas').dispatchEvent(new KeyboardEvent('keydown', {{key: '{key}', bubbles: true, cancelable: true}}))"
    ));
}

#[test]
fn an_operator_works_with_the_map() {
    let Some((_, service, mut browser)) = paused("map-operator", "operational") else { return };
    browser.open(&service.url());
    browser.wait(&format!("{ROWS} > 2"), SOON);
    unidentified_aircraft_are_first(&mut browser);
    labels_keep_clear_of_each_other(&mut browser);
    units_are_the_operators(&mut browser);
    filters_say_what_they_leave_out(&mut browser);
    a_watched_track_is_first(&mut browser);
    distances_are_measured(&mut browser);
    browser.run(CATCH_FILES);
    a_zone_is_saved_and_not_active(&mut browser);
    // Runs for some seconds of trail.
    service.order("play");
    std::thread::sleep(std::time::Duration::from_secs(4));
    service.order("pause");
    browser.wait(&format!("{BADGE} === 'REPLAY paused'"), SOON);
    std::thread::sleep(std::time::Duration::from_secs(2));
    view_is_exported(&mut browser);
    assert_eq!(browser.complaints(), Vec::<String>::new(), "errors in the console");
}

fn unidentified_aircraft_are_first(browser: &mut Browser) {
    browser.wait(&format!("/^R \\d+$/.test({FIRST_NAME})"), SOON);
    let sources = "[...document.querySelectorAll('#table-body td.source')].map(cell => cell.dataset.source)";
    browser.wait(&format!("{sources}.lastIndexOf('radar') < {sources}.indexOf('fused')"), SOON);
    // The end of a serial number; the column and the details have all of it.
    browser
        .wait(&format!("{FUSED_ROW}.cells[2].textContent.endsWith({FUSED_ROW}.cells[1].textContent)"), SOON);
    browser.wait(&format!("{FUSED_ROW}.cells[1].textContent.length === 5"), SOON);
}

/// In one frame no two texts of the map overlap, except the two lines of a label, which are 13 pixels apart.
fn labels_keep_clear_of_each_other(browser: &mut Browser) {
    let overlaps = "(async () => { \
        const texts = []; \
        const canvas = document.getElementById('canvas'); \
        const fill = CanvasRenderingContext2D.prototype.fillText; \
        CanvasRenderingContext2D.prototype.fillText = function (text, px, py, ...rest) { \
            const {width} = this.measureText(text); \
            const left = px - {left: 0, center: 0.5, right: 1}[this.textAlign] * width; \
            const top = py - {top: 0, middle: 6, bottom: 12}[this.textBaseline]; \
            texts.push([text, left, top, left + width, top + 12]); \
            return fill.call(this, text, px, py, ...rest); }; \
        const clear = CanvasRenderingContext2D.prototype.fillRect; \
        CanvasRenderingContext2D.prototype.fillRect = function (...box) { \
            if (box[2] === canvas.clientWidth) texts.length = 0; \
            return clear.apply(this, box); }; \
        document.getElementById('zoom-in').click(); \
        for (let frame = 0; frame < 3; frame++) await new Promise(requestAnimationFrame); \
        CanvasRenderingContext2D.prototype.fillText = fill; \
        CanvasRenderingContext2D.prototype.fillRect = clear; \
        const meet = (a, b) => a[1] < b[3] && b[1] < a[3] && a[2] < b[4] && b[2] < a[4]; \
        const pairs = texts.flatMap((one, i) => texts.slice(i + 1).filter(other => meet(one, other)).map(other => `${one[0]} / ${other[0]}`)); \
        return JSON.stringify({drawn: texts.length, pairs}); })()";
    let seen: serde_json::Value = serde_json::from_str(&browser.text(overlaps)).unwrap();
    assert!(seen["drawn"].as_u64() > Some(10), "hardly anything is written: {seen}");
    assert_eq!(seen["pairs"], serde_json::json!([]), "texts over each other");
}

fn choose(browser: &mut Browser, id: &str, value: &str) {
    browser.run(&format!(
        "(() => {{ const list = document.getElementById('{id}'); list.value = '{value}'; list.dispatchEvent(new Event('change')); }})()"
    ));
}

fn units_are_the_operators(browser: &mut Browser) {
    let height = format!("Number.parseFloat({FUSED_ROW}.querySelector('td.height').textContent)");
    browser.run(&format!("window.metres = {height}; window.row = {FUSED_ROW}.dataset.id"));
    choose(browser, "unit-height", "ft");
    choose(browser, "unit-speed", "kt");
    browser.wait(&format!("Math.abs({height} * 0.3048 - metres) < 0.7"), SOON);
    browser.wait("document.querySelector('th.speed').textContent === 'kt'", SOON);
    browser.wait("location.hash.includes('units=ft,kt,m')", SOON);
    // Heights above ground are available only where the ground is known.
    choose(browser, "unit-height", "m-agl");
    browser.wait(&format!("Math.abs({height} - metres) < 0.7"), SOON);
    choose(browser, "ground", "50");
    browser.wait(&format!("Math.abs({height} + 50 - metres) < 1.1"), SOON);
    browser.wait("document.querySelector('th.height button').title.includes('above the ground')", SOON);
    choose(browser, "ground", "");
    choose(browser, "unit-height", "m");
    choose(browser, "unit-speed", "m/s");
}

fn filters_say_what_they_leave_out(browser: &mut Browser) {
    let all = browser.number(ROWS);
    choose(browser, "height-low", "5000");
    // Tracks of unknown height stay.
    browser.wait(&format!("{ROWS} < {all} && {FILTERED}.endsWith('from 5000\\u2009m up')"), SOON);
    browser.wait("[...document.querySelectorAll('#table-body td.height')].every(cell => cell.textContent.startsWith('–'))", SOON);
    browser.run("document.getElementById('filter-clear-all').click()");
    browser.wait(&format!("{ROWS} === {all} && document.getElementById('filtered').hidden"), SOON);
    browser.run("document.querySelector('#kinds input[name=identified]').click()");
    browser.wait(&format!("{ROWS} > 0 && {ROWS} < {all} && {FIRST_NAME}.startsWith('R ')"), SOON);
    browser.wait("[...document.querySelectorAll('#table-body td.source')].every(cell => cell.dataset.source === 'radar')", SOON);
    browser.wait("location.hash.includes('kind=unknown,doubtful')", SOON);
    browser.run("document.getElementById('filter-clear').click()");
    // Filters for the site's one area, and for outside of all areas.
    let zones = "[...document.getElementById('by-zone').options].map(({value}) => value)";
    browser.wait(&format!("{zones}.length === 2"), SOON);
    browser.run(&format!("window.zone = {zones}[1]; const list = document.getElementById('by-zone'); list.value = zone; list.dispatchEvent(new Event('change'))"));
    browser.wait(&format!("{ROWS} > 0 && {FILTERED}.includes('inside ' + zone)"), SOON);
    browser.run("document.getElementById('filter-clear').click()");
}

fn a_watched_track_is_first(browser: &mut Browser) {
    browser.run(&format!("{FUSED_ROW}.click(); window.watched = {FUSED_ROW}.cells[1].textContent"));
    browser.run("document.getElementById('watch').click()");
    browser.wait(&format!("{FIRST_NAME} === watched && location.hash.includes('watch=')"), SOON);
    browser.wait("document.getElementById('watch').getAttribute('aria-pressed') === 'true'", SOON);
    browser.run("document.getElementById('watched-only').click()");
    browser.wait(&format!("{ROWS} === 1"), SOON);
    browser.run("document.getElementById('filter-clear').click(); document.getElementById('watch').click()");
    browser.wait(&format!("/^R \\d+$/.test({FIRST_NAME}) && {ROWS} > 2"), SOON);
    browser.run("document.getElementById('detail-close').click()");
}

/// With the mouse, and with the keyboard only.
fn distances_are_measured(browser: &mut Browser) {
    let words = "document.getElementById('tool-words').textContent";
    browser.run("document.activeElement.blur()");
    browser.press("m");
    browser
        .wait("!document.getElementById('tool-bar').hidden && document.activeElement.id === 'canvas'", SOON);
    key(browser, "Enter");
    browser.wait(&format!("{words} === '1 place'"), SOON);
    key(browser, "ArrowLeft"); // 80 pixels west
    key(browser, "Enter");
    // A track in the middle would be selected instead; either way the distance is to the west.
    browser.wait(&format!("/^\\d+\\u2009m at 2[67]\\d°$/.test({words})"), SOON);
    click(browser, 200, 300);
    browser.wait(&format!("/; 2 legs, together [\\d.]+\\u2009k?m$/.test({words})"), SOON);
    browser.wait("!location.hash.includes('&s=')", SOON); // the click selected no track
    key(browser, "Escape");
    browser.wait("document.getElementById('tool-bar').hidden", SOON);
}

fn a_zone_is_saved_and_not_active(browser: &mut Browser) {
    let fault = "document.getElementById('zone-fault').textContent";
    let save = "document.getElementById('zone-form').requestSubmit()";
    let corners = [(200, 200), (400, 200), (400, 400)];
    browser.run("document.getElementById('zone-button').click()");
    browser
        .wait("document.getElementById('zone-panel').textContent.includes('This zone is not active')", SOON);
    browser.run(save);
    browser.wait(&format!("{fault}.startsWith('A zone has at least three corners')"), SOON);
    // Two edges that cross.
    for (x, y) in [corners[0], corners[2], corners[1], (200, 400)] {
        click(browser, x, y);
    }
    browser.run(save);
    browser.wait(&format!("{fault} === 'Its edges cross each other.'"), SOON);
    browser.run("document.getElementById('tool-clear').click()");
    for (x, y) in corners {
        click(browser, x, y);
    }
    for (id, value) in [("zone-name", "School \"<b>\""), ("zone-floor", "120"), ("zone-ceiling", "100")] {
        browser.run(&format!("document.getElementById('{id}').value = '{value}'"));
    }
    browser.run(save);
    browser.wait(&format!("{fault} === 'The ceiling is not above the floor.'"), SOON);
    browser.run("document.getElementById('zone-floor').value = ''; document.getElementById('zone-form').dispatchEvent(new Event('input'))");
    let lines = browser.text("document.getElementById('zone-lines').textContent");
    assert_eq!(lines, "[[areas]]\nkind = \"alert\"\nfile = \"school-b.geojson\"\nceiling_m = 100.0\n");
    let before = browser.requests().len();
    browser.run(save);
    browser.wait("Boolean(saved['school-b.geojson'])", SOON);
    let zone: serde_json::Value = serde_json::from_str(&browser.text("saved['school-b.geojson']")).unwrap();
    let feature = &zone["features"][0];
    assert_eq!(
        feature["properties"],
        serde_json::json!({"name": "School \"<b>\"", "floor_m": null, "ceiling_m": 100})
    );
    let ring = feature["geometry"]["coordinates"][0].as_array().unwrap();
    assert_eq!((ring.len(), &ring[0]), (4, &ring[3]), "a ring is closed");
    let place = |i: usize, j: usize| ring[i][j].as_f64().unwrap();
    let twice_area: f64 = (0..3).map(|i| place(i, 0) * place(i + 1, 1) - place(i + 1, 0) * place(i, 1)).sum();
    assert!(twice_area > 0.0, "anticlockwise, as RFC 7946 asks");
    assert!(
        (place(0, 0) + 0.588).abs() < 0.2 && (place(0, 1) - 52.5065).abs() < 0.2,
        "at the site: {ring:?}"
    );
    // The zone is only a file; it is not applied.
    browser.wait(DRAWN, SOON);
    let posted = browser.requests()[before..].iter().any(|url| url.contains("areas") || url.contains("zone"));
    assert!(!posted, "{:?}", &browser.requests()[before..]);
    browser.run("document.getElementById('tool-end').click()");
}

fn view_is_exported(browser: &mut Browser) {
    let rows = browser.number(ROWS);
    for format in ["geojson", "kml", "csv"] {
        browser.run(&format!("document.getElementById('export-{format}').click()"));
        browser.wait(
            &format!(
                "Object.keys(saved).some(name => /^tracks-2026-03-14T0901\\d\\dZ.{format}$/.test(name))"
            ),
            SOON,
        );
    }
    let mut saved = |ending: &str| {
        browser.text(&format!("Object.entries(saved).find(([name]) => name.startsWith('tracks') && name.endsWith('{ending}'))[1]"))
    };
    let tracks: serde_json::Value = serde_json::from_str(&saved("geojson")).unwrap();
    let of = |kind: &str| {
        tracks["features"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|feature| feature["geometry"]["type"] == kind)
            .count() as u64
    };
    assert_eq!(of("Point"), rows);
    assert!(of("LineString") > 2, "trails");
    let kml = saved("kml");
    assert_eq!(kml.matches("<Placemark>").count() as u64, rows);
    assert_eq!(kml.matches("<Placemark>").count(), kml.matches("</Placemark>").count());
    let csv = saved("csv");
    assert_eq!(csv.lines().count() as u64, rows + 1);
    assert!(
        csv.starts_with("id,source,track_number,time,lat,lng,alt_msl,") && csv.contains(",000000000003\r\n")
    );
}
