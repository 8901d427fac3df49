//! Spatial index of a slot's detections: squares on the ground.

use std::ops::{Range, RangeInclusive};

use serde::{Deserialize, Serialize};

use crate::frames::Enu;

/// Indices of positions by square. A search covers only the squares near a point, so a slot with ten thousand
/// detections costs little more than one with a hundred.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct GroundCells {
    /// Row, column and index, ordered by row from south to north, then from west to east.
    squares: Vec<(i32, i32, u32)>,
    /// The rows that contain positions, with their ranges in `squares`.
    rows: Vec<(i32, Range<usize>)>,
}

impl GroundCells {
    /// Sorts the positions into squares of `side_m`; an index is a position's place in the iteration.
    pub fn fill(&mut self, positions: impl Iterator<Item = Enu>, side_m: f64) {
        self.clear();
        self.squares.extend((0..).zip(positions).map(|(index, position)| {
            let (row, column) = square(position, side_m);
            (row, column, index)
        }));
        self.squares.sort_unstable();
        let mut start = 0;
        for row in self.squares.chunk_by(|a, b| a.0 == b.0) {
            self.rows.push((row[0].0, start..start + row.len()));
            start += row.len();
        }
    }

    /// Removes all positions.
    pub fn clear(&mut self) {
        self.squares.clear();
        self.rows.clear();
    }

    /// Indices in the square of `point` and the eight around it: all within `side_m` over ground, and some beyond.
    pub fn around(&self, point: Enu, side_m: f64) -> impl Iterator<Item = usize> {
        let (row, column) = square(point, side_m);
        let beside = |index: i32| index.saturating_sub(1)..=index.saturating_add(1);
        self.indices(self.parts(beside(row), beside(column)))
    }

    /// Indices of all positions within `reach_m` of `point` over ground, and some beyond; `side_m` is the squares'
    /// side.
    pub fn within(&self, point: Enu, reach_m: f64, side_m: f64) -> impl Iterator<Item = usize> {
        self.indices(self.parts_within(point, reach_m, side_m))
    }

    /// Like [`Self::within`], as ranges of [`Self::order`].
    pub fn parts_within(&self, point: Enu, reach_m: f64, side_m: f64) -> impl Iterator<Item = Range<usize>> {
        let corner =
            |away_m: f64| square(Enu::new(point.east() + away_m, point.north() + away_m, 0.0), side_m);
        let ((south, west), (north, east)) = (corner(-reach_m), corner(reach_m));
        self.parts(south..=north, west..=east)
    }

    /// All indices, square by square.
    pub fn order(&self) -> impl Iterator<Item = usize> {
        self.squares.iter().map(|&(_, _, index)| index as usize)
    }

    fn indices(&self, parts: impl Iterator<Item = Range<usize>>) -> impl Iterator<Item = usize> {
        parts.flat_map(|part| &self.squares[part]).map(|&(_, _, index)| index as usize)
    }

    /// Ranges of `squares` within these rows and columns, one for each row.
    fn parts(
        &self,
        rows: RangeInclusive<i32>,
        columns: RangeInclusive<i32>,
    ) -> impl Iterator<Item = Range<usize>> {
        let south = self.rows.partition_point(|(row, _)| row < rows.start());
        let rows = self.rows[south..].iter().take_while(move |(row, _)| row <= rows.end());
        rows.map(move |(_, part)| {
            let squares = &self.squares[part.clone()];
            let west = squares.partition_point(|(_, column, _)| column < columns.start());
            let held = squares[west..].partition_point(|(_, column, _)| column <= columns.end());
            part.start + west..part.start + west + held
        })
    }
}

/// Row and column of a position. `as` saturates, and no position on Earth comes near the limits with squares of 1 m or
/// more.
fn square(position: Enu, side_m: f64) -> (i32, i32) {
    let index = |metres: f64| (metres / side_m).floor() as i32;
    (index(position.north()), index(position.east()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn nothing_within_a_side_is_missed(
            positions in prop::collection::vec((-900.0..900.0_f64, -900.0..900.0_f64), 0..80),
            (east, north) in (-900.0..900.0_f64, -900.0..900.0_f64),
        ) {
            let positions: Vec<Enu> = positions.into_iter().map(|(e, n)| Enu::new(e, n, 0.0)).collect();
            let point = Enu::new(east, north, 0.0);
            let mut cells = GroundCells::default();
            cells.fill(positions.iter().copied(), 300.0);
            let found: Vec<usize> = cells.around(point, 300.0).collect();
            for (index, position) in positions.iter().enumerate() {
                let distance_m = (position.0 - point.0).norm();
                prop_assert_eq!(found.iter().filter(|&&other| other == index).count() == 1, found.contains(&index));
                prop_assert!(distance_m > 300.0 || found.contains(&index));
                prop_assert!(distance_m < 850.0 || !found.contains(&index), "two squares away at most");
            }
        }

        #[test]
        fn nothing_within_reach_is_missed(
            positions in prop::collection::vec((-900.0..900.0_f64, -900.0..900.0_f64), 0..80),
            (east, north, reach_m) in (-900.0..900.0_f64, -900.0..900.0_f64, 0.0..1500.0_f64),
        ) {
            let positions: Vec<Enu> = positions.into_iter().map(|(e, n)| Enu::new(e, n, 0.0)).collect();
            let point = Enu::new(east, north, 0.0);
            let mut cells = GroundCells::default();
            cells.fill(positions.iter().copied(), 100.0);
            let mut found: Vec<usize> = cells.within(point, reach_m, 100.0).collect();
            found.sort_unstable();
            prop_assert!(found.windows(2).all(|pair| pair[0] < pair[1]), "none twice");
            for (index, position) in positions.iter().enumerate() {
                let apart = position.0 - point.0;
                prop_assert!(apart.norm() > reach_m || found.contains(&index));
                prop_assert!(apart.amax() <= reach_m + 100.0 || !found.contains(&index), "a square away at most");
            }
        }
    }
}
