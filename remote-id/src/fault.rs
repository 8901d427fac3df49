//! What is wrong with octets that should be Remote ID.

use thiserror::Error;

/// Why octets hold no message, or no further one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Fault {
    /// There is less than one message.
    #[error("a message has 25 octets, here are {there}")]
    Short {
        /// Octets that are there.
        there: usize,
    },
    /// A pack of messages of another length than 25.
    #[error("the pack says that its messages have {length} octets; they have 25")]
    PackLength {
        /// Octets of a message, as the pack says.
        length: u8,
    },
    /// A pack of none, or of more than ten.
    #[error("the pack says that it has {count} messages; a pack has 1 to 10")]
    PackCount {
        /// As the pack says.
        count: u8,
    },
    /// The pack ends before its last message.
    #[error("the pack says that it has {count} messages, and ends in message {ends_in}")]
    PackCut {
        /// As the pack says.
        count: u8,
        /// The message that is cut, from 1.
        ends_in: u8,
    },
    /// A pack inside a pack.
    #[error("a pack stands inside a pack")]
    NestedPack,
    /// A protocol version that nobody has published: noise.
    #[error("version {version} of the protocol does not exist")]
    Version {
        /// Low four bits of the message's first octet.
        version: u8,
    },
    /// A kind of message that nobody has published.
    #[error("there are no messages of type {kind}")]
    Kind {
        /// High four bits of the message's first octet.
        kind: u8,
    },
}

/// Why a frame off the air gives no advertisement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum NotHeard {
    /// It carries no Remote ID.
    #[error("the frame carries no Remote ID")]
    Other,
    /// The radio's own checksum failed.
    #[error("the radio's checksum failed")]
    Damaged,
    /// It ends before its own lengths say.
    #[error("the frame is cut")]
    Cut,
}
