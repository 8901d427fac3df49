//! Several cells, one region: which aircraft each of them publishes, and under which id and number. Sans-IO.
//!
//! Every cell's engine sees what is in the cell and in a halo around it, so near a border two know the same aircraft. Who owns
//! one is said by cells to each other in letters, which stand in the recipient's input like everything else that it handles.

mod border;
mod letter;
#[cfg(test)]
mod made;
mod matching;
mod merge;
mod numbers;
mod public;
mod teaching;

use crate::territory::{CellName, Outline, Territory};
use fusion::frames::Geodetic;

pub use border::{Border, Counts, View};
pub use letter::{Letter, Offer, Word};
pub use merge::{Merger, Part};
pub use numbers::{BLOCK, FIRST_BLOCK, LAST_BLOCK, numbers_office};
pub(super) use teaching::Teaching;

/// Slots from a hand-over's being offered to the first one that the new owner publishes: 4 s, so that the answer comes before,
/// also where the owner of one of the two cells is lost just then.
pub const AHEAD: i64 = 16;

/// Who flies so far inside of a halo is seen there: a plot of a radar is off by no more, metres.
const SEEN_M: f64 = 100.0;

/// One cell among those of its region.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// All cells.
    pub territory: Territory,
    /// This one.
    pub cell: CellName,
    /// So far around it everything is seen, metres.
    pub halo_m: f64,
    /// An aircraft that has left it is kept so far, metres: less than the halo.
    pub hysteresis_m: f64,
    /// All cells that there are.
    cells: Vec<CellName>,
    outline: Outline,
    /// The cells that see some of what this one sees.
    neighbours: Vec<(CellName, Outline)>,
}

impl Region {
    /// The cell of this name among all that there are; `None`: the territory has none.
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

    /// Where the cell is.
    pub const fn outline(&self) -> &Outline {
        &self.outline
    }

    /// The cells that see some of what this one sees.
    pub fn neighbours(&self) -> impl Iterator<Item = &CellName> {
        self.neighbours.iter().map(|(cell, _)| cell)
    }

    /// Those that see who is in a place.
    fn who_see(&self, place: Geodetic) -> impl Iterator<Item = &CellName> {
        let within_m = self.halo_m - SEEN_M;
        let near = self.neighbours.iter().filter(move |(_, outline)| outline.is_within(place, within_m));
        near.map(|(cell, _)| cell)
    }

    /// Those in which a place is, or so near that an aircraft there is kept.
    fn who_is_near(&self, place: Geodetic) -> impl Iterator<Item = &CellName> {
        let near =
            self.neighbours.iter().filter(move |(_, outline)| outline.is_within(place, self.hysteresis_m));
        near.map(|(cell, _)| cell)
    }

    /// Whether a place is in the cell.
    fn contains(&self, place: Geodetic) -> bool {
        self.outline.contains(place)
    }

    /// Whether it is so far in it that no other cell keeps what is there.
    fn is_deep(&self, place: Geodetic) -> bool {
        self.contains(place) && self.outline.edge_m(place) > self.hysteresis_m
    }

    /// Whether it is outside, farther than an aircraft is kept.
    fn is_left(&self, place: Geodetic) -> bool {
        !self.outline.is_within(place, self.hysteresis_m)
    }
}
