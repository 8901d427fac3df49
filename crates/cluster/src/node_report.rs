//! Counters and report of a node.

use serde::{Deserialize, Serialize};

use crate::log::{Holder, Log, LogError, Skipped};
use fusion::time::Time;
use service::live::{NodePart, NodeState};

/// Role of a node in a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum NodeRole {
    /// No role.
    #[default]
    None,
    /// Standby.
    Standby,
    /// Owner.
    Owner,
}

impl NodeRole {
    /// Name of the role in the API and the status.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => NodePart::None,
            Self::Standby => NodePart::Standby,
            Self::Owner => NodePart::Owner,
        }
        .name()
    }
}

/// Counters of a node for a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CellCounts {
    /// Current role.
    pub part: NodeRole,
    /// Lease number, if the node owns the cell.
    pub epoch: u64,
    /// Number of times that the node became the owner.
    pub takeovers: u64,
    /// Number of times that the node was refused because another node owned the cell.
    pub fenced: u64,
    /// Number of times that its state differed from the owner's.
    pub diverged: u64,
    /// Number of slots by which the standby is behind the owner.
    pub behind: u64,
    /// Number of slots published.
    pub published: u64,
    /// Number of checkpoints written.
    pub checkpoints: u64,
    /// Level of load shedding.
    pub step: u8,
    /// Number of times that the level was raised.
    pub relieved: u64,
    /// Number of outputs skipped because no owner can have written them.
    pub foreign: u64,
    /// Number of inputs refused because of their gateway's clock, their configuration or their slot.
    pub refused: u64,
}

/// A node's report, written each second.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NodeReport {
    /// Time of the report by the node's own clock.
    pub sent: Time,
    /// The node.
    pub holder: Holder,
    /// Its counters by cell.
    pub cells: Vec<(String, CellCounts)>,
    /// Names of the cells that it may own; `*` for all.
    pub owns: Vec<String>,
    /// Whether the node is being drained and takes no cells.
    pub is_draining: bool,
    /// Messages of the log that it has skipped.
    pub skipped: Vec<Skipped>,
    /// Time by which its clock is ahead of reference time, in seconds; `None` if unknown.
    pub ahead_s: Option<f64>,
}

impl NodeReport {
    /// Reads the reports of all nodes.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn all(log: &Log) -> Result<Vec<Self>, LogError> {
        Ok(Self::all_by_name(log).await?.into_iter().filter_map(|(_, report)| report).collect())
    }

    /// Reads the reports of all nodes by name; `None` for an unreadable report.
    pub(super) async fn all_by_name(log: &Log) -> Result<Vec<(String, Option<Self>)>, LogError> {
        let read = |(node, _, octets): (String, Time, Vec<u8>)| {
            let report =
                postcard::from_bytes(&octets).ok().filter(|report: &Self| report.holder.node == node);
            if report.is_none() {
                log.skips.unreadable("node", &octets);
            }
            (node, report)
        };
        Ok(log.entries("node.").await?.into_iter().map(read).collect())
    }

    /// Counters for a cell.
    pub fn counts(&self, cell: &str) -> CellCounts {
        self.cells.iter().find(|(of, _)| of == cell).map(|(_, counts)| *counts).unwrap_or_default()
    }

    /// Cells in which the node has this role.
    pub fn cells_as(&self, part: NodeRole) -> impl Iterator<Item = &str> {
        self.cells.iter().filter(move |(_, counts)| counts.part == part).map(|(cell, _)| cell.as_str())
    }

    /// Name of the node's highest role in any cell.
    pub fn part(&self) -> &'static str {
        let most = self.cells.iter().map(|(_, counts)| counts.part).max();
        if self.is_draining { NodePart::Drained.name() } else { most.unwrap_or_default().name() }
    }

    /// Sum of the counters over all cells, without role, lease and level.
    pub fn sum(&self) -> CellCounts {
        self.cells.iter().fold(CellCounts::default(), |sum, (_, counts)| CellCounts {
            takeovers: sum.takeovers + counts.takeovers,
            fenced: sum.fenced + counts.fenced,
            diverged: sum.diverged + counts.diverged,
            published: sum.published + counts.published,
            checkpoints: sum.checkpoints + counts.checkpoints,
            relieved: sum.relieved + counts.relieved,
            refused: sum.refused + counts.refused,
            foreign: sum.foreign + counts.foreign,
            ..sum
        })
    }

    /// The node's state as shown by the API and the status.
    pub fn state(&self) -> NodeState {
        let CellCounts { takeovers, fenced, diverged, published, checkpoints, .. } = self.sum();
        let cells = |part| self.cells_as(part).map(str::to_owned).collect();
        NodeState {
            node: self.holder.node.clone(),
            machine: self.holder.machine.clone(),
            part: self.part(),
            owns: cells(NodeRole::Owner),
            stands_by: cells(NodeRole::Standby),
            takeovers,
            fenced,
            diverged,
            published,
            checkpoints,
            clock_ahead_s: self.ahead_s,
        }
    }
}
