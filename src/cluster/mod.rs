//! Several machines, one picture: who handles what, and who publishes it. Sans-IO.
//!
//! Gateways write what the sensors send into a log, in messages ([`Input`]). For each cell one node owns the output and another
//! stands by, both with an engine of their own. The owner decides where in the log a slot is made, and says so in its output;
//! the one that stands by makes it at the same place, so that both know the same, to the byte, whatever their clocks.
//!
//! Of the log four operations are used: append where the last message of a subject is the expected one, read from a sequence on,
//! create what is not there yet, watch. No clock takes part in who publishes: a node that was away is refused by the sequence.

mod cell;
mod engine;
mod message;
pub mod region;
mod watermarks;

pub use cell::{Appended, Cell, Fusing, Lost, Wish};
pub use engine::{SiteEngine, pictures};
pub use message::{Heard, Input, Malformed, Output};

#[cfg(test)]
mod tests;
