//! Report of a gateway: counters, lines and clock.

use serde::{Deserialize, Serialize};

use super::log::{Log, LogError};
use fusion::time::Time;
use service::live::{ClockSource, ClockStanding, GatewayState, LineStatus};

/// State of a machine's clock, as stated by the service that disciplines it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ClockState {
    /// Whether the clock is synchronised; `None` if unknown.
    pub is_synchronised: Option<bool>,
    /// Upper bound of the clock's error, in seconds; `None` if unknown.
    pub bound_s: Option<f64>,
    /// Program that stated this; `None` if none answered.
    pub by: Option<ClockSource>,
}

/// Clock state in a gateway's report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GatewayClock {
    /// State of the clock.
    pub state: ClockState,
    /// Rating of that state.
    pub standing: ClockStanding,
    /// Whether the clock has been unsynchronised for at least a minute.
    pub is_unfit: bool,
    /// Whether the gateway publishes nothing because its clock is unfit and other gateways carry all of its lines.
    pub is_silent: bool,
}

/// Counters of a gateway.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GatewayCounts {
    /// Messages written to the log.
    pub written: u64,
    /// Messages waiting for the log.
    pub waiting: u64,
    /// Datagrams dropped because the log was unavailable for too long.
    pub dropped: u64,
    /// Datagrams not published because the clock is unfit and other gateways carry them.
    pub withheld: u64,
    /// Number of times that the gateway has resumed publication.
    pub resumed: u64,
}

/// A gateway's report, written each second.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GatewayReport {
    /// Name of the gateway.
    pub node: String,
    /// Its counters.
    pub counts: GatewayCounts,
    /// Its lines, each with the indices of its sensors in the configuration.
    pub lines: Vec<(Vec<usize>, LineStatus)>,
    /// Number of the report. A gateway whose number does not change is gone.
    pub report_number: u64,
    /// State of its clock.
    pub clock: GatewayClock,
    /// Some of the latest datagrams: hash and time of reception, in nanoseconds since 1970.
    pub recent_datagrams: Vec<(u64, i64)>,
    /// Hash of its shared configuration; 0 if not stated.
    pub config: u64,
    /// Time of the report by the gateway's own clock.
    pub sent: Time,
    /// Time by which its clock is ahead of reference time, in seconds; `None` if unknown.
    pub ahead_s: Option<f64>,
}

impl GatewayReport {
    /// Reads the reports of all gateways.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn all(log: &Log) -> Result<Vec<Self>, LogError> {
        Ok(Self::all_stamped(log).await?.into_iter().map(|(_, report)| report).collect())
    }

    /// Reads the reports of all gateways, each with the log's timestamp.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn all_stamped(log: &Log) -> Result<Vec<(Time, Self)>, LogError> {
        let read = |(name, stamp, said): (String, Time, Vec<u8>)| {
            let report = postcard::from_bytes(&said).ok().filter(|report: &Self| report.node == name);
            if report.is_none() {
                log.skips.unreadable("gateway", &said);
            }
            report.map(|report| (stamp, report))
        };
        Ok(log.entries("gateway.").await?.into_iter().filter_map(read).collect())
    }

    /// The gateway's state as shown by the API and the status.
    pub fn state(&self) -> GatewayState {
        let Self { node, counts, lines, clock, ahead_s, .. } = self;
        let GatewayCounts { written, waiting, dropped, withheld, .. } = *counts;
        GatewayState {
            node: node.clone(),
            lines: lines.len() as u64,
            written,
            waiting,
            dropped,
            clock: clock.standing,
            clock_bound_s: clock.state.bound_s,
            clock_by: clock.state.by,
            unfit: clock.is_unfit,
            silent: clock.is_silent,
            withheld,
            clock_ahead_s: *ahead_s,
        }
    }
}
