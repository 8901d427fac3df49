//! Members of a cluster: the state that cells, nodes and gateways report of themselves.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::alerts::{ServiceFault, Severity};

/// Maximum difference of a correct clock from reference time, in seconds.
const WRONG_S: f64 = 1.0;

/// Members of the cluster, at most a second old.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "Members")]
pub struct ClusterMembers {
    /// Name of the region.
    pub region: String,
    /// Cells of the region.
    pub cells: Vec<CellState>,
    /// Nodes of the region.
    pub nodes: Vec<NodeState>,
    /// Gateways of the region.
    pub gateways: Vec<GatewayState>,
    /// Clock differences between each two gateways that receive the same datagrams.
    pub clocks: Vec<ClockDifference>,
    /// Names of expected gateways without a report for 3 s.
    pub missing_gateways: Vec<String>,
    /// Members whose configuration differs from this process's, each with the differences.
    pub different: Vec<String>,
    /// Slots shown by this process.
    pub shown: u64,
    /// Slots received again after they, or later ones, had been shown.
    pub doubled: u64,
    /// Slots that no node published.
    pub missing: u64,
    /// Aircraft left out of a slot because another cell published them too.
    pub twice: u64,
    /// Slots of a cell received after the region's picture of that slot had been shown without them.
    pub too_late: u64,
}

/// A cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct CellState {
    /// Name of the cell.
    pub cell: String,
    /// Node that owns the cell; absent if no node does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub owner: Option<String>,
    /// Node that takes over when the owner falls silent; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standby: Option<String>,
    /// Number of the owner's lease; greater than that of any earlier owner.
    pub lease: u64,
    /// Number of slots by which the standby is behind.
    pub behind: u64,
    /// Level of load shedding of an overloaded owner, as in docs/SCALING.md; 0 if nothing is left out.
    pub step: u8,
    /// Text for the level of load shedding.
    pub left_out: &'static str,
    /// Whether the cell is missing from the picture: no node has published it for longer than a takeover takes.
    pub is_missing: bool,
    /// Whether the cell is missing from the picture because its owner has a different configuration.
    pub is_foreign: bool,
    /// Corners of the cell: longitude and latitude, in degrees; empty if the cell is the whole site.
    pub corners: Vec<[f64; 2]>,
}

/// Role of a node in its cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodePart {
    /// The node owns a cell.
    Owner,
    /// The node is the standby of a cell.
    Standby,
    /// The node has no cell.
    None,
    /// The node hands its cells over, and takes no others.
    Drained,
}

fusion::interface_names!(NodePart { Owner = "owner", Standby = "standby", None = "none", Drained = "drained" });

/// A node.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct NodeState {
    /// Name of the node.
    pub node: String,
    /// Machine that the node runs on.
    pub machine: String,
    /// Role of the node, in at least one of its cells.
    #[schemars(extend("enum" = NodePart::NAMES))]
    pub part: &'static str,
    /// Cells that the node owns.
    pub owns: Vec<String>,
    /// Cells for which the node is the standby.
    pub stands_by: Vec<String>,
    /// Number of times the node became the owner of a cell.
    pub takeovers: u64,
    /// Number of times its output was refused because another node owned the cell.
    pub fenced: u64,
    /// Number of times its state differed from the owner's.
    pub diverged: u64,
    /// Slots that the node published.
    pub published: u64,
    /// Checkpoints that the node wrote.
    pub checkpoints: u64,
    /// Offset of the node's clock from reference time (the median of the clocks of the log and the gateways), in seconds;
    /// positive if ahead; absent if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clock_ahead_s: Option<f64>,
}

/// A gateway.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct GatewayState {
    /// Name of the gateway.
    pub node: String,
    /// Number of its input lines.
    pub lines: u64,
    /// Messages that it wrote into the log.
    pub written: u64,
    /// Messages waiting for the log.
    pub waiting: u64,
    /// Datagrams dropped because the log was unavailable for too long.
    pub dropped: u64,
    /// Quality of its clock.
    pub clock: ClockStanding,
    /// Maximum error of its clock, in seconds; absent if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub clock_bound_s: Option<f64>,
    /// Source of the clock's quality; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clock_by: Option<ClockSource>,
    /// Whether its clock has been unsynchronised for a minute or longer.
    pub unfit: bool,
    /// Whether it publishes nothing because its clock is unsynchronised; other gateways receive the same data.
    pub silent: bool,
    /// Datagrams not published while it was silent.
    pub withheld: u64,
    /// Offset of the gateway's clock from reference time (the median of the clocks of the log and the gateways), in
    /// seconds; positive if ahead; absent if unknown. Beyond 1 s its messages are refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clock_ahead_s: Option<f64>,
}

/// Quality of a clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ClockStanding {
    /// Synchronised, with an error of at most 20 ms.
    Good,
    /// The error may exceed 20 ms.
    Warning,
    /// The error may exceed 100 ms.
    Degraded,
    /// Synchronised, with an unknown error.
    Unbounded,
    /// Not synchronised.
    Unsynchronised,
    /// No source reports on the clock.
    #[default]
    Unknown,
}

/// Source of a clock's quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ClockSource {
    /// chrony, by `chronyc`.
    Chrony,
    /// The kernel, by `adjtimex`.
    Kernel,
    /// systemd, by `timedatectl`.
    Systemd,
}

/// Difference between the clocks of two gateways, from the times at which both received the same datagrams.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct ClockDifference {
    /// Name of the first gateway.
    pub gateway: String,
    /// Name of the second gateway.
    pub other: String,
    /// Median of the first gateway's time stamps minus the second's, in seconds.
    pub difference_s: f64,
    /// Number of datagrams compared.
    #[schemars(range(min = 5))]
    pub datagrams: u64,
    /// Whether the clocks have been more than 20 ms apart, and not less than 15 ms since.
    pub apart: bool,
}

impl ClusterMembers {
    /// Faults of cells, and of the clocks of gateways and nodes; each becomes an alert.
    pub fn troubles(&self) -> Vec<ServiceFault> {
        let cells = self.cells.iter().filter_map(CellState::trouble);
        let gateways = self.gateways.iter().filter_map(GatewayState::trouble);
        let refused = self.gateways.iter().filter_map(GatewayState::refused);
        let nodes = self.nodes.iter().filter_map(NodeState::trouble);
        let missing = self.missing_gateways.iter().map(|gateway| ServiceFault {
            about: format!("{} gateway {gateway}", ServiceFault::CLUSTER).into(),
            severity: Severity::Warning,
            text: format!(
                "gateway {gateway} says nothing: what it alone hears is lost, and no other one may fail"
            ),
        });
        let different = self.different.iter().map(|different| ServiceFault {
            about: format!(
                "{} configuration {}",
                ServiceFault::CLUSTER,
                different.split(':').next().unwrap_or_default()
            )
            .into(),
            severity: Severity::Critical,
            text: format!("another configuration than this one's: {different}"),
        });
        let clocks = self.clocks.iter().filter_map(ClockDifference::trouble);
        let troubles = cells.chain(gateways).chain(refused).chain(nodes);
        troubles.chain(missing).chain(different).chain(clocks).collect()
    }
}

impl CellState {
    fn trouble(&self) -> Option<ServiceFault> {
        let Self { cell, is_missing, is_foreign, step, left_out, .. } = self;
        let (severity, text) = match (is_missing, step) {
            _ if *is_foreign => {
                let owner = self.owner.as_deref().unwrap_or("nobody");
                let text = format!(
                    "the picture is without cell {cell}: its owner {owner} has another configuration"
                );
                (Severity::Critical, text)
            }
            (true, _) => {
                let text = format!("the picture is without cell {cell}: nobody publishes what flies there");
                (Severity::Critical, text)
            }
            (false, 0) => return None,
            (false, _) => (Severity::Warning, format!("the owner of cell {cell} cannot keep up: {left_out}")),
        };
        Some(ServiceFault { about: format!("{} cell {cell}", ServiceFault::CLUSTER).into(), severity, text })
    }
}

/// Text for the error of a clock; `None` if it is within the bound, or unknown.
fn wrong(ahead_s: Option<f64>) -> Option<String> {
    let ahead_s = ahead_s.filter(|ahead_s| ahead_s.abs() > WRONG_S)?;
    Some(format!("{:.1} s {}", ahead_s.abs(), if ahead_s > 0.0 { "ahead" } else { "behind" }))
}

impl NodeState {
    fn trouble(&self) -> Option<ServiceFault> {
        let Self { node, clock_ahead_s, .. } = self;
        let wrong = wrong(*clock_ahead_s)?;
        Some(ServiceFault {
            about: format!("{} reference clock {node}", ServiceFault::CLUSTER).into(),
            severity: Severity::Warning,
            text: format!(
                "the clock of node {node} is {wrong}: it decides nothing, and other nodes go first"
            ),
        })
    }
}

impl GatewayState {
    fn refused(&self) -> Option<ServiceFault> {
        let Self { node, clock_ahead_s, .. } = self;
        let wrong = wrong(*clock_ahead_s)?;
        Some(ServiceFault {
            about: format!("{} reference clock {node}", ServiceFault::CLUSTER).into(),
            severity: Severity::Warning,
            text: format!("the clock of gateway {node} is {wrong}: what it sends is refused"),
        })
    }

    /// Text for the quality of the gateway's clock.
    pub fn clock_text(&self) -> String {
        let bound = match self.clock_bound_s {
            Some(bound_s) => format!("±{} ms", milliseconds(bound_s)),
            None => String::new(),
        };
        let text = match self.clock {
            ClockStanding::Good => bound,
            ClockStanding::Warning => format!("{bound}, warning"),
            ClockStanding::Degraded => format!("{bound}, degraded"),
            ClockStanding::Unbounded => "synchronised, how well is not known".to_owned(),
            ClockStanding::Unsynchronised => "not synchronised".to_owned(),
            ClockStanding::Unknown => "not known".to_owned(),
        };
        if self.silent { format!("{text}, silent") } else { text }
    }

    fn trouble(&self) -> Option<ServiceFault> {
        let Self { node, silent, .. } = self;
        let (severity, text) = match (self.unfit, self.clock, self.clock_bound_s) {
            (true, ..) if *silent => {
                let text = "is not synchronised: it publishes nothing, others carry what it hears";
                (Severity::Warning, text.to_owned())
            }
            (true, ..) => {
                let text = "is not synchronised, and no other gateway carries all that it hears: what it stamps may be wrong";
                (Severity::Critical, text.to_owned())
            }
            (false, ClockStanding::Degraded, Some(bound_s)) => {
                (Severity::Warning, format!("may be off by {} ms", milliseconds(bound_s)))
            }
            _ => return None,
        };
        let about = format!("{} clock {node}", ServiceFault::CLUSTER).into();
        Some(ServiceFault { about, severity, text: format!("the clock of gateway {node} {text}") })
    }
}

impl ClockDifference {
    fn trouble(&self) -> Option<ServiceFault> {
        let Self { gateway, other, difference_s, .. } = self;
        let (ahead, behind) = if *difference_s > 0.0 { (gateway, other) } else { (other, gateway) };
        self.apart.then(|| ServiceFault {
            about: format!("{} clocks {gateway} {other}", ServiceFault::CLUSTER).into(),
            severity: Severity::Warning,
            text: format!(
                "the clocks of gateways {gateway} and {other} differ by {} ms: {ahead} is ahead of {behind}, and which one is wrong is not known",
                milliseconds(difference_s.abs())
            ),
        })
    }
}

/// Formats seconds as milliseconds, with two or three digits.
pub fn milliseconds(seconds: f64) -> String {
    let ms = seconds * 1e3;
    if ms.abs() < 10.0 { format!("{ms:.1}") } else { format!("{ms:.0}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_clock_is_a_fault_and_each_fault_has_a_subject() {
        let gateway = |node: &str| GatewayState { node: node.to_owned(), ..GatewayState::default() };
        assert_eq!(gateway("g0").clock_text(), "not known");
        let good = GatewayState { clock: ClockStanding::Good, clock_bound_s: Some(0.0031), ..gateway("g0") };
        assert_eq!(good.clock_text(), "±3.1 ms");
        let degraded =
            GatewayState { clock: ClockStanding::Degraded, clock_bound_s: Some(0.15), ..gateway("g1") };
        let alone = GatewayState { clock: ClockStanding::Unsynchronised, unfit: true, ..gateway("g2") };
        let silent = GatewayState { node: "g3".to_owned(), silent: true, ..alone.clone() };
        assert_eq!(silent.clock_text(), "not synchronised, silent");
        // Unsynchronised for less than a minute.
        let restarted = GatewayState { unfit: false, ..alone.clone() };
        let apart = |gateway: &str, difference_s: f64, apart| ClockDifference {
            gateway: gateway.to_owned(),
            other: "g3".to_owned(),
            difference_s,
            datagrams: 60,
            apart,
        };
        let members = ClusterMembers {
            gateways: vec![gateway("g4"), good, degraded, alone, silent, restarted],
            clocks: vec![apart("g0", -0.0502, true), apart("g1", 0.001, false)],
            ..ClusterMembers::default()
        };
        let troubles = members.troubles();
        let about: Vec<&str> = troubles.iter().map(|trouble| &*trouble.about).collect();
        assert_eq!(
            about,
            ["cluster clock g1", "cluster clock g2", "cluster clock g3", "cluster clocks g0 g3"]
        );
        let severe = troubles.iter().filter(|trouble| trouble.severity == Severity::Critical);
        assert_eq!(severe.map(|trouble| &*trouble.about).collect::<Vec<_>>(), ["cluster clock g2"]);
        assert!(troubles[3].text.contains("differ by 50 ms: g3 is ahead of g0"), "{}", troubles[3].text);
    }
    #[test]
    fn clock_beyond_the_bound_is_named_with_seconds() {
        let node = |node: &str, ahead_s| NodeState {
            node: node.to_owned(),
            clock_ahead_s: ahead_s,
            ..NodeState::default()
        };
        let gateway = |node: &str, ahead_s| GatewayState {
            node: node.to_owned(),
            clock_ahead_s: ahead_s,
            ..GatewayState::default()
        };
        let members = ClusterMembers {
            nodes: vec![node("n0", Some(0.9)), node("n1", Some(-30.04)), node("n2", None)],
            gateways: vec![gateway("g0", Some(-0.9)), gateway("g1", Some(600.0))],
            ..ClusterMembers::default()
        };
        let texts: Vec<String> = members.troubles().into_iter().map(|trouble| trouble.text).collect();
        assert_eq!(
            texts,
            [
                "the clock of gateway g1 is 600.0 s ahead: what it sends is refused",
                "the clock of node n1 is 30.0 s behind: it decides nothing, and other nodes go first"
            ]
        );
    }
}
