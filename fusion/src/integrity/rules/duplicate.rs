//! `duplicate`: an identity alternates between two positions that no aircraft can fly between.

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::history::TimedReport;
use super::stream::ReportStream;
use crate::report::SensorIndex;
use crate::time::Time;

/// Speed that no drone reaches, m/s.
const SPEED_MAX_M_S: f64 = 60.0;
/// Error of the positions, metres: four standard deviations between two reports of a receiver with 10 m on each axis.
const RECEIVER_M: f64 = 60.0;
/// Maximum difference between the clocks of two receivers, seconds.
const RECEIVERS_APART_S: f64 = 2.0;
/// Length of the evaluated period.
const LOOK_BACK: SignedDuration = SignedDuration::from_secs(20);
/// Minimum number of changes between the positions in that period.
const CHANGES: u32 = 3;
/// Minimum number of reports at each position.
const REPORTS: u32 = 2;
/// Time for which the finding holds.
const HOLDS: SignedDuration = SignedDuration::from_secs(12);

/// Evidence that an identity is at two positions.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Duplicate {
    newest: Option<ReceiverReport>,
    /// Time of the last report that no aircraft could have sent after the one before it.
    apart: Option<Time>,
    last: Option<Time>,
}

/// A report and its receiver.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct ReceiverReport {
    heard: TimedReport,
    sensor: SensorIndex,
}

impl ReceiverReport {
    fn is_near(&self, other: &Self) -> bool {
        let clocks_s = if self.sensor == other.sensor { 0.0 } else { RECEIVERS_APART_S };
        let reach_m = RECEIVER_M + SPEED_MAX_M_S * (self.heard.apart_s(&other.heard) + clocks_s);
        self.heard.distance_m(&other.heard) <= reach_m
    }
}

impl Duplicate {
    /// Adds a report that is already in `streams`, which are of one identity.
    pub(super) fn add_report(&mut self, heard: TimedReport, sensor: SensorIndex, streams: &[ReportStream]) {
        let received = ReceiverReport { heard, sensor };
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

    pub(super) fn is_active(&self, deadline: Time) -> bool {
        self.last.is_some_and(|last| deadline <= last + HOLDS)
    }
}

fn alternates(streams: &[ReportStream], newest: Time) -> bool {
    let since = newest - LOOK_BACK;
    let of_stream = |stream: &ReportStream| {
        let (sensor, at) = (stream.sensor, stream.history.after(since));
        stream.history.from(at).map(|&heard| ReceiverReport { heard, sensor }).collect::<Vec<_>>()
    };
    let mut reports: Vec<ReceiverReport> = streams.iter().flat_map(of_stream).collect();
    reports.sort_by_key(|received| (received.heard.order(), received.sensor));
    let mut places = AlternatingPlaces::default();
    reports.into_iter().any(|received| places.alternate(received))
}

/// Two positions between which an identity alternates.
#[derive(Debug, Default)]
struct AlternatingPlaces {
    /// Last report at the current position and at the other one, each with the number of reports.
    here: Option<(ReceiverReport, u32)>,
    there: Option<(ReceiverReport, u32)>,
    changes: u32,
}

impl AlternatingPlaces {
    /// Adds the next report; returns whether the evidence is sufficient.
    fn alternate(&mut self, received: ReceiverReport) -> bool {
        let near = |place: &Option<(ReceiverReport, u32)>| {
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
            // A third position excludes two transmitters.
            (None, None) => *self = Self { here: Some((received, 1)), ..Self::default() },
        }
        let is_place =
            |place: &Option<(ReceiverReport, u32)>| place.is_some_and(|(_, reports)| reports >= REPORTS);
        self.changes >= CHANGES && is_place(&self.here) && is_place(&self.there)
    }
}
