//! Errors in messages of the log.

/// Reason why octets are not a valid message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MalformedMessage {
    /// The first octets are not those of a message of this version.
    #[error("not a message of this version")]
    Beginning,
    /// The message ends too early.
    #[error("the message is not whole")]
    Short,
}
