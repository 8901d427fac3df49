//! A cluster: several machines produce one picture, and one node publishes each slot. Sans-IO.
//!
//! Gateways write sensor data into a log, as messages ([`GatewayInput`]). Each cell has an owner, which publishes, and a standby; both
//! run an engine. The owner decides after which input a slot is made, and states that input's sequence in its output. The standby
//! makes the slot after the same input, so both states are identical, byte for byte, whatever the machines' clocks show.
//!
//! The log provides four operations: append if the last message of a subject is the expected one, read from a sequence on, create
//! if absent, and look up. No clock decides which node publishes: the log refuses an append by a node that missed an output.

mod batches;
mod cell;
mod cell_thread;
mod cells;
mod clocks;
mod engine;
mod gateway;
mod log;
mod member_clock;
mod message;
mod node;
mod overload;
mod picture_reader;
mod recording;
mod reference_clock;
pub mod region;
mod report;
mod shared_configuration;
mod verify;
mod watermarks;

pub use batches::InputBatcher;
pub use cell::{AppendResult, Cell, CellEngine, CellLoss, InputRecord, InputRefusals, LogRequest, Tail};
pub use cells::{Audience, Cells, WHOLE};
pub use clocks::{ClockState, GatewayClock, differences};
pub use engine::{SiteEngine, pictures};
pub use gateway::{Gateway, GatewayCounts, GatewayReport};
pub use log::{
    Checkpoint, EntryState, HeldEntry, Holder, Log, LogError, Mark, Skipped, SubjectReader, check, reach,
};
pub use member_clock::{MemberClock, ReportTime, report_times};
pub use message::{
    CellOutput, GatewayInput, InputHeader, InputOrigin, LoggedMessage, MalformedMessage, ReceivedDatagram,
};
pub use node::{CellCounts, ClusterNode, NodeReport, NodeRole, run_number};
pub use overload::{OverloadControl, SheddingLevel};
pub use picture_reader::PictureReader;
pub use recording::{NotRecorded, record, record_region};
pub use reference_clock::{BOUND, ClockReading, InputRefusal, NodeTime, ReferenceClock};
pub use report::CellReport;
pub use shared_configuration::{ConfigurationDifference, SharedConfiguration};
pub use verify::{Verification, verify};

#[cfg(test)]
mod tests;
