//! UDP in and out, and connections to receivers and brokers.

pub(crate) mod dial;
pub(crate) mod health;
pub mod listen;
pub(crate) mod mqtt;
pub(crate) mod peers;
pub(crate) mod post;
pub(crate) mod secret;
pub mod send;
