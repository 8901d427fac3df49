//! Pictures for the documentation, to be checked by eye.
//!
//! Run `cargo test --release --test map picture -- --ignored --test-threads 1` while no other program on this machine sends the
//! multicast of the demo. Then `pngquant --force --quality 80-98 -o docs/images/map.png docs/images/map.png`: the README's picture
//! stays below 300 kB.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use super::browser::Browser;
use super::service::{self, Service};
use super::{BADGE, DRAWN, FUSED_ROW, ROWS, SOON, encounter, fresh_folder, installed};

#[test]
#[ignore = "writes docs/images/map.png, and takes a minute"]
fn the_picture_of_the_readme_is_taken() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-picture");
    let service = Service::demo();
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    // By then radar tracks are associated with transponders, and trails are long.
    std::thread::sleep(Duration::from_secs(60));
    browser.wait(&format!("{FUSED_ROW} !== undefined"), SOON);
    browser.run("document.getElementById('fit').click()");
    without_first_steps(&mut browser);
    browser.run(&format!("{FUSED_ROW}.click()"));
    // The details appear once the service has answered.
    browser.wait("document.getElementById('detail').textContent.includes('Last measurement')", SOON);
    take(&mut browser, "map");
}

#[test]
#[ignore = "writes docs/images/city-*.png, and takes a minute"]
fn the_pictures_of_a_city_are_taken() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-city");
    service::simulate(&folder, "city");
    let service = Service::replay_in("operational", &folder, 0);
    service.order("pause");
    service.seek("09:01:48");
    service.order("play");
    std::thread::sleep(Duration::from_secs(45)); // for long trails
    service.order("pause");
    let mut browser = Browser::start(&program, &folder.join("profile"));
    let nearer = "theme=light&colour=height&c=52.5085,-0.586&z=0.14";
    for (name, view, width, is_phone) in [
        ("city-dark", "theme=dark", 1280, false),
        ("city-light", nearer, 1280, false),
        ("city-phone", "theme=dark", 390, true),
    ] {
        browser.resize(width, if is_phone { 844 } else { 800 }, is_phone);
        browser.open("about:blank");
        browser.open(&format!("{}#{view}", service.url()));
        browser.wait(
            &format!(
                "{BADGE} === 'REPLAY paused' && document.querySelector('#sources .count').textContent > 99"
            ),
            SOON,
        );
        without_first_steps(&mut browser);
        if view == nearer {
            browser.run("document.getElementById('legend').open = true");
            browser.run("document.querySelector('#table-body tr:not(.spacer)').click()");
        }
        take(&mut browser, name);
    }
}

#[test]
#[ignore = "writes docs/images/encounter-*.png and alerts*.png"]
fn the_pictures_of_alerts_are_taken() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-pictures");
    let service = encounter::paused(&folder, false);
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.resize(1280, 800, false);
    let (longitude, latitude) = encounter::PLACE;
    let about = format!("c={latitude},{longitude}");

    // The warning.
    browser.open(&format!("{}#{about}&z=0.75&theme=dark", service.url()));
    browser.wait(&format!("{ROWS} === 2"), SOON);
    without_first_steps(&mut browser);
    service.order("play");
    browser.wait(&format!("{CONFLICT} < 16"), SOON + SOON);
    pause(&mut browser, &service);
    take(&mut browser, "encounter-dark");
    browser.resize(390, 844, true);
    browser.run(&format!("location.hash = '{about}&z=0.5&theme=dark'"));
    take(&mut browser, "encounter-phone");
    browser.resize(1280, 800, false);
    browser.run(&format!("location.hash = '{about}&z=0.75&theme=light'"));

    // The volume is entered; shown in light colours with actions in progress.
    service.order("play");
    browser.run("document.getElementById('alert-by').value = 'Mira, desk 2'");
    browser.wait("document.getElementById('alert-list').innerText.includes('too close')", SOON + SOON);
    pause(&mut browser, &service);
    take(&mut browser, "encounter-light");

    // One alert is acknowledged, another about to be shelved.
    let press = |item: usize, words: &str| {
        format!(
            "[...document.querySelectorAll('#alert-list li')[{item}].querySelectorAll('button')].find(button => button.innerText === '{words}').click()"
        )
    };
    browser.run(&press(0, "Acknowledge"));
    browser.wait("document.querySelectorAll('#alert-list [data-seen=true]').length === 1", SOON);
    take(&mut browser, "alerts");
    browser.run(&press(0, "Shelve, note…"));
    browser.resize(390, 844, true);
    browser.run("document.getElementById('sheet').scrollTop = 0");
    take(&mut browser, "alerts-phone");
}

/// Seconds until the closest point of approach.
const CONFLICT: &str =
    "Number.parseInt(/come close in (\\d+) s/.exec(document.getElementById('alert-list').innerText)?.[1])";

/// Closes what a first visit shows.
fn without_first_steps(browser: &mut Browser) {
    browser.run("document.getElementById('welcome-close').click()");
    browser.run("document.getElementById('legend').open = false");
}

fn pause(browser: &mut Browser, service: &Service) {
    service.order("pause");
    browser.wait(&format!("{BADGE} === 'REPLAY paused'"), SOON);
}

fn take(browser: &mut Browser, name: &str) {
    std::thread::sleep(Duration::from_secs(2)); // waits for pending answers
    browser.run("document.activeElement.blur()");
    browser.wait(DRAWN, SOON);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("docs/images/{name}.png"));
    fs::write(&file, browser.screenshot()).unwrap();
    // If installed: a picture has few colours, and is a third as large with a palette.
    let small = Command::new("pngquant").args(["--force", "--ext", ".png"]).arg(&file).status();
    assert!(small.map_or_else(|error| error.kind() == ErrorKind::NotFound, |status| status.success()));
}
