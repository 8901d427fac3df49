//! The sender of a datagram, and the outcome of its records.

use std::net::SocketAddr;

use super::senders::{Earlier, Judged, Senders, Subject};
use super::{Event, Journal};
use crate::normalise::{Refusal, Refused};
use fusion::SensorIndex;
use fusion::report::Host;
use fusion::time::Time;

/// The sender of a datagram, and the outcome of its records.
#[derive(Debug, Default)]
pub(super) struct Sender {
    /// Address; a datagram without one is not checked.
    pub(super) address: Option<SocketAddr>,
    /// Senders from which the same datagram was refused before.
    pub(super) earlier: Vec<Earlier>,
    /// Whether a record was accepted.
    pub(super) was_taken: bool,
    /// Whether a record was refused because of its sender.
    pub(super) was_refused: bool,
}

impl Sender {
    /// The sender with this address, if known.
    pub(super) fn of(address: Option<SocketAddr>) -> Self {
        Self { address, ..Self::default() }
    }

    /// The host of the sender; all its ports are one.
    pub(super) fn host(&self) -> Host {
        self.address.map(|address| Host::from(address.ip())).unwrap_or_default()
    }

    /// Checks whether the sender may speak for this sensor.
    pub(super) fn admit(
        &mut self,
        (sensor, category): (SensorIndex, u8),
        senders: &mut Senders,
        now: Time,
        journal: &mut Journal,
    ) -> Result<(), Refused> {
        let Some(from) = self.address else { return Ok(()) };
        senders.admit((sensor, category), from, now).map_err(|contest| {
            self.was_refused = true;
            contest.into_iter().for_each(|contest| journal.note(Event::Contested(contest)));
            (Some(sensor), Refusal::ForeignSource)
        })
    }

    /// Checks whether the sender speaks for the subject of a record.
    pub(super) fn judge(
        &mut self,
        subject: Subject,
        senders: &mut Senders,
        now: Time,
        journal: &mut Journal,
    ) -> Result<(), Refused> {
        let judged = self.address.map(|from| senders.judge(subject, from, &self.earlier, now));
        match judged.unwrap_or(Judged::Counts(None)) {
            Judged::Counts(takeover) => {
                self.was_taken = true;
                takeover.into_iter().for_each(|takeover| journal.note(Event::TookOver(takeover)));
                Ok(())
            }
            Judged::Refused => {
                self.was_refused = true;
                Err((Some(subject.sensor), Refusal::OtherSender))
            }
        }
    }

    /// Notes that the sender still speaks for a subject, whatever the outcome of the record.
    pub(super) fn keep_active(&self, subject: Subject, senders: &mut Senders, now: Time) {
        if let Some(from) = self.address {
            senders.keep_active(subject, from, now);
        }
    }
}
