//! Reports of the cells' owners, written each second beside the picture.

use serde::{Deserialize, Serialize};

use fusion::operational::ActiveAssociation;
use service::live::{Status, TrustAssessments};

/// Report of a cell by its owner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellReport {
    /// The node that owns the cell.
    pub node: String,
    /// Number of its lease.
    pub epoch: u64,
    /// State of the sensors, and counters; without lines, which the gateways report.
    pub status: Status,
    /// Integrity assessments of transponders.
    pub integrities: TrustAssessments,
    /// Operator decisions in force.
    pub correlations: Vec<ActiveAssociation>,
}

impl CellReport {
    /// Serialises the report.
    pub fn octets(&self) -> Vec<u8> {
        postcard::to_stdvec(self).expect("every report can be written down")
    }

    /// Parses a report; `None` if the octets are invalid.
    pub fn parse(octets: &[u8]) -> Option<Self> {
        postcard::from_bytes(octets).ok()
    }
}
