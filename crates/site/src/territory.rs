//! The cells of a region: the cell that contains a position, and the cells near one.
//!
//! Positions are compared in integer nanodegrees (0.1 mm), so every node finds a position in the same cell, and in at most one.

mod name;
mod outline;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use fusion::frames::Geodetic;

pub use name::{CellName, NotAName};
pub use outline::Outline;
use outline::{Corner, DEGREE};

/// Maximum distance from the centre of a cell to its farthest corner, in metres.
const RADIUS_MAX_M: f64 = 20_000.0;
/// Limit of a grid, in degrees of latitude: near the poles the meridians converge.
const LATITUDE_MAX_DEG: i64 = 85;
/// Longitude of the western edge of the grid, in nanodegrees.
const WEST: i64 = -180 * DEGREE;

/// Reason why cells do not form a territory.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TerritoryError {
    /// The squares do not fit evenly around the Earth.
    #[error("cells of {0}° do not divide 5° evenly; take 0.05, 0.1, 0.125, 0.2 or 0.25")]
    Grid(f64),
    /// A cell is too large for one tangent plane.
    #[error("the cell {name} reaches {radius_m:.0} m from its centre: at most 20,000")]
    Large {
        /// Name of the cell; for a grid, of one at the equator.
        name: CellName,
        /// Distance from the centre to the farthest corner, in metres.
        radius_m: f64,
    },
    /// A name is not valid.
    #[error(transparent)]
    Name(#[from] NotAName),
    /// Two cells have the same name.
    #[error("two cells are called {0}")]
    Twice(CellName),
    /// A polygon has less than three corners, or no area.
    #[error(
        "the cell {0} has no area: a polygon has three corners or more, longitude and latitude in degrees each"
    )]
    Flat(CellName),
    /// Two cells overlap.
    #[error("the cells {0} and {1} overlap: a place is in one cell at most")]
    Overlap(CellName, CellName),
}

/// The cells of a region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Territory {
    /// Squares with sides of this many nanodegrees, aligned at 0. The western and southern edges belong to a cell.
    Grid(i64),
    /// Polygons by name.
    Polygons(BTreeMap<CellName, Outline>),
}

impl Territory {
    /// A grid of squares with sides of `degrees`.
    ///
    /// # Errors
    /// The squares do not divide five degrees evenly, or are larger than 40 km across.
    pub fn grid(degrees: f64) -> Result<Self, TerritoryError> {
        let step = (degrees * DEGREE as f64).round();
        if !(step >= 1e6 && step <= 5.0 * DEGREE as f64) || 5 * DEGREE % step as i64 != 0 {
            return Err(TerritoryError::Grid(degrees));
        }
        let step = step as i64;
        let at_equator = square(step, (0, 0));
        if at_equator.radius_m() > RADIUS_MAX_M {
            let name = CellName::of_square((0, 0));
            return Err(TerritoryError::Large { name, radius_m: at_equator.radius_m() });
        }
        Ok(Self::Grid(step))
    }

    /// Named polygons. Corners are longitude and latitude, in degrees, in order; the first one is not repeated.
    ///
    /// # Errors
    /// A name is not valid or used twice, or a polygon is not valid, too large, or overlaps another one.
    pub fn polygons(cells: Vec<(String, Vec<[f64; 2]>)>) -> Result<Self, TerritoryError> {
        let mut outlines: BTreeMap<CellName, Outline> = BTreeMap::new();
        for (name, corners) in cells {
            let name = CellName::new(&name)?;
            let corners =
                corners.iter().map(|&[longitude, latitude]| Corner::of_degrees(longitude, latitude));
            let outline =
                Outline::new(corners.collect()).ok_or_else(|| TerritoryError::Flat(name.clone()))?;
            if outline.radius_m() > RADIUS_MAX_M {
                return Err(TerritoryError::Large { radius_m: outline.radius_m(), name });
            }
            if let Some((other, _)) = outlines.iter().find(|(_, other)| other.overlaps(&outline)) {
                return Err(TerritoryError::Overlap(other.clone(), name));
            }
            if outlines.insert(name.clone(), outline).is_some() {
                return Err(TerritoryError::Twice(name));
            }
        }
        Ok(Self::Polygons(outlines))
    }

    /// The cell that contains a position.
    pub fn cell_of(&self, place: Geodetic) -> Option<CellName> {
        let corner = Corner::from(place);
        match self {
            Self::Grid(step) => {
                let is_covered = corner.latitude.abs() < LATITUDE_MAX_DEG * DEGREE;
                let index = (corner.latitude.div_euclid(*step), corner.longitude.div_euclid(*step));
                is_covered.then(|| CellName::of_square(index))
            }
            Self::Polygons(cells) => {
                cells.iter().find(|(_, outline)| outline.contains(place)).map(|(name, _)| name.clone())
            }
        }
    }

    /// The outline of a cell; `None`: there is no cell with this name.
    pub fn outline(&self, cell: &CellName) -> Option<Outline> {
        match self {
            Self::Grid(step) => {
                let index = cell.square()?;
                let is_there = |of: i64, most: i64| of * step >= -most * DEGREE && of * step < most * DEGREE;
                (is_there(index.0, LATITUDE_MAX_DEG) && is_there(index.1, 180)).then(|| square(*step, index))
            }
            Self::Polygons(cells) => cells.get(cell).cloned(),
        }
    }

    /// The other cells within `within_m` metres of this cell, sorted by name.
    pub fn neighbours(&self, cell: &CellName, within_m: f64) -> Vec<CellName> {
        let Some(own) = self.outline(cell) else { return Vec::new() };
        let is_near = |other: &Outline| own.distance_to_m(other) <= within_m;
        let mut near: Vec<CellName> = match self {
            Self::Grid(step) => {
                let [south, west, north, east] = own.bounds(within_m);
                let around = |low: i64, high: i64| low.div_euclid(*step)..=high.div_euclid(*step);
                let squares =
                    around(south, north).flat_map(|row| around(west, east).map(move |column| (row, column)));
                let turn = 360 * DEGREE / step;
                let names = squares.map(|(row, column)| {
                    CellName::of_square((row, (column - WEST / step).rem_euclid(turn) + WEST / step))
                });
                names.filter(|name| self.outline(name).is_some_and(|other| is_near(&other))).collect()
            }
            Self::Polygons(cells) => {
                cells.iter().filter(|(_, other)| is_near(other)).map(|(name, _)| name.clone()).collect()
            }
        };
        near.sort();
        near.retain(|name| name != cell);
        near
    }

    /// The cells within `within_m` metres of a position, sorted by name, for instance those that a sensor there serves.
    pub fn around(&self, place: Geodetic, within_m: f64) -> Vec<CellName> {
        match self {
            Self::Grid(_) => {
                let Some(own) = self.cell_of(place) else { return Vec::new() };
                let mut near = self.neighbours(&own, within_m);
                near.push(own);
                near.sort();
                near.retain(|cell| self.outline(cell).is_some_and(|cell| cell.is_within(place, within_m)));
                near
            }
            Self::Polygons(cells) => {
                let near = cells.iter().filter(|(_, outline)| outline.is_within(place, within_m));
                near.map(|(name, _)| name.clone()).collect()
            }
        }
    }

    /// The cell of `cells` that contains a position, or else the one of them that is nearest to it.
    pub fn home<'a>(
        &self,
        place: Geodetic,
        cells: impl IntoIterator<Item = &'a CellName>,
    ) -> Option<CellName> {
        let away = |cell: &CellName| Some((self.outline(cell)?.distance_m(place), cell.clone()));
        let nearest = cells
            .into_iter()
            .filter_map(away)
            .min_by(|one, other| one.0.total_cmp(&other.0).then_with(|| one.1.cmp(&other.1)));
        // On a common edge two cells are equally near; the edge belongs to one of them.
        let own = self.cell_of(place).filter(|_| nearest.as_ref().is_some_and(|(away_m, _)| *away_m == 0.0));
        own.or(nearest.map(|(_, cell)| cell))
    }
}

/// A square of a grid; rows are counted from the equator, columns from Greenwich.
fn square(step: i64, (row, column): (i64, i64)) -> Outline {
    let (south, west) = (row * step, column * step);
    let corner = |longitude, latitude| Corner { longitude, latitude };
    let (north, east) = (south + step, west + step);
    Outline::new(vec![corner(west, south), corner(east, south), corner(east, north), corner(west, north)])
        .expect("a square has an area")
}
