//! Who makes the picture where several machines do: what they say of themselves.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::alerts::{Severity, Trouble};

/// A clock that is further from reference time than this is wrong, seconds.
const WRONG_S: f64 = 1.0;

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
    /// How far apart the clocks of each two gateways are that hear the same.
    pub clocks: Vec<ClockDifference>,
    /// Gateways that ought to be heard of, and have said nothing for 3 s.
    pub missing_gateways: Vec<String>,
    /// Members whose configuration is another one than this process's: which, and in what.
    pub different: Vec<String>,
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
    /// Whether the picture is without it because its owner has another configuration.
    pub is_foreign: bool,
    /// Where it is, longitude and latitude of its corners in degrees; empty: it is the whole site.
    pub corners: Vec<[f64; 2]>,
}

/// Part of a node in its cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodePart {
    /// It owns one.
    Owner,
    /// It stands by for one.
    Standby,
    /// Neither.
    None,
    /// It gives its cells away, and takes no others.
    Drained,
}

fusion::interface_names!(NodePart { Owner = "owner", Standby = "standby", None = "none", Drained = "drained" });

/// A node.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct NodeState {
    /// Its name.
    pub node: String,
    /// The machine that it runs on.
    pub machine: String,
    /// What it is: for one cell at least, where there are several.
    #[schemars(extend("enum" = NodePart::NAMES))]
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
    /// How far its clock is ahead of reference time, the median of the log's and the gateways' clocks, seconds; negative where it is
    /// behind; absent: not known yet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clock_ahead_s: Option<f64>,
}

/// A gateway.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
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
    /// What its clock is worth.
    pub clock: ClockStanding,
    /// Its clock is off by no more than this, seconds; absent: nobody knows.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub clock_bound_s: Option<f64>,
    /// Who says so; absent: nobody does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clock_by: Option<ClockSource>,
    /// Its clock has not been synchronised for a minute or longer.
    pub unfit: bool,
    /// It publishes nothing, because of that: other gateways carry all that it hears.
    pub silent: bool,
    /// Datagrams that it did not publish while it was silent.
    pub withheld: u64,
    /// How far its clock is ahead of reference time, the median of the log's and the gateways' clocks, seconds; negative where it is
    /// behind; absent: not known yet. Beyond 1 s what it sends is refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clock_ahead_s: Option<f64>,
}

/// What a clock is worth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ClockStanding {
    /// It is synchronised, and off by 20 ms at most.
    Good,
    /// It may be off by more than 20 ms.
    Warning,
    /// It may be off by more than 100 ms.
    Degraded,
    /// It is synchronised, and nobody says how well.
    Unbounded,
    /// It is not synchronised.
    Unsynchronised,
    /// Nobody says anything of it.
    #[default]
    Unknown,
}

/// Who says how good a clock is.
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

/// How far apart the clocks of two gateways are, by when both heard the same datagrams.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct ClockDifference {
    /// One of them.
    pub gateway: String,
    /// The other one.
    pub other: String,
    /// The median of how much later the one stamps than the other one, seconds.
    pub difference_s: f64,
    /// Datagrams that were compared.
    #[schemars(range(min = 5))]
    pub datagrams: u64,
    /// They have been more than 20 ms apart, and not less than 15 ms since.
    pub apart: bool,
}

impl Members {
    /// Faults of cells and of the clocks of gateways and nodes; each becomes an alert.
    pub fn troubles(&self) -> Vec<Trouble> {
        let cells = self.cells.iter().filter_map(CellState::trouble);
        let gateways = self.gateways.iter().filter_map(GatewayState::trouble);
        let refused = self.gateways.iter().filter_map(GatewayState::refused);
        let nodes = self.nodes.iter().filter_map(NodeState::trouble);
        let missing = self.missing_gateways.iter().map(|gateway| Trouble {
            about: format!("{} gateway {gateway}", Trouble::CLUSTER).into(),
            severity: Severity::Warning,
            text: format!(
                "gateway {gateway} says nothing: what it alone hears is lost, and no other one may fail"
            ),
        });
        let different = self.different.iter().map(|different| Trouble {
            about: format!(
                "{} configuration {}",
                Trouble::CLUSTER,
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
    fn trouble(&self) -> Option<Trouble> {
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
        Some(Trouble { about: format!("{} cell {cell}", Trouble::CLUSTER).into(), severity, text })
    }
}

/// By how much a clock is wrong, in words; `None`: it is within the bound, or not known.
fn wrong(ahead_s: Option<f64>) -> Option<String> {
    let ahead_s = ahead_s.filter(|ahead_s| ahead_s.abs() > WRONG_S)?;
    Some(format!("{:.1} s {}", ahead_s.abs(), if ahead_s > 0.0 { "ahead" } else { "behind" }))
}

impl NodeState {
    fn trouble(&self) -> Option<Trouble> {
        let Self { node, clock_ahead_s, .. } = self;
        let wrong = wrong(*clock_ahead_s)?;
        Some(Trouble {
            about: format!("{} reference clock {node}", Trouble::CLUSTER).into(),
            severity: Severity::Warning,
            text: format!(
                "the clock of node {node} is {wrong}: it decides nothing, and other nodes go first"
            ),
        })
    }
}

impl GatewayState {
    fn refused(&self) -> Option<Trouble> {
        let Self { node, clock_ahead_s, .. } = self;
        let wrong = wrong(*clock_ahead_s)?;
        Some(Trouble {
            about: format!("{} reference clock {node}", Trouble::CLUSTER).into(),
            severity: Severity::Warning,
            text: format!("the clock of gateway {node} is {wrong}: what it sends is refused"),
        })
    }

    /// What is known of its clock, in words.
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

    fn trouble(&self) -> Option<Trouble> {
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
        let about = format!("{} clock {node}", Trouble::CLUSTER).into();
        Some(Trouble { about, severity, text: format!("the clock of gateway {node} {text}") })
    }
}

impl ClockDifference {
    fn trouble(&self) -> Option<Trouble> {
        let Self { gateway, other, difference_s, .. } = self;
        let (ahead, behind) = if *difference_s > 0.0 { (gateway, other) } else { (other, gateway) };
        self.apart.then(|| Trouble {
            about: format!("{} clocks {gateway} {other}", Trouble::CLUSTER).into(),
            severity: Severity::Warning,
            text: format!(
                "the clocks of gateways {gateway} and {other} differ by {} ms: {ahead} is ahead of {behind}, and which one is wrong is not known",
                milliseconds(difference_s.abs())
            ),
        })
    }
}

/// Seconds as milliseconds: three digits are enough.
pub(crate) fn milliseconds(seconds: f64) -> String {
    let ms = seconds * 1e3;
    if ms.abs() < 10.0 { format!("{ms:.1}") } else { format!("{ms:.0}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_nobody_knows_is_not_said_to_be_good_and_each_trouble_has_a_subject_of_its_own() {
        let gateway = |node: &str| GatewayState { node: node.to_owned(), ..GatewayState::default() };
        assert_eq!(gateway("g0").clock_text(), "not known");
        let good = GatewayState { clock: ClockStanding::Good, clock_bound_s: Some(0.0031), ..gateway("g0") };
        assert_eq!(good.clock_text(), "±3.1 ms");
        let degraded =
            GatewayState { clock: ClockStanding::Degraded, clock_bound_s: Some(0.15), ..gateway("g1") };
        let alone = GatewayState { clock: ClockStanding::Unsynchronised, unfit: true, ..gateway("g2") };
        let silent = GatewayState { node: "g3".to_owned(), silent: true, ..alone.clone() };
        assert_eq!(silent.clock_text(), "not synchronised, silent");
        // Not yet for a minute.
        let restarted = GatewayState { unfit: false, ..alone.clone() };
        let apart = |gateway: &str, difference_s: f64, apart| ClockDifference {
            gateway: gateway.to_owned(),
            other: "g3".to_owned(),
            difference_s,
            datagrams: 60,
            apart,
        };
        let members = Members {
            gateways: vec![gateway("g4"), good, degraded, alone, silent, restarted],
            clocks: vec![apart("g0", -0.0502, true), apart("g1", 0.001, false)],
            ..Members::default()
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
        let members = Members {
            nodes: vec![node("n0", Some(0.9)), node("n1", Some(-30.04)), node("n2", None)],
            gateways: vec![gateway("g0", Some(-0.9)), gateway("g1", Some(600.0))],
            ..Members::default()
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
