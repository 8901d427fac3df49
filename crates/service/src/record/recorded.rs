//! Items of a recording.

use std::net::SocketAddrV4;
use std::sync::Arc;

use bytes::Bytes;
use fusion::numbering::Given;
use fusion::time::Time;

/// An item for the recorder, which may be slow or lose it, but never makes the engine wait.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordingItem {
    /// A datagram that the engine handled.
    Input {
        /// Time of handling.
        received: Time,
        /// Line on which it was received, an index of [`lines`](crate::net::listen::lines).
        line: usize,
        /// Sender.
        from: SocketAddrV4,
        /// Payload of the datagram.
        payload: Vec<u8>,
    },
    /// Number assigned to a transponder, or the first point of a transponder after a break of
    /// [`NOTED`](fusion::numbering::NOTED).
    Numbered(Given),
    /// Text of the registration's file, at the start and after each change.
    Registered(Arc<str>),
    /// Line of an operator's decision.
    Decided(Arc<str>),
    /// Lines of the decisions in force, after a change; the next file begins with them.
    Correlations(Arc<str>),
    /// State of the engine before the following items ([`EngineState`](crate::state::EngineState)). A file that begins here
    /// is replayed from it.
    Checkpoint(Bytes),
    /// Slots up to this centre were published by an earlier run: a replay has them, this run's output does not.
    Published(Time),
    /// A datagram that was sent.
    Output {
        /// Time at which it was due.
        due: Time,
        /// Payload of the datagram.
        payload: Vec<u8>,
    },
    /// Items up to this time were lost, because the queue was full. The following items are recorded to new files.
    Gap(Time),
}
