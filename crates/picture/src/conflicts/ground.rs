//! Aircraft on the ground, which take no part in conflicts.

use std::collections::BTreeMap;

use crate::PictureTrack;
use conflict::ConflictKey;
use fusion::time::{SECOND, Time};

/// Operational status of Remote ID of a drone on the ground (ASTM F3411).
const GROUND: u8 = 1;
/// Maximum speed of an aircraft at rest, over ground and in height, in metres per second.
const RESTING_M_S: f64 = 1.0;
/// Minimum duration of the rest, in nanoseconds.
const RESTING_NS: i64 = 5 * SECOND;
/// A landed aircraft is within this height of the lowest one of its flight, in metres.
const LANDED_M: f64 = 3.0;
/// Minimum height that it descended from, above the lowest one, in metres.
const DESCENT_M: f64 = 15.0;
/// Maximum height above the lowest one of any aircraft with a transponder, and above the ground as stated by the aircraft, in
/// metres. A hovering drone is mostly higher.
const LOW_M: f64 = 10.0;
/// Time after which an aircraft that is no longer in the picture is forgotten, in nanoseconds.
const FORGET_NS: u64 = 60 * SECOND as u64;

/// Finds aircraft on the ground in successive pictures.
#[derive(Debug, Default)]
pub(super) struct GroundMonitor {
    flights: BTreeMap<ConflictKey, FlightHeights>,
    /// Lowest height of any aircraft with a transponder, metres above mean sea level.
    lowest_m: Option<f64>,
    /// Time of the last picture.
    time: Option<Time>,
}

#[derive(Debug)]
struct FlightHeights {
    /// Lowest and highest height so far, metres above mean sea level; `None`: no height is known yet.
    range_m: Option<[f64; 2]>,
    /// Time since which the aircraft rests; `None`: it moves.
    resting: Option<Time>,
    seen: Time,
}

impl GroundMonitor {
    /// Records the motion of the aircraft of a picture. A picture before the last one discards all records.
    pub(super) fn note<'a>(&mut self, now: Time, tracks: impl Iterator<Item = &'a PictureTrack>) {
        if self.time.replace(now).is_some_and(|before| now < before) {
            (self.flights, self.lowest_m) = (BTreeMap::new(), None);
        }
        for track in tracks {
            let new = FlightHeights { range_m: None, resting: None, seen: now };
            let flight = self.flights.entry(track.key()).or_insert(new);
            flight.seen = now;
            if is_at_rest(track) {
                flight.resting.get_or_insert(now);
            } else {
                flight.resting = None;
            }
            let Some(height_m) = track.altitude_amsl_m else { continue };
            let [lowest_m, highest_m] = flight.range_m.unwrap_or([height_m; 2]);
            flight.range_m = Some([lowest_m.min(height_m), highest_m.max(height_m)]);
            if track.point.source.transponder().is_some() {
                self.lowest_m = Some(self.lowest_m.map_or(height_m, |lowest_m| lowest_m.min(height_m)));
            }
        }
        self.flights.retain(|_, flight| now.nanos().abs_diff(flight.seen.nanos()) <= FORGET_NS);
    }

    /// Whether an aircraft of the last picture rests on the ground: it states so, or it rests at the lowest height of its
    /// flight after a descent. A moving aircraft that states the ground is not believed.
    pub(super) fn has(&self, track: &PictureTrack) -> bool {
        let Some(flight) = self.flights.get(&track.key()) else { return false };
        let is_at_rest = flight.resting.zip(self.time);
        if is_at_rest.is_none_or(|(since, now)| now.nanos() - since.nanos() < RESTING_NS) {
            return false;
        }
        let declared = track.point.source.transponder().map(|part| part.aircraft.declared);
        if declared.is_some_and(|declared| declared.status == Some(GROUND)) {
            return true;
        }
        let stated = declared.and_then(|declared| declared.height);
        if stated.is_some_and(|height| f64::from(height.half_metres) / 2.0 > LOW_M) {
            return false;
        }
        let Some((height_m, [lowest_m, highest_m])) = track.altitude_amsl_m.zip(flight.range_m) else {
            return false;
        };
        let is_landed = height_m <= lowest_m + LANDED_M && height_m <= highest_m - DESCENT_M;
        is_landed && self.lowest_m.is_none_or(|lowest_m| height_m <= lowest_m + LOW_M)
    }
}

fn is_at_rest(track: &PictureTrack) -> bool {
    let climb_m_s = track.vertical_motion().map_or(0.0, |motion| motion.climb().abs());
    track.motion.is_some_and(|motion| motion.speed() <= RESTING_M_S && climb_m_s <= RESTING_M_S)
}
