//! The items of a recording.

use std::net::SocketAddrV4;
use std::sync::Arc;

use bytes::Bytes;
use fusion::numbering::Given;
use fusion::time::Time;

/// An item for the recorder, which may lag or lose it, but never makes the engine wait.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Recorded {
    /// A datagram as the engine handled it.
    Input {
        /// When it was handled.
        received: Time,
        /// The line on which it came, an index of [`lines`](crate::net::listen::lines).
        line: usize,
        /// Who sent it.
        from: SocketAddrV4,
        /// The datagram.
        payload: Vec<u8>,
    },
    /// A transponder was given a number, or has its first point after a break of [`NOTED`](fusion::numbering::NOTED).
    Numbered(Given),
    /// The text of the registration's file, at the start and whenever it has changed.
    Registered(Arc<str>),
    /// The line of an operator's decision.
    Decided(Arc<str>),
    /// The lines of the decisions in force, which have changed: a further file begins with these.
    Correlations(Arc<str>),
    /// The state of the engine before what follows ([`EngineState`](crate::state::EngineState)): a file that begins here is
    /// replayed from it.
    Checkpoint(Bytes),
    /// Slots up to this centre were an earlier service's to publish: a replay has them, the output of this run has not.
    Published(Time),
    /// A datagram that was sent.
    Output {
        /// When it was due.
        due: Time,
        /// The datagram.
        payload: Vec<u8>,
    },
    /// Something is missing, up to this time: it did not fit the queue. What follows is recorded into files of its own.
    Gap(Time),
}
