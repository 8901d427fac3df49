//! What breaks around the service: the disk, the interface, the clock, clients and senders. Through the built program where
//! that can be; each test says on standard error where this machine does not let it.

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

/// Drones and birds for as long as a fault lasts, and some time more.
pub(crate) fn scenario(duration_s: u32) -> String {
    format!(
        "name = \"fault\"\nduration_s = {duration_s}\n[drones]\nmultirotors = 2\nequipped = 2\n[birds]\ncount = 3\n"
    )
}

/// A service that publishes each slot 2.25 s after it opened, of a window of 5 s: nobody has to wait long.
pub(crate) fn quick(config: &mut Config) {
    let fusion = &mut config.fusion;
    (fusion.latency_slots, fusion.window_slots, fusion.suppress_slots) = (9, 20, 8);
    fusion.max_gap = jiff::SignedDuration::from_secs(5);
    fusion.radar_only_min_s = 1.0;
}
