//! Reading a subject without end, whatever becomes of the server that one reads from.

use std::pin::Pin;
use std::time::Duration;

use async_nats::jetstream::Message;
use async_nats::jetstream::consumer::{AckPolicy, DeliverPolicy, pull};
use async_nats::jetstream::stream::{DirectGetErrorKind, Stream};
use futures_util::StreamExt;
use tokio::time::{Instant, timeout, timeout_at};
use tracing::debug;

use fusion::time::Time;

use super::{LogError, PATIENCE};

/// A reader is told that often that there is nothing, and asks anew when it hears nothing for some of these.
const HEARTBEAT: Duration = Duration::from_millis(250);
/// Pause before it asks anew where that did not work.
const ANEW: Duration = Duration::from_millis(50);
/// An ask for messages holds for this long.
const ASK: Duration = Duration::from_secs(3);
/// Most messages of one ask.
const ASKED: usize = 500;
/// A reader that hears nothing for this long, not even that there is nothing, is made anew.
const SILENT: Duration = Duration::from_secs(1);
/// The servers forget a reader that they have not heard of for this long.
const FORGOTTEN: Duration = Duration::from_secs(10);

/// A reader that is being made. `None`: the stream is shorter than what was read of it. `Err`: nobody makes one now.
type Beginning = Pin<Box<dyn Future<Output = Result<Option<pull::Stream>, LogError>> + Send>>;

/// Messages of a subject, in order. A reader whose server is gone is made anew where it had come to. Whoever waits for a message
/// may give up at any time, as in a `select!`, and ask again: nothing is begun anew for it.
pub struct Reading {
    stream: Stream,
    subject: String,
    /// The sequence of the next message.
    next: u64,
    beginning: Option<Beginning>,
    messages: Option<Box<pull::Stream>>,
    /// When it is made anew if nothing is heard until then.
    patience: Instant,
    /// Counts the messages of this reader, so that none is left out.
    count: u64,
    has_more: bool,
    stamp: Time,
}

impl Reading {
    pub(super) fn new(stream: Stream, subject: String, next: u64) -> Self {
        let patience = Instant::now() + SILENT;
        Self {
            stream,
            subject,
            next,
            beginning: None,
            messages: None,
            patience,
            count: 0,
            has_more: false,
            stamp: Time::default(),
        }
    }

    /// The next message and its sequence; waits for it. `None`: the stream was lost, and what it is now is shorter than what was
    /// read of it.
    pub async fn next(&mut self) -> Option<(u64, bytes::Bytes)> {
        self.next_of().await.map(|(sequence, _, payload)| (sequence, payload))
    }

    /// The same with the last part of the message's subject: of an output the cell.
    pub async fn next_of(&mut self) -> Option<(u64, String, bytes::Bytes)> {
        loop {
            let Some(messages) = &mut self.messages else {
                let (stream, subject, next) = (&self.stream, &self.subject, self.next);
                let beginning = self
                    .beginning
                    .get_or_insert_with(|| Box::pin(begin(stream.clone(), subject.clone(), next)));
                let begun = beginning.as_mut().await;
                self.beginning = None;
                match begun {
                    Ok(Some(messages)) => {
                        (self.messages, self.count) = (Some(Box::new(messages)), 0);
                        self.patience = Instant::now() + SILENT;
                    }
                    Ok(None) => return None,
                    // Servers that choose a leader make no readers, but any of them still knows the stream.
                    Err(_) => match self.fetch().await {
                        Some(message) => return Some(message),
                        None => tokio::time::sleep(ANEW).await,
                    },
                }
                continue;
            };
            let message = timeout_at(self.patience, messages.next()).await;
            let Ok(Some(Ok(message))) = message else {
                // Silent, ended, or failed: whatever it was, it is asked anew.
                self.messages = None;
                continue;
            };
            self.patience = Instant::now() + SILENT;
            match self.place(&message) {
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

    /// The next message, asked for alone.
    async fn fetch(&mut self) -> Option<(u64, String, bytes::Bytes)> {
        let from = (self.next > 0).then_some(self.next)?;
        let asked = self.stream.direct_get_next_for_subject(self.subject.as_str(), Some(from));
        match timeout(PATIENCE, asked).await {
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

    /// Whether there were more messages of the subject when the last one was sent; not known of one that was asked for alone.
    pub const fn has_more(&self) -> bool {
        self.has_more
    }

    /// When the log stamped the last message: the same for all who read it.
    pub const fn stamp(&self) -> Time {
        self.stamp
    }

    /// Its sequence, which one of this reader it is, how many were behind it, and its stamp.
    fn place(&self, message: &Message) -> Option<(u64, u64, u64, Time)> {
        let info = message.info().ok()?;
        Some((
            info.stream_sequence,
            info.consumer_sequence,
            info.pending,
            stamped(info.published.unix_timestamp_nanos()),
        ))
    }
}

/// A reader of the subject from this sequence on. `None`: the stream ends before it, so it is another one than it was.
async fn begin(stream: Stream, subject: String, next: u64) -> Result<Option<pull::Stream>, LogError> {
    let consumer = pull::Config {
        deliver_policy: match next {
            0 => DeliverPolicy::New,
            start_sequence => DeliverPolicy::ByStartSequence { start_sequence },
        },
        ack_policy: AckPolicy::None,
        filter_subject: subject,
        inactive_threshold: FORGOTTEN,
        num_replicas: 1,
        memory_storage: true,
        ..pull::Config::default()
    };
    let made = async {
        let consumer = stream.create_consumer(consumer).await.map_err(LogError::unanswered)?;
        let messages = consumer.stream().max_messages_per_batch(ASKED).expires(ASK).heartbeat(HEARTBEAT);
        messages.messages().await.map_err(LogError::unanswered)
    };
    let messages = timeout(2 * HEARTBEAT, made).await.map_err(LogError::unanswered)??;
    let state = stream.get_info().await.map(|info| info.state);
    let is_shorter = state.is_ok_and(|state| state.last_sequence + 1 < next);
    Ok((!is_shorter).then_some(messages))
}

/// A stamp of the log, nanoseconds since 1970.
pub(super) fn stamped(nanos: i128) -> Time {
    Time::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX))
}

fn last_part(subject: &str) -> String {
    subject.rsplit('.').next().unwrap_or_default().to_owned()
}
