//! Who makes the picture where several machines do: what they say of themselves.

use schemars::JsonSchema;
use serde::Serialize;

/// The members of a cluster, as of a second ago at most.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Members {
    /// The region.
    pub region: String,
    /// Its cells.
    pub cells: Vec<CellState>,
    /// Its nodes.
    pub nodes: Vec<NodeState>,
    /// Its gateways.
    pub gateways: Vec<GatewayState>,
    /// Slots that were shown here.
    pub shown: u64,
    /// Slots that came again after they, or later ones, had been shown.
    pub doubled: u64,
    /// Slots that nobody published.
    pub missing: u64,
    /// Aircraft of a slot that were left out because another cell published them, too.
    pub twice: u64,
    /// Slots of a cell that came when the region's picture of that slot had been shown without them.
    pub too_late: u64,
}

/// A cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct CellState {
    /// Its name.
    pub cell: String,
    /// The node that owns it; absent: nobody does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub owner: Option<String>,
    /// The node that takes over when the owner falls silent; absent: nobody would.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standby: Option<String>,
    /// The number of the owner's lease; greater than of whoever owned the cell before.
    pub lease: u64,
    /// Slots that the standby is behind.
    pub behind: u64,
    /// What is left out because its owner cannot keep up: a step of docs/SCALING.md, 0 for nothing.
    pub step: u8,
    /// The same in words.
    pub left_out: &'static str,
    /// Whether the picture is without it: nobody has published it for longer than a take-over takes.
    pub is_missing: bool,
    /// Where it is, longitude and latitude of its corners in degrees; empty: it is the whole site.
    pub corners: Vec<[f64; 2]>,
}

/// A node.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct NodeState {
    /// Its name.
    pub node: String,
    /// The machine that it runs on.
    pub machine: String,
    /// What it is: for one cell at least, where there are several.
    #[schemars(extend("enum" = ["owner", "standby", "none", "drained"]))]
    pub part: &'static str,
    /// Cells that it owns.
    pub owns: Vec<String>,
    /// Cells beside whose owner it stands.
    pub stands_by: Vec<String>,
    /// How often it became the owner.
    pub takeovers: u64,
    /// How often it was refused because somebody else owned the cell.
    pub fenced: u64,
    /// How often its state was not the owner's.
    pub diverged: u64,
    /// Slots that it published.
    pub published: u64,
    /// Checkpoints that it wrote.
    pub checkpoints: u64,
}

/// A gateway.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct GatewayState {
    /// Its name.
    pub node: String,
    /// Its lines.
    pub lines: u64,
    /// Messages that it wrote into the log.
    pub written: u64,
    /// Messages that wait for the log.
    pub waiting: u64,
    /// Datagrams that were dropped because the log was away for too long.
    pub dropped: u64,
}
