//! The map page in a real browser with the real program: a simulated flight, its recording, and failures of sensors and of the
//! service.
//!
//! Without Chromium the test reports itself as skipped and passes, unless `UTM_FUSION_BROWSER=required`.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![expect(
    clippy::disallowed_methods,
    reason = "a browser takes the time that it takes, and the flight is a file"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use browser::Browser;
use service::{HOSTILE, Service};
use tiles::Tiles;

mod alerts;
mod axe;
mod browser;
mod condition;
mod conflicts;
mod crowds;
mod encounter;
mod failures;
mod frames;
mod ground;
mod names;
mod naming;
mod news;
mod operator;
mod past;
mod phone;
mod picture;
mod questions;
mod service;
mod tiles;
mod trust;
mod zones;

const SOON: Duration = Duration::from_secs(60);

/// The first fused row of the table.
const FUSED_ROW: &str =
    "[...document.querySelectorAll('#table-body tr')].find(row => row.cells[0]?.dataset.source === 'fused')";
/// The rows of tracks, without the spacers above and below.
const ROWS: &str = "document.querySelectorAll('#table-body tr:not(.spacer)').length";
/// Waits two frames, after which everything is drawn.
const DRAWN: &str =
    "new Promise(drawn => requestAnimationFrame(() => requestAnimationFrame(() => drawn(true))))";
/// By this time two transponders have been silent for some seconds.
const COASTING: &str = "09:02:00";
const BADGE: &str = "document.getElementById('badge').textContent";
const CLOCK: &str = "document.getElementById('utc').textContent";

/// One test, because a browser takes a second to start and the steps depend on the state of the page.
#[test]
fn an_operator_sees_the_flight_and_what_is_wrong() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map");
    service::fly(&folder, None);
    let mut service = Service::replay(&folder, 0);
    let url = service.url();
    // Trails contain the positions of some seconds by then; nothing else arrives while paused.
    service.seek("09:01:20");
    std::thread::sleep(Duration::from_secs(7));
    service.order("pause");
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&url);

    a_paused_recording_has_trails_at_once(&mut browser);
    the_slider_seeks(&mut browser);
    three_quick_steps_back_are_thirty_seconds(&mut browser);
    tracks_move(&mut browser);
    a_fused_track_says_why(&mut browser);
    the_filter_filters(&mut browser);
    the_themes_differ(&mut browser, &folder);
    raw_inputs_are_asked_for_while_they_are_shown(&mut browser);
    hostile_text_is_only_text(&mut browser);
    a_sensors_light_follows_its_state(&mut browser, &service);
    the_hash_brings_the_view_back(&mut browser, &url);
    own_overlays_are_drawn_and_stay_here(&mut browser);
    silence_is_stale_until_it_ends(&mut browser, &service);

    assert_eq!(browser.complaints(), Vec::<String>::new(), "errors in the console");
    let elsewhere: Vec<_> = browser.requests().iter().filter(|asked| !asked.starts_with(&url)).collect();
    assert!(elsewhere.is_empty(), "requests to another origin: {elsewhere:?}");

    // From here on the console reports failed connections.
    let port = service.port();
    drop(service);
    browser.wait(&format!("{BADGE}.startsWith('STALE')"), SOON);
    service = Service::replay(&folder, port);
    service.seek("09:01:20");
    browser.wait(&format!("{BADGE} === 'REPLAY' && {ROWS} > 0"), SOON);
}

#[test]
fn the_live_picture_says_how_far_it_is_behind() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-live");
    let service = Service::demo();
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    // A slot is published 6.25 s after its start, on a busy machine a little later.
    browser.wait(&format!("/^LIVE −6\\.[2-9]\\d s$/.test({BADGE})"), SOON + SOON);
    browser.wait("document.getElementById('replay').hidden", SOON);
    browser.wait("document.querySelectorAll('#sensors [data-look=ok]').length === 2", SOON);
    browser.wait(&format!("{ROWS} > 0"), SOON + SOON);
    now_is_predicted(&mut browser);
    the_lines_of_a_sensor_are_a_table(&mut browser);
    a_late_picture_is_not_live(&mut browser, &service);
    assert_eq!(browser.complaints(), Vec::<String>::new(), "errors in the console");
    assert!(browser.requests().iter().all(|asked| asked.starts_with(&service.url())));
}

/// A key switches to the predicted present positions and back.
fn now_is_predicted(browser: &mut Browser) {
    browser.press("n");
    browser.wait(&format!("{BADGE} === 'NOW (predicted)' && {ROWS} > 0"), SOON);
    browser.wait("location.hash.includes('at=now')", SOON);
    browser.wait("Math.abs(Date.parse(document.getElementById('picture-time').textContent.replace('picture ', '1970-01-01T') + 'Z') - Date.parse('1970-01-01T' + document.getElementById('utc').textContent.replace(' UTC', 'Z'))) < 2500", SOON);
    browser.press("n");
    browser.wait(&format!("/^LIVE −6\\.[2-9]\\d s$/.test({BADGE}) && {ROWS} > 0"), SOON);
}

/// The service stops for some seconds and then publishes the delayed slots, which the page marks as late.
fn a_late_picture_is_not_live(browser: &mut Browser, service: &Service) {
    browser.run(
        "window.seen = [];
         new MutationObserver(() => {
             const badge = document.getElementById('badge');
             const fresh = !document.body.classList.contains('stale');
             seen.push({ text: badge.textContent, fresh, colour: getComputedStyle(badge).backgroundColor });
         }).observe(document.getElementById('badge'), { childList: true, characterData: true, subtree: true })",
    );
    service.freeze(true);
    browser.wait(&format!("{BADGE}.startsWith('STALE')"), SOON);
    service.freeze(false);
    let late = "seen.filter(({ text }) => /^LATE \\d+(\\.\\d)? s$/.test(text))";
    browser.wait(&format!("{late}.length > 0 && {late}.every(({{ fresh }}) => !fresh)"), SOON);
    browser.wait(&format!("/^LIVE −6\\.[2-9]\\d s$/.test({BADGE})"), SOON);
    let live = "seen.filter(({ text }) => text.startsWith('LIVE'))";
    browser.wait(&format!("{late}[0].colour !== {live}[0].colour"), SOON);
}

#[test]
fn estimates_are_shown_where_there_are_some() {
    let Some((folder, service, mut browser)) = paused("map-operational", "operational") else { return };
    browser.open(&service.url());
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} > 2"), SOON);
    // The service reports speeds, so the page does not estimate them.
    let speeds = "[...document.querySelectorAll('#table-body td.speed')].map(cell => cell.textContent)";
    browser.wait(&format!("{speeds}.filter(Boolean).every(text => /^\\d+$/.test(text))"), SOON);
    browser.wait(&format!("{FUSED_ROW} !== undefined"), SOON);
    browser.run(&format!("{FUSED_ROW}.click()"));
    let said = "document.getElementById('detail').textContent";
    for words in [
        r"apart, (high|medium|low) confidence",
        r"Speed\d+\.\d.m.s(?! \(derived)",
        r"Course\d{3}°",
        r"Accuracy, horizontal\d+\.\d.m \(95.%\), HA",
        r"Accuracy, vertical\d+\.\d.m \(95.%\), VA",
        r"Last measurement09:01:",
        r"IdU-\d+",
    ] {
        browser.wait(&format!("/{words}/.test({said})"), SOON);
    }
    the_circle_of_the_accuracy_is_drawn(&mut browser);
    the_ellipses_of_now_are_drawn(&mut browser);
    a_radars_registration_is_in_its_panel(&mut browser);
    an_operator_decides(&mut browser, &service);

    service.seek(COASTING);
    let coasting = "fetch('api/v1/tracks').then(answer => answer.json()).then(({features}) => {
        const found = features.find(({properties}) => properties.state === 'coasting');
        document.querySelector(`#table-body tr[data-id='${found.id}']`).click();
        return true; })";
    browser.wait(coasting, SOON);
    browser.wait(&format!("{said}.includes('coasting: extrapolated from the last measurement')"), SOON);
    for theme in ["light", "dark"] {
        browser.press("t");
        browser.wait(&format!("document.documentElement.dataset.theme === '{theme}'"), SOON);
        browser.wait(DRAWN, SOON);
        fs::write(folder.join(format!("map-{theme}.png")), browser.screenshot()).unwrap();
    }
    assert_eq!(browser.complaints(), Vec::<String>::new(), "errors in the console");
}

/// At the closest zoom.
fn the_circle_of_the_accuracy_is_drawn(browser: &mut Browser) {
    browser.run("document.getElementById('follow').click()");
    for _ in 0..14 {
        browser.run("document.getElementById('zoom-in').click()");
    }
    browser.wait(DRAWN, SOON);
    // Counts pixels in the colour of the selection outside the brackets in the middle.
    let far = "(() => { const canvas = document.getElementById('canvas'); \
        const {width, height} = canvas; \
        const {data} = canvas.getContext('2d').getImageData(0, 0, width, height); \
        const probe = document.createElement('span'); \
        probe.style.color = 'var(--selected)'; document.body.append(probe); \
        const [r, g, b] = getComputedStyle(probe).color.match(/\\d+/g).map(Number); probe.remove(); \
        let count = 0; \
        for (let y = 0; y < height; y++) for (let x = 0; x < width; x++) { \
            const at = 4 * (y * width + x); \
            const near = Math.abs(data[at] - r) + Math.abs(data[at + 1] - g) + Math.abs(data[at + 2] - b) < 90; \
            const away = Math.hypot(x - width / 2, y - height / 2); \
            if (near && away > 22 && y > height / 2 + 22) count += 1; } \
        return count; })()";
    assert!(browser.number(far) > 20, "no circle is drawn");
}

/// Around every track, not only around the selected one.
fn the_ellipses_of_now_are_drawn(browser: &mut Browser) {
    browser.press("n");
    browser.wait(&format!("{BADGE} === 'REPLAY paused NOW (predicted)' && {ROWS} > 2"), SOON);
    browser.wait(DRAWN, SOON);
    let with_ellipses = browser.screenshot();
    browser.press("n");
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} > 2"), SOON);
    browser.wait(DRAWN, SOON);
    assert!(browser.screenshot() != with_ellipses);
}

#[test]
fn own_tiles_are_the_only_thing_from_elsewhere() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-tiles");
    let tiles = Tiles::start();
    service::fly(&folder, Some(&tiles.template()));
    let service = Service::replay(&folder, 0);
    let url = service.url();
    service.order("pause");
    service.seek("09:01:20");
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&url);
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} > 0"), SOON);
    browser.wait("document.getElementById('attribution').textContent === \"nobody's\"", SOON);
    let loaded = format!(
        "performance.getEntriesByType('resource').filter(({{name}}) => name.startsWith({:?})).length >= 4",
        tiles.url()
    );
    browser.wait(&loaded, SOON);
    for path in tiles.asked() {
        let numbers: Vec<u32> =
            path[1..].trim_end_matches(".svg").split('/').map(|n| n.parse().unwrap()).collect();
        let [zoom, x, y] = numbers[..] else { panic!("{path}") };
        // The site is in England, a little west of Greenwich.
        let (across, down) = (f64::from(x) / f64::from(1 << zoom), f64::from(y) / f64::from(1 << zoom));
        assert!((12..=19).contains(&zoom), "{path}");
        assert!((across - 0.4984).abs() < 2e-3 && (down - 0.3285).abs() < 2e-3, "{path}: {across} {down}");
    }
    // While the replay is paused, only the layer changes the image.
    browser.wait(DRAWN, SOON);
    let with_tiles = browser.screenshot();
    browser.run("document.querySelector('input[name=tiles]').click()");
    // The click and the new image may be some frames apart.
    let differs = (0..100).any(|_| {
        browser.wait(DRAWN, SOON);
        browser.screenshot() != with_tiles
    });
    assert!(differs, "the tiles are not drawn");
    assert_eq!(browser.complaints(), Vec::<String>::new(), "errors in the console");
    let own = |asked: &&String| asked.starts_with(&url) || asked.starts_with(tiles.url());
    assert!(browser.requests().iter().all(|asked| own(&asked)), "{:?}", browser.requests());
}

/// The flight as a recording, paused while all drones are visible, with its folder and a browser that has not opened it yet.
fn paused(name: &str, profile: &str) -> Option<(PathBuf, Service, Browser)> {
    let program = installed()?;
    let folder = fresh_folder(name);
    service::fly(&folder, None);
    let service = Service::replay_in(profile, &folder, 0);
    service.order("pause");
    service.seek("09:01:20");
    let browser = Browser::start(&program, &folder.join("profile"));
    Some((folder, service, browser))
}

fn installed() -> Option<PathBuf> {
    let program = browser::installed();
    if program.is_none() {
        assert!(std::env::var_os("UTM_FUSION_BROWSER").is_none_or(|wish| wish != "required"), "no Chromium");
        println!("skipped: Chromium is not installed");
    }
    program
}

fn a_paused_recording_has_trails_at_once(browser: &mut Browser) {
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} > 2"), SOON);
    // One slot has no speeds. The page derives them from trails.
    browser.wait(
        "[...document.querySelectorAll('#table-body td.speed')].filter(c => /^≈\\d+$/.test(c.textContent)).length > 2",
        SOON,
    );
    // The connection stays open.
    std::thread::sleep(Duration::from_secs(4));
    browser.wait(&format!("{BADGE} === 'REPLAY paused'"), Duration::ZERO);
}

fn the_slider_seeks(browser: &mut Browser) {
    browser.wait("document.getElementById('replay-length').textContent === '0:04:58'", SOON);
    for (seconds, time) in [(150, "09:02:3"), (60, "09:01:0")] {
        browser.run(&format!(
            "(() => {{ const slider = document.getElementById('replay-position'); slider.value = {seconds}; \
                for (const name of ['input', 'change']) slider.dispatchEvent(new Event(name)); }})()"
        ));
        browser.wait(&format!("{CLOCK}.startsWith({time:?}) && {ROWS} > 0"), SOON);
    }
    assert_eq!(browser.text(BADGE), "REPLAY paused");
}

/// Each step starts from the requested time, not from the time reached, so that quick clicks add up.
fn three_quick_steps_back_are_thirty_seconds(browser: &mut Browser) {
    browser.run("for (let i = 0; i < 3; i++) document.getElementById('replay-back').click()");
    browser.wait("document.getElementById('replay-at').textContent === '0:00:30'", SOON);
    browser.wait(&format!("/^09:00:(29|30)/.test({CLOCK}) && {ROWS} > 0"), SOON);
    browser.run("for (let i = 0; i < 3; i++) document.getElementById('replay-forward').click()");
    browser.wait(&format!("/^09:(00:59|01:00)/.test({CLOCK}) && {ROWS} > 0"), SOON);
    browser.press(" ");
    browser.wait(&format!("{BADGE} === 'REPLAY'"), SOON);
}

/// Each input has address, state, rate and refusals in the table; nothing is shown as JSON.
fn the_lines_of_a_sensor_are_a_table(browser: &mut Browser) {
    let panel = "document.getElementById('sensor-panel')";
    browser.run("document.querySelector('#sensors button').click()");
    let cells = format!(
        "[...{panel}.querySelectorAll('.lines tbody tr')].map(row => [...row.cells].map(cell => cell.textContent))"
    );
    browser.wait(
        &format!("{cells}.some(([address, state, rate, refused]) => \
            /^\\S*239[.]\\S+:\\d+/.test(address) && state.startsWith('open, last ') && Number(rate) > 0 && /^\\d+$/.test(refused))"),
        SOON + SOON, // a rate needs two answers, ten seconds apart
    );
    let heads = format!("[...{panel}.querySelectorAll('.lines th')].map(head => head.textContent).join()");
    assert_eq!(browser.text(&heads), "Address,State,a second,Refused");
    let said = browser.text(&format!("{panel}.textContent"));
    assert!(!said.contains(['{', '}', '"']), "as JSON: {said}");
    browser.run(&format!("{panel}.hidePopover()"));
}

fn tracks_move(browser: &mut Browser) {
    let ranges =
        "[...document.querySelectorAll('#table-body td.range')].map(cell => cell.textContent).join(' ')";
    let before = browser.text(ranges);
    browser.wait(&format!("{ranges} !== {before:?}"), SOON);
    browser.wait(&format!("{FUSED_ROW} !== undefined"), SOON);
}

fn a_fused_track_says_why(browser: &mut Browser) {
    // A pair may be separated at any time; then another fused track is selected.
    browser.wait(
        &format!(
            r"(() => {{
                const said = document.getElementById('detail').textContent;
                const row = {FUSED_ROW};
                if (!said.includes('Why it is fused')) row?.click();
                return /radar track \d+: [\d.]+ m of [\d.]+ m allowed, within in \d+ of \d+ slots \(needs 90.%\)/.test(said)
                    && said.includes('weight 91');
            }})()"
        ),
        SOON,
    );
}

fn the_filter_filters(browser: &mut Browser) {
    let all = browser.number(ROWS);
    browser.press("/");
    browser.type_text("000000000003");
    browser.wait(&format!("{ROWS} > 0 && {ROWS} < {all}"), SOON);
    browser.wait("!document.getElementById('filtered').hidden", SOON);
    browser.run("document.getElementById('filter-clear').click()");
    browser.wait(&format!("{ROWS} > 2"), SOON);
}

fn the_themes_differ(browser: &mut Browser, folder: &Path) {
    // Most frequent colour in the map, and number of colours drawn on it.
    let ground = "(() => { const canvas = document.getElementById('canvas'); \
        const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height); \
        const counts = new Map(); \
        for (let i = 0; i < data.length; i += 4) { \
            const key = (data[i] << 16) | (data[i + 1] << 8) | data[i + 2]; \
            counts.set(key, (counts.get(key) ?? 0) + 1); } \
        const [[most]] = [...counts].sort((a, b) => b[1] - a[1]); \
        return [counts.size, (most >> 16) + ((most >> 8) & 255) + (most & 255)].join(' '); })()";
    browser.run("document.activeElement.blur()");
    let mut brightness = Vec::new();
    for theme in ["light", "dark"] {
        browser.press("t");
        browser.wait(&format!("document.documentElement.dataset.theme === '{theme}'"), SOON);
        browser.wait(
            "new Promise(drawn => requestAnimationFrame(() => requestAnimationFrame(() => drawn(true))))",
            SOON,
        );
        let seen = browser.text(ground);
        let (colours, bright) = seen.split_once(' ').unwrap();
        assert!(colours.parse::<u32>().unwrap() > 20, "the map of the {theme} theme is blank: {seen}");
        brightness.push(bright.parse::<u32>().unwrap());
        let picture = browser.screenshot();
        assert!(picture.len() > 20_000, "the screenshot of the {theme} theme is blank");
        let file = folder.join(format!("map-{theme}.png"));
        fs::write(&file, picture).unwrap();
        println!("{}", file.display());
    }
    assert!(brightness[0] > 600 && brightness[1] < 150, "light and dark grounds: {brightness:?}");
}

fn raw_inputs_are_asked_for_while_they_are_shown(browser: &mut Browser) {
    let after = |least: u32| {
        format!(
            "performance.getEntriesByType('resource').some(({{name}}) => Number(name.split('raw?after=')[1]) >= {least})"
        )
    };
    assert_eq!(browser.number(&format!("Number({})", after(0))), 0, "nobody looks");
    browser.run("document.querySelector('input[name=raw]').click()");
    browser.wait(&after(50), SOON);
    // Sensor reports are drawn beside their tracks once the picture has reached their time.
    let colours = "(() => { const canvas = document.getElementById('canvas'); \
        return new Set(new Uint32Array(canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.buffer)).size; })()";
    browser.wait(&format!("{colours} > 20"), SOON);
    browser.run("document.querySelector('input[name=raw]').click()");
}

fn hostile_text_is_only_text(browser: &mut Browser) {
    browser.wait("Number(document.getElementById('alert-count').textContent) > 0", SOON);
    browser.wait(&format!("document.getElementById('alert-list').textContent.includes({HOSTILE:?})"), SOON);
    assert_eq!(browser.number("document.querySelectorAll('#alert-list img').length"), 0);
}

fn a_sensors_light_follows_its_state(browser: &mut Browser, service: &Service) {
    let sensor = "document.querySelector('#sensors [data-id=gamekeeper]')";
    browser.wait(&format!("{sensor}.dataset.look === 'ok'"), SOON);
    service.seek("09:02:50");
    browser.wait(&format!("{sensor}.dataset.look === 'critical'"), SOON);
    browser.wait(&format!("{sensor}.querySelector('button').title.includes('nothing received for')"), SOON);
    service.seek("09:01:20");
    browser.wait(&format!("{sensor}.dataset.look === 'ok'"), SOON);
}

fn a_radars_registration_is_in_its_panel(browser: &mut Browser) {
    let panel = "document.getElementById('sensor-panel')";
    browser.run("document.querySelector('#sensors [data-id=gamekeeper] button').click()");
    for words in [
        r"Modeapply: ",
        r"Bearing\(?[+−]\d+\.\d\d ± \d+\.\d\d°",
        r"Time\(?[+−]\d\.\d\d ± ",
        r"Radar tracks\d",
        r"Errors, as learntRange\d\.\d of its data sheet ± \d\.\d",
        r"Velocitiesnot known yet",
    ] {
        browser.wait(&format!("/{words}/.test({panel}.textContent)"), SOON);
    }
    // Unobservable values are greyed out, with the reason.
    let tilt =
        format!("[...{panel}.querySelectorAll('dd.unknown')].find(dd => dd.textContent.includes('°'))");
    browser.wait(&format!("{tilt}.title.startsWith('Not observable')"), SOON);
    let colours = format!("getComputedStyle({tilt}).color !== getComputedStyle({panel}).color");
    // Cycles through all themes.
    for _ in ["light", "dark", "auto"] {
        browser.run("document.querySelector('#sensor-panel').hidePopover()");
        browser.press("t");
        browser.run("document.querySelector('#sensors [data-id=gamekeeper] button').click()");
        browser.wait(&colours, SOON);
    }
    browser.run(&format!("{panel}.hidePopover()"));
}

fn an_operator_decides(browser: &mut Browser, service: &Service) {
    let button = |words: &str| {
        format!(
            "[...document.querySelectorAll('#detail .decide')].find(one => one.textContent === {words:?})"
        )
    };
    let in_force = |so: &str| {
        format!("fetch('api/v1/correlations').then(answer => answer.json()).then(({{correlations}}) => {so})")
    };
    service.order("play");
    // A pair may be separated at any time; then another fused track is selected.
    let part = button("Not one aircraft");
    browser.wait(&format!("Boolean({part} ?? ({FUSED_ROW}?.click(), null))"), SOON);
    browser.run(&format!("{part}.click()"));
    browser.wait("document.querySelector('#detail [role=status]')?.textContent.startsWith('Decided')", SOON);
    browser.wait(&in_force("correlations.length === 1 && correlations[0].verdict === 'decorrelated'"), SOON);
    // The decision is shown with both tracks, near or not, and can be withdrawn there.
    let withdraw = button("Decide automatically");
    browser.wait(&format!("Boolean({withdraw})"), SOON);
    browser.wait(
        "/An operator: radar track \\d+ of \\S+ and transponder \\S+ are not one aircraft/.test(\
            document.getElementById('detail').textContent)",
        SOON,
    );
    browser.run(&format!("{withdraw}.click()"));
    browser.wait(&in_force("correlations.length === 0"), SOON);
    service.order("pause");
}

fn the_hash_brings_the_view_back(browser: &mut Browser, url: &str) {
    browser.open(&format!(
        "{url}#c=52.5065,-0.588&z=0.1&q=drone-it&src=fused,transponder&theme=dark&layers=rings"
    ));
    browser.run("location.reload()");
    browser.wait("document.getElementById('filter-input').value === 'drone-it'", SOON);
    browser
        .wait("document.querySelector('[data-source=radar]').getAttribute('aria-pressed') === 'false'", SOON);
    browser.wait("!document.querySelector('input[name=labels]').checked", SOON);
    browser.wait(&format!("{ROWS} > 0"), SOON);
    browser.wait("location.hash.includes('z=0.1')", SOON);
}

fn silence_is_stale_until_it_ends(browser: &mut Browser, service: &Service) {
    service.freeze(true);
    browser.wait(&format!("{BADGE}.startsWith('STALE since ')"), SOON);
    browser.wait("document.body.classList.contains('stale')", SOON);
    browser.wait("[...document.querySelectorAll('.count')].every(count => count.textContent === '?')", SOON);
    service.freeze(false);
    browser.wait(&format!("{BADGE} === 'REPLAY' && {ROWS} > 0"), SOON);
    browser.wait("!document.body.classList.contains('stale')", SOON);
}

fn own_overlays_are_drawn_and_stay_here(browser: &mut Browser) {
    let line = r#"{"type": "LineString", "coordinates": [[-0.59, 52.51], [-0.56, 52.52]]}"#;
    let drop = format!(
        "(() => {{ const files = new DataTransfer(); \
            files.items.add(new File([{line:?}], 'line.geojson')); \
            files.items.add(new File(['nonsense'], 'bad.json')); \
            dispatchEvent(new DragEvent('drop', {{dataTransfer: files, cancelable: true}})); }})()"
    );
    let before = browser.requests().len();
    browser.run(&drop);
    browser.wait("document.getElementById('overlay-error').textContent === 'bad.json: not JSON'", SOON);
    browser.wait("document.getElementById('overlay-list').textContent.includes('line.geojson')", SOON);
    let since = &browser.requests()[before..];
    assert!(since.iter().all(|url| !url.contains("geojson")), "{since:?}");
    browser.run("document.getElementById('layers').hidePopover()");
}

/// Folder for files of the test, emptied first. It is kept so that screenshots can be viewed.
fn fresh_folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}
