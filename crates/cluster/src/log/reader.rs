//! Endless reading of a subject, across failures of servers.

use std::pin::Pin;
use std::time::Duration;

use async_nats::jetstream::Message;
use async_nats::jetstream::consumer::{AckPolicy, DeliverPolicy, pull};
use async_nats::jetstream::stream::{DirectGetErrorKind, Stream};
use futures_util::StreamExt;
use tokio::time::{Instant, timeout, timeout_at};
use tracing::debug;

use fusion::time::Time;

use super::{LogError, REQUEST_TIMEOUT};

/// Interval of the server's heartbeats to a reader.
const HEARTBEAT: Duration = Duration::from_millis(250);
/// Pause before a failed request is repeated.
const RETRY_PAUSE: Duration = Duration::from_millis(50);
/// Validity of a request for messages.
const REQUEST_TIMEOUT_S: Duration = Duration::from_secs(3);
/// Maximum number of messages of one request.
const MESSAGES_PER_REQUEST: usize = 500;
/// Time without a message or heartbeat after which a reader is created again.
const SILENCE_TIMEOUT: Duration = Duration::from_secs(1);
/// Time without a request after which the servers delete a reader.
const READER_EXPIRY: Duration = Duration::from_secs(10);

/// A reader being created. `None` if the stream is shorter than what was read of it; `Err` if no server creates readers now.
type ReaderCreation = Pin<Box<dyn Future<Output = Result<Option<pull::Stream>, LogError>> + Send>>;

/// Messages of a subject, in order. A reader whose server is gone is created again at its last position. Waiting for a message
/// can be cancelled at any time, as in a `select!`, and repeated without loss.
pub struct SubjectReader {
    stream: Stream,
    subject: String,
    /// Sequence of the next message.
    next: u64,
    creation: Option<ReaderCreation>,
    messages: Option<Box<pull::Stream>>,
    /// Time at which the reader is created again if it receives nothing until then.
    deadline: Instant,
    /// Number of messages from this reader, to detect gaps.
    count: u64,
    has_more: bool,
    stamp: Time,
}

impl SubjectReader {
    pub(super) fn new(stream: Stream, subject: String, next: u64) -> Self {
        let deadline = Instant::now() + SILENCE_TIMEOUT;
        Self {
            stream,
            subject,
            next,
            creation: None,
            messages: None,
            deadline,
            count: 0,
            has_more: false,
            stamp: Time::default(),
        }
    }

    /// Waits for the next message, and returns it with its sequence. `None` if the stream was lost, and is now shorter than what
    /// was read of it.
    pub async fn next(&mut self) -> Option<(u64, bytes::Bytes)> {
        self.next_with_subject().await.map(|(sequence, _, payload)| (sequence, payload))
    }

    /// Waits for the next message, and returns it also with the last part of its subject: the cell, for an output.
    pub async fn next_with_subject(&mut self) -> Option<(u64, String, bytes::Bytes)> {
        loop {
            let Some(messages) = &mut self.messages else {
                let (stream, subject, next) = (&self.stream, &self.subject, self.next);
                let creation = self
                    .creation
                    .get_or_insert_with(|| Box::pin(create_reader(stream.clone(), subject.clone(), next)));
                let created = creation.as_mut().await;
                self.creation = None;
                match created {
                    Ok(Some(messages)) => {
                        (self.messages, self.count) = (Some(Box::new(messages)), 0);
                        self.deadline = Instant::now() + SILENCE_TIMEOUT;
                    }
                    Ok(None) => return None,
                    // Servers without a leader create no readers, but each of them can still read the stream.
                    Err(_) => match self.fetch().await {
                        Some(message) => return Some(message),
                        None => tokio::time::sleep(RETRY_PAUSE).await,
                    },
                }
                continue;
            };
            let message = timeout_at(self.deadline, messages.next()).await;
            let Ok(Some(Ok(message))) = message else {
                // The reader is silent, has ended, or has failed: request again.
                self.messages = None;
                continue;
            };
            self.deadline = Instant::now() + SILENCE_TIMEOUT;
            match self.entry_state(&message) {
                Some((sequence, count, waiting, stamp)) if count == self.count + 1 => {
                    (self.count, self.has_more, self.stamp) = (count, waiting > 0, stamp);
                    if sequence >= self.next {
                        self.next = sequence + 1;
                        let of = last_part(&message.message.subject);
                        return Some((sequence, of, message.message.payload));
                    }
                }
                _ => self.messages = None,
            }
        }
    }

    /// Requests the next message alone.
    async fn fetch(&mut self) -> Option<(u64, String, bytes::Bytes)> {
        let from = (self.next > 0).then_some(self.next)?;
        let asked = self.stream.direct_get_next_for_subject(self.subject.as_str(), Some(from));
        match timeout(REQUEST_TIMEOUT, asked).await {
            Ok(Ok(message)) => {
                (self.next, self.has_more) = (message.sequence + 1, false);
                self.stamp = stamped(message.time.unix_timestamp_nanos());
                Some((message.sequence, last_part(&message.subject), message.payload))
            }
            Ok(Err(error)) if error.kind() != DirectGetErrorKind::NotFound => {
                debug!(%error, subject = self.subject, "not read: tried again");
                None
            }
            _ => None,
        }
    }

    /// Whether the subject had more messages when the last one was sent; not known for a message that was requested alone.
    pub const fn has_more(&self) -> bool {
        self.has_more
    }

    /// The log's timestamp of the last message, which is the same for every reader.
    pub const fn stamp(&self) -> Time {
        self.stamp
    }

    /// Sequence of a message, its index within this reader, the number of messages after it, and its timestamp.
    fn entry_state(&self, message: &Message) -> Option<(u64, u64, u64, Time)> {
        let info = message.info().ok()?;
        Some((
            info.stream_sequence,
            info.consumer_sequence,
            info.pending,
            stamped(info.published.unix_timestamp_nanos()),
        ))
    }
}

/// Creates a reader of the subject from this sequence on. `None` if the stream ends before it, and so was created again.
async fn create_reader(stream: Stream, subject: String, next: u64) -> Result<Option<pull::Stream>, LogError> {
    let consumer = pull::Config {
        deliver_policy: match next {
            0 => DeliverPolicy::New,
            start_sequence => DeliverPolicy::ByStartSequence { start_sequence },
        },
        ack_policy: AckPolicy::None,
        filter_subject: subject,
        inactive_threshold: READER_EXPIRY,
        num_replicas: 1,
        memory_storage: true,
        ..pull::Config::default()
    };
    let open_stream = async {
        let consumer = stream.create_consumer(consumer).await.map_err(LogError::unanswered)?;
        let messages = consumer
            .stream()
            .max_messages_per_batch(MESSAGES_PER_REQUEST)
            .expires(REQUEST_TIMEOUT_S)
            .heartbeat(HEARTBEAT);
        messages.messages().await.map_err(LogError::unanswered)
    };
    let messages = timeout(2 * HEARTBEAT, open_stream).await.map_err(LogError::unanswered)??;
    let state = stream.get_info().await.map(|info| info.state);
    let is_shorter = state.is_ok_and(|state| state.last_sequence + 1 < next);
    Ok((!is_shorter).then_some(messages))
}

/// Converts a timestamp of the log, in nanoseconds since 1970.
pub(super) fn stamped(nanos: i128) -> Time {
    Time::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX))
}

fn last_part(subject: &str) -> String {
    subject.rsplit('.').next().unwrap_or_default().to_owned()
}
