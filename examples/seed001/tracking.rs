//! A tracker in one flight, and its errors.

use nalgebra::Vector3;
use tracker::{Flight, Reading, Tracker, TrackerEstimate, Turning, wrapped};

use crate::scenario::Intruder;
use crate::sensors::time;

/// Probability that a model still applies after one second.
pub const STAYS: f64 = 0.95;
/// Number of detections with a range that start a track.
const STARTED_BY: usize = 4;
/// Standard deviations of an intruder's initial velocity, over ground per axis, and vertical, metres per second.
const FIRST_SPEED: f64 = 200.0;
const FIRST_CLIMB: f64 = 10.0;
/// Interval between outputs of a track, seconds.
pub const STEP_S: f64 = 0.1;

/// The models of a tracker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackerModels {
    /// Straight flight only.
    Straight,
    /// Straight flight, turns of 2, 6 and 9 degrees per second.
    Seven,
    /// Straight flight, turns of 2 and 6 degrees per second: crewed aeroplanes.
    Crewed,
    /// Straight flight and turns of 2 degrees per second.
    Three,
}

impl TrackerModels {
    fn turning(self, noise: f64) -> Turning {
        let mut turning = match self {
            Self::Seven => Turning::any(noise, STAYS),
            _ => Turning::crewed(noise, STAYS),
        };
        match self {
            Self::Straight => turning.rates.clear(),
            Self::Three => turning.rates.truncate(2),
            Self::Seven | Self::Crewed => {}
        }
        turning
    }
}

/// A track at one time, and its errors.
#[derive(Clone, Copy, Debug)]
pub struct TrackSample {
    pub at: f64,
    pub position: Vector3<f64>,
    /// Position error, metres.
    pub error_m: f64,
    /// Along-track error, forward positive, metres.
    pub along_m: f64,
    /// Heading error, degrees.
    pub heading_deg: f64,
    /// Probability of the turns to the left.
    pub left: f64,
}

/// Track of a flight, from its start on.
pub fn track(intruder: &Intruder, readings: &[Reading], models: TrackerModels) -> Vec<TrackSample> {
    let flight = Flight::Turning(models.turning(intruder.noise));
    let left: Vec<bool> = std::iter::once(false)
        .chain(models.turning(intruder.noise).rates.iter().map(|rate| *rate < 0.0))
        .collect();
    let Some((mut tracker, begin)) = started(intruder, readings, &flight) else { return Vec::new() };
    let mut coming = readings.iter().filter(|reading| reading.origin().time > begin).peekable();
    let mut samples = Vec::new();
    for step in 0..=(intruder.end_s() / STEP_S).floor() as u32 {
        let at = f64::from(step) * STEP_S;
        if time(at) < begin {
            continue;
        }
        while let Some(reading) = coming.next_if(|reading| reading.origin().time <= time(at)) {
            // The readings are in order of time, so none is too old.
            let _ = tracker.update(reading.clone());
        }
        tracker.forget_before(time(at));
        let (Some(estimate), Some(likely)) = (tracker.at(time(at)), tracker.probabilities(time(at))) else {
            continue;
        };
        let (position, velocity) = intruder.at(at);
        let off = estimate.position.0 - position;
        let heading = |velocity: &Vector3<f64>| velocity.x.atan2(velocity.y);
        samples.push(TrackSample {
            at,
            position: estimate.position.0,
            error_m: off.norm(),
            along_m: off.dot(&velocity) / velocity.norm(),
            heading_deg: wrapped(heading(&estimate.velocity) - heading(&velocity)).to_degrees(),
            left: likely.iter().zip(&left).filter(|(_, left)| **left).map(|(likely, _)| likely).sum(),
        });
    }
    samples
}

/// Track started for straight flight by the first detections with a position. Also returns its start time.
fn started(intruder: &Intruder, readings: &[Reading], flight: &Flight) -> Option<(Tracker, fusion::Time)> {
    let mut first = readings.iter().filter(|reading| reading.place().is_some()).take(STARTED_BY);
    let mut estimate = TrackerEstimate::first(first.next()?, FIRST_SPEED)?;
    estimate.covariance[(5, 5)] = FIRST_CLIMB * FIRST_CLIMB;
    let straight = Flight::Turning(TrackerModels::Straight.turning(intruder.noise));
    let mut starting = Tracker::begin(&straight, &estimate)?;
    let mut begin = estimate.time;
    for reading in first {
        begin = reading.origin().time;
        starting.update(reading.clone()).ok()?;
    }
    Some((Tracker::begin(flight, &starting.at(begin)?)?, begin))
}
