//! UDP input and output, and connections to receivers and brokers.

pub mod dial;
pub mod health;
pub mod listen;
#[cfg_attr(not(feature = "mqtt"), path = "net/mqtt/absent.rs")]
pub mod mqtt;
pub mod peers;
pub mod post;
pub mod secret;
pub mod send;
