//! Sockets: UDP in and out, connections to brokers and receivers.

pub(crate) mod dial;
pub mod listen;
pub(crate) mod mqtt;
pub(crate) mod secret;
pub mod send;
