//! Outputs of a cell: appended conditionally, and validated on reading, since any process that reaches the servers may write
//! there.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use async_nats::header::{HeaderMap, NATS_EXPECTED_LAST_SUBJECT_SEQUENCE, NATS_MESSAGE_ID};
use async_nats::jetstream::context::PublishErrorKind;
use async_nats::jetstream::message::StreamMessage;
use async_nats::jetstream::stream::{LastRawMessageErrorKind, RawMessageError, Stream};
use tokio::time::Instant;

use super::{Log, LogError, is_gone};
use crate::cell::AppendResult;
use crate::engine::pictures;
use crate::message::CellOutput;
use site::config::MAX_WINDOW_SLOTS;

/// Pause before the log is asked again.
const RETRY_PAUSE: Duration = Duration::from_millis(50);
/// Maximum number of message names tried for a slot if other messages have taken them.
const MAX_MESSAGE_NAMES: usize = 16;
/// Maximum time to read forward in one call of [`Log::behind`].
const MAX_READ_TIME: Duration = Duration::from_millis(300);
/// Number of sequences searched first for the last output of a cell.
const FIRST_SEARCH_SEQUENCES: u64 = 512;
/// Known minimum of the streams' last sequences. An output that names a later lease or input is invalid.
#[derive(Clone, Debug, Default)]
pub(super) struct Bounds(Arc<KnownBounds>);

#[derive(Debug, Default)]
struct KnownBounds {
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
    /// Notes that an input with this sequence was read.
    pub(crate) fn note_input(&self, sequence: u64) {
        self.bounds.0.input.fetch_max(sequence, Ordering::Relaxed);
    }

    /// Validates a message among the outputs of a cell. `None` if no owner can have written it; it is counted as skipped.
    ///
    /// # Errors
    /// The log does not answer, so the message cannot be validated.
    pub async fn validated(&self, cell: &str, octets: &[u8]) -> Result<Option<CellOutput>, LogError> {
        let place = format!("out.{cell}");
        let Ok(output) = CellOutput::parse(octets) else {
            self.skips.unreadable(&place, octets);
            return Ok(None);
        };
        let reason = if !(0..self.last_slot()).contains(&output.slot.0) {
            "a slot that is no time"
        } else if output.epoch == 0 || !reaches(&self.bounds.0.lease, &self.held_stream, output.epoch).await?
        {
            "of a lease that was never given"
        } else if !reaches(&self.bounds.0.input, &self.input, output.after_input).await? {
            "behind an input that is not there"
        } else if pictures(&output.picture).is_none_or(|(picture, _)| picture.slot != output.slot) {
            "without a picture of its slot"
        } else {
            return Ok(Some(output));
        };
        self.skips.note(&place, reason);
        Ok(None)
    }

    /// First slot number beyond the range of [`fusion::time::Time`].
    fn last_slot(&self) -> i64 {
        let slot_ns = i64::try_from(self.grid.slot().as_nanos()).unwrap_or(i64::MAX);
        i64::MAX / slot_ns - i64::from(MAX_WINDOW_SLOTS)
    }

    /// Validates a message like [`Log::validated`], and waits until the log answers.
    pub async fn validated_when_available(&self, cell: &str, octets: &[u8]) -> Option<CellOutput> {
        loop {
            match self.validated(cell, octets).await {
                Ok(output) => return output,
                Err(_) => tokio::time::sleep(RETRY_PAUSE).await,
            }
        }
    }

    /// Appends an output of a cell if the last message there has the expected sequence. Servers with several copies check this
    /// before they agree on a message, so two concurrent messages could both pass; therefore each slot also has a message name,
    /// which is stored once. If a message that is not this output has taken the name, the next name contains that message's
    /// sequence.
    pub async fn append(&self, cell: &str, expected: u64, output: &CellOutput) -> AppendResult {
        let (subject, body) = (self.outputs_of(cell), bytes::Bytes::from(output.body()));
        let mut name = format!("{cell}:{}", output.slot.0);
        for _ in 0..MAX_MESSAGE_NAMES {
            let mut headers = HeaderMap::new();
            headers.insert(NATS_EXPECTED_LAST_SUBJECT_SEQUENCE, expected.to_string());
            headers.insert(NATS_MESSAGE_ID, name);
            let sent = self.context.publish_with_headers(subject.clone(), headers, body.clone()).await;
            let Ok(acknowledged) = sent else { return AppendResult::Unknown };
            let there = match acknowledged.await {
                Ok(acknowledged) if acknowledged.duplicate => acknowledged.sequence,
                Ok(acknowledged) => return AppendResult::Stored(acknowledged.sequence),
                Err(error) if error.kind() == PublishErrorKind::WrongLastSequence => {
                    return AppendResult::Refused;
                }
                Err(_) => return AppendResult::Unknown,
            };
            let result = match self.output.get_raw_message(there).await {
                Ok(message) => {
                    let is_output = *message.subject == *subject;
                    AppendResult::of_taken_name(there, expected, is_output, message.payload == body)
                }
                Err(error) if is_gone(&error.kind()) => None,
                Err(_) => Some(AppendResult::Unknown),
            };
            if let Some(result) = result {
                return result;
            }
            self.skips.note(&format!("out.{cell}"), "under the name of a slot that it does not hold");
            name = format!("{cell}:{}:{there}", output.slot.0);
        }
        AppendResult::Unknown
    }

    /// Reads a cell's outputs after a sequence from the stream's leader. Returns the outputs, the sequence of the last message
    /// read, and whether no message follows it.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn outputs_after(
        &self,
        cell: &str,
        after: u64,
    ) -> Result<(Vec<(u64, CellOutput)>, u64, bool), LogError> {
        let (began, mut outputs, mut last) = (Instant::now(), Vec::new(), after);
        while began.elapsed() < MAX_READ_TIME {
            let Some(message) = self.next_with_subject(cell, last + 1).await? else {
                return Ok((outputs, last, true));
            };
            last = message.sequence;
            let output = self.validated(cell, &message.payload).await?;
            outputs.extend(output.map(|output| (last, output)));
        }
        Ok((outputs, last, false))
    }

    async fn next_with_subject(&self, cell: &str, from: u64) -> Result<Option<StreamMessage>, LogError> {
        let asked = self.output.raw_message_builder().sequence(from).next_by_subject(self.outputs_of(cell));
        found(asked.send().await)
    }

    /// Reads the last output of a cell from the stream's leader.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn last(&self, cell: &str) -> Result<Option<(u64, CellOutput)>, LogError> {
        let last = self.output.get_last_raw_message_by_subject(&self.outputs_of(cell)).await;
        let Some(last) = found(last)? else { return Ok(None) };
        if let Some(output) = self.validated(cell, &last.payload).await? {
            return Ok(Some((last.sequence, output)));
        }
        // Search backwards in growing steps.
        let (mut until, mut back) = (last.sequence, FIRST_SEARCH_SEQUENCES);
        while until > 1 {
            let from = until.saturating_sub(back).max(1);
            let (mut next, mut newest) = (from, None);
            while let Some(message) =
                self.next_with_subject(cell, next).await?.filter(|found| found.sequence < until)
            {
                next = message.sequence + 1;
                let output = self.validated(cell, &message.payload).await?;
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
