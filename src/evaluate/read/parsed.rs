//! What is read from files.

use crate::evaluate::place::Place;
use crate::evaluate::types::OutputPoint;
use fusion::time::Time;

/// The samples of drones, by id: what [`crate::evaluate::Truth::new`] takes.
pub type Tracks = Vec<(String, Vec<(Time, Place)>)>;

/// The points of a file, and what a user should know about it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OutputFile {
    /// The points, in the order of the file.
    pub points: Vec<OutputPoint>,
    /// Number of points from CAT129 records without a source: they count as fused, with no known contributor.
    pub unknown_sources: u64,
    /// Number of CAT129 records skipped because others in the file state a source: these are transponder reports, not output.
    pub inputs: u64,
}
