//! Spatial index over ground.

use crate::cells::GroundCells;
use crate::frames::Enu;

/// Side of the index's squares, metres; gates are a few hundred metres.
const SIDE_M: f64 = 250.0;

/// Objects by position.
#[derive(Debug)]
pub(super) struct SpatialIndex<T> {
    cells: GroundCells,
    all: Vec<(Enu, T)>,
}

impl<T> SpatialIndex<T> {
    /// Builds the index of these objects.
    pub(super) fn of(things: impl Iterator<Item = (Enu, T)>) -> Self {
        let mut all = Vec::with_capacity(things.size_hint().1.unwrap_or(0));
        all.extend(things);
        let mut cells = GroundCells::default();
        cells.fill(all.iter().map(|thing| thing.0), SIDE_M);
        Self { cells, all }
    }

    /// All objects.
    pub(super) fn iter(&self) -> impl Iterator<Item = &(Enu, T)> {
        self.all.iter()
    }

    /// Objects within `reach_m` over ground and some beyond, in the order in which they were given.
    pub(super) fn within(&self, place: Enu, reach_m: f64) -> impl Iterator<Item = &(Enu, T)> {
        let mut indices: Vec<usize> = self.cells.within(place, reach_m, SIDE_M).collect();
        indices.sort_unstable();
        indices.into_iter().map(|index| &self.all[index])
    }
}
