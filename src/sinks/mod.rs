//! Whom the picture goes to once a second, beside CAT129 and the API: each in a format of its own.
//!
//! ```text
//! hub ──► follow ──► Desk (8 s at most, per sink) ──► sink's task ──► UDP
//!         never waits                             ├─► sink's task ──► TCP, TLS: a Dialogue
//!                                             ├─► sink's task ──► HTTP
//!                                             └─► sink's task ──► a broker of MQTT 5
//! ```
//!
//! No slot waits for a sink: the follower reads the hub as any reader does, and what a receiver does not take in time is lost
//! and counted. Each sink has a task of its own; one that is slow or gone hinders nobody else. A format that needs a connection
//! is a `stream::Dialogue`, which is sans-IO.

mod cot;
mod counts;
mod datagrams;
mod desk;
mod f3623;
mod follow;
mod mqtt;
mod outbox;
mod sapient;
mod second;
mod stream;

use std::sync::Arc;

use tokio::sync::watch;

use crate::config::Config;
use crate::live::{Hub, Outgoing, Trouble};
use crate::net::peers::{Closing, Deliveries, Unusable};
use datagrams::Datagrams;
use desk::Desk;
use f3623::Posts;
use mqtt::TrackBroker;
use stream::Peer;

pub use counts::{Counts, Loss};
pub use second::Second;

/// A sink that is opened.
#[derive(Debug)]
enum Sink {
    Datagrams(Datagrams),
    Peer(Peer),
    Posts(Posts),
    Broker(TrackBroker),
}

impl Sink {
    fn desk(&self) -> &Arc<Desk> {
        match self {
            Self::Datagrams(datagrams) => &datagrams.desk,
            Self::Peer(peer) => &peer.desk,
            Self::Posts(posts) => &posts.desk,
            Self::Broker(broker) => &broker.desk,
        }
    }

    async fn deliver(self, closing: Closing) {
        match self {
            Self::Datagrams(datagrams) => datagrams.deliver(closing).await,
            Self::Peer(peer) => peer.deliver(closing).await,
            Self::Posts(posts) => posts.deliver(closing).await,
            Self::Broker(broker) => broker.deliver(closing).await,
        }
    }

    /// Whether it can be reached now; nothing is sent.
    async fn reach(&self) -> Result<(), String> {
        match self {
            Self::Datagrams(datagrams) => datagrams.reach().await,
            Self::Peer(peer) => peer.reach().await,
            Self::Posts(posts) => posts.reach().await,
            Self::Broker(broker) => broker.reach().await,
        }
    }
}

/// The sinks of a configuration; nobody is connected to yet.
#[derive(Debug, Default)]
pub struct PictureSinks {
    sinks: Vec<Sink>,
    /// For people.
    lines: Vec<String>,
    warnings: Vec<String>,
}

impl PictureSinks {
    /// Those of a configuration; the files that they name are read.
    ///
    /// # Errors
    /// A file cannot be read or used.
    pub fn open(config: &Config) -> Result<Self, Unusable> {
        let mut all = Self::default();
        for cot in &config.output.cot {
            let refuse = |problem| Unusable::new(format!("output.cot, id \"{}\"", cot.id), problem);
            all.lines.push(cot::line(cot));
            all.warnings.extend(cot::warning(cot));
            all.sinks.push(cot::open(cot, &config.site).map_err(refuse)?);
        }
        for f3623 in &config.output.f3623 {
            let refuse = |problem| Unusable::new(format!("output.f3623, id \"{}\"", f3623.id), problem);
            all.lines.push(f3623::line(f3623));
            all.warnings.extend(f3623::warning(f3623));
            all.sinks.push(f3623::open(f3623).map_err(refuse)?);
        }
        for sapient in &config.output.sapient {
            all.lines.push(sapient::line(sapient));
            all.warnings.extend(sapient::warning(sapient));
            all.sinks.push(sapient::open(sapient, config));
        }
        for mqtt in &config.output.mqtt {
            let refuse = |problem| Unusable::new(format!("output.mqtt, id \"{}\"", mqtt.id), problem);
            all.lines.push(mqtt::line(mqtt));
            all.warnings.extend(mqtt::warning(mqtt));
            all.sinks.push(mqtt::open(mqtt, &config.site).map_err(refuse)?);
        }
        Ok(all)
    }

    /// A line for each, without secrets.
    pub fn lines(&self) -> &[String] {
        &self.lines
    }

    /// What works and should not stay so.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Tries each: its name, and what went wrong. Nothing is sent.
    pub async fn reach(&self) -> Vec<(String, Result<(), String>)> {
        let mut reached = Vec::new();
        for sink in &self.sinks {
            reached.push((sink.desk().name().to_owned(), sink.reach().await));
        }
        reached
    }

    /// Begins to deliver what the hub publishes from now on; within a runtime.
    pub fn start(self, hub: Hub) -> (SinkMeter, Deliveries) {
        let desks: Arc<[Arc<Desk>]> = self.sinks.iter().map(|sink| sink.desk().clone()).collect();
        let closing = watch::Sender::new(false);
        // The sinks end when the follower has seen the last slot.
        let seen = watch::Sender::new(false);
        let mut tasks = Vec::new();
        for sink in self.sinks {
            tasks.push(tokio::spawn(sink.deliver(seen.subscribe())));
        }
        if !tasks.is_empty() {
            tasks.insert(0, tokio::spawn(follow::follow(hub, desks.clone(), closing.subscribe(), seen)));
        }
        (SinkMeter(desks), Deliveries::new(closing, tasks))
    }
}

/// How the sinks are; cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct SinkMeter(Arc<[Arc<Desk>]>);

impl SinkMeter {
    /// What was sent and lost so far, with the name of each sink.
    pub fn counts(&self) -> impl Iterator<Item = (&str, Counts)> {
        self.0.iter().map(|desk| (desk.name(), desk.counts()))
    }
}

impl Outgoing for SinkMeter {
    fn troubles(&self) -> Vec<Trouble> {
        self.0.iter().filter_map(|desk| desk.trouble()).collect()
    }
}
