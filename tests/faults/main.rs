//! Faults around the service: the disk, the interface, the clock, clients and senders. The tests use the built program
//! where possible. A test that this machine does not permit prints a message on standard error.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![expect(clippy::disallowed_methods, reason = "files that the service wrote, and the real time")]

mod clients;
mod clock;
#[path = "../live/common.rs"]
#[allow(dead_code, reason = "shared with the live tests")]
mod common;
mod datagrams;
mod disk;
mod http;
mod inside;
mod interface;
mod lateness;
#[path = "../shared/program.rs"]
#[allow(dead_code, reason = "shared by several tests")]
mod program;
mod recorded;
#[path = "../live/stage.rs"]
#[allow(dead_code, reason = "shared with the live tests")]
mod stage;

use utm_fusion::config::Config;

/// Drones and birds, for longer than a fault lasts.
pub(crate) fn scenario(duration_s: u32) -> String {
    format!(
        "name = \"fault\"\nduration_s = {duration_s}\n[drones]\nmultirotors = 2\nequipped = 2\n[birds]\ncount = 3\n"
    )
}

/// Publishes each slot 2.25 s after it opened, with a window of 5 s, so that the tests wait less.
pub(crate) fn quick(config: &mut Config) {
    let fusion = &mut config.fusion;
    (fusion.latency_slots, fusion.window_slots, fusion.suppress_slots) = (9, 20, 8);
    fusion.max_gap = jiff::SignedDuration::from_secs(5);
    fusion.radar_only_min_s = 1.0;
}
