//! What a node counts, and says of itself.

use serde::{Deserialize, Serialize};

use crate::cluster::log::{Holder, Log, LogError, Skipped};
use crate::live::{NodePart, NodeState};
use fusion::time::Time;

/// What a node is for a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Part {
    /// Nothing.
    #[default]
    None,
    /// It stands by.
    Standby,
    /// It owns the cell.
    Owner,
}

impl Part {
    /// As it is shown.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => NodePart::None,
            Self::Standby => NodePart::Standby,
            Self::Owner => NodePart::Owner,
        }
        .name()
    }
}

/// What a node counts of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CellCounts {
    /// What it is for the cell now.
    pub part: Part,
    /// The number of its lease, where it owns the cell.
    pub epoch: u64,
    /// How often it became the owner.
    pub takeovers: u64,
    /// How often it was refused because somebody else owned the cell.
    pub fenced: u64,
    /// How often its state was not the owner's.
    pub diverged: u64,
    /// Slots that it is behind the owner, where it stands by.
    pub behind: u64,
    /// Slots that it published.
    pub published: u64,
    /// Checkpoints that it wrote.
    pub checkpoints: u64,
    /// What is left out because it cannot keep up: the step, and how often a further one was taken.
    pub step: u8,
    /// How often a further step was taken.
    pub relieved: u64,
    /// Outputs of the cell that were left out because no owner can have made them.
    pub foreign: u64,
    /// Inputs that were refused: the clock of their gateway is wrong, or its configuration another one, or their slot is not over.
    pub refused: u64,
}

/// What a node says of itself, each second.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NodeReport {
    /// When it said this, by its own clock.
    pub sent: Time,
    /// Who.
    pub holder: Holder,
    /// What it counts, by cell.
    pub cells: Vec<(String, CellCounts)>,
    /// Cells that it may have, by name; `*` for all.
    pub owns: Vec<String>,
    /// Whether it takes no cell any more.
    pub is_draining: bool,
    /// Messages of the log that it has skipped.
    pub skipped: Vec<Skipped>,
    /// How far its clock is ahead of reference time, seconds; `None`: not known.
    pub ahead_s: Option<f64>,
}

impl NodeReport {
    /// What all nodes say.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn all(log: &Log) -> Result<Vec<Self>, LogError> {
        Ok(Self::said(log).await?.into_iter().filter_map(|(_, report)| report).collect())
    }

    /// The same by name, also of those that say something else.
    pub(super) async fn said(log: &Log) -> Result<Vec<(String, Option<Self>)>, LogError> {
        let read = |(node, _, said): (String, Time, Vec<u8>)| {
            let report = postcard::from_bytes(&said).ok().filter(|report: &Self| report.holder.node == node);
            if report.is_none() {
                log.skips.unreadable("node", &said);
            }
            (node, report)
        };
        Ok(log.all_said("node.").await?.into_iter().map(read).collect())
    }

    /// What it counts of a cell.
    pub fn counts(&self, cell: &str) -> CellCounts {
        self.cells.iter().find(|(of, _)| of == cell).map(|(_, counts)| *counts).unwrap_or_default()
    }

    /// The cells for which it is that.
    pub fn cells_as(&self, part: Part) -> impl Iterator<Item = &str> {
        self.cells.iter().filter(move |(_, counts)| counts.part == part).map(|(cell, _)| cell.as_str())
    }

    /// What it is: of several cells the most that it is for one.
    pub fn part(&self) -> &'static str {
        let most = self.cells.iter().map(|(_, counts)| counts.part).max();
        if self.is_draining { NodePart::Drained.name() } else { most.unwrap_or_default().name() }
    }

    /// What it counts of all cells together; its part and what belongs to that are of none.
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

    /// As it is shown.
    pub fn state(&self) -> NodeState {
        let CellCounts { takeovers, fenced, diverged, published, checkpoints, .. } = self.sum();
        let cells = |part| self.cells_as(part).map(str::to_owned).collect();
        NodeState {
            node: self.holder.node.clone(),
            machine: self.holder.machine.clone(),
            part: self.part(),
            owns: cells(Part::Owner),
            stands_by: cells(Part::Standby),
            takeovers,
            fenced,
            diverged,
            published,
            checkpoints,
            clock_ahead_s: self.ahead_s,
        }
    }
}
