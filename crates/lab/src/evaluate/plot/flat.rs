//! A local flat-Earth frame of some kilometres, around the radar if known.

use super::super::place::GeodeticPlace;
use super::super::types::ErrorSample;
use super::axis::drawable;
use super::figure::{PlotStream, TruthLine};
use input::statistics::quantile;

/// Conversion to metres east and north of an origin.
pub(super) struct Flat {
    /// A place near the origin.
    reference: GeodeticPlace,
    /// Offset of the origin from the reference.
    origin: (f64, f64),
    /// Whether the origin is the first radar; otherwise it is the middle of the true paths.
    pub(super) from_radar: bool,
}

impl Flat {
    /// Frame around the radar that samples are seen from, else around the true paths, else around the points.
    pub(super) fn of(streams: &[PlotStream<'_>], truth: &[TruthLine<'_>]) -> Self {
        let samples = || streams.iter().flat_map(|stream| stream.samples);
        let true_places = || truth.iter().flat_map(|line| line.points).map(|(_, place)| place);
        let known = |place: &&GeodeticPlace| drawable(place.latitude_deg) && drawable(place.longitude_deg);
        let first = true_places().chain(samples().map(|sample| &sample.place)).find(known);
        let reference = first.map_or((0.0, 0.0), |place| (place.latitude_deg, place.longitude_deg));
        let reference =
            GeodeticPlace { latitude_deg: reference.0, longitude_deg: reference.1, altitude_amsl_m: None };
        let mut flat = Self { reference, origin: (0.0, 0.0), from_radar: false };
        let radar = middle(samples().filter_map(|sample| flat.radar_of(sample)), median);
        flat.from_radar = radar.is_some();
        let centre = || middle(true_places().filter_map(|place| flat.position(place)), half_way);
        let points = || middle(samples().filter_map(|sample| flat.position(&sample.place)), half_way);
        flat.origin = radar.or_else(centre).or_else(points).unwrap_or_default();
        flat
    }

    /// Metres east and north of the origin; `None` if the place cannot be drawn.
    pub(super) fn position(&self, place: &GeodeticPlace) -> Option<(f64, f64)> {
        let offset = place.offset_from(&self.reference);
        let (east, north) = (offset.east_m - self.origin.0, offset.north_m - self.origin.1);
        (drawable(east) && drawable(north)).then_some((east, north))
    }

    /// Position of the radar that sees a drone, computed from the sample, its error, and the range and azimuth of the
    /// drone.
    fn radar_of(&self, sample: &ErrorSample) -> Option<(f64, f64)> {
        let (seen, error) = (sample.seen?, sample.error?);
        let (east, north) = self.position(&sample.place)?;
        let (sin, cos) = seen.azimuth_deg.to_radians().sin_cos();
        let (east, north) =
            (east - error.east_m - seen.range_m * sin, north - error.north_m - seen.range_m * cos);
        (drawable(east) && drawable(north)).then_some((east, north))
    }
}

/// Middle of points, per axis.
fn middle(points: impl Iterator<Item = (f64, f64)>, of: fn(&mut [f64]) -> f64) -> Option<(f64, f64)> {
    let (mut east, mut north): (Vec<f64>, Vec<f64>) = points.unzip();
    (!east.is_empty()).then(|| (of(&mut east), of(&mut north)))
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    quantile(values, 0.5).unwrap_or_default()
}

fn half_way(values: &mut [f64]) -> f64 {
    let (low, high) =
        values.iter().fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(*value), high.max(*value)));
    0.5 * (low + high)
}
