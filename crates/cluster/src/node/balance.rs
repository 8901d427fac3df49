//! Rules that distribute the cells of a region evenly over the nodes. Sans-IO.

use crate::node_report::{NodeReport, NodeRole};
use crate::reference_clock::BOUND;

/// A node by its report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PeerNode {
    pub(super) node: String,
    machine: String,
    /// Numbers of cells that the node owns, and for which it is the standby.
    owned: usize,
    beside: usize,
    is_draining: bool,
    /// Whether its clock's error exceeds the bound.
    is_wrong: bool,
    may_own: Vec<String>,
}

impl From<&NodeReport> for PeerNode {
    fn from(report: &NodeReport) -> Self {
        let of = |part| report.cells.iter().filter(|(_, counts)| counts.part == part).count();
        Self {
            node: report.holder.node.clone(),
            machine: report.holder.machine.clone(),
            owned: of(NodeRole::Owner),
            beside: of(NodeRole::Standby),
            is_draining: report.is_draining,
            is_wrong: report.ahead_s.is_some_and(|ahead_s| ahead_s.abs() > BOUND.as_secs_f64()),
            may_own: report.owns.clone(),
        }
    }
}

impl PeerNode {
    /// Number of engines that the node runs. An owner and a standby cost the same.
    const fn load(&self) -> usize {
        self.owned + self.beside
    }

    fn may_have(&self, cell: &str) -> bool {
        !self.is_draining && self.may_own.iter().any(|own| own == "*" || own == cell)
    }
}

/// Whether a free standby role is for another node. A node with a right clock comes first, then one on another machine than the
/// owner's, then the one with the fewest cells.
pub(super) fn is_for_others(peers: &[PeerNode], me: &str, cell: &str, owner: Option<&str>) -> bool {
    let Some(own) = peers.iter().find(|peer| peer.node == me) else { return false };
    let machine =
        owner.and_then(|owner| peers.iter().find(|peer| peer.node == owner)).map(|peer| &peer.machine);
    let rank = |peer: &PeerNode| (peer.is_wrong, Some(&peer.machine) == machine, peer.load());
    let others = peers.iter().filter(|peer| peer.node != me && Some(peer.node.as_str()) != owner);
    others.filter(|peer| peer.may_have(cell)).any(|peer| rank(peer) < rank(own))
}

/// Whether a standby leaves its role to another node. That node has at least two cells fewer, and is not on the owner's machine
/// unless this one is, too; or its clock is right while this one's is wrong.
pub(super) fn leaves_standby(peers: &[PeerNode], me: &str, cell: &str, owner: &str) -> bool {
    let of = |name: &str| peers.iter().find(|peer| peer.node == name);
    let (Some(own), Some(owner)) = (of(me), of(owner)) else { return false };
    let others = peers.iter().filter(|peer| peer.node != own.node && peer.node != owner.node);
    others
        .filter(|peer| peer.may_have(cell) && (peer.machine != owner.machine || own.machine == owner.machine))
        .any(|peer| match (own.is_wrong, peer.is_wrong) {
            (true, false) => true,
            (false, true) => false,
            _ => peer.load() + 2 <= own.load(),
        })
}

/// Whether an owner leaves a cell to its standby: the standby owns at least two cells fewer, or its clock is right and the
/// owner's is wrong.
pub(super) fn leaves_cell(peers: &[PeerNode], me: &str, cell: &str, standby: &str) -> bool {
    let of = |name: &str| peers.iter().find(|peer| peer.node == name);
    let (Some(own), Some(beside)) = (of(me), of(standby)) else { return false };
    let is_better = match (own.is_wrong, beside.is_wrong) {
        (true, false) => true,
        (false, true) => false,
        _ => beside.owned + 2 <= own.owned,
    };
    beside.may_have(cell) && is_better
}

/// Whether a node is allowed to take over the cell.
pub(super) fn may_take(peers: &[PeerNode], cell: &str, node: &str) -> bool {
    peers.iter().any(|peer| peer.node == node && peer.may_have(cell))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn peer(node: &str, machine: &str, owned: usize, beside: usize) -> PeerNode {
        PeerNode {
            node: node.to_owned(),
            machine: machine.to_owned(),
            owned,
            beside,
            is_draining: false,
            is_wrong: false,
            may_own: vec!["*".to_owned()],
        }
    }

    #[test]
    fn standby_prefers_fewest_cells_on_another_machine() {
        let peers = [peer("a", "1", 2, 0), peer("b", "1", 0, 0), peer("c", "2", 0, 3), peer("d", "3", 0, 2)];
        let takes = |owner| {
            let free = peers.iter().filter(|peer| Some(peer.node.as_str()) != owner);
            let takes = free.filter(|peer| !is_for_others(&peers, &peer.node, "x", owner));
            takes.map(|peer| peer.node.as_str()).collect::<Vec<_>>()
        };
        assert_eq!(takes(Some("a")), ["d"]);
        assert_eq!(takes(None), ["b"]);
        // With no other machine available, the same machine is accepted.
        let two = [peer("a", "1", 2, 0), peer("b", "1", 0, 0)];
        assert!(!is_for_others(&two, "b", "x", Some("a")));
        assert!(!is_for_others(&[], "b", "x", Some("a")), "nobody has spoken yet");
        let other =
            [peer("a", "1", 0, 0), PeerNode { may_own: vec!["y".to_owned()], ..peer("b", "2", 0, 0) }];
        assert!(!is_for_others(&other, "a", "x", None));
    }

    /// Nodes join one that has all cells. Cells move until the distribution is stable, with a limited number of moves.
    #[test]
    fn cells_are_balanced_in_few_moves_and_stay() {
        for nodes in 2..6_usize {
            let cells = 7;
            // Owner and standby of each cell.
            let mut held: Vec<[usize; 2]> = vec![[0, 1]; cells];
            let peers = |held: &[[usize; 2]]| -> Vec<PeerNode> {
                let count = |part: usize, node| held.iter().filter(|of| of[part] == node).count();
                (0..nodes)
                    .map(|node| peer(&node.to_string(), &node.to_string(), count(0, node), count(1, node)))
                    .collect()
            };
            let mut moves = 0;
            loop {
                let known = peers(&held);
                let names: Vec<String> = (0..nodes).map(|node| node.to_string()).collect();
                let moved = (0..cells).find_map(|cell| {
                    let [owner, beside] = held[cell];
                    if leaves_cell(&known, &names[owner], "x", &names[beside]) {
                        return Some((cell, [beside, owner]));
                    }
                    let leaves = leaves_standby(&known, &names[beside], "x", &names[owner]);
                    let next = (0..nodes).find(|next| {
                        *next != owner && !is_for_others(&known, &names[*next], "x", Some(&names[owner]))
                    });
                    leaves.then(|| (cell, [owner, next.unwrap()]))
                });
                let Some((cell, now)) = moved else { break };
                held[cell] = now;
                moves += 1;
                assert!(moves <= 3 * cells, "{nodes} nodes: {held:?}");
            }
            let loads: Vec<usize> = peers(&held).iter().map(PeerNode::load).collect();
            let owned: Vec<usize> = peers(&held).iter().map(|peer| peer.owned).collect();
            let spread = |of: &[usize]| of.iter().max().unwrap() - of.iter().min().unwrap();
            assert!(spread(&loads) <= 3 && spread(&owned) <= 2, "{nodes} nodes: {loads:?} {owned:?}");
        }
    }
}
