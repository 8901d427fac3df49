//! Sinks that receive the picture once a second, beside CAT129 and the API, each in its own format.
//!
//! ```text
//! hub ──► follow ──► SinkQueue (8 s at most, per sink) ──► sink's task ──► UDP
//!         never waits                             ├─► sink's task ──► TCP, TLS: a Dialogue
//!                                                 ├─► sink's task ──► HTTP
//!                                                 └─► sink's task ──► a broker of MQTT 5
//! ```
//!
//! No slot waits for a sink: the follower reads the hub like any reader, and pictures that a receiver does not accept in time are
//! dropped and counted. Each sink has its own task, so a slow or unreachable one does not affect the others. A format that needs
//! a connection is a `stream::Dialogue`, which is sans-IO.

mod cot;
mod counts;
mod datagrams;
mod delivery;
mod f3623;
mod follow;
mod mqtt;
mod outbox;
mod sapient;
mod second;
mod stream;

use std::sync::Arc;

use tokio::sync::watch;

use crate::live::{Hub, Outgoing, ServiceFault};
use crate::net::peers::{Closing, Deliveries, UnusableReceiver};
use datagrams::DatagramSink;
use delivery::SinkQueue;
use f3623::F3623Sink;
use mqtt::TrackBroker;
use site::config::Config;
use stream::StreamSink;

pub use counts::{SinkCounts, SinkLoss};
pub use second::PictureSecond;

/// An opened sink.
#[derive(Debug)]
enum PictureSink {
    Datagrams(DatagramSink),
    Peer(StreamSink),
    Posts(F3623Sink),
    Broker(TrackBroker),
}

impl PictureSink {
    fn queue(&self) -> &Arc<SinkQueue> {
        match self {
            Self::Datagrams(datagrams) => &datagrams.queue,
            Self::Peer(peer) => &peer.queue,
            Self::Posts(posts) => &posts.queue,
            Self::Broker(broker) => &broker.queue,
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

    /// Whether the sink can be reached now; no message is sent.
    async fn reach(&self) -> Result<(), String> {
        match self {
            Self::Datagrams(datagrams) => datagrams.reach().await,
            Self::Peer(peer) => peer.reach().await,
            Self::Posts(posts) => posts.reach().await,
            Self::Broker(broker) => broker.reach().await,
        }
    }
}

/// The sinks of a configuration, before any connection is made.
#[derive(Debug, Default)]
pub struct PictureSinks {
    sinks: Vec<PictureSink>,
    /// Descriptions for the log and the terminal.
    lines: Vec<String>,
    warnings: Vec<String>,
}

impl PictureSinks {
    /// Opens the sinks of a configuration; reads the files that they name.
    ///
    /// # Errors
    /// A file cannot be read or used.
    pub fn open(config: &Config) -> Result<Self, UnusableReceiver> {
        let mut all = Self::default();
        for cot in &config.output.cot {
            let refuse = |problem| UnusableReceiver::new(format!("output.cot, id \"{}\"", cot.id), problem);
            all.lines.push(cot::line(cot));
            all.warnings.extend(cot::warning(cot));
            all.sinks.push(cot::open(cot, &config.site).map_err(refuse)?);
        }
        for f3623 in &config.output.f3623 {
            let refuse =
                |problem| UnusableReceiver::new(format!("output.f3623, id \"{}\"", f3623.id), problem);
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
            let refuse = |problem| UnusableReceiver::new(format!("output.mqtt, id \"{}\"", mqtt.id), problem);
            all.lines.push(mqtt::line(mqtt));
            all.warnings.extend(mqtt::warning(mqtt));
            all.sinks.push(mqtt::open(mqtt, &config.site).map_err(refuse)?);
        }
        Ok(all)
    }

    /// One description for each sink, without secrets.
    pub fn lines(&self) -> &[String] {
        &self.lines
    }

    /// Weaknesses of the configuration that the operator should remove.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Tests each sink. Returns its name with the error, if any. No message is sent.
    pub async fn reach(&self) -> Vec<(String, Result<(), String>)> {
        let mut reached = Vec::new();
        for sink in &self.sinks {
            reached.push((sink.queue().name().to_owned(), sink.reach().await));
        }
        reached
    }

    /// Begins to deliver what the hub publishes from now on; called within a runtime.
    pub fn start(self, hub: Hub) -> (SinkMeter, Deliveries) {
        let queues: Arc<[Arc<SinkQueue>]> = self.sinks.iter().map(|sink| sink.queue().clone()).collect();
        let closing = watch::Sender::new(false);
        // The sinks end when the follower has passed on the last slot.
        let seen = watch::Sender::new(false);
        let mut tasks = Vec::new();
        for sink in self.sinks {
            tasks.push(tokio::spawn(sink.deliver(seen.subscribe())));
        }
        if !tasks.is_empty() {
            tasks.insert(0, tokio::spawn(follow::follow(hub, queues.clone(), closing.subscribe(), seen)));
        }
        (SinkMeter(queues), Deliveries::new(closing, tasks))
    }
}

/// Counts and faults of the sinks; cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct SinkMeter(Arc<[Arc<SinkQueue>]>);

impl SinkMeter {
    /// Counts so far, with the name of each sink.
    pub fn counts(&self) -> impl Iterator<Item = (&str, SinkCounts)> {
        self.0.iter().map(|queue| (queue.name(), queue.counts()))
    }
}

impl Outgoing for SinkMeter {
    fn troubles(&self) -> Vec<ServiceFault> {
        self.0.iter().filter_map(|queue| queue.trouble()).collect()
    }
}
