//! Metrics of a cluster's members.

use super::text::Metrics;
use service::live::ClusterMembers;

impl Metrics {
    /// Metrics of cells, nodes and gateways.
    pub(super) fn members(&mut self, members: &ClusterMembers) {
        let ClusterMembers {
            cells,
            nodes,
            gateways,
            clocks,
            shown,
            doubled,
            missing,
            twice,
            too_late,
            missing_gateways,
            ..
        } = members;
        let of_cell = |value: fn(&service::live::CellState) -> u64| {
            cells.iter().map(move |cell| (&*cell.cell, value(cell)))
        };
        let help = "Whether a node owns the cell";
        self.by("cluster_owner", help, "cell", of_cell(|cell| cell.owner.is_some().into()));
        let help = "Whether a node takes over when its owner falls silent";
        self.by("cluster_standby", help, "cell", of_cell(|cell| cell.standby.is_some().into()));
        let help = "Number of the owner's lease, which grows with each take-over";
        self.by("cluster_epoch", help, "cell", of_cell(|cell| cell.lease));
        let help = "Slots that the standby is behind its owner";
        self.by("cluster_standby_behind_slots", help, "cell", of_cell(|cell| cell.behind));
        let help =
            "What is left out because its owner cannot keep up, a step of docs/SCALING.md; 0 for nothing";
        self.by("cluster_shed_step", help, "cell", of_cell(|cell| cell.step.into()));
        let of_node = |value: fn(&service::live::NodeState) -> u64| {
            nodes.iter().map(move |node| (&*node.node, value(node)))
        };
        let help = "How often a node became the owner";
        self.by("cluster_takeovers_total", help, "node", of_node(|node| node.takeovers));
        let help = "How often a node was refused because another one owned the cell";
        self.by("cluster_fenced_total", help, "node", of_node(|node| node.fenced));
        let help = "How often the state of a standby was not its owner's";
        self.by("cluster_standby_diverged_total", help, "node", of_node(|node| node.diverged));
        let help = "Checkpoints that a node wrote";
        self.by("cluster_checkpoints_total", help, "node", of_node(|node| node.checkpoints));
        let of_gateway = |value: fn(&service::live::GatewayState) -> u64| {
            gateways.iter().map(move |gateway| (&*gateway.node, value(gateway)))
        };
        let help = "Messages that a gateway wrote into the log";
        self.by("cluster_written_total", help, "gateway", of_gateway(|gateway| gateway.written));
        let help = "Messages of a gateway that wait for the log";
        self.by("cluster_waiting", help, "gateway", of_gateway(|gateway| gateway.waiting));
        let help = "Datagrams that a gateway dropped because the log was away for too long";
        self.by("cluster_dropped_total", help, "gateway", of_gateway(|gateway| gateway.dropped));
        let help =
            "Datagrams that a gateway did not publish because its clock is not fit, and others carry them";
        self.by("cluster_withheld_total", help, "gateway", of_gateway(|gateway| gateway.withheld));
        let help = "Whether a gateway publishes nothing because its clock is not synchronised";
        self.by("cluster_gateway_silent", help, "gateway", of_gateway(|gateway| gateway.silent.into()));
        let help = "Whether a gateway that ought to be heard of says nothing";
        self.by("cluster_gateway_missing", help, "gateway", missing_gateways.iter().map(|name| (&**name, 1)));
        let help = "How far the clock of a gateway may be off; absent where nobody knows";
        let bound = |gateway: &service::live::GatewayState| {
            gateway.clock_bound_s.map(|bound_s| (gateway.node.clone(), bound_s))
        };
        self.by("cluster_clock_bound_seconds", help, "gateway", gateways.iter().filter_map(bound));
        let ahead = nodes.iter().map(|node| (&node.node, node.clock_ahead_s));
        let ahead = ahead.chain(gateways.iter().map(|gateway| (&gateway.node, gateway.clock_ahead_s)));
        let help =
            "How far the clock of a node or gateway is ahead of reference time; absent where it is not known";
        let known = ahead.filter_map(|(member, ahead_s)| Some((member.clone(), ahead_s?)));
        self.by("cluster_clock_ahead_seconds", help, "member", known);
        let name = "cluster_clock_difference_seconds";
        self.family(
            name,
            "How much later a gateway stamps the same datagrams than the other one, the median",
        );
        for clock in clocks {
            let labels = [("gateway", &*clock.gateway), ("other", &*clock.other)];
            self.sample(name, &labels, clock.difference_s);
        }
        self.one("cluster_slots_shown_total", "Slots of the cluster that were shown here", shown);
        let help = "Slots that came again after they, or later ones, had been shown";
        self.one("cluster_doubled_total", help, doubled);
        self.one("cluster_missing_slots_total", "Slots that nobody published", missing);
        let help = "Whether the picture is without the cell";
        self.by("cluster_cell_missing", help, "cell", of_cell(|cell| cell.is_missing.into()));
        let help = "Aircraft of a slot that were left out because another cell published them, too";
        self.one("cluster_twice_total", help, twice);
        let help = "Slots of cells that came when the picture had been shown without them";
        self.one("cluster_late_slots_total", help, too_late);
        let help = "Cells that a node owns";
        self.by("cluster_cells_owned", help, "node", of_node(|node| node.owns.len() as u64));
    }
}
