//! A spatial index: finds the places near a given one.

use super::place::GeodeticPlace;
use super::truth::Truth;
use fusion::time::Time;

/// Minimum length of a degree along the meridian, metres (110.57 km at the equator).
const METRES_A_DEGREE: f64 = 110_000.0;

/// Bounding rectangle of a place or a path, in degrees.
#[derive(Clone, Copy, Debug)]
struct Extent {
    index: usize,
    south_deg: f64,
    north_deg: f64,
    /// Middle and half width in longitude, which are valid across the antimeridian.
    longitude_deg: f64,
    half_width_deg: f64,
}

/// Bounding rectangles, sorted by their southern ends.
#[derive(Clone, Debug, Default)]
pub(super) struct Nearby {
    extents: Vec<Extent>,
    /// Largest south-to-north size of a rectangle, degrees.
    tallest_deg: f64,
}

impl Nearby {
    /// Index of single places.
    pub(super) fn of_places<'a>(places: impl IntoIterator<Item = &'a GeodeticPlace>) -> Self {
        let extents = places.into_iter().enumerate();
        Self::new(extents.filter_map(|(index, place)| Extent::of(index, std::iter::once(*place))).collect())
    }

    /// Index of the drones' paths between two times. Holes of the truth are bridged by straight lines.
    pub(super) fn of_truth(truth: &Truth, from: Time, until: Time) -> Self {
        let extent = |(index, track): (usize, &super::TrueTrack)| {
            let samples = track.samples();
            let first = samples.partition_point(|sample| sample.0 < from);
            let last = samples.partition_point(|sample| sample.0 <= until);
            let ends = [from, until].into_iter().filter_map(|time| track.at_or_across_hole(time));
            Extent::of(index, ends.chain(samples[first..last].iter().map(|sample| sample.1)))
        };
        Self::new(truth.tracks().iter().enumerate().filter_map(extent).collect())
    }

    fn new(mut extents: Vec<Extent>) -> Self {
        extents.sort_by(|a, b| a.south_deg.total_cmp(&b.south_deg));
        let tallest_deg =
            extents.iter().map(|extent| extent.north_deg - extent.south_deg).fold(0.0, f64::max);
        Self { extents, tallest_deg }
    }

    /// Indices of all candidates within `reach_m` of `place`. None is missing; some may be further away.
    pub(super) fn within(&self, place: GeodeticPlace, reach_m: f64) -> impl Iterator<Item = usize> + '_ {
        let reach_deg = reach_m / METRES_A_DEGREE;
        let (south_deg, north_deg) = (place.latitude_deg - reach_deg, place.latitude_deg + reach_deg);
        let first = self.extents.partition_point(|extent| extent.south_deg < south_deg - self.tallest_deg);
        // The parallel is shortest at the end nearer to the pole.
        let parallel = south_deg.abs().max(north_deg.abs()).to_radians().cos();
        let sideways_deg = if parallel > 1e-3 { reach_deg / parallel } else { 360.0 };
        self.extents[first..]
            .iter()
            .take_while(move |extent| extent.south_deg <= north_deg)
            .filter(move |extent| {
                let aside_deg = wrapped(place.longitude_deg - extent.longitude_deg).abs();
                extent.north_deg >= south_deg && aside_deg <= extent.half_width_deg + sideways_deg
            })
            .map(|extent| extent.index)
    }
}

impl Extent {
    fn of(index: usize, mut places: impl Iterator<Item = GeodeticPlace>) -> Option<Self> {
        let first = places.next()?;
        let (mut south_deg, mut north_deg) = (first.latitude_deg, first.latitude_deg);
        let (mut west_deg, mut east_deg) = (0.0_f64, 0.0_f64);
        for place in places {
            south_deg = south_deg.min(place.latitude_deg);
            north_deg = north_deg.max(place.latitude_deg);
            let aside_deg = wrapped(place.longitude_deg - first.longitude_deg);
            west_deg = west_deg.min(aside_deg);
            east_deg = east_deg.max(aside_deg);
        }
        Some(Self {
            index,
            south_deg,
            north_deg,
            longitude_deg: first.longitude_deg + 0.5 * (west_deg + east_deg),
            // Margin for rounding.
            half_width_deg: 0.5 * (east_deg - west_deg) + 1e-9,
        })
    }
}

/// Wraps an angle to -180 to 180 degrees.
fn wrapped(angle_deg: f64) -> f64 {
    (angle_deg + 180.0).rem_euclid(360.0) - 180.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn nothing_near_is_missed(
            origin in prop::sample::select(vec![(52.0, -0.5), (0.0, 179.9999), (-70.0, -180.0), (80.0, 10.0)]),
            offsets in prop::collection::vec((-0.004..0.004_f64, -0.02..0.02_f64), 1..40),
        ) {
            let places: Vec<GeodeticPlace> = offsets.iter().map(|offset| GeodeticPlace {
                latitude_deg: origin.0 + offset.0,
                longitude_deg: wrapped(origin.1 + offset.1),
                altitude_amsl_m: None,
            }).collect();
            let nearby = Nearby::of_places(&places);
            let mut found: Vec<usize> = nearby.within(places[0], 150.0).collect();
            found.sort_unstable();
            found.retain(|&index| places[0].offset_from(&places[index]).horizontal_m() < 150.0);
            let all = 0..places.len();
            let near = |index: &usize| places[0].offset_from(&places[*index]).horizontal_m() < 150.0;
            prop_assert_eq!(found, all.filter(near).collect::<Vec<_>>());
        }
    }

    #[test]
    fn drone_is_near_along_its_whole_path() {
        let at = |second: i64, latitude_deg: f64| {
            let place = GeodeticPlace { latitude_deg, longitude_deg: 8.0, altitude_amsl_m: None };
            (Time::from_nanos(second * fusion::time::SECOND), place)
        };
        // North by a degree and back again.
        let truth = Truth::new([("A".to_owned(), vec![at(0, 50.0), at(1, 51.0), at(2, 50.0)])]);
        let near = |from: i64, until: i64, latitude_deg: f64| {
            let nearby = Nearby::of_truth(&truth, at(from, 0.0).0, at(until, 0.0).0);
            nearby.within(at(0, latitude_deg).1, 150.0).next().is_some()
        };
        assert!(near(0, 2, 51.001) && near(0, 2, 50.5) && !near(0, 2, 51.01) && !near(0, 2, 49.99));
        assert!(!near(3, 4, 50.0), "it has landed");
    }
}
