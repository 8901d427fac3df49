//! The picture in the README: made here, and looked at by people.

use std::fs;
use std::path::Path;
use std::time::Duration;

use super::browser::Browser;
use super::service::Service;
use super::{FUSED_ROW, SOON, fresh_folder, installed};

/// `cargo test --test map picture -- --ignored`, while nothing else on this machine sends the demo's multicast.
#[test]
#[ignore = "writes docs/images/map.png, and takes a minute"]
fn the_picture_of_the_readme_is_taken() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-picture");
    let service = Service::demo();
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    // By then radar tracks have their transponders, and trails are long.
    std::thread::sleep(Duration::from_secs(60));
    browser.wait(&format!("{FUSED_ROW} !== undefined"), SOON);
    browser.run("document.getElementById('fit').click()");
    browser.run(&format!("{FUSED_ROW}.click()"));
    // The list shows the details once the service has answered.
    browser.wait("document.getElementById('detail').textContent.includes('Last measurement')", SOON);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/images/map.png");
    fs::create_dir_all(file.parent().unwrap()).unwrap();
    fs::write(file, browser.screenshot()).unwrap();
}
