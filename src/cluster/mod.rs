//! Several machines, one picture: who handles what, and who publishes it. Sans-IO.
//!
//! Gateways write what the sensors send into a log, in messages ([`Input`]). For each cell one node owns the output and another
//! stands by, both with an engine of their own. The owner decides where in the log a slot is made, and says so in its output;
//! the one that stands by makes it at the same place, so that both know the same, to the byte, whatever their clocks.
//!
//! Of the log four operations are used: append where the last message of a subject is the expected one, read from a sequence on,
//! create what is not there yet, watch. No clock takes part in who publishes: a node that was away is refused by the sequence.

mod batches;
mod cell;
mod cells;
#[cfg(feature = "cluster")]
mod clocks;
mod engine;
#[cfg(feature = "cluster")]
mod gateway;
#[cfg(feature = "cluster")]
mod log;
#[cfg(feature = "cluster")]
mod member_clock;
mod message;
#[cfg(feature = "cluster")]
mod node;
#[cfg(feature = "cluster")]
mod recording;
mod reference_clock;
pub mod region;
mod relief;
mod report;
#[cfg(feature = "cluster")]
mod seat;
#[cfg(feature = "cluster")]
mod shared;
#[cfg(feature = "cluster")]
mod verify;
mod watermarks;
#[cfg(feature = "cluster")]
mod window;

pub use batches::Batches;
pub use cell::{Appended, Cell, Fusing, Lost, Read, Refusals, Tail, Wish};
pub use cells::{Audience, Cells, WHOLE};
#[cfg(feature = "cluster")]
pub use clocks::{ClockState, GatewayClock, differences};
pub use engine::{SiteEngine, pictures};
#[cfg(feature = "cluster")]
pub use gateway::{Gateway, GatewayCounts, GatewayReport};
#[cfg(feature = "cluster")]
pub use log::{Checkpoint, Held, Holder, Log, LogError, Mark, Place, Reading, Skipped, check, reach};
#[cfg(feature = "cluster")]
pub use member_clock::{MemberClock, Written, written};
pub use message::{Header, Heard, Input, Logged, Malformed, Origin, Output};
#[cfg(feature = "cluster")]
pub use node::{CellCounts, Node, NodeReport, Part, run_number};
#[cfg(feature = "cluster")]
pub use recording::{NotRecorded, record, record_region};
pub use reference_clock::{BOUND, Moment, NodeTime, ReferenceClock, Refusal};
pub use relief::{Relief, Step};
pub use report::CellReport;
#[cfg(feature = "cluster")]
pub use shared::{Different, SharedConfiguration};
#[cfg(feature = "cluster")]
pub use verify::{Verdict, verify};
#[cfg(feature = "cluster")]
pub use window::Window;

#[cfg(test)]
mod tests;
