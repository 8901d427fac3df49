//! One radar track of an aircraft with a transponder: stretches of straight flight and of turns, and what they tell.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::AXES;
use super::axis::{MEAN_OF, Mean};
use super::pyramid::{Change, Pyramid, Sample};
use crate::time::{SECOND, Time};

/// A plot against the transponder's curve at its time.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Compared {
    /// When.
    pub(crate) time: Time,
    /// Plot less curve, as an aligned radar would have it: range (metres), azimuth (milliradians), height (metres).
    pub(crate) offsets: [Option<f64>; AXES],
    /// Variances in these axes: of the transponder's bias, of the curve through its reports,
    pub(crate) slow: [f64; AXES],
    pub(crate) curve: [f64; AXES],
    /// and of what is constant over a track: what is left of a misalignment, the transponder's delay.
    pub(crate) constant: [f64; AXES],
    /// Velocity over ground along the curve, metres a second.
    pub(crate) velocity: Vector2<f64>,
    /// The velocity that the radar told, where it did.
    pub(crate) told_velocity: Option<Vector2<f64>>,
}

/// What a piece of a track told, one at a time.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) enum Told {
    Change(usize, Change),
    Mean(usize, Mean, Flight),
    /// A plot was seen in such flight.
    Plot(Flight),
    /// The radar's velocity less the transponder's.
    Velocity(Vector2<f64>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Flight {
    Straight,
    Turning,
}

/// Turning: the direction changes by more than this, radians a second,
const TURN_RAD_S: f64 = 4.0_f64.to_radians();
/// measured over at least this long, seconds,
const TURN_BASE_S: f64 = 1.5;
/// of a velocity that changes by more than this, metres a second: what changes less is as well a transponder's noise.
const TURN_CHANGE_M_S: f64 = 1.0;
/// A stretch counts from this long after its beginning on, seconds: how a track flies is not known at once, and a radar's tracker
/// feels a turn, and recovers from one, for as long.
const SETTLED_S: f64 = 2.0;
/// Plots further apart are of two stretches, seconds, or so many times the time between the two before.
const BREAK_S: f64 = 2.0;
const BREAK_SPACINGS: f64 = 4.0;
/// Velocities this far apart are told independently of one another, seconds.
const VELOCITY_EVERY_S: f64 = 3.0;

/// What is known of a track so far.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct TrackLearning {
    /// Means of the bias are taken this far apart, seconds: nearer, they are the same.
    correlation_s: f64,
    told: Vec<Told>,
    /// The last plot, and the time between the two before, seconds.
    last: Option<(Time, f64)>,
    /// The course about a second ago, and that to be compared with next.
    courses: Option<[(Time, Vector2<f64>); 2]>,
    flight: Flight,
    /// From when on a stretch counts.
    settled: Time,
    changes: [Pyramid; AXES],
    /// The plots of the mean that is being gathered,
    mean: Vec<Compared>,
    /// and by flight, from when on there may be one.
    next_mean: [Time; 2],
    next_velocity: Time,
}

impl TrackLearning {
    /// A track of a radar whose bias has about this correlation time.
    pub(crate) fn new(correlation_s: f64) -> Self {
        Self {
            correlation_s,
            told: Vec::new(),
            last: None,
            courses: None,
            flight: Flight::Straight,
            settled: EARLIEST,
            changes: Default::default(),
            mean: Vec::new(),
            next_mean: [EARLIEST; 2],
            next_velocity: EARLIEST,
        }
    }

    /// One plot more, later than those before.
    pub(crate) fn add(&mut self, plot: &Compared) {
        let time = plot.time;
        let spacing_s = self.last.map(|(last, _)| time.seconds_since(last));
        let is_near = self
            .last
            .zip(spacing_s)
            .is_some_and(|((_, before_s), spacing_s)| spacing_s <= BREAK_S.max(BREAK_SPACINGS * before_s));
        self.last = Some((time, spacing_s.filter(|_| is_near).unwrap_or(0.0)));
        if !is_near {
            self.courses = None;
            self.begin(Flight::Straight, later(time, SETTLED_S));
        }
        let flight = self.flies(time, plot.velocity);
        if flight != self.flight {
            self.begin(flight, later(time, SETTLED_S));
        }
        self.told.push(Told::Plot(flight));
        self.take_velocity(plot);
        if time < self.settled {
            return;
        }
        self.take_mean(plot);
        if flight == Flight::Straight {
            let told = &mut self.told;
            for (axis, changes) in self.changes.iter_mut().enumerate() {
                if let Some(offset) = plot.offsets[axis] {
                    let sample = Sample { time, offset, slow: plot.slow[axis], curve: plot.curve[axis] };
                    changes.add(&sample, |change| told.push(Told::Change(axis, change)));
                }
            }
        }
    }

    /// What was told since the last take.
    pub(super) fn take(&mut self) -> Vec<Told> {
        std::mem::take(&mut self.told)
    }

    /// A new stretch, which counts from then on.
    fn begin(&mut self, flight: Flight, settled: Time) {
        (self.flight, self.settled) = (flight, settled);
        self.changes = Default::default();
        self.mean.clear();
    }

    /// How it flies, by its course now and a second or two ago.
    fn flies(&mut self, time: Time, velocity: Vector2<f64>) -> Flight {
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
        if is_turning { Flight::Turning } else { Flight::Straight }
    }

    fn take_velocity(&mut self, plot: &Compared) {
        if let Some(told) = plot.told_velocity
            && plot.time >= self.next_velocity
        {
            self.told.push(Told::Velocity(told - plot.velocity));
            self.next_velocity = later(plot.time, VELOCITY_EVERY_S);
        }
    }

    fn take_mean(&mut self, plot: &Compared) {
        let next = &mut self.next_mean[self.flight as usize];
        if plot.time < *next {
            return;
        }
        self.mean.push(*plot);
        if self.mean.len() < MEAN_OF {
            return;
        }
        let plots = std::mem::take(&mut self.mean);
        let mean = |part: &dyn Fn(&Compared) -> Option<f64>| -> Option<f64> {
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
            let mean = Mean { size, spacing_s, slow, curve, constant };
            self.told.push(Told::Mean(axis, mean, self.flight));
        }
        *next = later(plot.time, self.correlation_s);
    }
}

fn later(time: Time, seconds: f64) -> Time {
    Time::from_nanos(time.nanos() + (seconds * SECOND as f64) as i64)
}

/// Earlier than every plot.
const EARLIEST: Time = Time::from_nanos(i64::MIN);
