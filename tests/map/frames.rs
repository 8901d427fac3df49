//! Measurement of the frame rate while the map of a whole city is panned and zoomed; not a test.

use super::browser::Browser;
use super::service::{self, Service};
use super::{SOON, fresh_folder, installed};

/// Each movement takes 150 frames; measures the time between frames, in milliseconds.
const MEASURE: &str = "(async () => { \
    const canvas = document.getElementById('canvas'); \
    canvas.setPointerCapture = () => {}; \
    const point = (type, x, y) => canvas.dispatchEvent(new PointerEvent(type, \
        {pointerId: 1, button: 0, clientX: x, clientY: y, bubbles: true})); \
    const wheel = deltaY => canvas.dispatchEvent(new WheelEvent('wheel', {deltaY, clientX: 400, clientY: 400, cancelable: true})); \
    const moves = { \
        pan: i => point('pointermove', 400 + 120 * Math.sin(i / 12), 400 + 80 * Math.cos(i / 15)), \
        zoom: i => wheel(i % 60 < 30 ? -25 : 25), \
        rest: () => {} }; \
    const lines = []; \
    for (const [name, move] of Object.entries(moves)) { \
        const spans = []; \
        if (name === 'pan') point('pointerdown', 400, 480); \
        let before = await new Promise(requestAnimationFrame); \
        for (let i = 0; i < 150; i++) { \
            move(i); \
            const now = await new Promise(requestAnimationFrame); \
            spans.push(now - before); \
            before = now; } \
        if (name === 'pan') point('pointerup', 400, 480); \
        spans.sort((a, b) => a - b); \
        const at = share => spans[Math.floor(share * (spans.length - 1))].toFixed(1).padStart(6); \
        lines.push(`${name.padEnd(5)} p50 ${at(0.5)} p95 ${at(0.95)} most ${at(1)} ms`); } \
    return lines.join('\\n'); })()";

/// Run `cargo test --release --test map frames -- --ignored --nocapture` on an otherwise idle machine.
#[test]
#[ignore = "measures, and takes a minute"]
fn the_frames_of_a_city_are_timed() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-frames");
    service::simulate(&folder, "city");
    let service = Service::replay_in("operational", &folder, 0);
    service.order("pause");
    service.seek("09:02:30");
    service.order("play");
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.resize(1280, 800, false);
    browser.open(&service.url());
    let tracks = "[...document.querySelectorAll('#sources .count')].reduce((sum, count) => sum + Number(count.textContent), 0)";
    browser.wait(&format!("{tracks} > 400"), SOON);
    println!("{} tracks at 1280 x 800", browser.number(tracks));
    for _ in 0..3 {
        println!("{}", browser.text(MEASURE));
    }
}
