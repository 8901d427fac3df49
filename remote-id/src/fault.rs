//! Errors in octets of Remote ID.

use thiserror::Error;

/// Reason why octets hold no message, or no further one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Fault {
    /// The octets are shorter than a message.
    #[error("a message has 25 octets, here are {there}")]
    Short {
        /// Number of octets present.
        there: usize,
    },
    /// The pack has messages of a length other than 25.
    #[error("the pack says that its messages have {length} octets; they have 25")]
    PackLength {
        /// Length of its messages, in octets, as stated by the pack.
        length: u8,
    },
    /// The pack has no messages, or more than ten.
    #[error("the pack says that it has {count} messages; a pack has 1 to 10")]
    PackCount {
        /// Number of messages stated by the pack.
        count: u8,
    },
    /// The pack ends before its last message.
    #[error("the pack says that it has {count} messages, and ends in message {ends_in}")]
    PackCut {
        /// Number of messages stated by the pack.
        count: u8,
        /// The message that is cut, counted from 1.
        ends_in: u8,
    },
    /// A pack within a pack.
    #[error("a pack stands inside a pack")]
    NestedPack,
    /// A protocol version that does not exist.
    #[error("version {version} of the protocol does not exist")]
    Version {
        /// Low four bits of the message's first octet.
        version: u8,
    },
    /// A message type that does not exist.
    #[error("there are no messages of type {kind}")]
    Kind {
        /// High four bits of the message's first octet.
        kind: u8,
    },
}

/// Reason why a received frame yields no advertisement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum NotHeard {
    /// The frame carries no Remote ID.
    #[error("the frame carries no Remote ID")]
    Other,
    /// The checksum of the radio frame is wrong.
    #[error("the radio's checksum failed")]
    Damaged,
    /// The frame is shorter than its own length fields state.
    #[error("the frame is cut")]
    Cut,
}
