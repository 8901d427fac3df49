//! Contents of files.

use crate::evaluate::place::GeodeticPlace;
use crate::evaluate::types::OutputPoint;
use fusion::time::Time;

/// Samples of drones, by id: the input of [`crate::evaluate::Truth::new`].
pub type TruthTracks = Vec<(String, Vec<(Time, GeodeticPlace)>)>;

/// Points of a file, with counts to report to the user.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OutputFile {
    /// The points, in the order of the file.
    pub points: Vec<OutputPoint>,
    /// Number of points from CAT129 records without a source: they count as fused, with no known contributor.
    pub unknown_sources: u64,
    /// Number of CAT129 records skipped because other records in the file state a source: they are transponder reports,
    /// not output.
    pub inputs: u64,
}
