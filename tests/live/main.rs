//! The live service: its recording replays to what it sent, whatever happens to clock, disk, network and process.

mod common;
mod driver;
mod process;
mod recorder;
mod sockets;
