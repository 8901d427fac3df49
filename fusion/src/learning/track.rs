//! Evidence of one radar track of an aircraft with a transponder: segments of straight flight and of turns.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::axis::{AXES, MEAN_OF, SegmentMean};
use super::pyramid::{MeanChange, OffsetSample, Pyramid};
use crate::time::{SECOND, Time};

/// A plot compared with the transponder's curve at its time.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct ComparedPlot {
    /// Time of the plot.
    pub(crate) time: Time,
    /// Plot minus curve, for an aligned radar: range (metres), azimuth (milliradians), height (metres).
    pub(crate) offsets: [Option<f64>; AXES],
    /// Variances on these axes: of the transponder's bias, and of the curve through its reports.
    pub(crate) slow: [f64; AXES],
    pub(crate) curve: [f64; AXES],
    /// Variances of errors that are constant over a track: remaining misalignment, and the transponder's delay.
    pub(crate) constant: [f64; AXES],
    /// Velocity over ground along the curve, metres a second.
    pub(crate) velocity: Vector2<f64>,
    /// Velocity reported by the radar, if any.
    pub(crate) reported_velocity: Option<Vector2<f64>>,
}

/// A piece of evidence from a track.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) enum TrackEvidence {
    Change(usize, MeanChange),
    Mean(usize, SegmentMean, FlightPhase),
    /// A plot in this kind of flight.
    Plot(FlightPhase),
    /// The radar's velocity minus the transponder's.
    Velocity(Vector2<f64>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum FlightPhase {
    Straight,
    Turning,
}

/// Minimum rate of turn of the course, radians a second.
const TURN_RAD_S: f64 = 4.0_f64.to_radians();
/// Minimum period over which the rate of turn is measured, seconds.
const TURN_BASE_S: f64 = 1.5;
/// Minimum change of velocity in a turn, metres a second: smaller ones may be a transponder's noise.
const TURN_CHANGE_M_S: f64 = 1.0;
/// Time after the start of a segment from which it counts, seconds. The kind of flight is not known at once, and a
/// radar's tracker takes as long to follow a turn and to recover from it.
const SETTLED_S: f64 = 2.0;
/// Gap that separates segments, seconds, or in multiples of the previous interval between plots.
const BREAK_S: f64 = 2.0;
const BREAK_SPACINGS: f64 = 4.0;
/// Minimum interval of velocities that count as independent, seconds.
const VELOCITY_EVERY_S: f64 = 3.0;

/// State of a track.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct TrackLearning {
    /// Interval between means of the bias, seconds; means at a shorter interval are not independent.
    correlation_s: f64,
    evidence: Vec<TrackEvidence>,
    /// Time of the last plot, and the interval between the two plots before, seconds.
    last: Option<(Time, f64)>,
    /// The course about a second ago, and the one to be compared next.
    courses: Option<[(Time, Vector2<f64>); 2]>,
    flight: FlightPhase,
    /// Time from which the segment counts.
    settled: Time,
    changes: [Pyramid; AXES],
    /// The plots of the mean in progress.
    mean: Vec<ComparedPlot>,
    /// Time from which the next mean may begin, by kind of flight.
    next_mean: [Time; 2],
    next_velocity: Time,
}

impl TrackLearning {
    /// Creates a track of a radar whose bias has about this correlation time, seconds.
    pub(crate) fn new(correlation_s: f64) -> Self {
        Self {
            correlation_s,
            evidence: Vec::new(),
            last: None,
            courses: None,
            flight: FlightPhase::Straight,
            settled: EARLIEST,
            changes: Default::default(),
            mean: Vec::new(),
            next_mean: [EARLIEST; 2],
            next_velocity: EARLIEST,
        }
    }

    /// Adds a plot, later than those before.
    pub(crate) fn add(&mut self, plot: &ComparedPlot) {
        let time = plot.time;
        let spacing_s = self.last.map(|(last, _)| time.seconds_since(last));
        let is_near = self
            .last
            .zip(spacing_s)
            .is_some_and(|((_, before_s), spacing_s)| spacing_s <= BREAK_S.max(BREAK_SPACINGS * before_s));
        self.last = Some((time, spacing_s.filter(|_| is_near).unwrap_or(0.0)));
        if !is_near {
            self.courses = None;
            self.begin(FlightPhase::Straight, later(time, SETTLED_S));
        }
        let flight = self.flies(time, plot.velocity);
        if flight != self.flight {
            self.begin(flight, later(time, SETTLED_S));
        }
        self.evidence.push(TrackEvidence::Plot(flight));
        self.take_velocity(plot);
        if time < self.settled {
            return;
        }
        self.take_mean(plot);
        if flight == FlightPhase::Straight {
            let evidence = &mut self.evidence;
            for (axis, changes) in self.changes.iter_mut().enumerate() {
                if let Some(offset) = plot.offsets[axis] {
                    let sample =
                        OffsetSample { time, offset, slow: plot.slow[axis], curve: plot.curve[axis] };
                    changes.add(&sample, |change| evidence.push(TrackEvidence::Change(axis, change)));
                }
            }
        }
    }

    /// Returns the evidence since the last call.
    pub(super) fn take_evidence(&mut self) -> Vec<TrackEvidence> {
        std::mem::take(&mut self.evidence)
    }

    /// Begins a new segment, which counts from `settled` on.
    fn begin(&mut self, flight: FlightPhase, settled: Time) {
        (self.flight, self.settled) = (flight, settled);
        self.changes = Default::default();
        self.mean.clear();
    }

    /// Kind of flight, from the present course and that of a second or two ago.
    fn flies(&mut self, time: Time, velocity: Vector2<f64>) -> FlightPhase {
        let [before, next] = self.courses.get_or_insert([(time, velocity); 2]);
        let (since, course) = *before;
        let passed_s = time.seconds_since(since);
        if passed_s < TURN_BASE_S {
            return self.flight;
        }
        if time.seconds_since(next.0) >= TURN_BASE_S / 2.0 {
            (*before, *next) = (*next, (time, velocity));
        }
        let turned = velocity.angle(&course) / passed_s;
        let is_turning = turned > TURN_RAD_S && (velocity - course).norm() > TURN_CHANGE_M_S;
        if is_turning { FlightPhase::Turning } else { FlightPhase::Straight }
    }

    fn take_velocity(&mut self, plot: &ComparedPlot) {
        if let Some(evidence) = plot.reported_velocity
            && plot.time >= self.next_velocity
        {
            self.evidence.push(TrackEvidence::Velocity(evidence - plot.velocity));
            self.next_velocity = later(plot.time, VELOCITY_EVERY_S);
        }
    }

    fn take_mean(&mut self, plot: &ComparedPlot) {
        let next = &mut self.next_mean[self.flight as usize];
        if plot.time < *next {
            return;
        }
        self.mean.push(*plot);
        if self.mean.len() < MEAN_OF {
            return;
        }
        let plots = std::mem::take(&mut self.mean);
        let mean = |part: &dyn Fn(&ComparedPlot) -> Option<f64>| -> Option<f64> {
            Some(plots.iter().map(part).sum::<Option<f64>>()? / MEAN_OF as f64)
        };
        for axis in 0..AXES {
            let (Some(size), Some(slow), Some(curve), Some(constant)) = (
                mean(&|plot| plot.offsets[axis]),
                mean(&|plot| Some(plot.slow[axis])),
                mean(&|plot| Some(plot.curve[axis])),
                mean(&|plot| Some(plot.constant[axis])),
            ) else {
                continue;
            };
            let spacing_s = plot.time.seconds_since(plots[0].time) / (MEAN_OF - 1) as f64;
            let mean = SegmentMean { size, spacing_s, slow, curve, constant };
            self.evidence.push(TrackEvidence::Mean(axis, mean, self.flight));
        }
        *next = later(plot.time, self.correlation_s);
    }
}

fn later(time: Time, seconds: f64) -> Time {
    Time::from_nanos(time.nanos() + (seconds * SECOND as f64) as i64)
}

/// A time before every plot.
const EARLIEST: Time = Time::from_nanos(i64::MIN);
