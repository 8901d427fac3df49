//! Trails of the last minutes, one position per second, for clients that open the picture now.

use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use super::geometry::GeoPosition;
use super::track_slice::TrackSlice;
use fusion::time::{SECOND, Time};
use input::json::rounded;
use picture::Rfc3339;

/// Maximum length of a trail, in seconds.
pub const LONGEST_S: u32 = 600;
/// Maximum number of places of all tracks together, about 8 MB. 166 tracks have ten minutes each; more tracks have shorter
/// trails.
const PLACES: usize = 100_000;

/// Number of places that cost about as much as a usual request.
pub const PLACES_OF_A_REQUEST: u32 = 5_000;

/// Places of the last seconds, oldest first.
#[derive(Debug, Default)]
pub struct Trails {
    seconds: VecDeque<Arc<TrailSecond>>,
    places: usize,
    /// One shared name per track. The names of the slots would be scattered over the memory.
    names: HashSet<Arc<str>>,
}

/// Places of all tracks in one second.
#[derive(Debug)]
pub struct TrailSecond {
    time: Time,
    places: Vec<(Arc<str>, TrailPoint)>,
}

/// Longitude, latitude and, if measured, ellipsoidal height.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
enum TrailPoint {
    Low([f64; 2]),
    High([f64; 3]),
}

/// Trail of a track: times and places, oldest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "RecentTrail")]
pub struct RecentTrail {
    #[schemars(with = "Vec<Rfc3339>")]
    times: Vec<String>,
    #[schemars(with = "Vec<GeoPosition>")]
    coordinates: Vec<TrailPoint>,
}

impl RecentTrail {
    /// Trail of each track over these seconds.
    pub fn all(seconds: &[Arc<TrailSecond>]) -> HashMap<Arc<str>, Self> {
        let mut trails: HashMap<Arc<str>, Self> = HashMap::new();
        for second in seconds {
            let time = second.time.to_string();
            for (id, place) in &second.places {
                let trail = trails.entry(id.clone()).or_default();
                trail.times.push(time.clone());
                trail.coordinates.push(*place);
            }
        }
        trails
    }

    /// Times with longitude, latitude and, if measured, ellipsoidal height.
    pub fn places(&self) -> impl Iterator<Item = (&str, f64, f64, Option<f64>)> {
        self.times.iter().zip(&self.coordinates).map(|(time, place)| match *place {
            TrailPoint::Low([lng, lat]) => (&**time, lng, lat, None),
            TrailPoint::High([lng, lat, height_m]) => (&**time, lng, lat, Some(height_m)),
        })
    }
}

impl Trails {
    /// Stores the first slot of each second. After a replay jumped back, later seconds are removed.
    pub fn note<'a>(&mut self, time: Time, slices: impl Iterator<Item = &'a TrackSlice>) {
        while self.seconds.back().is_some_and(|second| second.time >= time) {
            self.seconds.pop_back().inspect(|second| self.places -= second.places.len());
        }
        if self.seconds.back().is_some_and(|second| time.nanos() - second.time.nanos() < SECOND) {
            return;
        }
        let names = &mut self.names;
        let place = |slice: &TrackSlice| {
            let [lng, lat] = [rounded(slice.lng, 7), rounded(slice.lat, 7)];
            let high = |height_m| TrailPoint::High([lng, lat, rounded(height_m, 1)]);
            let place = slice.height_m.map_or(TrailPoint::Low([lng, lat]), high);
            let name = names.get(&slice.id).cloned().unwrap_or_else(|| {
                let name = Arc::<str>::from(&*slice.id);
                names.insert(name.clone());
                name
            });
            (name, place)
        };
        let places: Vec<_> = slices.map(place).collect();
        self.places += places.len();
        self.seconds.push_back(Arc::new(TrailSecond { time, places }));
        let oldest = Time::from_nanos(time.nanos() - i64::from(LONGEST_S) * SECOND);
        while self.places > PLACES || self.seconds.front().is_some_and(|second| second.time < oldest) {
            self.seconds.pop_front().inspect(|second| self.places -= second.places.len());
        }
        self.names.retain(|name| Arc::strong_count(name) > 1);
    }

    /// The last `seconds` before `now`.
    pub fn last(&self, seconds: u32, now: Time) -> Vec<Arc<TrailSecond>> {
        let since = now.nanos() - i64::from(seconds) * SECOND;
        let is_wanted = |second: &&Arc<TrailSecond>| second.time.nanos() >= since && second.time < now;
        self.seconds.iter().filter(is_wanted).cloned().collect()
    }

    /// Number of places in the last `seconds`.
    pub fn places(&self, seconds: u32) -> usize {
        let Some(newest) = self.seconds.back() else { return 0 };
        let since = newest.time.nanos() - i64::from(seconds) * SECOND;
        let last = self.seconds.iter().rev().take_while(|second| second.time.nanos() >= since);
        last.map(|second| second.places.len()).sum()
    }
}
