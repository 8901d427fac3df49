//! Recent reports of nodes. A name in a lease is valid if its node reports.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::cell_member::steady_now;
use crate::log::Holder;
use crate::node_report::{NodeReport, NodeRole};

/// Time without a report after which a node is gone.
const REPORT_TIMEOUT: Duration = Duration::from_secs(5);

/// Reports of nodes by name; `None` if the report is unreadable, for example of another version.
#[derive(Debug, Default)]
pub(super) struct NodeReports(BTreeMap<String, (Option<NodeReport>, Instant)>);

impl NodeReports {
    /// Adds the current reports of all nodes.
    pub(super) fn update(&mut self, reports: &[(String, Option<NodeReport>)]) {
        let now = steady_now();
        for (node, report) in reports {
            // An unreadable report does not replace a readable one.
            match (report, self.0.get(node)) {
                (None, Some((Some(_), _))) => {}
                _ => _ = self.0.insert(node.clone(), (report.clone(), now)),
            }
        }
        self.0.retain(|_, (_, at)| now - *at < REPORT_TIMEOUT);
    }

    /// Whether that run of a node reports.
    pub(super) fn is_reporting(&self, by: &Holder) -> bool {
        self.0
            .get(&by.node)
            .is_some_and(|(report, _)| report.as_ref().is_none_or(|report| report.holder == *by))
    }

    /// Role that the node reports for a cell.
    pub(super) fn role(&self, by: &Holder, cell: &str) -> Option<NodeRole> {
        let report = self.0.get(&by.node)?.0.as_ref().filter(|report| report.holder == *by)?;
        Some(report.counts(cell).part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(node: &str, run: u64) -> NodeReport {
        let holder = Holder { node: node.to_owned(), run, ..Holder::default() };
        NodeReport { holder, ..NodeReport::default() }
    }

    #[test]
    fn unreadable_report_does_not_replace_a_valid_one() {
        let mut reports = NodeReports::default();
        let named = |node: &str, report| (node.to_owned(), report);
        reports.update(&[named("n0", Some(report("n0", 7))), named("n1", None)]);
        reports.update(&[named("n0", None)]);
        let holder = |node: &str, run| report(node, run).holder;
        assert!(reports.is_reporting(&holder("n0", 7)) && !reports.is_reporting(&holder("n0", 8)));
        assert!(reports.is_reporting(&holder("n1", 3)), "one of another version");
        assert!(!reports.is_reporting(&holder("n2", 1)));
        assert_eq!(reports.role(&holder("n0", 7), "all"), Some(NodeRole::None));
        assert_eq!(reports.role(&holder("n1", 3), "all"), None);
    }
}
