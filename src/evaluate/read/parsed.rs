//! What is read from files.

use crate::evaluate::place::Place;
use crate::evaluate::types::OutputPoint;
use fusion::time::Time;

/// The samples of drones, by id: what [`super::Truth::new`] takes.
pub type Tracks = Vec<(String, Vec<(Time, Place)>)>;

/// The points of a file, and what was remarkable about it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OutputFile {
    /// The points, in the order of the file.
    pub points: Vec<OutputPoint>,
    /// Those of CAT129 records that do not say what they are made of: they count as fused, with no known contributor.
    pub unknown_sources: u64,
    /// CAT129 records passed over because others of the file do say it: reports of transponders, not output.
    pub inputs: u64,
}
