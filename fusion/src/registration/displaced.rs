//! Information about a radar's displacement, as the comparison along a track gathers it.

use nalgebra::{Matrix2, Matrix6x2, Vector2};
use serde::{Deserialize, Serialize};

/// Number of axes that show a displacement: azimuth and range.
pub(super) const AXES_OVER_GROUND: usize = 2;

/// Information about the displacement, and together with p, from one axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct PlaceInformation {
    /// Information about p (rows) together with the displacement (columns).
    pub(super) cross: Matrix6x2<f64>,
    pub(super) matrix: Matrix2<f64>,
    pub(super) vector: Vector2<f64>,
}

impl PlaceInformation {
    pub(super) fn none() -> Self {
        Self { cross: Matrix6x2::zeros(), matrix: Matrix2::zeros(), vector: Vector2::zeros() }
    }
}
