//! The log, which is NATS JetStream: what is asked of it, in the cluster's own words.
//!
//! Of it is used: append where the last message of a subject is the expected one, read from a sequence on, create what is not there
//! yet, and look. Nothing that servers know since 2.10 only.

mod checkpoints;
mod connection;
mod numbers;
mod reading;

use std::time::Duration;

use async_nats::Client;
use async_nats::header::{HeaderMap, NATS_EXPECTED_LAST_SUBJECT_SEQUENCE, NATS_MESSAGE_ID};
use async_nats::jetstream::Context;
use async_nats::jetstream::context::PublishErrorKind;
use async_nats::jetstream::kv::{Operation, Store, UpdateErrorKind};
use async_nats::jetstream::object_store::{self, ObjectStore};
use async_nats::jetstream::stream::{
    Config as StreamConfig, DiscardPolicy, LastRawMessageErrorKind, RawMessageErrorKind, StorageType, Stream,
};
use futures_util::TryStreamExt;
use serde::{Deserialize, Serialize};
use tracing::warn;

use super::cell::Appended;
use super::message::{Input, Output};
use super::region::Letter;
use crate::config::Cluster;
use fusion::slots::Slot;

pub use checkpoints::Checkpoint;
use connection::connect;
pub use connection::{check, reach};
pub use reading::Reading;

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

/// Who holds something until it is no longer renewed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Holder {
    /// The node.
    pub node: String,
    /// Its machine.
    pub machine: String,
    /// A number of this run of its process.
    pub run: u64,
}

/// What a name of the log stands for now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Held {
    /// By whom.
    pub by: Holder,
    /// Its number: greater than of whoever held it before.
    pub revision: u64,
}

/// What became of an attempt to go on holding something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Renewed {
    /// It goes on, under this number.
    Until(u64),
    /// Somebody else has it, or it ended.
    Lost,
    /// Nobody answered.
    Unknown,
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
            match Self::of(cluster, client.clone(), context.clone()).await {
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

    async fn of(cluster: &Cluster, client: Client, context: Context) -> Result<Self, LogError> {
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
        Self::of(cluster, self.client.clone(), self.context.clone()).await
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

    /// Writes an output of a cell if its last one has this sequence. Servers of several copies look at that before they agree on
    /// a message, so two that are on their way at once would both get in: a slot has a name besides, of which one is written.
    pub async fn append(&self, cell: &str, expected: u64, output: &Output) -> Appended {
        let mut headers = HeaderMap::new();
        headers.insert(NATS_EXPECTED_LAST_SUBJECT_SEQUENCE, expected.to_string());
        headers.insert(NATS_MESSAGE_ID, format!("{cell}:{}", output.slot.0));
        let sent = self.context.publish_with_headers(self.outputs_of(cell), headers, output.body().into());
        let Ok(acknowledged) = sent.await else { return Appended::Unknown };
        match acknowledged.await {
            // Of this slot there is one already: whose, is to be read.
            Ok(acknowledged) if acknowledged.duplicate => Appended::Refused,
            Ok(acknowledged) => Appended::Stored(acknowledged.sequence),
            Err(error) if error.kind() == PublishErrorKind::WrongLastSequence => Appended::Refused,
            Err(_) => Appended::Unknown,
        }
    }

    /// The last output of a cell, as whoever leads the stream knows it.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn last(&self, cell: &str) -> Result<Option<(u64, Output)>, LogError> {
        match self.output.get_last_raw_message_by_subject(&self.outputs_of(cell)).await {
            Ok(last) => {
                let output = Output::parse(&last.payload).map_err(LogError::unanswered)?;
                Ok(Some((last.sequence, output)))
            }
            Err(error) if matches!(error.kind(), LastRawMessageErrorKind::NoMessageFound) => Ok(None),
            Err(error) => Err(LogError::unanswered(error)),
        }
    }

    fn outputs_of(&self, cell: &str) -> String {
        format!("utm.out.{}.{cell}", self.region)
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

    /// Takes hold of what nobody holds; its number. `None`: somebody has it, or nobody answers.
    pub async fn take(&self, key: &str, holder: &Holder) -> Option<u64> {
        self.held.create(key, written(holder)).await.ok()
    }

    /// Goes on holding what is held under this number.
    pub async fn renew(&self, key: &str, holder: &Holder, revision: u64) -> Renewed {
        match self.held.update(key, written(holder), revision).await {
            Ok(revision) => Renewed::Until(revision),
            Err(error) if error.kind() == UpdateErrorKind::WrongLastRevision => Renewed::Lost,
            Err(_) => Renewed::Unknown,
        }
    }

    /// Gives up what is held under this number.
    ///
    /// # Errors
    /// The log does not answer, or it is no longer held: it ends by itself.
    pub async fn give_up(&self, key: &str, revision: u64) -> Result<(), LogError> {
        let given = self.held.delete_expect_revision(key, Some(revision)).await;
        given.map_err(LogError::unanswered)
    }

    /// Who holds something now.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn holder(&self, key: &str) -> Result<Option<Held>, LogError> {
        let entry = self.held.entry(key).await.map_err(LogError::unanswered)?;
        let held = entry.filter(|entry| entry.operation == Operation::Put).and_then(|entry| {
            Some(Held { by: serde_json::from_slice(&entry.value).ok()?, revision: entry.revision })
        });
        Ok(held)
    }

    /// Says something that is forgotten when it is not said again.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn say(&self, key: &str, what: Vec<u8>) -> Result<(), LogError> {
        self.held.put(key, what.into()).await.map(|_| ()).map_err(LogError::unanswered)
    }

    /// What was said so.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn said(&self, key: &str) -> Result<Option<Vec<u8>>, LogError> {
        let entry = self.held.entry(key).await.map_err(LogError::unanswered)?;
        Ok(entry.filter(|entry| entry.operation == Operation::Put).map(|entry| entry.value.to_vec()))
    }

    /// Under which names something is held or said.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn keys(&self) -> Result<Vec<String>, LogError> {
        keys(&self.held, &self.held_stream, "").await
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
    matches!(kind, RawMessageErrorKind::JetStream(_) | RawMessageErrorKind::NoMessageFound)
}

fn written(holder: &Holder) -> bytes::Bytes {
    serde_json::to_vec(holder).expect("it can be written").into()
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

/// The slot and the epoch of an output, with its sequence.
pub(super) const fn placed(last: &(u64, Output)) -> (u64, Slot, u64) {
    (last.0, last.1.slot, last.1.epoch)
}
