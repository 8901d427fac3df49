//! The site's own base map: vector tiles from its file only, and the invented ground of the demo.

use std::fs;
use std::path::Path;

use super::browser::Browser;
use super::service::{self, Service};
use super::{BADGE, DRAWN, ROWS, SOON, fresh_folder, installed, paused};

/// Counts pixels in a colour of the base map.
const PIXELS: &str = "(name => { const canvas = document.getElementById('canvas'); \
    const {width, height} = canvas; \
    const {data} = canvas.getContext('2d').getImageData(0, 0, width, height); \
    const probe = document.createElement('span'); \
    probe.style.color = `var(--map-${name})`; document.body.append(probe); \
    const [r, g, b] = getComputedStyle(probe).color.match(/\\d+/g).map(Number); probe.remove(); \
    let count = 0; \
    for (let at = 0; at < data.length; at += 4) if (data[at] === r && data[at + 1] === g && data[at + 2] === b) count += 1; \
    return count; })";
/// Whether the card of the first visit is shown, and whether it says that there is no base map.
const HINT: &str =
    "`${!document.getElementById('welcome').hidden} ${!document.getElementById('welcome-base').hidden}`";

#[test]
fn the_ground_is_the_sites_own() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-ground");
    service::fly(&folder, None);
    let tiles = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/basemap/site.pmtiles");
    fs::copy(tiles, folder.join("ground.pmtiles")).unwrap();
    let water = pixels("water");
    let site = fs::read_to_string(folder.join("site.toml")).unwrap();
    let map = site.replace("# pmtiles: none, the map has no ground", "pmtiles = \"ground.pmtiles\"");
    assert_ne!(map, site);
    fs::write(folder.join("site.toml"), map).unwrap();
    let service = Service::replay(&folder, 0);
    service.order("pause");
    service.seek("09:01:20");
    let mut browser = Browser::start(&program, &folder.join("profile"));
    let layers = "layers=base"; // no other layers, whose colours would mix
    browser.open(&format!("{}#{layers}", service.url()));
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} > 0"), SOON);
    browser.wait("document.getElementById('attribution').textContent === '© nobody & everybody'", SOON);
    browser.wait(&format!("{water} > 5000"), SOON);
    // In the colours of each theme, and at zoom levels beyond those of the file.
    for step in
        ["document.getElementById('theme-button').click()", "document.getElementById('theme-button').click()"]
    {
        browser.run(step);
        browser.wait(DRAWN, SOON);
        browser.wait(&format!("{water} > 5000"), SOON);
    }
    browser.open(&format!("{}#c=52.5065,-0.588&z=1.5&{layers}", service.url()));
    browser.run("location.reload()");
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} > 0"), SOON);
    browser.wait(&format!("{water} > 5000"), SOON);
    // The page may still be loading again.
    browser.wait("document.querySelector('input[name=base]') !== null", SOON);
    browser.run("document.querySelector('input[name=base]').click()");
    browser.wait(&format!("{water} === 0"), SOON);
    assert_eq!(browser.complaints(), Vec::<String>::new(), "errors in the console");
    assert!(
        browser.requests().iter().all(|asked| asked.starts_with(&service.url())),
        "{:?}",
        browser.requests()
    );
}

#[test]
fn demo_has_an_invented_ground() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-demo-ground");
    let service = Service::demo();
    let mut browser = Browser::start(&program, &folder.join("profile"));
    // The first view's scale, then two zoom levels closer, in both themes.
    for (theme, place, least) in [
        (
            "light",
            "c=52.516,-0.572&z=0.37",
            [("water", 4000), ("wood", 8000), ("farm", 20_000), ("building", 300)],
        ),
        (
            "dark",
            "c=52.5193,-0.5715&z=1.5",
            [("water", 8000), ("wood", 2000), ("green", 20_000), ("building", 500)],
        ),
    ] {
        browser.open("about:blank");
        browser.open(&format!("{}#{place}&theme={theme}&layers=base", service.url()));
        let note = "document.getElementById('attribution').textContent";
        browser.wait(&format!("{note} === 'Invented ground of the demo, no real map'"), SOON);
        for (colour, least) in least {
            browser.wait(&format!("{} > {least}", pixels(colour)), SOON);
        }
        assert_eq!(browser.text(HINT), "true false");
    }
    assert_eq!(browser.complaints(), Vec::<String>::new(), "errors in the console");
    assert!(browser.requests().iter().all(|asked| asked.starts_with(&service.url())));
}

#[test]
fn map_without_ground_says_how_to_add_one() {
    let Some((_, service, mut browser)) = paused("map-no-ground", "operational") else { return };
    browser.open(&service.url());
    browser.wait(&format!("{HINT} === 'true true'"), SOON);
    let hint = browser.text("document.getElementById('welcome-base').innerText");
    assert!(hint.contains("pmtiles") && hint.contains("[map]"), "{hint}");
    browser.run("document.getElementById('welcome-close').click()");
    browser.wait(&format!("{HINT}.startsWith('false')"), SOON);
    assert_eq!(browser.text("document.getElementById('attribution').textContent"), "");
}

fn pixels(colour: &str) -> String {
    format!("{PIXELS}('{colour}')")
}
