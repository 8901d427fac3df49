//! True paths of the drones.

use std::collections::BTreeMap;

use super::place::GeodeticPlace;
use fusion::time::{SECOND, Time};

/// Two samples further apart than this bound a hole, in which the drone's position is unknown, nanoseconds.
const HOLE_NS: i64 = 5 * SECOND;

/// Minimum rate of change of the course of a turning drone, degrees per second. `simulate` uses the same limit for the
/// radar's errors in turns.
const TURNS_DEG_S: f64 = 4.0;
/// Minimum speed for a course to be meaningful, metres per second; a slower drone hovers.
const MOVES_M_S: f64 = 2.0;

/// True tracks of all drones, in the order of their ids.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    tracks: Vec<TrueTrack>,
}

/// True track of one drone.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueTrack {
    id: String,
    /// Samples by time, with distinct times; never empty.
    samples: Vec<(Time, GeodeticPlace)>,
}

impl Truth {
    /// Builds the truth from each drone's samples, in any order. Of two samples with the same time, the last counts.
    /// Entries with the same id are one drone, and an id without samples is dropped.
    pub fn new(tracks: impl IntoIterator<Item = (String, Vec<(Time, GeodeticPlace)>)>) -> Self {
        let mut by_id: BTreeMap<String, BTreeMap<Time, GeodeticPlace>> = BTreeMap::new();
        for (id, samples) in tracks {
            if !samples.is_empty() {
                by_id.entry(id).or_default().extend(samples);
            }
        }
        let track =
            |(id, samples): (String, BTreeMap<_, _>)| TrueTrack { id, samples: Vec::from_iter(samples) };
        Self { tracks: by_id.into_iter().map(track).collect() }
    }

    /// The drones, by id.
    pub fn tracks(&self) -> &[TrueTrack] {
        &self.tracks
    }

    /// Index in [`Truth::tracks`] of the drone with this id.
    pub fn index_of(&self, id: &str) -> Option<usize> {
        self.tracks.binary_search_by(|track| track.id.as_str().cmp(id)).ok()
    }

    /// Times of the first and last sample of any drone; `None` without drones.
    pub fn span(&self) -> Option<(Time, Time)> {
        let first = self.tracks.iter().map(|track| track.span().0).min()?;
        let last = self.tracks.iter().map(|track| track.span().1).max()?;
        Some((first, last))
    }
}

impl TrueTrack {
    /// Id of the drone.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// Samples, by time.
    pub fn samples(&self) -> &[(Time, GeodeticPlace)] {
        &self.samples
    }

    /// First and last time.
    pub fn span(&self) -> (Time, Time) {
        (self.samples[0].0, self.samples[self.samples.len() - 1].0)
    }

    /// Position, interpolated linearly; `None` outside the span and inside holes (samples more than 5 s apart).
    pub fn at(&self, time: Time) -> Option<GeodeticPlace> {
        let ((before, from), (after, to)) = self.around(time)?;
        let length_ns = after.nanos() - before.nanos();
        (length_ns <= HOLE_NS)
            .then(|| between(from, to, time.seconds_since(before), after.seconds_since(before)))
    }

    /// Whether the drone turns at `time`: its mean courses over the second before and the second after differ by more
    /// than the limit. `None` if the position is unknown in either second.
    pub(crate) fn turns(&self, time: Time) -> Option<bool> {
        let at = |later_ns: i64| self.at(Time::from_nanos(time.nanos() + later_ns));
        let (before, now, after) = (at(-SECOND)?, at(0)?, at(SECOND)?);
        let (to, from) = (now.offset_from(&before), after.offset_from(&now));
        let moves = to.horizontal_m() > MOVES_M_S && from.horizontal_m() > MOVES_M_S;
        let across = to.east_m * from.north_m - to.north_m * from.east_m;
        let along = to.east_m * from.east_m + to.north_m * from.north_m;
        Some(moves && across.atan2(along).to_degrees().abs() > TURNS_DEG_S)
    }

    /// Mean speed over ground in the second around `time`, metres per second; `None` if the position is unknown.
    pub(crate) fn speed_m_s(&self, time: Time) -> Option<f64> {
        let at = |later_ns: i64| self.at(Time::from_nanos(time.nanos() + later_ns));
        Some(at(SECOND / 2)?.offset_from(&at(-SECOND / 2)?).horizontal_m())
    }

    /// Position, interpolated across holes; `None` outside the span.
    pub(super) fn at_or_across_hole(&self, time: Time) -> Option<GeodeticPlace> {
        let ((before, from), (after, to)) = self.around(time)?;
        Some(between(from, to, time.seconds_since(before), after.seconds_since(before)))
    }

    /// Holes: times of the last sample before and of the first sample after each.
    pub fn holes(&self) -> impl Iterator<Item = (Time, Time)> + '_ {
        let pairs = self.samples.windows(2).map(|pair| (pair[0].0, pair[1].0));
        pairs.filter(|(from, to)| to.nanos() - from.nanos() > HOLE_NS)
    }

    /// Samples on either side; at a sample's own time, the same sample twice.
    fn around(&self, time: Time) -> Option<((Time, GeodeticPlace), (Time, GeodeticPlace))> {
        let next = self.samples.partition_point(|sample| sample.0 < time);
        let after = *self.samples.get(next)?;
        if after.0 == time {
            return Some((after, after));
        }
        Some((self.samples[next.checked_sub(1)?], after))
    }
}

/// Position after `elapsed_s` of `length_s`; with a height only if both ends have one.
fn between(from: GeodeticPlace, to: GeodeticPlace, elapsed_s: f64, length_s: f64) -> GeodeticPlace {
    if length_s <= 0.0 {
        return from;
    }
    let share = elapsed_s / length_s;
    // The short way round, across the antimeridian if necessary.
    let east_deg = (to.longitude_deg - from.longitude_deg + 180.0).rem_euclid(360.0) - 180.0;
    let longitude_deg = (from.longitude_deg + share * east_deg + 180.0).rem_euclid(360.0) - 180.0;
    GeodeticPlace {
        latitude_deg: from.latitude_deg + share * (to.latitude_deg - from.latitude_deg),
        longitude_deg,
        altitude_amsl_m: from
            .altitude_amsl_m
            .zip(to.altitude_amsl_m)
            .map(|(from_m, to_m)| from_m + share * (to_m - from_m)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_s(second: f64) -> Time {
        Time::from_nanos((second * 1e9) as i64)
    }

    fn place(latitude_deg: f64, longitude_deg: f64, altitude: Option<f64>) -> GeodeticPlace {
        GeodeticPlace { latitude_deg, longitude_deg, altitude_amsl_m: altitude }
    }

    fn one(samples: &[(f64, GeodeticPlace)]) -> Truth {
        let samples = samples.iter().map(|&(second, place)| (at_s(second), place)).collect();
        Truth::new([("A".to_owned(), samples)])
    }

    #[test]
    fn places_are_linear_between_samples_whatever_their_order() {
        let truth = one(&[
            (4.0, place(50.0, 9.0, Some(40.0))),
            (0.0, place(50.0, 8.0, Some(0.0))),
            (0.0, place(50.0, 8.0, Some(20.0))),
        ]);
        let track = &truth.tracks()[0];
        assert_eq!(
            track.at(at_s(1.0)),
            Some(place(50.0, 8.25, Some(25.0))),
            "the last sample of a time counts"
        );
        assert_eq!(track.at(at_s(0.0)), Some(place(50.0, 8.0, Some(20.0))));
        assert_eq!(track.at(at_s(4.0)), Some(place(50.0, 9.0, Some(40.0))));
        assert_eq!((track.at(at_s(-0.1)), track.at(at_s(4.1))), (None, None));
    }

    #[test]
    fn a_hole_is_longer_than_five_seconds_and_has_ends() {
        let (a, b) = (place(50.0, 8.0, None), place(50.0, 9.0, Some(1.0)));
        let truth = one(&[(0.0, a), (5.0, b), (10.1, b), (11.0, b)]);
        let track = &truth.tracks()[0];
        assert_eq!(track.at(at_s(2.5)), Some(place(50.0, 8.5, None)), "5 s are no hole");
        assert_eq!(
            [5.0, 5.1, 10.0, 10.1].map(|second| track.at(at_s(second)).is_some()),
            [true, false, false, true]
        );
        assert_eq!(track.at_or_across_hole(at_s(6.0)), Some(b));
        assert_eq!(track.holes().collect::<Vec<_>>(), [(at_s(5.0), at_s(10.1))]);
    }

    #[test]
    fn a_turn_is_a_change_of_course_in_motion() {
        // A circle at `rate_deg_s` and `speed_m_s`; half a millionth of a degree is 5.6 cm.
        let circling = |rate_deg_s: f64, speed_m_s: f64| {
            let radius_deg = speed_m_s / rate_deg_s.to_radians() / 111_320.0;
            let on_circle = |step: i32| {
                let second = f64::from(step) * 0.1;
                let (sin, cos) = (rate_deg_s * second).to_radians().sin_cos();
                (second, place(radius_deg * sin, radius_deg * cos, None))
            };
            let truth = one(&(0..=40).map(on_circle).collect::<Vec<_>>());
            truth.tracks()[0].turns(at_s(2.0))
        };
        assert_eq!([3.9, 4.1, -4.1].map(|rate| circling(rate, 10.0)), [Some(false), Some(true), Some(true)]);
        assert_eq!(circling(60.0, 1.9), Some(false), "it hovers");
        let still = one(&[(0.0, place(0.0, 0.0, None)), (4.0, place(0.0, 0.0, None))]);
        assert_eq!(
            [0.9, 1.0, 3.1].map(|second| still.tracks()[0].turns(at_s(second))),
            [None, Some(false), None]
        );
    }

    #[test]
    fn the_antimeridian_is_no_way_round_the_world() {
        let truth = one(&[(0.0, place(0.0, 179.0, None)), (1.0, place(0.0, -179.0, None))]);
        let longitude = truth.tracks()[0].at(at_s(0.75)).unwrap().longitude_deg;
        assert!((longitude + 179.5).abs() < 1e-9, "{longitude}");
    }

    #[test]
    fn drones_are_in_the_order_of_their_ids_and_each_is_one() {
        let sample = |second| (at_s(second), place(0.0, 0.0, None));
        let tracks =
            [("B", vec![sample(1.0)]), ("A", vec![sample(7.0)]), ("B", vec![sample(0.0)]), ("C", vec![])];
        let truth = Truth::new(tracks.map(|(id, samples)| (id.to_owned(), samples)));
        assert_eq!(truth.tracks().iter().map(TrueTrack::id).collect::<Vec<_>>(), ["A", "B"]);
        assert_eq!((truth.index_of("B"), truth.index_of("C")), (Some(1), None));
        assert_eq!(truth.tracks()[1].span(), (at_s(0.0), at_s(1.0)));
        assert_eq!(truth.span(), Some((at_s(0.0), at_s(7.0))));
    }
}
