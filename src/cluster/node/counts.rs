//! What a node counts, and says of itself.

use serde::{Deserialize, Serialize};

use crate::cluster::log::Holder;
use crate::live::NodeState;

/// What a node is for a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
            Self::None => "none",
            Self::Standby => "standby",
            Self::Owner => "owner",
        }
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
}

/// What a node says of itself, each second.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NodeReport {
    /// Who.
    pub holder: Holder,
    /// What it counts, by cell.
    pub cells: Vec<(String, CellCounts)>,
    /// Whether it takes no cell any more.
    pub is_draining: bool,
}

impl NodeReport {
    /// As it is shown.
    pub(in crate::cluster) fn state(&self) -> NodeState {
        let Self { holder, cells, is_draining } = self;
        let counts = cells.first().map(|(_, counts)| *counts).unwrap_or_default();
        NodeState {
            node: holder.node.clone(),
            machine: holder.machine.clone(),
            part: if *is_draining { "drained" } else { counts.part.name() },
            takeovers: counts.takeovers,
            fenced: counts.fenced,
            diverged: counts.diverged,
            published: counts.published,
            checkpoints: counts.checkpoints,
        }
    }
}
