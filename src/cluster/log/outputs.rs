//! The outputs of a cell: written on a condition, and read with caution, since any process that reaches the servers may write
//! there, too.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use async_nats::header::{HeaderMap, NATS_EXPECTED_LAST_SUBJECT_SEQUENCE, NATS_MESSAGE_ID};
use async_nats::jetstream::context::PublishErrorKind;
use async_nats::jetstream::message::StreamMessage;
use async_nats::jetstream::stream::{LastRawMessageErrorKind, RawMessageError, Stream};
use tokio::time::Instant;

use super::{Log, LogError, is_gone};
use crate::cluster::cell::Appended;
use crate::cluster::engine::pictures;
use crate::cluster::message::Output;
use crate::config::MAX_WINDOW_SLOTS;

/// Pause before the log is asked again.
const SOON: Duration = Duration::from_millis(50);
/// Names of a slot that are tried where others have taken them.
const NAMES: usize = 16;
/// How long is read forward before it is said how far that came.
const FORWARD: Duration = Duration::from_millis(300);
/// Sequences that are looked through for the last output of a cell, at first.
const BACK: u64 = 512;
/// How far the streams have come at least: no output can name a lease or an input that is not there yet.
#[derive(Clone, Debug, Default)]
pub(super) struct Bounds(Arc<Known>);

#[derive(Debug, Default)]
struct Known {
    lease: AtomicU64,
    input: AtomicU64,
}

async fn reaches(known: &AtomicU64, stream: &Stream, sequence: u64) -> Result<bool, LogError> {
    if sequence <= known.load(Ordering::Relaxed) {
        return Ok(true);
    }
    let info = stream.get_info().await.map_err(LogError::unanswered)?;
    known.fetch_max(info.state.last_sequence, Ordering::Relaxed);
    Ok(sequence <= info.state.last_sequence)
}

impl Log {
    /// An input of this sequence was read.
    pub(crate) fn note_input(&self, sequence: u64) {
        self.bounds.0.input.fetch_max(sequence, Ordering::Relaxed);
    }

    /// A message among the outputs of a cell; `None`: no owner can have written it, which is counted.
    ///
    /// # Errors
    /// The log does not answer, and it is not known what the message is worth.
    pub async fn judged(&self, cell: &str, octets: &[u8]) -> Result<Option<Output>, LogError> {
        let place = format!("out.{cell}");
        let Ok(output) = Output::parse(octets) else {
            self.skips.unreadable(&place, octets);
            return Ok(None);
        };
        let reason = if !(0..self.last_slot()).contains(&output.slot.0) {
            "a slot that is no time"
        } else if output.epoch == 0 || !reaches(&self.bounds.0.lease, &self.held_stream, output.epoch).await?
        {
            "of a lease that was never given"
        } else if !reaches(&self.bounds.0.input, &self.input, output.behind).await? {
            "behind an input that is not there"
        } else if pictures(&output.picture).is_none_or(|(picture, _)| picture.slot != output.slot) {
            "without a picture of its slot"
        } else {
            return Ok(Some(output));
        };
        self.skips.note(&place, reason);
        Ok(None)
    }

    /// Beyond it no slot has a time.
    fn last_slot(&self) -> i64 {
        let slot_ns = i64::try_from(self.grid.slot().as_nanos()).unwrap_or(i64::MAX);
        i64::MAX / slot_ns - i64::from(MAX_WINDOW_SLOTS)
    }

    /// The same; waits until the log answers.
    pub async fn worth(&self, cell: &str, octets: &[u8]) -> Option<Output> {
        loop {
            match self.judged(cell, octets).await {
                Ok(output) => return output,
                Err(_) => tokio::time::sleep(SOON).await,
            }
        }
    }

    /// Writes an output of a cell if the last message there has this sequence. Servers of several copies look at that before they
    /// agree on a message, so two that are on their way at once would both get in: a slot has a name besides, of which one is
    /// written. Where a message that is no output of the cell has the name, the slot is called after that one, too.
    pub async fn append(&self, cell: &str, expected: u64, output: &Output) -> Appended {
        let (subject, body) = (self.outputs_of(cell), bytes::Bytes::from(output.body()));
        let mut name = format!("{cell}:{}", output.slot.0);
        for _ in 0..NAMES {
            let mut headers = HeaderMap::new();
            headers.insert(NATS_EXPECTED_LAST_SUBJECT_SEQUENCE, expected.to_string());
            headers.insert(NATS_MESSAGE_ID, name);
            let sent = self.context.publish_with_headers(subject.clone(), headers, body.clone()).await;
            let Ok(acknowledged) = sent else { return Appended::Unknown };
            let there = match acknowledged.await {
                Ok(acknowledged) if acknowledged.duplicate => acknowledged.sequence,
                Ok(acknowledged) => return Appended::Stored(acknowledged.sequence),
                Err(error) if error.kind() == PublishErrorKind::WrongLastSequence => {
                    return Appended::Refused;
                }
                Err(_) => return Appended::Unknown,
            };
            match self.output.get_raw_message(there).await {
                Ok(message) if *message.subject == *subject && message.payload == body => {
                    return Appended::Stored(there);
                }
                // Its worth is found by reading it.
                Ok(message) if *message.subject == *subject && there > expected => return Appended::Refused,
                Ok(_) => {}
                Err(error) if is_gone(&error.kind()) => {}
                Err(_) => return Appended::Unknown,
            }
            self.skips.note(&format!("out.{cell}"), "under the name of a slot that it does not hold");
            name = format!("{cell}:{}:{there}", output.slot.0);
        }
        Appended::Unknown
    }

    /// A cell's outputs behind a sequence, as the leader of the stream knows them: the outputs, the sequence of the
    /// last message that was looked at, and whether there is nothing behind it.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn behind(&self, cell: &str, after: u64) -> Result<(Vec<(u64, Output)>, u64, bool), LogError> {
        let (began, mut outputs, mut last) = (Instant::now(), Vec::new(), after);
        while began.elapsed() < FORWARD {
            let Some(message) = self.next_of(cell, last + 1).await? else { return Ok((outputs, last, true)) };
            last = message.sequence;
            let output = self.judged(cell, &message.payload).await?;
            outputs.extend(output.map(|output| (last, output)));
        }
        Ok((outputs, last, false))
    }

    async fn next_of(&self, cell: &str, from: u64) -> Result<Option<StreamMessage>, LogError> {
        let asked = self.output.raw_message_builder().sequence(from).next_by_subject(self.outputs_of(cell));
        found(asked.send().await)
    }

    /// The last output of a cell, as the leader of the stream knows it.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn last(&self, cell: &str) -> Result<Option<(u64, Output)>, LogError> {
        let last = self.output.get_last_raw_message_by_subject(&self.outputs_of(cell)).await;
        let Some(last) = found(last)? else { return Ok(None) };
        if let Some(output) = self.judged(cell, &last.payload).await? {
            return Ok(Some((last.sequence, output)));
        }
        // Before it, in steps that grow.
        let (mut until, mut back) = (last.sequence, BACK);
        while until > 1 {
            let from = until.saturating_sub(back).max(1);
            let (mut next, mut newest) = (from, None);
            while let Some(message) = self.next_of(cell, next).await?.filter(|found| found.sequence < until) {
                next = message.sequence + 1;
                let output = self.judged(cell, &message.payload).await?;
                newest = output.map(|output| (message.sequence, output)).or(newest);
            }
            if newest.is_some() {
                return Ok(newest);
            }
            (until, back) = (from, back.saturating_mul(8));
        }
        Ok(None)
    }

    pub(super) fn outputs_of(&self, cell: &str) -> String {
        format!("utm.out.{}.{cell}", self.region)
    }
}

fn found(message: Result<StreamMessage, RawMessageError>) -> Result<Option<StreamMessage>, LogError> {
    match message {
        Ok(message) => Ok(Some(message)),
        Err(error) if matches!(error.kind(), LastRawMessageErrorKind::NoMessageFound) => Ok(None),
        Err(error) if is_gone(&error.kind()) => Ok(None),
        Err(error) => Err(LogError::unanswered(error)),
    }
}
