//! What those of a cluster say of themselves each second, beside the picture.

use serde::{Deserialize, Serialize};

use crate::live::{Integrities, Status};
use fusion::operational::HeldCorrelation;

/// What the owner of a cell says of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellReport {
    /// The node that owns it.
    pub node: String,
    /// The number of its lease.
    pub epoch: u64,
    /// How the sensors are, and what was counted; without the lines, which are the gateways'.
    pub status: Status,
    /// What is known of transponders.
    pub integrities: Integrities,
    /// Operators' decisions in force.
    pub correlations: Vec<HeldCorrelation>,
}

impl CellReport {
    /// As octets.
    pub fn octets(&self) -> Vec<u8> {
        postcard::to_stdvec(self).expect("every report can be written down")
    }

    /// Of octets; `None`: they are something else.
    pub fn parse(octets: &[u8]) -> Option<Self> {
        postcard::from_bytes(octets).ok()
    }
}
