//! The site's own base map: vector tiles from its file only.

use std::fs;
use std::path::Path;

use super::browser::Browser;
use super::service::{self, Service};
use super::{BADGE, DRAWN, ROWS, SOON, fresh_folder, installed};

/// Counts pixels in the colour of water.
const WATER: &str = "(() => { const canvas = document.getElementById('canvas'); \
    const {width, height} = canvas; \
    const {data} = canvas.getContext('2d').getImageData(0, 0, width, height); \
    const probe = document.createElement('span'); \
    probe.style.color = 'var(--map-water)'; document.body.append(probe); \
    const [r, g, b] = getComputedStyle(probe).color.match(/\\d+/g).map(Number); probe.remove(); \
    let count = 0; \
    for (let at = 0; at < data.length; at += 4) if (data[at] === r && data[at + 1] === g && data[at + 2] === b) count += 1; \
    return count; })()";

#[test]
fn the_ground_is_the_sites_own() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-ground");
    service::fly(&folder, None);
    let tiles = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/basemap/site.pmtiles");
    fs::copy(tiles, folder.join("ground.pmtiles")).unwrap();
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
    browser.wait(&format!("{WATER} > 5000"), SOON);
    // In the colours of each theme, and at zoom levels beyond those of the file.
    for step in
        ["document.getElementById('theme-button').click()", "document.getElementById('theme-button').click()"]
    {
        browser.run(step);
        browser.wait(DRAWN, SOON);
        browser.wait(&format!("{WATER} > 5000"), SOON);
    }
    browser.open(&format!("{}#c=52.5065,-0.588&z=1.5&{layers}", service.url()));
    browser.run("location.reload()");
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} > 0"), SOON);
    browser.wait(&format!("{WATER} > 5000"), SOON);
    // The page may still be loading again.
    browser.wait("document.querySelector('input[name=base]') !== null", SOON);
    browser.run("document.querySelector('input[name=base]').click()");
    browser.wait(&format!("{WATER} === 0"), SOON);
    assert_eq!(browser.complaints(), Vec::<String>::new(), "errors in the console");
    assert!(
        browser.requests().iter().all(|asked| asked.starts_with(&service.url())),
        "{:?}",
        browser.requests()
    );
}
