//! `duplicate`: an identity is in turn at two places no aircraft flies between.

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::history::Heard;
use super::stream::Stream;
use crate::report::SensorIndex;
use crate::time::Time;

/// Speed of no drone, m/s, and
const SPEED_MAX_M_S: f64 = 60.0;
/// errors of its receiver, metres: four standard deviations between two reports of one of 10 m an axis.
const RECEIVER_M: f64 = 60.0;
/// By how much two receivers differ in their clocks, seconds.
const RECEIVERS_APART_S: f64 = 2.0;
/// Looked back over.
const LOOK_BACK: SignedDuration = SignedDuration::from_secs(20);
/// Changes from one place to the other within it.
const CHANGES: u32 = 3;
/// Reports at either place.
const REPORTS: u32 = 2;
/// It holds so long.
const HOLDS: SignedDuration = SignedDuration::from_secs(12);

/// When an identity was at two places last.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Duplicate {
    newest: Option<Received>,
    /// The last report that no aircraft could have sent after the one before it.
    apart: Option<Time>,
    last: Option<Time>,
}

/// A report, and who received it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Received {
    heard: Heard,
    sensor: SensorIndex,
}

impl Received {
    fn is_near(&self, other: &Self) -> bool {
        let clocks_s = if self.sensor == other.sensor { 0.0 } else { RECEIVERS_APART_S };
        let reach_m = RECEIVER_M + SPEED_MAX_M_S * (self.heard.apart_s(&other.heard) + clocks_s);
        self.heard.distance_m(&other.heard) <= reach_m
    }
}

impl Duplicate {
    /// Takes a report that is now in `streams`, all of one identity.
    pub(super) fn hear(&mut self, heard: Heard, sensor: SensorIndex, streams: &[Stream]) {
        let received = Received { heard, sensor };
        let before = *self.newest.get_or_insert(received);
        if !before.is_near(&received) {
            self.apart = self.apart.max(Some(heard.time));
        }
        if before.heard.time <= heard.time {
            self.newest = Some(received);
        }
        let newest = before.heard.time.max(heard.time);
        if self.apart.is_some_and(|apart| newest - apart <= LOOK_BACK) && alternates(streams, newest) {
            self.last = Some(newest);
        }
    }

    pub(super) fn holds(&self, deadline: Time) -> bool {
        self.last.is_some_and(|last| deadline <= last + HOLDS)
    }
}

fn alternates(streams: &[Stream], newest: Time) -> bool {
    let since = newest - LOOK_BACK;
    let of_stream = |stream: &Stream| {
        let (sensor, at) = (stream.sensor, stream.history.after(since));
        stream.history.from(at).map(|&heard| Received { heard, sensor }).collect::<Vec<_>>()
    };
    let mut reports: Vec<Received> = streams.iter().flat_map(of_stream).collect();
    reports.sort_by_key(|received| (received.heard.order(), received.sensor));
    let mut places = TwoPlaces::default();
    reports.into_iter().any(|received| places.alternate(received))
}

/// Where an identity is in turn.
#[derive(Debug, Default)]
struct TwoPlaces {
    /// The place of the last report, and the other one; with how many reports.
    here: Option<(Received, u32)>,
    there: Option<(Received, u32)>,
    changes: u32,
}

impl TwoPlaces {
    /// Takes the next report; whether it is one too many.
    fn alternate(&mut self, received: Received) -> bool {
        let near = |place: &Option<(Received, u32)>| {
            place.filter(|(last, _)| last.is_near(&received)).map(|(_, reports)| reports)
        };
        match (near(&self.here), near(&self.there)) {
            (Some(reports), _) => self.here = Some((received, reports + 1)),
            (None, Some(reports)) => {
                self.there = self.here;
                self.here = Some((received, reports + 1));
                self.changes += 1;
            }
            (None, None) if self.there.is_none() => {
                self.there = self.here;
                self.here = Some((received, 1));
                self.changes += u32::from(self.there.is_some());
            }
            // A third place: whatever this is, it is not two transmitters.
            (None, None) => *self = Self { here: Some((received, 1)), ..Self::default() },
        }
        let is_place = |place: &Option<(Received, u32)>| place.is_some_and(|(_, reports)| reports >= REPORTS);
        self.changes >= CHANGES && is_place(&self.here) && is_place(&self.there)
    }
}
