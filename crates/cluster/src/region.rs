//! Several cells in one region: which cell publishes which aircraft, and under which id and number. Sans-IO.
//!
//! Every cell's engine processes the data in the cell and in a halo around it, so two cells know the same aircraft near a border.
//! Cells negotiate its owner by messages, which the recipient handles in sequence with its other inputs.

mod border;
mod cell_message;
mod matching;
mod merge;
mod numbers;
mod public_name;
#[cfg(test)]
mod test_tracks;
mod value_sharing;

use fusion::frames::Geodetic;
use site::territory::{CellName, Outline, Territory};

pub use border::{Border, BorderCounts, EngineView};
pub use cell_message::{AircraftOffer, CellMessage, CellMessageContent};
pub use merge::{CellPicture, PictureMerger};
pub use numbers::{BLOCK, FIRST_BLOCK, LAST_BLOCK, number_table};
pub(super) use value_sharing::{DEFAULT_REACH_M, ValueSharing, reach_m};

/// Number of slots from the offer of an aircraft to its first publication by the new owner (4 s). The answer arrives within this
/// time, even if the owner of one of the two cells is lost just then.
pub const AHEAD: i64 = 16;

/// Distance from a halo's outer edge within which an aircraft may not be seen, in metres: at least the error of a radar plot.
const SEEN_M: f64 = 100.0;

/// A cell among those of its region.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Division of the region.
    pub territory: Territory,
    /// Name of this cell.
    pub cell: CellName,
    /// Width of the halo around the cell, in metres.
    pub halo_m: f64,
    /// Distance outside the cell up to which it keeps an aircraft, in metres. It is less than the halo.
    pub hysteresis_m: f64,
    /// Names of all cells.
    cells: Vec<CellName>,
    outline: Outline,
    /// Cells whose data overlaps with this cell's.
    neighbours: Vec<(CellName, Outline)>,
}

impl Region {
    /// Creates the geometry of the cell with this name; `None` if the territory has no such cell.
    pub fn new(
        territory: Territory,
        mut cells: Vec<CellName>,
        cell: CellName,
        halo_m: f64,
        hysteresis_m: f64,
    ) -> Option<Self> {
        let outline = territory.outline(&cell)?;
        cells.sort();
        let neighbours =
            territory.neighbours(&cell, halo_m).into_iter().filter(|other| cells.contains(other));
        let neighbours =
            neighbours.filter_map(|other| Some((other.clone(), territory.outline(&other)?))).collect();
        Some(Self { territory, cell, halo_m, hysteresis_m, cells, outline, neighbours })
    }

    /// Outline of the cell.
    pub const fn outline(&self) -> &Outline {
        &self.outline
    }

    /// Cells whose data overlaps with this cell's.
    pub fn neighbours(&self) -> impl Iterator<Item = &CellName> {
        self.neighbours.iter().map(|(cell, _)| cell)
    }

    /// Adjacent cells that see an aircraft at this position.
    fn cells_that_see(&self, place: Geodetic) -> impl Iterator<Item = &CellName> {
        let within_m = self.halo_m - SEEN_M;
        let near = self.neighbours.iter().filter(move |(_, outline)| outline.is_within(place, within_m));
        near.map(|(cell, _)| cell)
    }

    /// Adjacent cells that contain this position, or are so near that they keep an aircraft there.
    fn cells_that_keep(&self, place: Geodetic) -> impl Iterator<Item = &CellName> {
        let near =
            self.neighbours.iter().filter(move |(_, outline)| outline.is_within(place, self.hysteresis_m));
        near.map(|(cell, _)| cell)
    }

    /// Whether the position is in the cell.
    fn contains(&self, place: Geodetic) -> bool {
        self.outline.contains(place)
    }

    /// Whether the position is so far inside that no other cell keeps an aircraft there.
    fn is_deep_inside(&self, place: Geodetic) -> bool {
        self.contains(place) && self.outline.edge_m(place) > self.hysteresis_m
    }

    /// Whether the position is outside, beyond the distance up to which an aircraft is kept.
    fn is_beyond(&self, place: Geodetic) -> bool {
        !self.outline.is_within(place, self.hysteresis_m)
    }
}
