//! The live service: its recording replays to the data sent, despite faults of clock, disk, network and process.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![expect(clippy::disallowed_methods, reason = "files that the service wrote, and the real time")]

mod alerts;
mod common;
mod correlations;
mod demo;
mod driver;
mod flood;
mod integrity;
#[path = "../shared/invented.rs"]
mod invented;
mod notices;
mod posted;
mod process;
#[path = "../shared/program.rs"]
#[allow(dead_code, reason = "shared by several tests")]
mod program;
mod proxy;
mod recorder;
mod registration;
mod rehearsed;
mod reload;
mod relocation;
mod replayed;
mod sapient;
mod senders;
mod sensors;
mod sinks;
mod sockets;
mod stage;
mod system_tracks;
mod takeover;
mod terminal;
mod tls;
mod warm;
mod zones;
