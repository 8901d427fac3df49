//! The outline of a cell: a polygon in longitude and latitude, so that adjacent cells share their edges exactly.

use serde::{Deserialize, Serialize};

use fusion::frames::Geodetic;

/// Nanodegrees per degree.
pub(super) const DEGREE: i64 = 1_000_000_000;
const TURN: i64 = 360 * DEGREE;

/// A position on the ground, in nanodegrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Corner {
    pub(super) longitude: i64,
    pub(super) latitude: i64,
}

impl Corner {
    pub(super) fn of_degrees(longitude: f64, latitude: f64) -> Self {
        let whole = |degrees: f64| (degrees * DEGREE as f64).round() as i64;
        Self { longitude: whole(longitude), latitude: whole(latitude) }.near(0)
    }

    /// This position with its longitude shifted by full turns into the half turn on either side of `longitude`.
    fn near(self, longitude: i64) -> Self {
        let away = (self.longitude - longitude + TURN / 2).rem_euclid(TURN) - TURN / 2;
        Self { longitude: longitude + away, ..self }
    }
}

impl From<Geodetic> for Corner {
    fn from(place: Geodetic) -> Self {
        Self::of_degrees(place.longitude_deg(), place.latitude_deg())
    }
}

/// The outline of a cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outline {
    corners: Vec<Corner>,
    centre: Corner,
    /// Metres per nanodegree of longitude and of latitude at the centre.
    scale_m: [f64; 2],
}

impl Outline {
    /// An outline with these corners, in order; `None`: it has no area.
    pub(super) fn new(corners: Vec<Corner>) -> Option<Self> {
        let first = corners.first()?.longitude;
        let corners: Vec<Corner> = corners.into_iter().map(|corner| corner.near(first)).collect();
        let middle = |of: fn(&Corner) -> i64| {
            let (low, high) = (corners.iter().map(of).min()?, corners.iter().map(of).max()?);
            Some(low + (high - low) / 2)
        };
        let centre = Corner { longitude: middle(|at| at.longitude)?, latitude: middle(|at| at.latitude)? };
        let latitude = centre.latitude as f64 / DEGREE as f64;
        let place = Geodetic::from_degrees(latitude, 0.0, 0.0);
        let (meridian_m, prime_vertical_m) = place.curvature_m();
        let radians = 1.0_f64.to_radians() / DEGREE as f64;
        let scale_m = [prime_vertical_m * place.latitude.cos() * radians, meridian_m * radians];
        let outline = Self { corners, centre, scale_m };
        (outline.corners.len() >= 3 && outline.doubled_area() != 0).then_some(outline)
    }

    fn doubled_area(&self) -> i128 {
        self.edges().map(|(from, to)| cross(self.centre, from, to)).sum()
    }

    fn edges(&self) -> impl Iterator<Item = (Corner, Corner)> {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().copied().zip(next.copied())
    }

    /// The centre of its bounds, on the ellipsoid.
    pub fn centre(&self) -> Geodetic {
        let degrees = |nanodegrees: i64| nanodegrees as f64 / DEGREE as f64;
        Geodetic::from_degrees(degrees(self.centre.latitude), degrees(self.centre.longitude), 0.0)
    }

    /// The corners: longitude and latitude, in degrees.
    pub fn corners_deg(&self) -> Vec<[f64; 2]> {
        let degrees = |nanodegrees: i64| nanodegrees as f64 / DEGREE as f64;
        self.corners.iter().map(|corner| [degrees(corner.longitude), degrees(corner.latitude)]).collect()
    }

    /// Distance from the centre to the farthest corner, in metres.
    pub fn radius_m(&self) -> f64 {
        let away = |corner: &Corner| self.vector_m(self.centre, *corner);
        self.corners
            .iter()
            .map(|corner| {
                let [x, y] = away(corner);
                x.hypot(y)
            })
            .fold(0.0, f64::max)
    }

    /// Whether a position is inside; the western and southern edges belong to the cell.
    pub fn contains(&self, place: Geodetic) -> bool {
        self.holds(Corner::from(place))
    }

    fn holds(&self, corner: Corner) -> bool {
        let at = corner.near(self.centre.longitude);
        // The edges crossed by a line to the west, calculated exactly.
        let is_crossed = |(from, to): &(Corner, Corner)| {
            let (low, high) = if from.latitude <= to.latitude { (from, to) } else { (to, from) };
            low.latitude <= at.latitude && at.latitude < high.latitude && cross(at, *low, *high) <= 0
        };
        self.edges().filter(is_crossed).count() % 2 == 1
    }

    /// Whether a position is inside, or at most `metres` outside.
    pub fn is_within(&self, place: Geodetic, metres: f64) -> bool {
        self.contains(place) || self.distance_m(place) <= metres
    }

    /// Distance of a position from the cell, in metres; 0 inside.
    pub fn distance_m(&self, place: Geodetic) -> f64 {
        if self.contains(place) { 0.0 } else { self.to_edge_m(Corner::from(place)) }
    }

    /// Distance of a position from the nearest edge, in metres, inside or outside.
    pub fn edge_m(&self, place: Geodetic) -> f64 {
        self.to_edge_m(Corner::from(place))
    }

    fn to_edge_m(&self, corner: Corner) -> f64 {
        let at = corner.near(self.centre.longitude);
        let to_edge = |(from, to): (Corner, Corner)| {
            let ([ax, ay], [bx, by]) = (self.vector_m(at, from), self.vector_m(at, to));
            let (dx, dy) = (bx - ax, by - ay);
            let along = (-(ax * dx + ay * dy) / (dx * dx + dy * dy).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            (ax + along * dx).hypot(ay + along * dy)
        };
        self.edges().map(to_edge).fold(f64::INFINITY, f64::min)
    }

    /// Distance of another cell, in metres; 0 if they touch.
    pub(super) fn distance_to_m(&self, other: &Self) -> f64 {
        let to_corners = other.corners.iter().map(|corner| self.to_edge_m(*corner));
        let from_corners = self.corners.iter().map(|corner| other.to_edge_m(*corner));
        to_corners.chain(from_corners).fold(f64::INFINITY, f64::min)
    }

    /// Whether the cells have an area in common.
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        let at = |corner: Corner| corner.near(self.centre.longitude);
        let side = |from, to, corner| cross(from, to, corner).signum();
        let is_cut = |(a, b): (Corner, Corner), (c, d): (Corner, Corner)| {
            let (c, d) = (at(c), at(d));
            side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0
        };
        self.edges().any(|own| other.edges().any(|edge| is_cut(own, edge)))
            || self.has_inside(other)
            || other.has_inside(self)
    }

    /// Whether a corner of `other`, the midpoint of one of its edges, or its centre is strictly inside.
    fn has_inside(&self, other: &Self) -> bool {
        let is_inside = |corner: Corner| {
            let at = corner.near(self.centre.longitude);
            let is_on = |(from, to): (Corner, Corner)| {
                let between = |of: fn(&Corner) -> i64| {
                    (of(&from).min(of(&to))..=of(&from).max(of(&to))).contains(&of(&at))
                };
                // Midpoints are rounded: they deviate by less than two nanodegrees.
                let length = (to.longitude - from.longitude).abs().max((to.latitude - from.latitude).abs());
                cross(from, to, at).abs() <= 2 * i128::from(length)
                    && between(|corner| corner.longitude)
                    && between(|corner| corner.latitude)
            };
            self.holds(at) && !self.edges().any(is_on)
        };
        let middle = |(from, to): (Corner, Corner)| Corner {
            longitude: from.longitude + (to.longitude - from.longitude) / 2,
            latitude: from.latitude + (to.latitude - from.latitude) / 2,
        };
        let own_middle = other.holds(other.centre).then_some(other.centre);
        other.corners.iter().copied().chain(other.edges().map(middle)).chain(own_middle).any(is_inside)
    }

    /// Southern, western, northern and eastern limit of the cell with a margin of `within_m` metres, in nanodegrees.
    pub(super) fn bounds(&self, within_m: f64) -> [i64; 4] {
        let [east, north] = self.scale_m.map(|scale_m| (within_m / scale_m).ceil() as i64);
        let range = |of: fn(&Corner) -> i64, more: i64| {
            let (low, high) = (self.corners.iter().map(of).min(), self.corners.iter().map(of).max());
            // Cells that only touch the margin are included.
            (low.unwrap_or_default() - more - 1, high.unwrap_or_default() + more + 1)
        };
        let ((south, north), (west, east)) = (range(|at| at.latitude, north), range(|at| at.longitude, east));
        [south, west, north, east]
    }

    fn vector_m(&self, from: Corner, to: Corner) -> [f64; 2] {
        let [east_m, north_m] = self.scale_m;
        let (east, north) = (to.longitude - from.longitude, to.latitude - from.latitude);
        [east as f64 * east_m, north as f64 * north_m]
    }
}

/// Twice the area of a triangle; positive if counterclockwise.
fn cross(at: Corner, from: Corner, to: Corner) -> i128 {
    let vector = |corner: Corner| {
        (i128::from(corner.longitude - at.longitude), i128::from(corner.latitude - at.latitude))
    };
    let ((ax, ay), (bx, by)) = (vector(from), vector(to));
    ax * by - ay * bx
}
