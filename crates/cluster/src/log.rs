//! The log (NATS JetStream), in the cluster's own terms.
//!
//! Operations used: append if the last message of a subject is the expected one, read from a sequence on, create if absent, and
//! look up. No feature introduced with nats-server 2.10 or later is used.

mod checkpoints;
mod connection;
mod entries;
mod numbers;
mod outputs;
mod persistent;
mod reader;
mod skips;

use std::time::Duration;

use async_nats::Client;
use async_nats::header::{HeaderMap, NATS_MESSAGE_ID};
use async_nats::jetstream::Context;
use async_nats::jetstream::kv::Store;
use async_nats::jetstream::object_store::{self, ObjectStore};
use async_nats::jetstream::stream::{
    Config as StreamConfig, DiscardPolicy, RawMessageErrorKind, StorageType, Stream,
};
use futures_util::TryStreamExt;
use serde::{Deserialize, Serialize};
use tracing::warn;

use super::message::GatewayInput;
use super::region::CellMessage;
use fusion::slots::SlotGrid;
use outputs::Bounds;
use site::config::Cluster;

pub use checkpoints::Checkpoint;
use connection::connect;
pub use connection::{check, reach};
pub use entries::{EntryState, HeldEntry, Holder, Renewal};
pub use reader::SubjectReader;
pub use skips::{Skipped, Skips};

/// Timeout of a request.
pub(super) const REQUEST_TIMEOUT: Duration = Duration::from_secs(1);
/// Retention of inputs: the maximum time that a node may be behind.
const INPUT_RETENTION: Duration = Duration::from_secs(180);
/// Retention of outputs.
const OUTPUT_RETENTION: Duration = Duration::from_secs(600);
/// Time within which the log recognises a copy of an input, or of an output.
const INPUT_COPY_WINDOW: Duration = Duration::from_secs(10);
const OUTPUT_COPY_WINDOW: Duration = Duration::from_secs(60);

/// Error of the log.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The credentials cannot be read, or no connection is possible.
    #[error("the log cannot be used: {0}")]
    Unusable(String),
    /// A request failed or timed out.
    #[error("the log does not answer: {0}")]
    Unanswered(String),
    /// A stream exists with other settings.
    #[error(
        "{stream} is there with {what} = {found}, and {wanted} is wanted: delete it, or use another region"
    )]
    Different {
        /// Name of the stream.
        stream: String,
        /// Name of the setting.
        what: &'static str,
        /// Current value.
        found: String,
        /// Required value.
        wanted: String,
    },
}

impl LogError {
    fn unanswered(error: impl std::fmt::Display) -> Self {
        Self::Unanswered(error.to_string())
    }
}

/// Timestamps of two messages, in nanoseconds since 1970. They identify the streams: a stream that was lost and created again has
/// others at the same sequences.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mark {
    /// Timestamp of an input.
    pub input: i128,
    /// Timestamp of an output.
    pub output: i128,
}

/// The streams of a region.
#[derive(Clone)]
pub struct Log {
    client: Client,
    context: Context,
    region: String,
    input: Stream,
    output: Stream,
    held: Store,
    held_stream: Stream,
    numbers: Store,
    numbers_stream: Stream,
    checkpoints: ObjectStore,
    bounds: Bounds,
    /// Counts the messages that this process has skipped.
    pub skips: Skips,
    /// Hash of this process's shared configuration; 0 if none is stated.
    pub config: u64,
    /// Slot grid of its outputs.
    pub grid: SlotGrid,
}

impl std::fmt::Debug for Log {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Log").field("region", &self.region).finish_non_exhaustive()
    }
}

impl Log {
    /// Connects, and creates missing streams and buckets. Waits until the servers answer.
    ///
    /// # Errors
    /// The credentials cannot be read, the servers refuse them, or a stream exists with other settings.
    pub async fn open(cluster: &Cluster) -> Result<Self, LogError> {
        let (client, context) = connect(cluster).await?;
        let mut is_logged = false;
        loop {
            match Self::of(cluster, client.clone(), context.clone(), Skips::default()).await {
                Err(error @ LogError::Unanswered(_)) => {
                    if !std::mem::replace(&mut is_logged, true) {
                        warn!(%error, "waits for the log");
                    }
                    tokio::time::sleep(REQUEST_TIMEOUT).await;
                }
                opened => return opened,
            }
        }
    }

    async fn of(cluster: &Cluster, client: Client, context: Context, skips: Skips) -> Result<Self, LogError> {
        let Cluster { region, replicas, lease_s, .. } = cluster;
        let replicas = *replicas as usize;
        let stream = |name: &str, subjects: String, max_age, duplicate_window| StreamConfig {
            name: format!("UTM_{name}_{region}"),
            subjects: vec![subjects],
            storage: StorageType::Memory,
            num_replicas: replicas,
            max_age,
            duplicate_window,
            discard: DiscardPolicy::Old,
            allow_direct: true,
            ..StreamConfig::default()
        };
        let input = stream("IN", format!("utm.in.{region}.>"), INPUT_RETENTION, INPUT_COPY_WINDOW);
        let output = stream("OUT", format!("utm.out.{region}.*"), OUTPUT_RETENTION, OUTPUT_COPY_WINDOW);
        let lease = Duration::from_secs_f64(*lease_s);
        // The settings that the client uses for a bucket, except for one that servers before 2.10 handle differently.
        let bucket = |name: &str, storage, max_age, duplicate_window| StreamConfig {
            name: format!("KV_{name}"),
            subjects: vec![format!("$KV.{name}.>")],
            max_messages_per_subject: 1,
            max_age,
            duplicate_window,
            storage,
            num_replicas: replicas,
            discard: DiscardPolicy::New,
            allow_rollup: true,
            deny_delete: true,
            // With direct reads any server may answer, even with an outdated value. The holder of a lease has to come from the
            // leader.
            allow_direct: false,
            ..StreamConfig::default()
        };
        let (own, num) = (format!("UTM_OWN_{region}"), format!("UTM_NUM_{region}"));
        let held = bucket(&own, StorageType::Memory, lease, lease);
        let numbers = bucket(&num, StorageType::File, Duration::ZERO, OUTPUT_COPY_WINDOW);
        let checkpoints = object_store::Config {
            bucket: format!("UTM_CK_{region}"),
            storage: StorageType::File,
            num_replicas: replicas,
            ..object_store::Config::default()
        };
        Ok(Self {
            held_stream: lease_bucket(&context, held).await?,
            input: open_stream(&context, input).await?,
            output: open_stream(&context, output).await?,
            held: context.get_key_value(&own).await.map_err(LogError::unanswered)?,
            numbers_stream: open_stream(&context, numbers).await?,
            numbers: context.get_key_value(&num).await.map_err(LogError::unanswered)?,
            checkpoints: checkpoints::open_store(&context, checkpoints).await?,
            region: region.clone(),
            client,
            context,
            bounds: Bounds::default(),
            skips,
            config: 0,
            grid: SlotGrid::default(),
        })
    }

    /// Whether the client is connected.
    pub fn is_connected(&self) -> bool {
        self.client.connection_state() == async_nats::connection::State::Connected
    }

    /// Timestamps of the messages at these sequences of inputs and outputs. `None` if a message has expired or does not exist
    /// yet.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn mark(&self, input: u64, output: u64) -> Result<Option<Mark>, LogError> {
        let at = async |stream: &Stream, sequence| match stream.get_raw_message(sequence).await {
            Ok(message) => Ok(Some(message.time.unix_timestamp_nanos())),
            Err(error) if is_gone(&error.kind()) => Ok(None),
            Err(error) => Err(LogError::unanswered(error)),
        };
        let (input, output) = (at(&self.input, input).await?, at(&self.output, output).await?);
        Ok(input.zip(output).map(|(input, output)| Mark { input, output }))
    }

    /// Opens the same streams again, and creates those that the servers have lost.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn reopen(&self, cluster: &Cluster) -> Result<Self, LogError> {
        let again = Self::of(cluster, self.client.clone(), self.context.clone(), self.skips.clone()).await?;
        Ok(Self { config: self.config, grid: self.grid, ..again })
    }

    /// Writes an input. The log stores copies once.
    ///
    /// # Errors
    /// The log does not answer. The input may be stored nevertheless, and has to be sent again.
    pub async fn publish(&self, input: &GatewayInput) -> Result<(), LogError> {
        let (sensor, region) = (input.sensor, &self.region);
        let mut headers = HeaderMap::new();
        headers.insert(NATS_MESSAGE_ID, input.id());
        let subject = format!("utm.in.{region}.{}.{}", sensor.sac, sensor.sic);
        let sent = self.context.publish_with_headers(subject, headers, input.body().into()).await;
        sent.map_err(LogError::unanswered)?.await.map_err(LogError::unanswered)?;
        Ok(())
    }

    /// Writes a message to a cell among the inputs. The log stores copies once.
    ///
    /// # Errors
    /// The log does not answer. The message may be stored nevertheless, and has to be sent again.
    pub async fn publish_message(&self, message: &CellMessage) -> Result<(), LogError> {
        let mut headers = HeaderMap::new();
        headers.insert(NATS_MESSAGE_ID, message.id());
        let subject = format!("utm.in.{}.to.{}", self.region, message.to);
        let sent = self.context.publish_with_headers(subject, headers, message.body().into()).await;
        sent.map_err(LogError::unanswered)?.await.map_err(LogError::unanswered)?;
        Ok(())
    }

    /// Sequence of the oldest stored input; of the next input if none is stored.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn oldest_input(&self) -> Result<u64, LogError> {
        self.input.get_info().await.map(|info| info.state.first_sequence).map_err(LogError::unanswered)
    }

    /// Reads the inputs from this sequence on, without end.
    pub fn inputs(&self, from: u64) -> SubjectReader {
        SubjectReader::new(self.input.clone(), format!("utm.in.{}.>", self.region), from)
    }

    /// Reads the outputs of a cell from this sequence on, without end.
    pub fn outputs(&self, cell: &str, from: u64) -> SubjectReader {
        SubjectReader::new(self.output.clone(), self.outputs_of(cell), from)
    }

    /// Reads the outputs of all cells from this sequence on, without end.
    pub fn all_outputs(&self, from: u64) -> SubjectReader {
        self.outputs("*", from)
    }
}

/// Keys of a bucket with this prefix, sorted, including deleted keys.
async fn keys(bucket: &Store, stream: &Stream, beginning: &str) -> Result<Vec<String>, LogError> {
    let of = format!("$KV.{}.", bucket.name);
    let subjects = stream.info_with_subjects(format!("{of}{beginning}>")).await;
    let mut subjects = subjects.map_err(LogError::unanswered)?;
    let mut keys = Vec::new();
    while let Some((subject, _)) = subjects.try_next().await.map_err(LogError::unanswered)? {
        keys.extend(subject.strip_prefix(&of).map(str::to_owned));
    }
    keys.sort();
    Ok(keys)
}

/// Whether the error means that the message does not exist, in any server version.
fn is_gone(kind: &RawMessageErrorKind) -> bool {
    const NOT_FOUND: usize = 404;
    match kind {
        RawMessageErrorKind::NoMessageFound => true,
        RawMessageErrorKind::JetStream(error) => error.code() == NOT_FOUND,
        _ => false,
    }
}

/// Opens the bucket of leases. A bucket whose leases last longer than configured is used unchanged, so that members can be
/// restarted one by one with a shorter lease.
async fn lease_bucket(context: &Context, mut wanted: StreamConfig) -> Result<Stream, LogError> {
    if let Ok(found) = context.get_stream(&wanted.name).await {
        let StreamConfig { max_age, duplicate_window, .. } = found.cached_info().config;
        wanted.max_age = wanted.max_age.max(max_age);
        wanted.duplicate_window = wanted.duplicate_window.max(duplicate_window);
    }
    open_stream(context, wanted).await
}

/// Opens a stream, and creates it if it is missing.
async fn open_stream(context: &Context, wanted: StreamConfig) -> Result<Stream, LogError> {
    let stream = context.get_or_create_stream(wanted.clone()).await.map_err(LogError::unanswered)?;
    let found = &stream.cached_info().config;
    let settings = |of: &StreamConfig| {
        [
            ("replicas", of.num_replicas.to_string()),
            ("max_age", format!("{:?}", of.max_age)),
            ("storage", format!("{:?}", of.storage)),
            ("subjects", of.subjects.join(", ")),
            ("duplicate_window", format!("{:?}", of.duplicate_window)),
        ]
    };
    for ((what, found), (_, wanted)) in settings(found).into_iter().zip(settings(&wanted)) {
        if found != wanted {
            let stream = stream.cached_info().config.name.clone();
            return Err(LogError::Different { stream, what, found, wanted });
        }
    }
    Ok(stream)
}
