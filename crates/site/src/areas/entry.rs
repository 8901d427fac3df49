//! The time at which a straight path enters an area.

use geo::{Coord, Intersects, LinesIter, Point, Rect};

use super::band::BandAmsl;
use super::shape::Shape;
use fusion::frames::Geodetic;

/// WGS-84 ellipsoid: semi-major axis, in metres, and first eccentricity squared.
const SEMI_MAJOR_M: f64 = 6_378_137.0;
const ECCENTRICITY2: f64 = 6.694_379_990_141_317e-3;
/// Maximum time inside an area that counts only as touching it, in seconds.
const GRAZE_S: f64 = 1e-6;

/// Shifts of longitude, in degrees, that continue a path across the antimeridian.
const SHIFTS: [f64; 3] = [0.0, -360.0, 360.0];

/// A straight path at constant speed. Longitude and latitude change linearly, which is accurate to 1 m within a few kilometres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    /// Start: longitude and latitude, in degrees.
    start: Coord,
    /// East and north components, in metres per second.
    velocity: Coord,
    /// Degrees of longitude and of latitude per metre at the start.
    degrees_per_metre: Coord,
    altitude_amsl_m: Option<f64>,
    /// Vertical speed, in metres per second.
    climb: f64,
}

impl Path {
    /// A path from `place`; velocity east, north and up, in metres per second. Without an altitude the height is unknown.
    pub fn new(place: &Geodetic, velocity: [f64; 3], altitude_amsl_m: Option<f64>) -> Self {
        let (sin, cos) = place.latitude.sin_cos();
        let root = (1.0 - ECCENTRICITY2 * sin * sin).sqrt();
        let east_m = (SEMI_MAJOR_M / root + place.height_m) * cos;
        let north_m = SEMI_MAJOR_M * (1.0 - ECCENTRICITY2) / root.powi(3) + place.height_m;
        let [east, north, climb] = velocity;
        Self {
            start: Coord { x: place.longitude_deg(), y: place.latitude_deg() },
            velocity: Coord { x: east, y: north },
            degrees_per_metre: Coord { x: (1.0 / east_m).to_degrees(), y: (1.0 / north_m).to_degrees() },
            altitude_amsl_m,
            climb,
        }
    }

    /// The path turned right by `angle`, in radians.
    pub(super) fn turned(self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let Coord { x, y } = self.velocity;
        Self { velocity: Coord { x: x * cos + y * sin, y: y * cos - x * sin }, ..self }
    }

    /// Change of longitude and latitude, in degrees per second.
    fn rate(&self) -> Coord {
        Coord { x: self.velocity.x * self.degrees_per_metre.x, y: self.velocity.y * self.degrees_per_metre.y }
    }

    /// Boxes, in degrees, that contain the path on any course for `horizon_s` seconds, also across the antimeridian.
    pub(super) fn reach(&self, horizon_s: f64) -> [Rect; 3] {
        /// Margin for rounding errors, in degrees: a tenth of a millimetre.
        const MARGIN_DEG: f64 = 1e-9;
        let reach = self.degrees_per_metre * (self.velocity.x.hypot(self.velocity.y) * horizon_s);
        let reach = reach + Coord { x: MARGIN_DEG, y: MARGIN_DEG };
        self.around_the_earth().map(|path| Rect::new(path.start - reach, path.start + reach))
    }

    /// The path in the three ranges of longitude that meet at the antimeridian.
    fn around_the_earth(&self) -> [Self; 3] {
        SHIFTS.map(|shift| Self { start: self.start + Coord { x: shift, y: 0.0 }, ..*self })
    }

    fn at(&self, seconds: f64) -> Coord {
        self.start + self.rate() * seconds
    }

    /// Longitude and latitude after `seconds`, in degrees.
    #[cfg(test)]
    pub(super) fn place_after(&self, seconds: f64) -> [f64; 2] {
        self.at(seconds).into()
    }
}

/// Time from the start of the path to its first entry, in seconds; `None` if that is beyond the horizon. Exact at the polygon's
/// edges: the path is cut at each edge, and every piece is either inside or outside.
pub(super) fn time_to_entry(shape: &Shape, band: &BandAmsl, path: &Path, horizon_s: f64) -> Option<f64> {
    let (from_s, to_s) = band.within(path.altitude_amsl_m, path.climb, horizon_s)?;
    let first = |path: &Path| first_inside(shape, path, from_s, to_s);
    path.around_the_earth().iter().filter_map(first).min_by(f64::total_cmp)
}

fn first_inside(shape: &Shape, path: &Path, from_s: f64, to_s: f64) -> Option<f64> {
    let begin = path.at(from_s);
    if !shape.bounds.intersects(&Rect::new(begin, path.at(to_s))) {
        return None;
    }
    if shape.contains(&Point(begin)) {
        return Some(from_s);
    }
    let rate = path.rate();
    let crossing = |line: geo::Line| {
        let (edge, to_edge) = (line.delta(), line.start - path.start);
        let across = cross(rate, edge);
        let (time_s, share) = (cross(to_edge, edge) / across, cross(to_edge, rate) / across);
        // Parallel to an edge both are infinite or NaN.
        (time_s > from_s && time_s < to_s && (-1e-9..=1.0 + 1e-9).contains(&share)).then_some(time_s)
    };
    let mut cuts: Vec<f64> = shape.polygon.lines_iter().filter_map(crossing).collect();
    cuts.sort_by(f64::total_cmp);
    let ends = cuts.iter().copied().skip(1).chain([to_s]);
    let is_inside = |&(begin_s, end_s): &(f64, f64)| {
        end_s - begin_s > GRAZE_S && shape.contains(&Point(path.at(0.5 * (begin_s + end_s))))
    };
    cuts.iter().copied().zip(ends).find(is_inside).map(|(begin_s, _)| begin_s)
}

fn cross(a: Coord, b: Coord) -> f64 {
    a.x * b.y - a.y * b.x
}
