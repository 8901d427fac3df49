//! A cluster: several machines produce one picture, and one node publishes each slot. Sans-IO.
//!
//! Gateways write sensor data into a log, as messages ([`GatewayInput`]). Each cell has an owner, which publishes, and a standby; both
//! run an engine. The owner decides after which input a slot is made, and states that input's sequence in its output. The standby
//! makes the slot after the same input, so both states are identical, byte for byte, whatever the machines' clocks show.
//!
//! The log provides four operations: append if the last message of a subject is the expected one, read from a sequence on, create
//! if absent, and look up. No clock decides which node publishes: the log refuses an append by a node that missed an output.

mod audience;
mod batches;
mod block_procedure;
mod cell;
mod cell_thread;
mod cells;
mod clocks;
mod differing_members;
mod engine;
mod gateway;
mod gateway_report;
mod lease_rules;
mod log;
mod malformed_message;
mod member_clock;
mod message;
mod node;
mod node_report;
mod overload;
mod picture_reader;
mod recording;
mod reference_clock;
pub mod region;
mod report;
mod shared_configuration;
mod verify;
mod watermarks;

pub use audience::Audience;
pub use batches::InputBatcher;
pub use cell::{AppendResult, Cell, CellEngine, CellLoss, InputRecord, InputRefusals, LogRequest, Tail};
pub use cells::{Cells, WHOLE};
pub use clocks::differences;
pub use differing_members::ConfigurationDifference;
pub use engine::{SiteEngine, pictures};
pub use gateway::Gateway;
pub use gateway_report::{ClockState, GatewayClock, GatewayCounts, GatewayReport};
pub use log::{
    Checkpoint, EntryState, HeldEntry, Holder, Log, LogError, Mark, Skipped, SubjectReader, check, reach,
};
pub use malformed_message::MalformedMessage;
pub use member_clock::{MemberClock, ReportTime, report_times};
pub use message::{CellOutput, GatewayInput, InputHeader, InputOrigin, LoggedMessage, ReceivedDatagram};
pub use node::{ClusterNode, run_number};
pub use node_report::{CellCounts, NodeReport, NodeRole};
pub use overload::{OverloadControl, SheddingLevel};
pub use picture_reader::PictureReader;
pub use recording::{NotRecorded, record, record_region};
pub use reference_clock::{BOUND, ClockReading, InputRefusal, NodeTime, ReferenceClock};
pub use report::CellReport;
pub use shared_configuration::SharedConfiguration;
pub use verify::{Verification, verify};

#[cfg(test)]
mod tests;
