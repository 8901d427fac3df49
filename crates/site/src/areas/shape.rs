//! Polygons, and circles as polygons.

use std::f64::consts::PI;

use geo::{
    Area, BoundingRect, Destination, Geodesic, Geometry, Intersects, LineString, LinesIter, MultiPolygon,
    Point, Polygon, Rect,
};
use serde_json::{Value, json};

use super::member::Member;

/// Number of corners of a circle's polygon; these are outside of the circle by 1/6500 of its radius.
const CORNERS: usize = 180;
/// Error message for a polygon that exceeds the range of coordinates.
const BEYOND: &str = "holds a position beyond ±180 degrees of longitude or ±90 of latitude";

/// Minimum area of a polygon, in square degrees: a hundredth of a square metre.
const LEAST_AREA: f64 = 1e-12;
/// Maximum length of an edge, in degrees of longitude. The direction of a longer one around the Earth would be ambiguous.
const LONGEST_EDGE_DEG: f64 = 180.0;

/// Polygons that form one shape, with their bounding box. Edges are straight in longitude and latitude, in degrees.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shape {
    pub(super) bounds: Rect,
    pub(super) polygon: MultiPolygon,
}

impl Shape {
    /// Refuses a polygon that is empty, has no area, exceeds the range of coordinates, or has an edge of ambiguous direction.
    pub(super) fn new(polygon: MultiPolygon) -> Result<Self, String> {
        let bounds = polygon.bounding_rect().ok_or("holds an empty polygon")?;
        let (min, max) = (bounds.min(), bounds.max());
        let is_on_earth = min.x >= -180.0 && max.x <= 180.0 && min.y >= -90.0 && max.y <= 90.0;
        if !is_on_earth {
            let is_swapped = min.x >= -90.0 && max.x <= 90.0 && min.y >= -180.0 && max.y <= 180.0;
            let swapped = if is_swapped { "; latitude and longitude seem to be swapped" } else { "" };
            return Err(format!("{BEYOND}{swapped}"));
        }
        // An edge along a pole has no length, whatever its extent in degrees.
        let is_polar = |line: &geo::Line| line.start.y == line.end.y && line.start.y.abs() == 90.0;
        let is_long = |line: &geo::Line| line.dx().abs() > LONGEST_EDGE_DEG && !is_polar(line);
        if let Some(line) = polygon.lines_iter().find(is_long) {
            let (from, to) = (line.start.x, line.end.x);
            return Err(format!(
                "has an edge from longitude {from} to {to}: a polygon over the antimeridian has to be cut in two at 180 \
                 degrees (RFC 7946, section 3.1.9), and an edge may not be longer than 180 degrees"
            ));
        }
        if polygon.unsigned_area() < LEAST_AREA {
            return Err("has no area: its corners are one place or lie on one line".to_owned());
        }
        Ok(Self { bounds, polygon })
    }

    /// The shape of a GeoJSON polygon; its other members are ignored.
    pub(super) fn of(geometry: &Value) -> Result<Self, String> {
        let plain = json!({ "type": geometry["type"], "coordinates": geometry["coordinates"] });
        let geometry: Result<geojson::Geometry, _> = serde_json::from_value(plain);
        let geometry = geometry.map_err(|cause| format!("is no GeoJSON: {cause}"))?;
        match Geometry::try_from(geometry).map_err(|cause| format!("is no GeoJSON: {cause}"))? {
            Geometry::Polygon(polygon) => Self::new(polygon.into()),
            Geometry::MultiPolygon(polygons) => Self::new(polygons),
            _ => Err("holds something that is no polygon".to_owned()),
        }
    }

    /// A circle about `centre` (longitude, latitude) with the `radius` of `extent`, in metres.
    pub(super) fn circle_of(centre: &Member<'_>, extent: &Member<'_>) -> Result<Self, String> {
        let radius_m = extent.need("radius", "a circle has a radius")?.number()?;
        match &centre.entries()[..] {
            [longitude, latitude, ..] => Self::circle(longitude.number()?, latitude.number()?, radius_m),
            _ => Err(centre.refused("a centre is longitude and latitude")),
        }
    }

    /// A polygon that encloses a circle on the ellipsoid, cut at the antimeridian.
    pub(super) fn circle(longitude_deg: f64, latitude_deg: f64, radius_m: f64) -> Result<Self, String> {
        const LARGEST_M: f64 = 1_000_000.0;
        /// Lower bound of the length of a degree of latitude, in metres.
        const DEGREE_M: f64 = 110_000.0;
        if longitude_deg.abs() > 180.0 || latitude_deg.abs() > 90.0 {
            return Err(BEYOND.to_owned());
        }
        if !(radius_m > 0.0 && radius_m <= LARGEST_M) {
            return Err(format!("has a circle whose radius is not between 0 and {LARGEST_M} m"));
        }
        if latitude_deg.abs() + radius_m / DEGREE_M >= 90.0 {
            return Err("has a circle around a pole".to_owned());
        }
        let centre = Point::new(longitude_deg, latitude_deg);
        let distance_m = radius_m / (PI / CORNERS as f64).cos();
        let corner = |number: usize| {
            // Counterclockwise from north.
            let place = Geodesic.destination(centre, -360.0 * number as f64 / CORNERS as f64, distance_m);
            // The longitude continued across the antimeridian, so that the ring is closed around the centre.
            let apart = (place.x() - longitude_deg + 180.0).rem_euclid(360.0) - 180.0;
            [longitude_deg + apart, place.y()]
        };
        let ring: Vec<[f64; 2]> = (0..CORNERS).map(corner).collect();
        let polygon = |ring: Vec<[f64; 2]>| Polygon::new(LineString::from(ring), Vec::new());
        Self::new(MultiPolygon::new(on_map(&ring).into_iter().map(polygon).collect()))
    }

    /// Whether a position is inside the shape or on an edge.
    pub(super) fn contains(&self, place: &Point) -> bool {
        self.bounds.intersects(place) && self.polygon.intersects(place)
    }
}

/// The parts of a convex ring (not closed) on the map: west of -180 degrees of longitude, between, and east of 180 degrees. The
/// outer parts are moved onto the map.
pub fn on_map(ring: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
    let parts = [(-540.0, -180.0, 360.0), (-180.0, 180.0, 0.0), (180.0, 540.0, -360.0)];
    let part = |(west, east, shift): (f64, f64, f64)| {
        let mut part = cut(&cut(ring, west, 1.0), east, -1.0);
        part.iter_mut().for_each(|place| place[0] += shift);
        (part.len() > 2).then_some(part)
    };
    parts.into_iter().filter_map(part).collect()
}

/// The part of a convex ring east (`side` 1) or west (`side` -1) of a meridian.
fn cut(ring: &[[f64; 2]], meridian: f64, side: f64) -> Vec<[f64; 2]> {
    let mut kept = Vec::new();
    for (index, &here) in ring.iter().enumerate() {
        let before = ring[(index + ring.len() - 1) % ring.len()];
        let inside = |place: [f64; 2]| (place[0] - meridian) * side >= 0.0;
        if inside(here) != inside(before) {
            let share = (meridian - before[0]) / (here[0] - before[0]);
            kept.push([meridian, before[1] + share * (here[1] - before[1])]);
        }
        if inside(here) {
            kept.push(here);
        }
    }
    kept
}
