//! Trails of the last minutes, one position per second: for readers that open the picture now.

use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use super::geometry::Position;
use super::piece::Piece;
use crate::json::rounded;
use crate::picture::Rfc3339;
use fusion::time::{SECOND, Time};

/// A trail is no longer than this, seconds.
pub const LONGEST_S: u32 = 600;
/// Places that are kept of all tracks together, some 8 MB: 166 tracks have ten minutes, where there are more their trails are
/// shorter.
const PLACES: usize = 100_000;

/// Places that cost about as much as a usual request.
pub const PLACES_OF_A_REQUEST: u32 = 5_000;

/// The last seconds, the oldest first.
#[derive(Debug, Default)]
pub struct Trails {
    seconds: VecDeque<Arc<Second>>,
    places: usize,
    /// One name per track: those of the slots, of which each has its own, would lie scattered over all the memory.
    names: HashSet<Arc<str>>,
}

/// The places of a second.
#[derive(Debug)]
pub struct Second {
    time: Time,
    places: Vec<(Arc<str>, Place)>,
}

/// Longitude, latitude and, where it was measured, ellipsoidal height.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
enum Place {
    Low([f64; 2]),
    High([f64; 3]),
}

/// Where a track was: times and places, the oldest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "RecentTrail")]
pub struct Trail {
    #[schemars(with = "Vec<Rfc3339>")]
    times: Vec<String>,
    #[schemars(with = "Vec<Position>")]
    coordinates: Vec<Place>,
}

impl Trail {
    /// The trail of each track over these seconds.
    pub fn all(seconds: &[Arc<Second>]) -> HashMap<Arc<str>, Self> {
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

    /// Each time with longitude, latitude and, where it was measured, ellipsoidal height.
    pub fn places(&self) -> impl Iterator<Item = (&str, f64, f64, Option<f64>)> {
        self.times.iter().zip(&self.coordinates).map(|(time, place)| match *place {
            Place::Low([lng, lat]) => (&**time, lng, lat, None),
            Place::High([lng, lat, height_m]) => (&**time, lng, lat, Some(height_m)),
        })
    }
}

impl Trails {
    /// Keeps the first slot of each second. A replay that went back takes back what it will show again.
    pub fn note<'a>(&mut self, time: Time, pieces: impl Iterator<Item = &'a Piece>) {
        while self.seconds.back().is_some_and(|second| second.time >= time) {
            self.seconds.pop_back().inspect(|second| self.places -= second.places.len());
        }
        if self.seconds.back().is_some_and(|second| time.nanos() - second.time.nanos() < SECOND) {
            return;
        }
        let names = &mut self.names;
        let place = |piece: &Piece| {
            let [lng, lat] = [rounded(piece.lng, 7), rounded(piece.lat, 7)];
            let high = |height_m| Place::High([lng, lat, rounded(height_m, 1)]);
            let place = piece.height_m.map_or(Place::Low([lng, lat]), high);
            let name = names.get(&piece.id).cloned().unwrap_or_else(|| {
                let name = Arc::<str>::from(&*piece.id);
                names.insert(name.clone());
                name
            });
            (name, place)
        };
        let places: Vec<_> = pieces.map(place).collect();
        self.places += places.len();
        self.seconds.push_back(Arc::new(Second { time, places }));
        let oldest = Time::from_nanos(time.nanos() - i64::from(LONGEST_S) * SECOND);
        while self.places > PLACES || self.seconds.front().is_some_and(|second| second.time < oldest) {
            self.seconds.pop_front().inspect(|second| self.places -= second.places.len());
        }
        self.names.retain(|name| Arc::strong_count(name) > 1);
    }

    /// The last `seconds` before `now`.
    pub fn last(&self, seconds: u32, now: Time) -> Vec<Arc<Second>> {
        let since = now.nanos() - i64::from(seconds) * SECOND;
        let is_wanted = |second: &&Arc<Second>| second.time.nanos() >= since && second.time < now;
        self.seconds.iter().filter(is_wanted).cloned().collect()
    }

    /// How many places the last `seconds` have.
    pub fn places(&self, seconds: u32) -> usize {
        let Some(newest) = self.seconds.back() else { return 0 };
        let since = newest.time.nanos() - i64::from(seconds) * SECOND;
        let last = self.seconds.iter().rev().take_while(|second| second.time.nanos() >= since);
        last.map(|second| second.places.len()).sum()
    }
}
