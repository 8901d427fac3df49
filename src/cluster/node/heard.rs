//! Recent reports of nodes: a name in a lease counts where its node reports.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::counts::{NodeReport, Part};
use super::desk::moment;
use crate::cluster::log::Holder;

/// A node without a report for this long is gone.
const GONE: Duration = Duration::from_secs(5);

/// Nodes that speak, by name; `None`: something is said that this program cannot read, as by one of another version.
#[derive(Debug, Default)]
pub(super) struct Heard(BTreeMap<String, (Option<NodeReport>, Instant)>);

impl Heard {
    /// The present reports of all nodes.
    pub(super) fn note(&mut self, said: &[(String, Option<NodeReport>)]) {
        let now = moment();
        for (node, report) in said {
            // An unreadable report does not replace a readable one.
            match (report, self.0.get(node)) {
                (None, Some((Some(_), _))) => {}
                _ => _ = self.0.insert(node.clone(), (report.clone(), now)),
            }
        }
        self.0.retain(|_, (_, at)| now - *at < GONE);
    }

    /// Whether that run of a node speaks.
    pub(super) fn is_heard(&self, by: &Holder) -> bool {
        self.0.get(&by.node).is_some_and(|(said, _)| said.as_ref().is_none_or(|said| said.holder == *by))
    }

    /// The part that it reports for a cell.
    pub(super) fn part(&self, by: &Holder, cell: &str) -> Option<Part> {
        let said = self.0.get(&by.node)?.0.as_ref().filter(|said| said.holder == *by)?;
        Some(said.counts(cell).part)
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
    fn node_that_speaks_is_heard_and_junk_does_not_silence_it() {
        let mut heard = Heard::default();
        let said = |node: &str, report| (node.to_owned(), report);
        heard.note(&[said("n0", Some(report("n0", 7))), said("n1", None)]);
        heard.note(&[said("n0", None)]);
        let holder = |node: &str, run| report(node, run).holder;
        assert!(heard.is_heard(&holder("n0", 7)) && !heard.is_heard(&holder("n0", 8)));
        assert!(heard.is_heard(&holder("n1", 3)), "one of another version");
        assert!(!heard.is_heard(&holder("n2", 1)));
        assert_eq!(heard.part(&holder("n0", 7), "all"), Some(Part::None));
        assert_eq!(heard.part(&holder("n1", 3), "all"), None);
    }
}
