//! The map page in a real browser: what an operator sees of a generated flight, and when sensors or the service fail.
//!
//! Where Chromium is not installed the test says so and passes, unless `UTM_FUSION_BROWSER=required`.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![expect(
    clippy::disallowed_methods,
    reason = "a browser takes the time that it takes, and the flight is a file"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use browser::Browser;
use server::Server;

mod browser;
mod flight;
mod server;

const SOON: Duration = Duration::from_secs(10);

/// The first fused row of the table.
const FUSED_ROW: &str =
    "[...document.querySelectorAll('#table-body tr')].find(row => row.cells[0]?.dataset.source === 'fused')";
/// The rows of tracks; the table has a spacer above and below them.
const ROWS: &str = "document.querySelectorAll('#table-body tr:not(.spacer)').length";
const BADGE: &str = "document.getElementById('badge').textContent";

/// One test, since a browser takes a second to start and the page's state is the story told here.
#[test]
fn an_operator_sees_the_flight_and_what_is_wrong() {
    let Some(program) = browser::installed() else {
        assert!(std::env::var_os("UTM_FUSION_BROWSER").is_none_or(|wish| wish != "required"), "no Chromium");
        println!("skipped: Chromium is not installed");
        return;
    };
    let folder = fresh_folder();
    let server = Server::start(flight::slots(&folder));
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(server.url());

    tracks_appear_and_move(&mut browser);
    a_fused_track_says_why(&mut browser);
    the_filter_filters(&mut browser);
    the_themes_differ(&mut browser, &folder);
    hostile_text_is_only_text(&mut browser, &server);
    a_sensors_light_follows_its_state(&mut browser, &server);
    the_hash_brings_the_view_back(&mut browser, &server);
    own_overlays_are_drawn_and_stay_here(&mut browser);
    silence_is_stale_until_it_ends(&mut browser, &server);
    a_cut_stream_comes_back(&mut browser, &server);
    a_recording_is_called_one(&mut browser, &server);

    assert_eq!(browser.complaints(), Vec::<String>::new(), "errors in the console");
    let elsewhere: Vec<_> = browser.requests().iter().filter(|url| !url.starts_with(server.url())).collect();
    assert!(elsewhere.is_empty(), "requests to another origin: {elsewhere:?}");
}

fn tracks_appear_and_move(browser: &mut Browser) {
    browser.wait(&format!("{ROWS} > 2"), SOON);
    browser.wait(&format!("{BADGE} === 'LIVE −6.25 s'"), SOON);
    browser.wait(&format!("{FUSED_ROW} !== undefined"), SOON);
    let ranges =
        "[...document.querySelectorAll('#table-body td.range')].map(cell => cell.textContent).join(' ')";
    let before = browser.text(ranges);
    browser.wait(&format!("{ranges} !== {before:?}"), SOON);
}

fn a_fused_track_says_why(browser: &mut Browser) {
    // A pair may part at any time: another fused track is selected then.
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
    // The middle of the map's ground, and how many colours are drawn on it.
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

fn hostile_text_is_only_text(browser: &mut Browser, server: &Server) {
    let markup = "<img src=x onerror=alert(1)>";
    server.alert(markup);
    browser.wait("document.getElementById('alert-count').textContent === '1'", SOON);
    browser.wait(&format!("document.getElementById('alert-list').textContent.includes({markup:?})"), SOON);
    assert_eq!(browser.number("document.querySelectorAll('#alert-list img').length"), 0);
}

fn a_sensors_light_follows_its_state(browser: &mut Browser, server: &Server) {
    let look = "document.querySelector('#sensors [data-id=gamekeeper]').dataset.look";
    browser.wait(&format!("{look} === 'ok'"), SOON);
    server.sensor("outage");
    browser.wait(&format!("{look} === 'critical'"), SOON);
    browser.wait(
        "document.querySelector('#sensors [data-id=gamekeeper] button').title.includes('nothing heard')",
        SOON,
    );
    server.sensor("operational");
    browser.wait(&format!("{look} === 'ok'"), SOON);
}

fn the_hash_brings_the_view_back(browser: &mut Browser, server: &Server) {
    browser.open(&format!(
        "{}#c=52.5065,-0.588&z=0.1&q=drone-it&src=fused,transponder&theme=dark&layers=rings",
        server.url()
    ));
    browser.run("location.reload()");
    browser.wait("document.getElementById('filter-input').value === 'drone-it'", SOON);
    browser
        .wait("document.querySelector('[data-source=radar]').getAttribute('aria-pressed') === 'false'", SOON);
    browser.wait("!document.querySelector('input[name=labels]').checked", SOON);
    browser.wait(&format!("{ROWS} > 0"), SOON);
    browser.wait("location.hash.includes('z=0.1')", SOON);
}

fn silence_is_stale_until_it_ends(browser: &mut Browser, server: &Server) {
    server.silent(true);
    browser.wait(&format!("{BADGE}.startsWith('STALE since ')"), SOON);
    browser.wait("document.body.classList.contains('stale')", SOON);
    server.silent(false);
    browser.wait(&format!("{BADGE}.startsWith('LIVE')"), SOON);
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

fn a_cut_stream_comes_back(browser: &mut Browser, server: &Server) {
    let streams =
        |browser: &Browser| browser.requests().iter().filter(|url| url.ends_with("/stream")).count();
    let before = streams(browser);
    server.cut();
    // The page hears of the new stream before it says that it is live again.
    let end = Instant::now() + SOON;
    while streams(browser) == before && Instant::now() < end {
        std::thread::sleep(Duration::from_millis(200));
        browser.wait("true", SOON); // which hears what the browser has told meanwhile
    }
    assert!(streams(browser) > before, "the stream was not opened again");
    browser.wait(&format!("{BADGE}.startsWith('LIVE') && {ROWS} > 0"), SOON);
}

fn a_recording_is_called_one(browser: &mut Browser, server: &Server) {
    assert_eq!(browser.number("document.querySelectorAll('#replay[hidden]').length"), 1);
    server.replay();
    browser.run("location.reload()");
    browser.wait(&format!("{BADGE}.startsWith('REPLAY')"), SOON);
    browser.wait("!document.getElementById('replay').hidden", SOON);
    browser.press(" ");
    browser.wait(&format!("{BADGE} === 'REPLAY paused'"), SOON);
    assert_eq!(server.posts(), ["/api/v1/replay/pause "]);
}

/// For what the test writes; emptied first, and left for who wants to look at the screenshots.
fn fresh_folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("map");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}
