//! A track as answers are put together of it.

use std::sync::{Arc, OnceLock};

use axum::body::Bytes;

/// Where a track can come from.
pub const SOURCES: [&str; 3] = ["fused", "radar", "transponder"];

/// A track's feature, and what filters ask of it.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Index in the picture.
    pub(super) index: usize,
    /// The track's id.
    pub id: Arc<str>,
    /// One of [`SOURCES`].
    pub source: &'static str,
    /// Degrees.
    pub lng: f64,
    /// Degrees.
    pub lat: f64,
    /// Metres above mean sea level, where it was measured.
    pub alt_msl: Option<f64>,
    /// Metres above the ellipsoid, where it was measured.
    pub height_m: Option<f64>,
    /// Radius that holds 95 % of its horizontal errors, metres, where no sensor measured it in its slot.
    pub unmeasured_accuracy_m: Option<f64>,
    pub(super) radar: Option<usize>,
    pub(super) transponder: Option<usize>,
    /// Whether it differs from the slot before.
    pub is_new: bool,
    /// The GeoJSON feature, without competitors.
    pub(super) feature: Bytes,
    /// With them, once somebody has asked for them.
    pub(super) full: OnceLock<Bytes>,
}

impl Piece {
    /// The sensors that took part, as indices.
    pub fn sensors(&self) -> impl Iterator<Item = usize> {
        self.radar.into_iter().chain(self.transponder)
    }
}
