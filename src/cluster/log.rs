//! The log, which is NATS JetStream: what is asked of it, in the cluster's own words.
//!
//! Of it is used: append where the last message of a subject is the expected one, read from a sequence on, create what is not there
//! yet, and look. Nothing that servers know since 2.10 only.

mod checkpoints;
mod connection;
mod holding;
mod kept;
mod numbers;
mod outputs;
mod reading;
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

use super::message::Input;
use super::region::Letter;
use crate::config::Cluster;
use fusion::slots::SlotGrid;
use outputs::Bounds;

pub use checkpoints::Checkpoint;
use connection::connect;
pub use connection::{check, reach};
pub use holding::{Held, Holder, Place, Renewed};
pub use reading::Reading;
pub use skips::{Skipped, Skips};

/// Nobody waits longer for an answer.
pub(super) const PATIENCE: Duration = Duration::from_secs(1);
/// How long inputs are kept: what a node may be behind.
const INPUTS_KEPT: Duration = Duration::from_secs(180);
/// And outputs.
const OUTPUTS_KEPT: Duration = Duration::from_secs(600);
/// Time within which a copy of an input, or of an output, is known as one.
const INPUT_COPIES: Duration = Duration::from_secs(10);
const OUTPUT_COPIES: Duration = Duration::from_secs(60);

/// What went wrong with the log.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The credentials cannot be read, or it cannot be connected to at all.
    #[error("the log cannot be used: {0}")]
    Unusable(String),
    /// It did not do what it was asked to, or not in time.
    #[error("the log does not answer: {0}")]
    Unanswered(String),
    /// A stream is there with other settings.
    #[error(
        "{stream} is there with {what} = {found}, and {wanted} is wanted: delete it, or use another region"
    )]
    Different {
        /// Which.
        stream: String,
        /// The setting.
        what: &'static str,
        /// As it is.
        found: String,
        /// As it should be.
        wanted: String,
    },
}

impl LogError {
    fn unanswered(error: impl std::fmt::Display) -> Self {
        Self::Unanswered(error.to_string())
    }
}

/// When messages were written, nanoseconds since 1970. Streams that were lost and are there again have others at the same place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mark {
    /// An input.
    pub input: i128,
    /// An output.
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
    /// The messages that this process has skipped.
    pub skips: Skips,
    /// Hash of this process's shared configuration; 0: none is stated.
    pub config: u64,
    /// The slots of its outputs.
    pub grid: SlotGrid,
}

impl std::fmt::Debug for Log {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Log").field("region", &self.region).finish_non_exhaustive()
    }
}

impl Log {
    /// Connects, and makes what is not there yet. Waits until the servers answer.
    ///
    /// # Errors
    /// The credentials cannot be read, the servers refuse them, or a stream is there with other settings.
    pub async fn open(cluster: &Cluster) -> Result<Self, LogError> {
        let (client, context) = connect(cluster).await?;
        let mut is_told = false;
        loop {
            match Self::of(cluster, client.clone(), context.clone(), Skips::default()).await {
                Err(error @ LogError::Unanswered(_)) => {
                    if !std::mem::replace(&mut is_told, true) {
                        warn!(%error, "waits for the log");
                    }
                    tokio::time::sleep(PATIENCE).await;
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
        let input = stream("IN", format!("utm.in.{region}.>"), INPUTS_KEPT, INPUT_COPIES);
        let output = stream("OUT", format!("utm.out.{region}.*"), OUTPUTS_KEPT, OUTPUT_COPIES);
        let lease = Duration::from_secs_f64(*lease_s);
        // What the client makes of a bucket, but for a question that servers before 2.10 answer otherwise.
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
            // Any server may answer, also one that does not know the latest yet: who holds a lease is asked of the leader.
            allow_direct: false,
            ..StreamConfig::default()
        };
        let (own, num) = (format!("UTM_OWN_{region}"), format!("UTM_NUM_{region}"));
        let held = bucket(&own, StorageType::Memory, lease, lease);
        let numbers = bucket(&num, StorageType::File, Duration::ZERO, OUTPUT_COPIES);
        let checkpoints = object_store::Config {
            bucket: format!("UTM_CK_{region}"),
            storage: StorageType::File,
            num_replicas: replicas,
            ..object_store::Config::default()
        };
        Ok(Self {
            held_stream: made(&context, held).await?,
            input: made(&context, input).await?,
            output: made(&context, output).await?,
            held: context.get_key_value(&own).await.map_err(LogError::unanswered)?,
            numbers_stream: made(&context, numbers).await?,
            numbers: context.get_key_value(&num).await.map_err(LogError::unanswered)?,
            checkpoints: checkpoints::made(&context, checkpoints).await?,
            region: region.clone(),
            client,
            context,
            bounds: Bounds::default(),
            skips,
            config: 0,
            grid: SlotGrid::default(),
        })
    }

    /// Whether there is a connection.
    pub fn is_connected(&self) -> bool {
        self.client.connection_state() == async_nats::connection::State::Connected
    }

    /// What is at these sequences of inputs and outputs. `None`: it is not there any more, or not yet.
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

    /// The same streams again; made anew where they are lost.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn again(&self, cluster: &Cluster) -> Result<Self, LogError> {
        let again = Self::of(cluster, self.client.clone(), self.context.clone(), self.skips.clone()).await?;
        Ok(Self { config: self.config, grid: self.grid, ..again })
    }

    /// Writes an input; a copy of one is written once.
    ///
    /// # Errors
    /// The log does not answer: it may be written all the same, and is to be sent again.
    pub async fn publish(&self, input: &Input) -> Result<(), LogError> {
        let (sensor, region) = (input.sensor, &self.region);
        let mut headers = HeaderMap::new();
        headers.insert(NATS_MESSAGE_ID, input.id());
        let subject = format!("utm.in.{region}.{}.{}", sensor.sac, sensor.sic);
        let sent = self.context.publish_with_headers(subject, headers, input.body().into()).await;
        sent.map_err(LogError::unanswered)?.await.map_err(LogError::unanswered)?;
        Ok(())
    }

    /// Writes a letter among the inputs; a copy of one is written once.
    ///
    /// # Errors
    /// The log does not answer: it may be written all the same, and is to be sent again.
    pub async fn post(&self, letter: &Letter) -> Result<(), LogError> {
        let mut headers = HeaderMap::new();
        headers.insert(NATS_MESSAGE_ID, letter.id());
        let subject = format!("utm.in.{}.to.{}", self.region, letter.to);
        let sent = self.context.publish_with_headers(subject, headers, letter.body().into()).await;
        sent.map_err(LogError::unanswered)?.await.map_err(LogError::unanswered)?;
        Ok(())
    }

    /// The sequence of the oldest input that is still there; of the next one where there is none.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn oldest_input(&self) -> Result<u64, LogError> {
        self.input.get_info().await.map(|info| info.state.first_sequence).map_err(LogError::unanswered)
    }

    /// The inputs from this sequence on, without end.
    pub fn inputs(&self, from: u64) -> Reading {
        Reading::new(self.input.clone(), format!("utm.in.{}.>", self.region), from)
    }

    /// The outputs of a cell from this sequence on, without end.
    pub fn outputs(&self, cell: &str, from: u64) -> Reading {
        Reading::new(self.output.clone(), self.outputs_of(cell), from)
    }

    /// The outputs of all cells, likewise.
    pub fn all_outputs(&self, from: u64) -> Reading {
        self.outputs("*", from)
    }
}

/// The keys of a bucket that begin so, in order; of those that were deleted, too.
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

/// Whether a message is not there, whatever the server's version calls that.
fn is_gone(kind: &RawMessageErrorKind) -> bool {
    const NOT_FOUND: usize = 404;
    match kind {
        RawMessageErrorKind::NoMessageFound => true,
        RawMessageErrorKind::JetStream(error) => error.code() == NOT_FOUND,
        _ => false,
    }
}

/// A stream, made where it is not there.
async fn made(context: &Context, wanted: StreamConfig) -> Result<Stream, LogError> {
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
