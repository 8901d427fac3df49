//! Loads the log between machines like a country's sensors, and measures it: messages into an in-memory stream on three
//! servers, read by several consumers.
//!
//! ```sh
//! cargo run --release --features cluster --example log_load -- --start-servers nats-server --seconds 60
//! cargo run --release --features cluster --example log_load -- --urls nats://10.0.0.1:4222,nats://10.0.0.2:4222
//! ```
//!
//! The first command starts three servers on this machine's loopback interface and stops them at the end. The second
//! uses running servers; their processor time is measured if they are on this machine and listed: `--servers $(pgrep
//! -d, -x nats-server)`. The stream `LOG_LOAD` is created and deleted. The exit code is 1 if a message was lost,
//! duplicated or refused.

#![expect(clippy::disallowed_methods, reason = "it measures how long things take")]

#[path = "../tests/cluster/servers.rs"]
#[allow(dead_code, clippy::unwrap_used, reason = "shared with tests")]
mod servers;

use std::collections::HashSet;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use async_nats::jetstream::consumer::{AckPolicy, DeliverPolicy, pull};
use async_nats::jetstream::stream::{Config, StorageType};
use async_nats::{HeaderMap, jetstream};
use clap::Parser;
use futures_util::StreamExt;
use tokio::sync::{Semaphore, mpsc};

use crate::servers::{Servers, cpu_seconds};

const STREAM: &str = "LOG_LOAD";
/// Timeout for acknowledgements, and for readers, after the last message.
const PATIENCE: Duration = Duration::from_secs(10);
/// Maximum number of unacknowledged messages per connection (docs/SCALING.md).
const UNACKNOWLEDGED: usize = 256;

/// Loads the log between machines and measures it.
#[derive(Parser)]
struct Args {
    /// Addresses of running servers.
    #[arg(long, value_delimiter = ',', required_unless_present = "start_servers")]
    urls: Vec<String>,
    /// Start three servers of this program instead.
    #[arg(long, conflicts_with_all = ["urls", "servers"])]
    start_servers: Option<PathBuf>,
    /// Process ids of the servers, to measure their processor time.
    #[arg(long, value_delimiter = ',')]
    servers: Vec<u32>,
    /// Messages per second.
    #[arg(long, default_value_t = 4_000)]
    rate: u64,
    /// Size of a message, octets.
    #[arg(long, default_value_t = 2_000)]
    octets: usize,
    /// Number of subjects, used in turn.
    #[arg(long, default_value_t = 1_000)]
    subjects: u64,
    /// Duration of sending, seconds.
    #[arg(long, default_value_t = 60)]
    seconds: u64,
    /// Number of sending connections.
    #[arg(long, default_value_t = 4)]
    connections: u64,
    /// Number of consumers, each of which reads every message.
    #[arg(long, default_value_t = 3)]
    readers: usize,
    /// Number of copies that the servers keep.
    #[arg(long, default_value_t = 3)]
    replicas: usize,
}

#[tokio::main]
async fn main() -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let args = Args::parse();
    let Some(binary) = &args.start_servers else {
        return load(&args, &args.urls, &args.servers).await;
    };
    let directory = std::env::temp_dir().join(format!("log_load-{}", std::process::id()));
    std::fs::create_dir_all(&directory)?;
    let started = Servers::start(binary, &directory, 3).await;
    let result = load(&args, &started.urls(), &started.processes()).await;
    drop(started);
    std::fs::remove_dir_all(directory)?;
    result
}

async fn load(
    args: &Args,
    urls: &[String],
    servers: &[u32],
) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let streams = jetstream::new(servers::options().connect(urls).await?);
    let _ = streams.delete_stream(STREAM).await;
    streams
        .create_stream(Config {
            name: STREAM.to_owned(),
            subjects: vec!["log_load.>".to_owned()],
            storage: StorageType::Memory,
            num_replicas: args.replicas,
            max_age: Duration::from_secs(180),
            duplicate_window: Duration::from_secs(10),
            ..Config::default()
        })
        .await?;

    let total = args.rate * args.seconds;
    let mut readers = Vec::new();
    for _ in 0..args.readers {
        let streams = jetstream::new(servers::options().connect(urls).await?);
        // Each reader has its own consumer of all messages.
        let consumer = consumer(&streams).await?;
        readers.push(tokio::spawn(read(consumer, total)));
    }
    let (results, mut acknowledged) = mpsc::unbounded_channel();
    let began = Instant::now();
    let busy = |processes: &[u32]| -> Vec<f64> {
        processes.iter().map(|&process| cpu_seconds(process).unwrap_or(f64::NAN)).collect()
    };
    let (of_servers, own) = (busy(servers), busy(&[std::process::id()]));
    let mut senders = Vec::new();
    for index in 0..args.connections {
        let client = servers::options().connect(urls).await?;
        let plan = SendPlan { index, began, total, ..SendPlan::of(args) };
        senders.push(tokio::spawn(send(client, plan, results.clone())));
    }
    drop(results);

    let (mut times, mut refused) = (Vec::new(), 0_u64);
    while let Some(result) = acknowledged.recv().await {
        match result {
            Ok(taken) => times.push(taken),
            Err(error) => {
                if refused == 0 {
                    println!("first refused: {error}");
                }
                refused += 1;
            }
        }
    }
    let mut sent = 0;
    for sender in senders {
        sent += sender.await??;
    }
    let lasted = began.elapsed().as_secs_f64();
    let cores = |before: &[f64], processes: &[u32]| -> Vec<f64> {
        busy(processes).iter().zip(before).map(|(after, before)| (after - before) / lasted).collect()
    };
    let (of_servers, own) = (cores(&of_servers, servers), cores(&own, &[std::process::id()]));
    times.sort_unstable();

    println!("sent {sent} in {lasted:.1} s, acknowledged {}, refused or in doubt {refused}", times.len());
    let mut right = refused == 0;
    for (index, reader) in readers.into_iter().enumerate() {
        let (numbers, messages) = reader.await?;
        let (lost, doubled) = (sent - numbers, messages - numbers);
        println!("reader {index}: read {numbers}, lost {lost}, doubled {doubled}");
        right &= lost == 0 && doubled == 0;
    }
    let at = |share: f64| {
        let index = ((times.len().saturating_sub(1)) as f64 * share) as usize;
        times.get(index).map_or(f64::NAN, |time| time.as_secs_f64() * 1e3)
    };
    println!("acknowledged after (ms): p50 {:.1}, p99 {:.1}, max {:.1}", at(0.5), at(0.99), at(1.0));
    let sum: f64 = of_servers.iter().sum();
    println!("cores: servers {of_servers:.2?}, together {sum:.2}; this program {:.2}", own[0]);
    streams.delete_stream(STREAM).await?;
    Ok(if right { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Messages of one connection: one in `connections`, sent when due.
#[derive(Clone, Copy)]
struct SendPlan {
    index: u64,
    connections: u64,
    began: Instant,
    rate: u64,
    total: u64,
    subjects: u64,
    octets: usize,
}

impl SendPlan {
    fn of(args: &Args) -> Self {
        Self {
            index: 0,
            connections: args.connections,
            began: Instant::now(),
            rate: args.rate,
            total: 0,
            subjects: args.subjects,
            octets: args.octets,
        }
    }
}

type AckDelay = Result<Duration, String>;

/// Sends messages, and passes on the time of each acknowledgement. Returns the number sent.
async fn send(
    client: async_nats::Client,
    plan: SendPlan,
    results: mpsc::UnboundedSender<AckDelay>,
) -> Result<u64, Box<dyn Error + Send + Sync>> {
    let streams = jetstream::ContextBuilder::new().timeout(PATIENCE).build(client);
    let window = Arc::new(Semaphore::new(UNACKNOWLEDGED));
    let mut sent = 0;
    for number in (plan.index..plan.total).step_by(usize::try_from(plan.connections)?) {
        let due = plan.began + Duration::from_secs_f64(number as f64 / plan.rate as f64);
        // The timer's resolution is a millisecond: messages due within it are sent immediately.
        if due > Instant::now() {
            tokio::time::sleep_until(due.into()).await;
        }
        let place = Arc::clone(&window).acquire_owned().await?;
        let mut headers = HeaderMap::new();
        headers.insert("Nats-Msg-Id", number.to_string());
        let mut body = vec![b'.'; plan.octets.max(8)];
        body[..8].copy_from_slice(&number.to_be_bytes());
        let begun = Instant::now();
        let subject = format!("log_load.{}", number % plan.subjects);
        let pending = streams.publish_with_headers(subject, headers, body.into()).await?;
        sent += 1;
        let results = results.clone();
        tokio::spawn(async move {
            let result = pending.await.map(|_| begun.elapsed()).map_err(|error| error.to_string());
            let _ = results.send(result);
            drop(place);
        });
    }
    let _ = window.acquire_many(UNACKNOWLEDGED as u32).await?;
    Ok(sent)
}

async fn consumer(streams: &jetstream::Context) -> Result<pull::Stream, Box<dyn Error + Send + Sync>> {
    let config = pull::Config {
        deliver_policy: DeliverPolicy::All,
        ack_policy: AckPolicy::None,
        inactive_threshold: Duration::from_secs(30),
        num_replicas: 1,
        memory_storage: true,
        ..pull::Config::default()
    };
    let consumer = streams.create_consumer_on_stream(config, STREAM).await?;
    let requests = consumer.stream().max_messages_per_batch(1_000).expires(Duration::from_secs(5));
    Ok(requests.heartbeat(Duration::from_secs(1)).messages().await?)
}

/// Reads until all messages have arrived or a timeout expires. Returns the numbers of distinct messages and of all
/// messages.
async fn read(mut messages: pull::Stream, total: u64) -> (u64, u64) {
    let (mut numbers, mut read) = (HashSet::new(), 0);
    while (numbers.len() as u64) < total {
        match tokio::time::timeout(PATIENCE, messages.next()).await {
            Ok(Some(Ok(message))) => {
                read += 1;
                if let Some(number) = message.payload.first_chunk() {
                    numbers.insert(u64::from_be_bytes(*number));
                }
            }
            Ok(Some(Err(error))) => println!("reader: {error}"),
            Ok(None) | Err(_) => break,
        }
    }
    (numbers.len() as u64, read)
}
