//! An operator draws a zone, activates it and revokes it. A read-only token can only save it.

use super::alerts::{complaints, sign_in};
use super::browser::Browser;
use super::encounter::{self, DESK, GUEST};
use super::service::Service;
use super::{DRAWN, SOON, fresh_folder, installed};

const FAULT: &str = "document.getElementById('zone-fault').textContent";
const ZONES: &str =
    "[...document.querySelectorAll('#zone-list li')].map(item => item.firstChild.textContent).join()";
/// Names of the areas that the page knows.
const AREAS: &str = "[...document.getElementById('by-zone').options].map(({value}) => value).join()";

/// Whether an element can be seen.
fn is_shown(id: &str) -> String {
    format!("document.getElementById('{id}').checkVisibility()")
}

/// Clicks at this pixel of the map with the mouse.
fn corner(browser: &mut Browser, x: u32, y: u32) {
    browser.run(&format!(
        "(() => {{ const canvas = document.getElementById('canvas'); canvas.setPointerCapture = () => {{}}; \
            const {{left, top}} = canvas.getBoundingClientRect(); \
            for (const type of ['pointerdown', 'pointerup']) canvas.dispatchEvent(new PointerEvent(type, \
                {{pointerId: 1, button: 0, clientX: left + {x}, clientY: top + {y}, bubbles: true}})); }})()"
    ));
}

fn draw(browser: &mut Browser) {
    for (x, y) in [(500, 200), (700, 200), (700, 400)] {
        corner(browser, x, y);
    }
}

#[test]
fn drawn_zone_is_activated_and_revoked() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-zones");
    encounter::fly(&folder, true);
    let mut service = Service::without_input(&folder);
    service.token = Some(DESK);
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    browser.wait("document.getElementById('sign-in').open", SOON);
    sign_in(&mut browser, GUEST);
    read_only_token_saves_a_file(&mut browser);
    browser
        .run("document.getElementById('tool-end').click(); document.getElementById('sign-in').showModal()");
    sign_in(&mut browser, DESK);
    zone_is_activated(&mut browser, &service);
    std::fs::write(folder.join("zones.png"), browser.screenshot()).unwrap();
    zone_is_revoked(&mut browser, &service);
    assert_eq!(complaints(&browser), Vec::<&String>::new(), "errors in the console");
}

fn read_only_token_saves_a_file(browser: &mut Browser) {
    browser.wait(&format!("{AREAS}.includes('Hospital')"), SOON);
    browser.run("document.getElementById('zone-button').click()");
    browser.wait(&format!("{} && !{}", is_shown("zone-file"), is_shown("zone-activate")), SOON);
    browser.wait(&format!("!{} && !{}", is_shown("zone-offer"), is_shown("zone-active")), SOON);
}

fn zone_is_activated(browser: &mut Browser, service: &Service) {
    browser.run("document.getElementById('zone-button').click()");
    browser.wait(&format!("{} && {}", is_shown("zone-activate"), is_shown("zone-offer")), SOON);
    browser.wait(&format!("!{}", is_shown("zone-file")), SOON);
    browser.run("document.getElementById('zone-activate').click()");
    browser.wait(&format!("{FAULT}.startsWith('A zone has at least three corners')"), SOON);
    draw(browser);
    browser.run("document.getElementById('zone-activate').click()");
    browser.wait(&format!("{FAULT} === 'An active zone needs a name.'"), SOON);
    browser.run("document.getElementById('zone-name').value = 'Fair <b>/1'");
    browser.run("document.getElementById('zone-ceiling').value = '150'");
    browser.run("document.getElementById('zone-activate').click()");
    browser.wait(&format!("{ZONES}.startsWith('Fair <b>/1: activated by desk, 20') && {FAULT} === ''"), SOON);
    let zones = service.get("/api/v1/zones");
    assert_eq!(
        (&zones["zones"][0]["name"], &zones["zones"][0]["ceiling_m"]),
        (&"Fair <b>/1".into(), &150.0.into())
    );
    let areas = service.get("/api/v1/areas");
    assert!(areas["features"].to_string().contains("\"activated_by\":\"desk\""), "{areas}");
    assert_eq!(service.logged("zone activated name=\"Fair <b>/1\" by=\"desk\"").len(), 1);
    // The page draws it without being loaded again, and begins the next zone.
    browser.wait(&format!("{AREAS}.includes('Fair <b>/1')"), SOON);
    browser.wait("document.getElementById('tool-words').textContent === '3 more corners needed'", SOON);
    browser.wait(DRAWN, SOON);
    // A second zone of this name would replace the first one.
    draw(browser);
    browser.run("document.getElementById('zone-name').value = 'Fair <b>/1'");
    browser.run("document.getElementById('zone-activate').click()");
    browser.wait(&format!("{FAULT}.startsWith('A zone of this name is active')"), SOON);
}

fn zone_is_revoked(browser: &mut Browser, service: &Service) {
    browser.run("document.querySelector('#zone-list button').click()");
    browser.wait("document.querySelector('#zone-list button').textContent === 'Really revoke?'", SOON);
    assert_eq!(service.get("/api/v1/zones")["zones"].as_array().unwrap().len(), 1);
    browser.run("document.querySelector('#zone-list button').click()");
    browser.wait(&format!("{ZONES} === '' && !{}", is_shown("zone-active")), SOON);
    browser.wait(&format!("!{AREAS}.includes('Fair')"), SOON);
    assert_eq!(service.get("/api/v1/zones")["zones"], serde_json::json!([]));
    assert_eq!(service.logged("zone revoked name=\"Fair <b>/1\" by=\"desk\"").len(), 1);
}
