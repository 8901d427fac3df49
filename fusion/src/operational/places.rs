//! What is near a place: an index over ground.

use crate::cells::Cells;
use crate::frames::Enu;

/// Side of its squares, metres: gates are a few hundred.
const SIDE_M: f64 = 250.0;

/// Things by where they are.
#[derive(Debug)]
pub(super) struct Places<T> {
    cells: Cells,
    all: Vec<(Enu, T)>,
}

impl<T> Places<T> {
    /// Of these.
    pub(super) fn of(things: impl Iterator<Item = (Enu, T)>) -> Self {
        let mut all = Vec::with_capacity(things.size_hint().1.unwrap_or(0));
        all.extend(things);
        let mut cells = Cells::default();
        cells.fill(all.iter().map(|thing| thing.0), SIDE_M);
        Self { cells, all }
    }

    /// All of them.
    pub(super) fn iter(&self) -> impl Iterator<Item = &(Enu, T)> {
        self.all.iter()
    }

    /// Those within `reach_m` over ground and some beyond, in the order in which they were given.
    pub(super) fn within(&self, place: Enu, reach_m: f64) -> impl Iterator<Item = &(Enu, T)> {
        let mut indices: Vec<usize> = self.cells.within(place, reach_m, SIDE_M).collect();
        indices.sort_unstable();
        indices.into_iter().map(|index| &self.all[index])
    }
}
