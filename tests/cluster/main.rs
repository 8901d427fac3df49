//! Tests with real `nats-server` processes on loopback: features of the log that the cluster relies on, and the duration of
//! outages.
#![expect(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    reason = "a test that cannot go on fails; its files and its clock are its own"
)]

#[path = "../map/browser.rs"]
#[allow(dead_code, reason = "tests of the map make use of more")]
mod browser;
mod caution;
mod cells;
mod clocks;
mod contract;
mod locked;
mod outages;
mod overload;
#[path = "../shared/program.rs"]
#[allow(dead_code, reason = "of the program, other tests of this target make use")]
mod program;
mod proxy;
mod readers;
mod recording;
#[allow(dead_code, reason = "shared with an example")]
mod servers;
mod site;
mod takeover;
mod times;
mod troubles;
mod watcher;

use std::time::Duration;

use async_nats::jetstream;
use async_nats::jetstream::stream::{Config, StorageType};

use crate::program::Scratch;
use crate::servers::Servers;

/// Servers and their directory; `None` if nats-server is not installed.
async fn cluster(count: usize) -> Option<(Servers, Scratch)> {
    let binary = servers::binary()?;
    let scratch = Scratch::new();
    let servers = Servers::start(&binary, &scratch.path(""), count).await;
    let (major, minor) = servers.version();
    println!("nats-server {major}.{minor}");
    Some((servers, scratch))
}

/// A stream in memory on three servers, for all subjects below `below`.
fn in_memory(name: &str, below: &str) -> Config {
    Config {
        name: name.to_owned(),
        subjects: vec![format!("{below}.>")],
        storage: StorageType::Memory,
        num_replicas: 3,
        max_age: Duration::from_secs(60),
        duplicate_window: Duration::from_secs(2),
        ..Config::default()
    }
}

/// Appends a message, and waits for its acknowledgement.
async fn append(
    streams: &jetstream::Context,
    subject: &str,
    header: (&str, &str),
) -> Result<jetstream::publish::PublishAck, jetstream::context::PublishError> {
    let mut headers = async_nats::HeaderMap::new();
    headers.insert(header.0, header.1);
    streams.publish_with_headers(subject.to_owned(), headers, "slot".into()).await?.await
}
